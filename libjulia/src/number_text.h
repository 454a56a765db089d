// SPDX-License-Identifier: Apache-2.0
/// @file number_text.h
/// Numbers for messages: short, but small ones are not rounded to 0.
#pragma once

#include <sstream>
#include <string>

namespace julia {

inline std::string textOf(double value) {
  std::ostringstream text;
  text << value;
  return text.str();
}

}  // namespace julia
