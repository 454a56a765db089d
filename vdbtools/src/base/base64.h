// SPDX-License-Identifier: Apache-2.0
/// @file base64.h
/// Bytes as text, for files of text that hold them.
#pragma once

#include <string>
#include <string_view>

namespace vdbtools {

/// In the alphabet of RFC 4648, with padding.
std::string base64(std::string_view bytes);

}  // namespace vdbtools
