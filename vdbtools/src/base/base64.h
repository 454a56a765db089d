// SPDX-License-Identifier: Apache-2.0
/// @file base64.h
/// Encodes bytes as text, for text files that contain them.
#pragma once

#include <string>
#include <string_view>

namespace vdbtools {

/// The standard alphabet of RFC 4648, with padding.
std::string base64(std::string_view bytes);

}  // namespace vdbtools
