// SPDX-License-Identifier: Apache-2.0
#include "mesh_files/mesh_comments.h"

#include "vdbtools/base/text.h"

#include <algorithm>
#include <istream>

namespace vdbtools {
namespace {

constexpr const char* kCommentMark = "juliavdb ";

/// Keeps a comment in one line.
std::string oneLine(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');
  return text;
}

}  // namespace

std::string commentLines(const std::string& start, const FileTexts& texts) {
  std::string lines;
  for (const auto& [key, value] : texts)
    lines.append(start).append(kCommentMark).append(key + ' ' + oneLine(value) + '\n');
  return lines;
}

FileTexts readCommentLines(std::istream& stream, const std::string& start) {
  FileTexts comments;
  const std::string prefix = start + kCommentMark;
  bool first = true;
  for (std::string line; std::getline(stream, line);) {
    if (first) line = withoutByteOrderMark(line);
    first = false;
    // The comments are in the head of the file: magic and format precede them, and geometry follows.
    if (line.rfind(prefix, 0) == 0) {
      const std::size_t space = line.find(' ', prefix.size());
      if (space != std::string::npos)
        comments[line.substr(prefix.size(), space - prefix.size())] = line.substr(space + 1);
    } else if (line.rfind("ply", 0) != 0 && line.rfind("format", 0) != 0) {
      break;
    }
  }
  return comments;
}

}  // namespace vdbtools
