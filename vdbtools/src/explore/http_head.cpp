// SPDX-License-Identifier: Apache-2.0
#include "explore/http_head.h"

#include "vdbtools/base/text.h"
#include "vdbtools/files/file_bytes.h"

#include <algorithm>

namespace vdbtools::explore {
namespace {

/// Whether a character may occur in a method or in a field's name, RFC 9110 5.6.2.
bool isToken(char c) {
  constexpr std::string_view kOthers = "!#$%&'*+-.^_`|~";
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || kOthers.find(c) != kOthers.npos;
}

bool isToken(std::string_view text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [](char c) { return isToken(c); });
}

/// Whether a character may occur in a line. Bytes beyond ASCII may, and have no meaning.
bool isText(char c) { return c == '\t' || (static_cast<unsigned char>(c) >= 0x20 && c != 0x7f); }

/// Removes the text up to @a end, and @a end itself, from @a rest and returns the text. If @a end does not occur, takes
/// everything.
std::string_view takeUpTo(std::string_view end, std::string_view& rest) {
  const std::size_t at = rest.find(end);
  const std::string_view taken = rest.substr(0, at);
  rest.remove_prefix(at == rest.npos ? rest.size() : at + end.size());
  return taken;
}

/// Reads "GET /path HTTP/1.1". The target must begin with a slash, because other targets are for proxies.
bool readRequestLine(std::string_view line, HttpHead& head) {
  head.method = takeUpTo(" ", line);
  head.target = takeUpTo(" ", line);
  head.old = line == "HTTP/1.0";
  return isToken(head.method) && head.target.starts_with('/') && head.target.find('\t') == std::string::npos &&
         (head.old || line == "HTTP/1.1");
}

/// Reads "Name: value" and refuses any other form, such as a space before the colon or a line that continues the
/// previous one.
bool readField(std::string_view line, HttpHead& head) {
  if (line.find(':') == line.npos) return false;
  const std::string_view name = takeUpTo(":", line);
  if (!isToken(name)) return false;
  head.fields.emplace_back(lowerCase(name), trimmed(line));
  return true;
}

}  // namespace

std::size_t HttpHead::count(std::string_view name) const {
  return static_cast<std::size_t>(
      std::count_if(fields.begin(), fields.end(), [&](const auto& field) { return field.first == name; }));
}

std::string_view HttpHead::value(std::string_view name) const {
  for (const auto& [other, value] : fields)
    if (other == name) return value;
  return {};
}

std::string HttpHead::path() const { return percentDecoded(std::string_view(target).substr(0, target.find('?'))); }

std::string HttpHead::parameter(std::string_view name) const {
  std::string_view query = target;
  takeUpTo("?", query);
  while (!query.empty()) {
    std::string value(takeUpTo("&", query));
    std::replace(value.begin(), value.end(), '+', ' ');  // forms encode a space as a plus sign
    std::string_view rest = value;
    if (percentDecoded(takeUpTo("=", rest)) == name) return percentDecoded(rest);
  }
  return {};
}

bool HttpHead::persists() const {
  if (old) return false;
  return std::none_of(fields.begin(), fields.end(), [](const auto& field) {
    return field.first == "connection" && lowerCase(field.second).find("close") != std::string::npos;
  });
}

std::optional<HttpHead> parsedHead(std::string_view bytes) {
  if (!bytes.ends_with("\r\n\r\n")) return std::nullopt;
  HttpHead head;
  for (bool first = true;; first = false) {
    const std::string_view line = takeUpTo("\r\n", bytes);
    if (!std::all_of(line.begin(), line.end(), isText)) return std::nullopt;
    if (!first && line.empty()) break;
    if (first ? !readRequestLine(line, head) : !readField(line, head)) return std::nullopt;
  }
  if (!bytes.empty()) return std::nullopt;
  return head;
}

}  // namespace vdbtools::explore
