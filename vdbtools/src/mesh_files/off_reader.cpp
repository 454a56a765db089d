// SPDX-License-Identifier: Apache-2.0
#include "mesh/polygon.h"
#include "mesh_files/mesh_formats.h"
#include "mesh_files/text_scan.h"
#include "mesh_files/usable_points.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/files/file_bytes.h"

#include <cstdint>
#include <string>
#include <vector>

namespace vdbtools {
namespace {

struct Counts {
  long long points = 0, faces = 0;
};

/// OFF, or with the letters before it that announce colours, normals and texture coordinates.
bool isOffKeyword(std::string_view word) {
  return word.ends_with("OFF") && word.find_first_not_of("STCNOF") == std::string_view::npos;
}

Counts readCounts(const std::filesystem::path& path, LineScanner& lines) {
  auto line = lines.nextMeaningful();
  if (!line) throw DataError(path.string() + ": it holds nothing but comments; export the mesh again");
  WordScanner header(*line);
  const std::string_view keyword = header.next();
  if (!isOffKeyword(keyword)) {
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
  Counts counts;
  counts.points = lines.integer(word);
  counts.faces = lines.integer(header.next());  // a count of edges may follow, but is unreliable
  // The shortest vertex is "0 0 0" and the shortest face "3 0 1 2", each with its line end.
  const auto available = static_cast<long long>(lines.rest().size()) + 1;
  if (counts.points < 0 || counts.faces < 0 || counts.points > available / 6 || counts.faces > available / 8) {
    lines.fail("the header announces " + std::to_string(counts.points) + " points and " + std::to_string(counts.faces) +
               " faces, which do not fit the " + std::to_string(available - 1) +
               " bytes that follow; the file is damaged or truncated: export it again");
  }
  if (counts.points > std::int64_t{1} << 32) {
    lines.fail(std::to_string(counts.points) + " points are more than can be indexed; decimate the mesh");
  }
  return counts;
}

}  // namespace

bool beginsAsOff(std::string_view head, std::uintmax_t) {
  const std::filesystem::path noName;
  const auto line = LineScanner(noName, head).nextMeaningful();
  return line && isOffKeyword(WordScanner(*line).next());
}

Mesh readOff(const std::filesystem::path& path, std::string_view contents) {
  LineScanner lines(path, contents);
  const Counts counts = readCounts(path, lines);
  const auto nextLine = [&](const char* what, long long done, long long total) {
    const auto found = lines.nextMeaningful();
    if (!found) {
      lines.fail("the file ends after " + std::to_string(done) + " of " + std::to_string(total) + " " + what +
                 "; it is truncated: export it again");
    }
    return *found;
  };
  Mesh mesh;
  mesh.points.reserve(static_cast<std::size_t>(counts.points));
  for (long long p = 0; p < counts.points; ++p) {
    WordScanner words(nextLine("points", p, counts.points));
    mesh.points.push_back(lines.point(words));  // normals and colours may follow
  }
  std::vector<std::uint32_t> face;
  for (long long f = 0; f < counts.faces; ++f) {
    WordScanner words(nextLine("faces", f, counts.faces));
    const long long corners = lines.integer(words.next());
    if (corners < 3) lines.fail("a face of " + std::to_string(corners) + " corners; export the mesh again");
    face.clear();
    for (long long c = 0; c < corners; ++c) {
      const long long index = lines.integer(words.next());
      if (index < 0 || index >= counts.points) {
        lines.fail("a face refers to point " + std::to_string(index) + ", but the points are 0 to " +
                   std::to_string(counts.points - 1) + "; export the mesh again");
      }
      face.push_back(static_cast<std::uint32_t>(index));
    }
    triangulatePolygon(face, mesh.points, mesh.triangles);
  }
  leaveOutUnusable(path, mesh);
  return mesh;
}

}  // namespace vdbtools
