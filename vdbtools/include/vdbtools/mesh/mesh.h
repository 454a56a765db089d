// SPDX-License-Identifier: Apache-2.0
/// @file mesh.h
/// The room `mesh` reads, checks, writes and decimates triangle meshes. It uses the rooms `base` and `files`.
///
/// Here: the indexed triangles that the project passes around, a report on them, and reading them from a file.
/// Positions are in the mesh's own units, called world units. A closed mesh is oriented outward if its signed volume is
/// positive: seen from outside, corners run counter-clockwise.
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

/// What a file says of each point besides its place: a channel of its colour, or any other number.
struct VertexAttribute {
  std::string name;
  std::vector<float> values;  ///< one a point; perhaps not finite
};

struct Mesh {
  std::vector<openvdb::Vec3d> points;     ///< world units
  std::vector<openvdb::Vec3I> triangles;  ///< indices into points
  std::vector<openvdb::Vec3s> normals{};  ///< unit length, one a point, or empty

  std::vector<VertexAttribute> attributes{};  ///< of different names
  /// Texture coordinates: three for each triangle, one a corner, since the triangles at a point of a seam have
  /// different ones there. Not a number at a corner that has none. Empty: the mesh has none.
  std::vector<openvdb::Vec2s> cornerUvs{};
};

/// What is known about a mesh. Edges are identified by the indices of their points, so in a soup whose triangles share
/// no points every edge is open.
struct MeshReport {
  std::uint64_t points = 0;
  std::uint64_t triangles = 0;
  std::uint64_t components = 0;        ///< triangles connected through shared points
  std::uint64_t openEdges = 0;         ///< used by one triangle
  std::uint64_t nonManifoldEdges = 0;  ///< used by more than two triangles
  std::uint64_t misorientedEdges = 0;  ///< used by two triangles in the same direction
  std::uint64_t degenerateFaces = 0;   ///< without area: a repeated corner, or three in line
  openvdb::BBoxd box;                  ///< of the points that triangles use, world units
  double area = 0;                     ///< world units squared
  double volume = 0;                   ///< signed, world units cubed; meaningful only for a closed mesh

  bool closed() const { return openEdges == 0 && nonManifoldEdges == 0 && misorientedEdges == 0; }
};

/// @throw DataError  an index out of range
MeshReport reportMesh(const Mesh& mesh);

/// Reads OBJ, PLY, STL, OFF or glTF (.glb, .gltf), by the file's extension in any case. Polygons are split into
/// triangles: convex ones into fans, others by ear clipping. Normals are skipped; unused points are kept; STL and glTF
/// are welded. Coordinates are read in double precision, except those of STL and glTF, which are floats. In OBJ,
/// corners that a face repeats are dropped. Of glTF, all triangles of the default scene are joined, where their nodes
/// place them; skins, morph targets and materials are not looked at, and a .gltf may name buffers beside it only.
///
/// Attributes are, of PLY, all single numbers of the vertices but x, y, z, nx, ny, nz and texture coordinates; integers
/// that are channels of a colour (red, green, blue, alpha) are scaled to 0..1. Of OBJ, red, green and blue where they
/// follow the three coordinates (and 1 at points without, if others have them). Texture coordinates are those of OBJ's
/// corners, of PLY's vertices where they have s and t, u and v, or texture_u and texture_v, and the first ones of glTF,
/// turned so that v counts from the bottom. Of glTF, COLOR_0 gives red, green, blue and perhaps alpha as they are,
/// which is linear light, and _NAME the attribute NAME, or NAME_x, NAME_y and so on.
/// @throw MissingInputError  there is no such file, it is not an ordinary file, or it may not be opened
/// @throw IoError            reading broke off
/// @throw DataError          unknown format, empty, truncated, counts that do not fit the file, an index out of range,
///                           coordinates that are not finite, no triangle
Mesh readMesh(const std::filesystem::path& path);

/// Merges points of equal position (bit for bit, except that 0 equals -0) and drops the triangles that then repeat a
/// corner. A soup such as STL needs this before its edges mean anything. Points keep the order of their first
/// occurrence, and its normal and attributes; corners keep their texture coordinates.
/// @throw DataError  an index out of range
Mesh weldMesh(const Mesh& mesh);

}  // namespace vdbtools
