// SPDX-License-Identifier: Apache-2.0
#include "mesh_files/mesh_comments.h"

#include "mesh_files/mesh_encoder.h"
#include "vdbtools/base/length_unit.h"
#include "vdbtools/base/utf8.h"

namespace vdbtools {
namespace {

/// The unit in the title of an STL, which ends with the first zero.
std::map<std::string, std::string> stlUnit(std::istream& stream) {
  constexpr std::size_t kTitle = 80;
  std::string title(kTitle, '\0');
  stream.read(title.data(), kTitle);
  if (!title.starts_with(kStlUnit)) return {};
  return {{kLengthUnit, title.substr(kStlUnit.size(), title.find('\0') - kStlUnit.size())}};
}

}  // namespace

std::map<std::string, std::string> readMeshComments(std::istream& stream, const std::string& extension) {
  std::map<std::string, std::string> comments;
  if (extension == ".stl") return stlUnit(stream);
  if (extension != ".ply" && extension != ".obj") return comments;
  const std::string prefix = (extension == ".ply" ? "comment " : "# ") + std::string(kCommentMark);
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
