// SPDX-License-Identifier: Apache-2.0
#include "mesh/polygon.h"
#include "mesh_files/face_names.h"
#include "mesh_files/mesh_formats.h"
#include "mesh_files/text_scan.h"
#include "mesh_files/usable_points.h"
#include "vdbtools/base/errors.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace vdbtools {
namespace {

/// Returns the next line of OBJ; a backslash at the end of a line continues it on the next one.
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

/// The index of a corner, counted from 1.
/// @param word  the whole corner, for the error message
/// @param what  the kind of index, likewise
long long indexOf(const LineScanner& lines, std::string_view number, std::string_view word, const char* what,
                  std::size_t countSoFar) {
  const long long index = lines.integer(number);
  if (index == 0) {
    lines.fail("a face refers to " + std::string(what) + " 0, but OBJ counts from 1; export the mesh again");
  }
  if (index > 0) return index;
  const long long fromStart = static_cast<long long>(countSoFar) + index + 1;  // negative: relative to the end
  if (fromStart < 1) {
    lines.fail("a face refers to " + std::string(what) + " " + shown(word) +
               ", which is before the first one; export the mesh again");
  }
  return fromStart;
}

/// A corner's point and texture coordinate, counted from 1; the latter is 0 if there is none.
struct Corner {
  long long point = 0, uv = 0;
};

/// A corner written as v, v/vt, v//vn or v/vt/vn.
Corner cornerOf(const LineScanner& lines, std::string_view word, std::size_t pointsSoFar, std::size_t uvsSoFar) {
  if (word.find_first_not_of("0123456789+-/") != std::string_view::npos) {
    lines.fail("a face has the corner " + shown(word) + "; the file is damaged or truncated: export it again");
  }
  const std::size_t slash = word.find('/');
  Corner corner{.point = indexOf(lines, word.substr(0, slash), word, "point", pointsSoFar)};
  if (slash == std::string_view::npos) return corner;
  std::string_view uv = word.substr(slash + 1);
  uv = uv.substr(0, uv.find('/'));
  if (!uv.empty()) corner.uv = indexOf(lines, uv, word, "texture coordinate", uvsSoFar);
  return corner;
}

/// Keeps the first of the corners at equal points.
/// @param uvs  one per corner, or empty
void dropRepetitions(std::vector<std::uint32_t>& corners, std::vector<std::uint32_t>& uvs) {
  std::vector<std::uint32_t> sorted(corners);
  std::sort(sorted.begin(), sorted.end());
  if (std::adjacent_find(sorted.begin(), sorted.end()) == sorted.end()) return;
  std::set<std::uint32_t> seen;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (!seen.insert(corners[i]).second) continue;
    corners[kept] = corners[i];
    if (!uvs.empty()) uvs[kept] = uvs[i];
    ++kept;
  }
  corners.resize(kept);
  if (!uvs.empty()) uvs.resize(kept);
}

/// Statements that say nothing about the surface (normals, lines) are skipped.
class ObjReader {
 public:
  ObjReader(const std::filesystem::path& path, std::string_view contents) : mPath(path), mLines(path, contents) {}

  Mesh read() {
    std::string joined;
    while (const auto line = nextObjLine(mLines, joined)) {
      WordScanner words(line->substr(0, line->find('#')));
      const std::string_view keyword = words.next();
      if (keyword == "v") readPoint(words);
      if (keyword == "vt") readUv(words);
      if (keyword == "f" || keyword == "fo") readFace(words);  // fo: the obsolete form from before 1995
      if (keyword == "usemtl") mNames.setMaterial(words.next());
      if (keyword == "g" || keyword == "o") mNames.setGroup(words.next());
      if (keyword == "mtllib") mNames.addLibrary(line->substr(line->find("mtllib") + keyword.size()));
    }
    // Faces may precede their points, so this can be checked only here.
    requirePoints();
    requireUvs();
    for (VertexAttribute& channel : mMesh.attributes) channel.values.resize(mMesh.points.size(), kNoColour);
    mNames.addAttributes(mPath, mPolygons, mMesh);
    mMesh.faceNames = mNames.list();
    mPolygons.triangulate(mMesh, mUvs);
    constexpr std::uint64_t kFirst = 1;
    leaveOutUnusable(mPath, mMesh, kFirst);
    return std::move(mMesh);
  }

 private:
  static constexpr float kNoColour = 1;  ///< white, which colours are multiplied by

  struct Largest {
    long long index = 0;   ///< counted from 1
    std::size_t line = 0;  ///< line number
    void meet(long long met, const LineScanner& lines) {
      if (met > index) *this = {met, lines.lineNumber()};
    }
  };

  /// Reads three coordinates; a weight, or the three channels of a colour, may follow.
  void readPoint(WordScanner& words) {
    mMesh.points.push_back(mLines.point(words));
    const std::string_view first = words.next();
    if (first.empty()) return;
    const std::string_view second = words.next(), third = words.next();
    if (third.empty() || !words.next().empty()) return;
    const float colour[3] = {static_cast<float>(mLines.number(first)), static_cast<float>(mLines.number(second)),
                             static_cast<float>(mLines.number(third))};
    if (mMesh.attributes.empty()) mMesh.attributes = {{"red", {}}, {"green", {}}, {"blue", {}}};
    for (std::size_t channel = 0; channel < 3; ++channel) {
      std::vector<float>& values = mMesh.attributes[channel].values;
      values.resize(mMesh.points.size() - 1, kNoColour);
      values.push_back(colour[channel]);
    }
  }

  /// Reads u and v, of which v is optional; a depth may follow.
  void readUv(WordScanner& words) {
    const double u = mLines.number(words.next());
    const std::string_view second = words.next();
    const double v = second.empty() ? 0 : mLines.number(second);
    mUvs.emplace_back(static_cast<float>(u), static_cast<float>(v));
  }

  void readFace(WordScanner& words) {
    std::vector<std::uint32_t> corners, uvs;
    for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
      const Corner corner = cornerOf(mLines, word, mMesh.points.size(), mUvs.size());
      mLargestPoint.meet(corner.point, mLines);
      mLargestUv.meet(corner.uv, mLines);
      corners.push_back(static_cast<std::uint32_t>(corner.point - 1));
      if (corner.uv > 0) {
        uvs.resize(corners.size() - 1, Polygons::kNoUv);
        uvs.push_back(static_cast<std::uint32_t>(corner.uv - 1));
      }
    }
    if (corners.size() < 3) {
      mLines.fail("a face of " + std::to_string(corners.size()) +
                  " corners; the file is damaged or truncated: export it again");
    }
    if (!uvs.empty()) uvs.resize(corners.size(), Polygons::kNoUv);
    dropRepetitions(corners, uvs);
    if (corners.size() < 3) return;
    mNames.addFace();
    if (uvs.empty())
      mPolygons.add(corners);
    else
      mPolygons.add(corners, uvs);
  }

  [[noreturn]] void refuse(const Largest& largest, const char* what, std::size_t count) const {
    throw DataError(mPath.string() + ", line " + std::to_string(largest.line) + ": a face refers to " + what + " " +
                    std::to_string(largest.index) + ", but there are only " + std::to_string(count) +
                    "; the file is damaged or truncated: export it again");
  }

  void requirePoints() const {
    if (mMesh.points.size() > std::numeric_limits<std::uint32_t>::max()) {
      throw DataError(mPath.string() + ": it has " + std::to_string(mMesh.points.size()) +
                      " points, which is more than can be indexed; decimate the mesh");
    }
    if (mLargestPoint.index > static_cast<long long>(mMesh.points.size()))
      refuse(mLargestPoint, "point", mMesh.points.size());
  }

  void requireUvs() const {
    if (mUvs.empty()) return;  // faces of some exporters refer to coordinates that were never written
    if (mLargestUv.index > static_cast<long long>(mUvs.size())) refuse(mLargestUv, "texture coordinate", mUvs.size());
  }

  const std::filesystem::path& mPath;
  LineScanner mLines;
  Mesh mMesh;
  Polygons mPolygons;
  FaceNames mNames;
  std::vector<openvdb::Vec2s> mUvs;
  Largest mLargestPoint, mLargestUv;  ///< largest indices to which faces refer
};

}  // namespace

Mesh readObj(const std::filesystem::path& path, std::string_view contents) { return ObjReader(path, contents).read(); }

}  // namespace vdbtools
