// SPDX-License-Identifier: Apache-2.0
/// @file program_text.h
/// The text of the program that devices compile.
#pragma once

#include <string>

namespace julia::device {

/// OpenCL C 1.2, the same for all fields; the switches of a field (program_data.h) go with it to the compiler.
std::string programText(bool floats);

}  // namespace julia::device
