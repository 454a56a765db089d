// SPDX-License-Identifier: Apache-2.0
/// @file percent_decoded.h
/// The percent-encoding of addresses, RFC 3986 2.1.
#pragma once

#include <string>
#include <string_view>

namespace vdbtools {

/// The bytes that "%20" and the like stand for. A percent sign without two hexadecimal digits behind it stands for
/// itself.
std::string percentDecoded(std::string_view text);

}  // namespace vdbtools
