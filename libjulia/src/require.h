// SPDX-License-Identifier: Apache-2.0
/// @file require.h
/// Checks of arguments.
#pragma once

#include <stdexcept>
#include <string>

namespace julia {

/// @throw std::invalid_argument  with @a text, unless @a good
inline void require(bool good, const std::string& text) {
  if (!good) throw std::invalid_argument(text);
}

}  // namespace julia
