// SPDX-License-Identifier: Apache-2.0
/// @file mesh.h
/// The room `mesh` holds triangle meshes as values, and the interface through which a mesh is passed on in pieces
/// (mesh_sink.h). It uses the rooms `base` and `files`.
///
/// This header declares the indexed triangles that the project passes around, and a report on them.
/// Positions are in the mesh's own units, called world units. A closed mesh is oriented outward if its signed volume is
/// positive: seen from outside, corners run counter-clockwise.
#pragma once

#include <openvdb/Types.h>
#include <openvdb/math/BBox.h>

#include <cstdint>
#include <iosfwd>
#include <string>
#include <string_view>
#include <vector>

namespace vdbtools {

/// A number that a file gives for each point in addition to its position: a colour channel or anything else.
struct VertexAttribute {
  std::string name;
  std::vector<float> values;  ///< one value per point; may be not finite
};

/// The names of faces, each once, in the order in which faces first have it.
struct FaceNameList {
  std::vector<std::string> materials{};
  std::vector<std::string> groups{};  ///< also the names of objects
};

struct Mesh {
  std::vector<openvdb::Vec3d> points;     ///< world units
  std::vector<openvdb::Vec3I> triangles;  ///< indices into points
  std::vector<openvdb::Vec3s> normals{};  ///< unit length, one normal per point, or empty

  std::vector<VertexAttribute> attributes{};  ///< all names differ
  /// Texture coordinates: three for each triangle, one per corner, because the triangles at a point on a seam have
  /// different ones there. NaN at a corner without any; empty if the mesh has none.
  std::vector<openvdb::Vec2s> cornerUvs{};
  /// The points of its file that a reader left out, because their coordinates are not finite and no triangle uses them.
  std::uint64_t pointsLeftOut = 0;
  FaceNameList faceNames{};  ///< those of its file, which is an OBJ
};

/// Properties of a mesh. Edges are identified by the indices of their points, so in a soup whose triangles share no
/// points every edge is open.
struct MeshReport {
  std::uint64_t points = 0;
  std::uint64_t triangles = 0;
  std::uint64_t components = 0;        ///< triangles connected through shared points
  std::uint64_t openEdges = 0;         ///< used by one triangle
  std::uint64_t nonManifoldEdges = 0;  ///< used by more than two triangles
  std::uint64_t misorientedEdges = 0;  ///< used by two triangles in the same direction
  std::uint64_t degenerateFaces = 0;   ///< zero area: a repeated corner, or three collinear ones
  openvdb::BBoxd box;                  ///< bounds of the points that triangles use, world units
  double area = 0;                     ///< world units squared
  double volume = 0;                   ///< signed, world units cubed; meaningful only for a closed mesh

  bool closed() const { return openEdges == 0 && nonManifoldEdges == 0 && misorientedEdges == 0; }
};

/// @throw DataError  an index out of range
MeshReport reportMesh(const Mesh& mesh);

/// World units, of all points, also of those that no triangle uses; empty if there are none.
openvdb::BBoxd boundingBox(const Mesh& mesh);

/// Merges points of equal position (bit for bit, except that 0 equals -0) and drops the triangles that then repeat a
/// corner. The edges of a soup such as STL mean nothing before this. A merged point takes the place, normal and
/// attributes of its first occurrence; corners keep their texture coordinates.
/// @throw DataError  an index out of range
Mesh weldMesh(const Mesh& mesh);

}  // namespace vdbtools
