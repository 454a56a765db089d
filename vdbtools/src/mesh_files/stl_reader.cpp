// SPDX-License-Identifier: Apache-2.0
#include "base/from_chars.h"
#include "mesh_files/mesh_formats.h"
#include "mesh_files/text_scan.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/base/text.h"
#include "vdbtools/files/file_bytes.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <string>

namespace vdbtools {
namespace {

constexpr std::size_t kHeaderSize = 84;  ///< 80 arbitrary bytes and a 32-bit count
constexpr std::size_t kFacetSize = 50;   ///< normal, three corners, and two unused bytes

std::uint32_t readUint32(std::string_view bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 4; i-- > 0;) value = (value << 8) | static_cast<unsigned char>(bytes[at + i]);
  return value;
}

/// The limit for triangles that share no point, with 32-bit indices.
constexpr std::size_t kMostFacets = std::numeric_limits<std::uint32_t>::max() / 3;

std::string tooManyFacets() {
  return "it has more than " + std::to_string(kMostFacets) + " triangles, which cannot be indexed; decimate the mesh";
}

/// Adds the triangle of the last three points.
void addLastTriangle(Mesh& mesh) {
  const auto first = static_cast<std::uint32_t>(mesh.points.size() - 3);
  mesh.triangles.emplace_back(first, first + 1, first + 2);
}

bool beginsAsText(std::string_view contents) {
  const std::string_view text = withoutByteOrderMark(contents);
  const std::size_t begin = text.find_first_not_of(" \t\r\n");
  return begin != std::string_view::npos && lowerCase(text.substr(begin, 5)) == "solid";
}

/// Whether a binary file of that size has the triangles that its head announces. Some programs pad the end, but a whole
/// additional facet is not padding.
bool fitsFacets(std::size_t facets, std::uintmax_t size) {
  const std::uintmax_t length = kHeaderSize + std::uintmax_t{facets} * kFacetSize;
  return size >= length && size < length + kFacetSize;
}

/// Whether the file is binary. Binary STL may begin with the word that marks the text form, and in practice it does, so
/// the length decides.
bool isBinary(std::string_view contents) {
  if (contents.size() >= kHeaderSize &&
      contents.size() == kHeaderSize + std::size_t{readUint32(contents, 80)} * kFacetSize) {
    return true;
  }
  return !beginsAsText(contents) || contents.find('\0') != std::string_view::npos;
}

Mesh readBinary(const std::filesystem::path& path, std::string_view contents) {
  const auto fail = [&path](const std::string& what) { throw DataError(path.string() + ": " + what); };
  if (contents.size() < kHeaderSize) {
    fail(
        "this is neither a text STL, which begins with 'solid', nor a binary one, which has at least 84 bytes; it "
        "has " +
        std::to_string(contents.size()) + " bytes: the file is damaged or truncated; export it again");
  }
  const std::size_t facets = readUint32(contents, 80);
  const std::size_t length = kHeaderSize + facets * kFacetSize;
  if (!fitsFacets(facets, contents.size())) {
    fail("the header announces " + std::to_string(facets) + " triangles, which take " + std::to_string(length) +
         " bytes, but the file has " + std::to_string(contents.size()) +
         "; it is damaged or truncated: export it again");
  }
  if (facets > kMostFacets) fail(tooManyFacets());
  Mesh mesh;
  mesh.points.reserve(3 * facets);
  mesh.triangles.reserve(facets);
  for (std::size_t f = 0; f < facets; ++f) {
    for (std::size_t corner = 0; corner < 3; ++corner) {
      openvdb::Vec3d point;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::size_t at = kHeaderSize + f * kFacetSize + 4 * (3 + 3 * corner + axis);  // past the normal
        const auto value = std::bit_cast<float>(readUint32(contents, at));
        if (!std::isfinite(value)) {
          fail("triangle " + std::to_string(f) + " has the coordinate " + std::to_string(value) +
               "; repair the mesh and export it again");
        }
        point[static_cast<int>(axis)] = double{value};
      }
      mesh.points.push_back(point);
    }
    addLastTriangle(mesh);
  }
  return mesh;
}

/// A coordinate of a text STL, rounded to the single precision of the format.
float singleOf(const LineScanner& lines, std::string_view word) {
  if (std::abs(lines.number(word)) > double{std::numeric_limits<float>::max()}) {
    lines.fail("the coordinate " + shown(word) +
               " is too large for STL's single precision; scale the mesh down or export it as PLY");
  }
  // Parsed directly from the text; converting the checked double would round twice.
  if (word.starts_with('+')) word.remove_prefix(1);
  float value = 0;
  const auto [end, error] = fromChars(word.data(), word.data() + word.size(), value);
  return error == std::errc() ? value : std::strtof(std::string(word).c_str(), nullptr);
}

Mesh readText(const std::filesystem::path& path, std::string_view contents) {
  Mesh mesh;
  LineScanner lines(path, contents);
  bool inSolid = false;
  int corners = -1;  // of the facet's loop; -1 outside one
  while (const auto line = lines.next()) {
    WordScanner words(*line);
    for (std::string word = lowerCase(words.next()); !word.empty(); word = lowerCase(words.next())) {
      if (word == "solid" || word == "endsolid") {  // a name of any words follows
        if (corners >= 0 || inSolid == (word == "solid")) {
          lines.fail("'" + word + "' in the midst of a solid or a triangle; the file is damaged: export it again");
        }
        inSolid = word == "solid";
        break;
      }
      if (word == "outer") {
        if (corners > 0) lines.fail("a triangle begins within another; the file is damaged: export it again");
        corners = 0;
      } else if (word == "vertex") {
        if (corners < 0 || corners > 2) lines.fail("a corner that belongs to no triangle; export the mesh again");
        ++corners;
        openvdb::Vec3d point;
        for (int axis = 0; axis < 3; ++axis) point[axis] = double{singleOf(lines, words.next())};
        mesh.points.push_back(point);
      } else if (word == "endloop") {
        if (corners != 3) {
          lines.fail("a triangle of " + std::to_string(std::max(corners, 0)) +
                     " corners; the file is damaged or truncated: export it again");
        }
        corners = -1;
        if (mesh.triangles.size() == kMostFacets) lines.fail(tooManyFacets());
        addLastTriangle(mesh);
      }
      // 'facet normal x y z', 'loop' and 'endfacet' are skipped word by word.
    }
  }
  if (inSolid || corners >= 0) lines.fail("the file ends before 'endsolid'; it is truncated: export it again");
  return mesh;
}

}  // namespace

bool beginsAsStl(std::string_view head, std::uintmax_t size) {
  return (head.size() >= kHeaderSize && fitsFacets(readUint32(head, 80), size)) || beginsAsText(head);
}

Mesh readStl(const std::filesystem::path& path, std::string_view contents) {
  return isBinary(contents) ? readBinary(path, contents) : readText(path, contents);
}

}  // namespace vdbtools
