// SPDX-License-Identifier: Apache-2.0
/// @file glb_layout.h
/// The layout of a GLB, the binary form of glTF 2.0 (Khronos Group, 2017 to 2021): the head of the file, JSON that
/// describes one mesh, the head of the binary part; then the vertices, each with all its data, and the triangles.
/// Levels of detail are further lists of triangles over the same vertices, as separate nodes that the extension
/// MSFT_lod ties to the mesh's node. A reader without it shows the whole mesh.
///
/// The JSON comes first, but its numbers are known last. It is therefore padded with blanks to a length that does not
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
  openvdb::Vec3s low{0}, high{0};   ///< bounds of the positions as stored in the file
  /// The origin of the stored positions, world units: for an object far from the origin the middle of its box, which
  /// the node adds.
  openvdb::Vec3d centre{0};
};

/// The size of a vertex in bytes.
std::size_t glbVertexSize(const MeshWriteOptions& options, bool normals);

/// Everything that precedes the vertices. Its length depends on the options and on whether there are normals.
std::string glbHeader(const GlbContent& content, const MeshWriteOptions& options);

/// @throw std::invalid_argument  the file would exceed the 4 GiB limit of a GLB
void requireGlbSize(const GlbContent& content, const MeshWriteOptions& options);

/// @throw std::invalid_argument  more numbers per point than a vertex can have
void requireGlbColumns(const MeshWriteOptions& options);

/// Writes the values of a row at @a to. @return its end
char* putGlbRow(char* to, const float* row, const MeshWriteOptions& options);

}  // namespace vdbtools
