// SPDX-License-Identifier: Apache-2.0
/// @file mesh_writer.h
/// Meshes out: binary little-endian PLY, OBJ, binary STL. Positions are 32-bit floats, but doubles in a PLY whose
/// vertices floats would move by more than 1/1000 of a voxel (a small object far from the origin).
#pragma once

#include "vdbtools/mesh.h"

#include <filesystem>
#include <iosfwd>
#include <map>
#include <string>

namespace vdbtools {

enum class MeshFormat { Ply, Obj, Stl };

/// By extension, in any case. @throw std::invalid_argument for any but .ply, .obj, .stl
MeshFormat meshFormat(const std::filesystem::path& path);

struct MeshWriteOptions {
  MeshFormat format = MeshFormat::Ply;
  double voxelSize = 0;  ///< world units; how exact positions must be. 0: floats will do
  /// Comment lines, "juliavdb KEY VALUE", in PLY and OBJ: the recipe.
  std::map<std::string, std::string> comments;
};

/// Normals are written where the mesh has them (STL has its own, of the faces).
/// @throw std::invalid_argument  an STL of more triangles than it can count
void writeMesh(std::ostream& stream, const Mesh& mesh, const MeshWriteOptions& options);

/// The comments of a PLY or OBJ that writeMesh() wrote; none from any other file.
/// @throw MissingInputError, IoError
std::map<std::string, std::string> readMeshComments(const std::filesystem::path& path);

}  // namespace vdbtools
