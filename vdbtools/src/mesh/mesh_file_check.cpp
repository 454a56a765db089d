// SPDX-License-Identifier: Apache-2.0
#include "mesh/mesh_file_check.h"

#include "mesh/text_scan.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/files/file_bytes.h"

#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>

namespace vdbtools {
namespace {

/// Coordinates reach the mesh as doubles, past OpenMesh, whose text readers know floats only; it gets this in their
/// place.
constexpr std::string_view kPlaceholder = "0 0 0\n";

openvdb::Vec3d readPoint(const LineScanner& lines, WordScanner& words) {
  openvdb::Vec3d point;
  for (int c = 0; c < 3; ++c) point[c] = lines.number(words.next());
  return point;
}

/// A line of OBJ may go on after a backslash, which OpenMesh does not know.
std::optional<std::string_view> nextObjLine(LineScanner& lines, std::string& joined) {
  auto line = lines.next();
  if (!line) return line;
  const auto goesOn = [](std::string_view l) {
    const std::size_t last = l.find_last_not_of(" \t\r");
    return last != std::string_view::npos && l[last] == '\\';
  };
  if (!goesOn(*line)) return line;
  joined.clear();
  while (line && goesOn(*line)) {
    joined.append(line->substr(0, line->rfind('\\'))).push_back(' ');
    line = lines.next();
  }
  if (line) joined.append(*line);
  return joined;
}

/// The point of an OBJ corner, v, v/vt, v//vn or v/vt/vn, counted from 1.
long long objCorner(const LineScanner& lines, std::string_view word, std::size_t pointsSoFar) {
  if (word.find_first_not_of("0123456789+-/") != std::string_view::npos) {
    lines.fail("a face has the corner " + shown(word) + "; the file is damaged or truncated: export it again");
  }
  const long long index = lines.integer(word.substr(0, word.find('/')));
  if (index == 0) lines.fail("a face refers to point 0, but OBJ counts from 1; export the mesh again");
  return index > 0 ? index : static_cast<long long>(pointsSoFar) + index + 1;  // negative: back from here
}

std::uint32_t readUint32(std::string_view bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 4; i-- > 0;) value = (value << 8) | static_cast<unsigned char>(bytes[at + i]);
  return value;
}

}  // namespace

CheckedFile checkObj(const std::filesystem::path& path, std::string_view contents) {
  CheckedFile result;
  LineScanner lines(path, contents);
  std::string joined;
  long long largest = 0;
  std::size_t largestLine = 0;
  while (const auto line = nextObjLine(lines, joined)) {
    WordScanner words(line->substr(0, line->find('#')));
    const std::string_view keyword = words.next();
    if (keyword == "v") {
      result.points.push_back(readPoint(lines, words));
      result.text.append("v ").append(kPlaceholder);
    } else if (keyword == "f" || keyword == "fo") {  // fo: the form of before 1995
      result.text += 'f';
      int corners = 0;
      for (std::string_view word = words.next(); !word.empty(); word = words.next(), ++corners) {
        const long long index = objCorner(lines, word, result.points.size());
        if (index < 1) {
          lines.fail("a face refers to point " + shown(word) +
                     ", which is before the first one; export the mesh again");
        }
        if (index > largest) {
          largest = index;
          largestLine = lines.lineNumber();
        }
        result.text.append(" ").append(std::to_string(index));
      }
      if (corners < 3) {
        lines.fail("a face of " + std::to_string(corners) +
                   " corners; the file is damaged or truncated: export it again");
      }
      result.text += '\n';
    }
    // All else (normals, texture coordinates, groups, lines, materials) is left out: it says nothing about the shape,
    // and 'mtllib' would make the reader open any file of that name.
  }
  if (largest > static_cast<long long>(result.points.size())) {
    throw DataError(path.string() + ", line " + std::to_string(largestLine) + ": a face refers to point " +
                    std::to_string(largest) + ", but there are only " + std::to_string(result.points.size()) +
                    "; the file is damaged or truncated: export it again");
  }
  return result;
}

CheckedFile checkOff(const std::filesystem::path& path, std::string_view contents) {
  CheckedFile result;
  LineScanner lines(path, contents);
  auto line = lines.nextMeaningful();
  if (!line) throw DataError(path.string() + ": there is nothing in it but comments; export the mesh again");
  WordScanner header(*line);
  std::string_view keyword = header.next();
  if (!keyword.ends_with("OFF") || keyword.find_first_not_of("STCNOF") != std::string_view::npos) {
    lines.fail("the file begins with " + shown(keyword) +
               " and not with OFF, COFF, NOFF or STOFF; export the mesh as OBJ, PLY or STL");
  }
  std::string_view word = header.next();
  if (lowerCase(word) == "binary") lines.fail("binary OFF is not read; export the mesh as text OFF, or as PLY");
  if (word.empty()) {
    line = lines.nextMeaningful();
    if (!line) lines.fail("the file ends before its counts; it is truncated: export it again");
    header = WordScanner(*line);
    word = header.next();
  }
  const long long points = lines.integer(word);
  const long long faces = lines.integer(header.next());  // a count of edges may follow; nobody relies on it
  // The shortest vertex is "0 0 0" and the shortest face "3 0 1 2", each with its line's end.
  const auto available = static_cast<long long>(lines.rest().size()) + 1;
  if (points < 0 || faces < 0 || points > available / 6 || faces > available / 8) {
    lines.fail("the header announces " + std::to_string(points) + " points and " + std::to_string(faces) +
               " faces, which do not fit the " + std::to_string(available - 1) +
               " bytes that follow; the file is damaged or truncated: export it again");
  }
  const auto nextLine = [&](const char* what, long long done, long long total) {
    const auto found = lines.nextMeaningful();
    if (!found) {
      lines.fail("the file ends after " + std::to_string(done) + " of " + std::to_string(total) + " " + what +
                 "; it is truncated: export it again");
    }
    return *found;
  };
  result.text = "OFF\n" + std::to_string(points) + " " + std::to_string(faces) + " 0\n";
  for (long long p = 0; p < points; ++p) {
    WordScanner words(nextLine("points", p, points));
    result.points.push_back(readPoint(lines, words));  // normals and colours may follow
    result.text.append(kPlaceholder);
  }
  for (long long f = 0; f < faces; ++f) {
    WordScanner words(nextLine("faces", f, faces));
    const long long corners = lines.integer(words.next());
    if (corners < 3) lines.fail("a face of " + std::to_string(corners) + " corners; export the mesh again");
    result.text.append(std::to_string(corners));
    for (long long c = 0; c < corners; ++c) {
      const long long index = lines.integer(words.next());
      if (index < 0 || index >= points) {
        lines.fail("a face refers to point " + std::to_string(index) + ", but the points are 0 to " +
                   std::to_string(points - 1) + "; export the mesh again");
      }
      result.text.append(" ").append(std::to_string(index));
    }
    result.text += '\n';
  }
  return result;
}

namespace {

constexpr std::size_t kStlHeader = 84;  ///< 80 bytes of anything and a 32-bit count
constexpr std::size_t kStlFacet = 50;   ///< normal, three corners, and two bytes that mean nothing

/// Binary STL may begin with the word that marks the text form, and does so in practice; its length tells it.
bool isBinaryStl(std::string_view contents) {
  if (contents.size() >= kStlHeader &&
      contents.size() == kStlHeader + std::size_t{readUint32(contents, 80)} * kStlFacet) {
    return true;
  }
  const std::size_t begin = contents.find_first_not_of(" \t\r\n");
  const bool solid = begin != std::string_view::npos && lowerCase(contents.substr(begin, 5)) == "solid";
  return !solid || contents.find('\0') != std::string_view::npos;
}

CheckedFile checkBinaryStl(const std::filesystem::path& path, std::string_view contents) {
  const auto fail = [&path](const std::string& what) { throw DataError(path.string() + ": " + what); };
  if (contents.size() < kStlHeader) {
    fail("this is neither a text STL, which begins with 'solid', nor a binary one, which has 84 bytes and more, but " +
         std::to_string(contents.size()) + " bytes; the file is damaged or truncated: export it again");
  }
  const std::size_t facets = readUint32(contents, 80);
  const std::size_t length = kStlHeader + facets * kStlFacet;
  // Some programs pad the end; a whole facet more than announced is no padding.
  if (contents.size() < length || contents.size() >= length + kStlFacet) {
    fail("the header announces " + std::to_string(facets) + " triangles, which take " + std::to_string(length) +
         " bytes, but the file has " + std::to_string(contents.size()) +
         "; it is damaged or truncated: export it again");
  }
  for (std::size_t f = 0; f < facets; ++f) {
    for (std::size_t i = 3; i < 12; ++i) {  // the corners; the normal does not matter
      const auto value = std::bit_cast<float>(readUint32(contents, kStlHeader + f * kStlFacet + 4 * i));
      if (!std::isfinite(value)) {
        fail("triangle " + std::to_string(f) + " has the coordinate " + std::to_string(value) +
             "; repair the mesh and export it again");
      }
    }
  }
  CheckedFile result;
  result.text = contents;
  result.binary = true;
  return result;
}

CheckedFile checkTextStl(const std::filesystem::path& path, std::string_view contents) {
  CheckedFile result;
  result.text = "solid\n";
  LineScanner lines(path, contents);
  bool inSolid = false;
  int corners = -1;  // of the facet's loop; -1 outside one
  while (const auto line = lines.next()) {
    WordScanner words(*line);
    for (std::string word = lowerCase(words.next()); !word.empty(); word = lowerCase(words.next())) {
      if (word == "solid" || word == "endsolid") {  // a name follows, of any words
        if (corners >= 0 || inSolid == (word == "solid")) {
          lines.fail("'" + word + "' in the midst of a solid or a triangle; the file is damaged: export it again");
        }
        inSolid = word == "solid";
        break;
      }
      if (word == "outer") {
        corners = 0;
        result.text.append("outer loop\n");
      } else if (word == "vertex") {
        if (corners < 0 || corners > 2) lines.fail("a corner that belongs to no triangle; export the mesh again");
        ++corners;
        result.text.append("vertex");
        for (int c = 0; c < 3; ++c) {
          const std::string_view coordinate = words.next();
          if (std::abs(lines.number(coordinate)) > double{std::numeric_limits<float>::max()}) {
            lines.fail("the coordinate " + shown(coordinate) +
                       " is too large for STL's single precision; scale the mesh down or export it as PLY");
          }
          result.text.append(" ").append(coordinate.substr(coordinate.starts_with('+') ? 1 : 0));
        }
        result.text += '\n';
      } else if (word == "endloop") {
        if (corners != 3) {
          lines.fail("a triangle of " + std::to_string(std::max(corners, 0)) +
                     " corners; the file is damaged or truncated: export it again");
        }
        corners = -1;
        result.text.append("endloop\n");
      }
      // 'facet normal x y z', 'loop' and 'endfacet' are passed over word by word.
    }
  }
  if (inSolid || corners >= 0) lines.fail("the file ends before 'endsolid'; it is truncated: export it again");
  result.text.append("endsolid\n");
  return result;
}

}  // namespace

CheckedFile checkStl(const std::filesystem::path& path, std::string_view contents) {
  return isBinaryStl(contents) ? checkBinaryStl(path, contents) : checkTextStl(path, contents);
}

}  // namespace vdbtools
