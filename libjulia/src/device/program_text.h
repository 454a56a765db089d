// SPDX-License-Identifier: Apache-2.0
/// @file program_text.h
/// The text of the program that devices compile.
#pragma once

#include <string>

namespace julia::device {

/// OpenCL C 1.2. The switches of a field (program_data.h) go with it to the compiler.
/// @param texture  ProgramData::texture, the only part that depends on the field
std::string programText(bool floats, const std::string& texture);

}  // namespace julia::device
