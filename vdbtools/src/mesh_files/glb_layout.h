// SPDX-License-Identifier: Apache-2.0
/// @file glb_layout.h
/// The layout of a GLB, the binary form of glTF 2.0 (Khronos Group, 2017 to 2021): the head of the file, JSON that
/// describes one mesh, the head of the binary part; then the vertices, each with all that it has, and the triangles.
/// Levels of detail are further lists of triangles over the same vertices, as nodes of their own that the extension
/// MSFT_lod ties to the mesh's node. A reader without it shows the whole mesh.
///
/// The JSON stands first, but its numbers are known last. It is therefore padded with blanks to a length that does not
/// depend on them, so that a mesh can be written while it is made.
#pragma once

#include "vdbtools/mesh_files/mesh_writer.h"

#include <cstdint>
#include <string>
#include <vector>

namespace vdbtools {

/// The numbers of the JSON.
struct GlbContent {
  bool normals = false;
  std::uint64_t points = 0, triangles = 0;
  std::vector<MeshLevel> levels{};  ///< one for each of the options' levels
  openvdb::Vec3s low{0}, high{0};   ///< the box of the positions as they stand in the file
  /// What positions are relative to, world units: for an object far from the origin the middle of its box, which the
  /// node then adds.
  openvdb::Vec3d centre{0};
};

/// The bytes of a vertex.
std::size_t glbVertexSize(const MeshWriteOptions& options, bool normals);

/// All that stands before the vertices. Its length depends on the options and on whether there are normals.
std::string glbHeader(const GlbContent& content, const MeshWriteOptions& options);

/// @throw std::invalid_argument  the file would be larger than the 4 GiB that a GLB can be
void requireGlbSize(const GlbContent& content, const MeshWriteOptions& options);

/// @throw std::invalid_argument  more numbers a point than a vertex can have
void requireGlbColumns(const MeshWriteOptions& options);

/// Writes the values of a row at @a to. @return its end
char* putGlbRow(char* to, const float* row, const MeshWriteOptions& options);

}  // namespace vdbtools
