// SPDX-License-Identifier: Apache-2.0
/// @file mesh.h
/// Triangle meshes: the indexed soup that the project passes around, what can be said about one, and reading one.
/// Positions are in the mesh's own units, called world units. A closed mesh is oriented outward when its signed volume
/// is positive: seen from outside, corners run counter-clockwise.
#pragma once

#include <openvdb/Types.h>
#include <openvdb/math/BBox.h>

#include <cstdint>
#include <filesystem>
#include <iosfwd>
#include <string>
#include <string_view>
#include <vector>

namespace vdbtools {

struct Mesh {
  std::vector<openvdb::Vec3d> points;     ///< world units
  std::vector<openvdb::Vec3I> triangles;  ///< indices into points
  std::vector<openvdb::Vec3s> normals;    ///< unit length, one a point, or empty
};

/// What is known of a mesh. Edges are told apart by point index, so a soup of unshared points is all open edges.
struct MeshReport {
  std::uint64_t points = 0;
  std::uint64_t triangles = 0;
  std::uint64_t components = 0;        ///< triangles connected through shared points
  std::uint64_t openEdges = 0;         ///< used by one triangle
  std::uint64_t nonManifoldEdges = 0;  ///< used by more than two triangles
  std::uint64_t misorientedEdges = 0;  ///< used by two triangles in the same direction
  std::uint64_t degenerateFaces = 0;   ///< no area: a repeated corner, or three in line
  openvdb::BBoxd box;                  ///< of the points that triangles use, world units
  double area = 0;                     ///< world units squared
  double volume = 0;                   ///< signed, world units cubed; means something for a closed mesh only

  bool closed() const { return openEdges == 0 && nonManifoldEdges == 0 && misorientedEdges == 0; }
};

/// @throw DataError  an index out of range
MeshReport reportMesh(const Mesh& mesh);

/// Reads OBJ, PLY, STL or OFF, by the file's extension. Polygons are split into triangles: convex ones into fans,
/// others ear by ear. Normals, colours and texture coordinates are skipped; unused points are kept; STL is welded.
/// Coordinates are read in double precision, except STL's. A face that repeats a corner loses the repetition in OBJ.
/// @throw MissingInputError  no such file, or not readable
/// @throw DataError          unknown format, empty, truncated, counts that do not fit the file, an index out of range,
///                           coordinates that are not finite, no triangle
Mesh readMesh(const std::filesystem::path& path);

/// Merges points of equal position (bit for bit, but 0 is -0) and drops triangles that repeat a corner thereby: what a
/// soup such as STL needs before its edges mean anything. The order of first occurrence is kept.
/// @throw DataError  an index out of range
Mesh weldMesh(const Mesh& mesh);

}  // namespace vdbtools
