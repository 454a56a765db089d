// SPDX-License-Identifier: Apache-2.0
#include "mesh/format_readers.h"
#include "mesh/polygon.h"
#include "mesh/text_scan.h"
#include "vdbtools/base/errors.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <unordered_set>
#include <vector>

namespace vdbtools {
namespace {

/// The next line of OBJ, which a backslash at its end continues on the following one.
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

/// The point of a corner written as v, v/vt, v//vn or v/vt/vn, counted from 1.
long long pointOf(const LineScanner& lines, std::string_view word, std::size_t pointsSoFar) {
  if (word.find_first_not_of("0123456789+-/") != std::string_view::npos) {
    lines.fail("a face has the corner " + shown(word) + "; the file is damaged or truncated: export it again");
  }
  const long long index = lines.integer(word.substr(0, word.find('/')));
  if (index == 0) lines.fail("a face refers to point 0, but OBJ counts from 1; export the mesh again");
  if (index > 0) return index;
  const long long fromStart = static_cast<long long>(pointsSoFar) + index + 1;  // negative: back from here
  if (fromStart < 1) {
    lines.fail("a face refers to point " + shown(word) + ", which is before the first one; export the mesh again");
  }
  return fromStart;
}

/// Keeps the first of equal corners.
void dropRepetitions(std::vector<std::uint32_t>& corners) {
  std::vector<std::uint32_t> sorted(corners);
  std::sort(sorted.begin(), sorted.end());
  if (std::adjacent_find(sorted.begin(), sorted.end()) == sorted.end()) return;
  std::unordered_set<std::uint32_t> seen;
  std::erase_if(corners, [&seen](std::uint32_t corner) { return !seen.insert(corner).second; });
}

/// Statements that say nothing about the shape (normals, texture coordinates, groups, lines, materials) are skipped.
class ObjReader {
 public:
  ObjReader(const std::filesystem::path& path, std::string_view contents) : mPath(path), mLines(path, contents) {}

  Mesh read() {
    std::string joined;
    while (const auto line = nextObjLine(mLines, joined)) {
      WordScanner words(line->substr(0, line->find('#')));
      const std::string_view keyword = words.next();
      if (keyword == "v") mMesh.points.push_back(mLines.point(words));  // a weight or a colour may follow
      if (keyword == "f" || keyword == "fo") readFace(words);           // fo: the form of before 1995
    }
    // Faces may stand before their points, so this can be checked only here.
    requirePoints();
    mPolygons.triangulate(mMesh);
    return std::move(mMesh);
  }

 private:
  void readFace(WordScanner& words) {
    std::vector<std::uint32_t> corners;
    for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
      const long long index = pointOf(mLines, word, mMesh.points.size());
      if (index > mLargest) {
        mLargest = index;
        mLargestLine = mLines.lineNumber();
      }
      corners.push_back(static_cast<std::uint32_t>(index - 1));
    }
    if (corners.size() < 3) {
      mLines.fail("a face of " + std::to_string(corners.size()) +
                  " corners; the file is damaged or truncated: export it again");
    }
    dropRepetitions(corners);
    if (corners.size() >= 3) mPolygons.add(corners);
  }

  void requirePoints() const {
    if (mMesh.points.size() > std::numeric_limits<std::uint32_t>::max()) {
      throw DataError(mPath.string() + ": it has " + std::to_string(mMesh.points.size()) +
                      " points, which is more than can be indexed; decimate the mesh");
    }
    if (mLargest > static_cast<long long>(mMesh.points.size())) {
      throw DataError(mPath.string() + ", line " + std::to_string(mLargestLine) + ": a face refers to point " +
                      std::to_string(mLargest) + ", but there are only " + std::to_string(mMesh.points.size()) +
                      "; the file is damaged or truncated: export it again");
    }
  }

  const std::filesystem::path& mPath;
  LineScanner mLines;
  Mesh mMesh;
  Polygons mPolygons;
  long long mLargest = 0;  ///< of the points that faces refer to, counted from 1
  std::size_t mLargestLine = 0;
};

}  // namespace

Mesh readObj(const std::filesystem::path& path, std::string_view contents) { return ObjReader(path, contents).read(); }

}  // namespace vdbtools
