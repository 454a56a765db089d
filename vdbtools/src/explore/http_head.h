// SPDX-License-Identifier: Apache-2.0
/// @file http_head.h
/// Parses the head of a request in HTTP/1.1 (RFC 9112), without sockets. It supports only what the server uses: no
/// ranges, no compression, no forms and no cookies.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace vdbtools::explore {

struct HttpHead {
  std::string method;
  std::string target;                                       ///< "/path?query" as it was sent, percent-encoded
  bool old = false;                                         ///< HTTP/1.0
  std::vector<std::pair<std::string, std::string>> fields;  ///< names in lower case, values without spaces around them

  /// The number of fields with this name.
  std::size_t count(std::string_view name) const;

  /// The value of the first field of this name; empty if there is none.
  std::string_view value(std::string_view name) const;

  /// The target without its query, decoded.
  std::string path() const;

  /// The value of the first parameter of this name in the query, decoded; empty if there is none.
  std::string parameter(std::string_view name) const;

  /// Whether the client may send another request through the same connection.
  bool persists() const;
};

/// @param bytes  everything up to and including the empty line
/// @return nothing unless every character is well formed: a malformed head may mean one thing to this server and
/// another to a proxy in front of it
std::optional<HttpHead> parsedHead(std::string_view bytes);

}  // namespace vdbtools::explore
