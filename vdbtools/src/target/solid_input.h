// SPDX-License-Identifier: Apache-2.0
/// @file solid_input.h
/// From a file to signed distances, in the same way for every command that takes a shape.
#pragma once

#include "vdbtools/target/exponent_grid.h"
#include "vdbtools/target/mesh_to_sdf.h"

#include <filesystem>
#include <optional>
#include <string>

namespace vdbtools {

/// Metadata of a file: the shape's box, six numbers, world units.
inline constexpr const char* kTargetBox = "julia_target_box";

std::string boxText(const openvdb::BBoxd& box);

double longestSide(const openvdb::BBoxd& box);

/// The report of a mesh.
/// @throw DataError  the mesh has no extent to measure voxels by
MeshReport reportOfSolid(const Mesh& mesh, const std::filesystem::path& path);

/// Of a mesh that no reader has checked; its indices are reportMesh()'s to check.
/// @throw DataError  it has no triangle, or a coordinate that is not finite
void requireUsable(const Mesh& mesh);

MeshToSdfOptions sdfBand(double voxelSize, double exteriorWidth, double interiorWidth);

struct MeshSdf {
  openvdb::FloatGrid::Ptr grid;
  std::optional<double> moved, closedGap;  ///< of a repair, world units
};

/// By meshToSdf(), or repairedMeshToSdf() if @a repair.
MeshSdf makeSdf(const Mesh& mesh, const MeshToSdfOptions& options, bool repair, double gap, Monitor& monitor);

/// The same on a lattice centred on the target: its nodes sample the shape in the same way wherever the shape lies, so
/// the fractal is the same.
MeshSdf makeSdfAbout(const openvdb::Vec3d& middle, Mesh mesh, const MeshToSdfOptions& options, bool repair, double gap,
                     Monitor& monitor);

/// The target that a VDB holds, its box from the metadata where they have it.
/// @throw as readVdb(), chooseFloatGrid() and makeTarget()
Target readVdbTarget(const std::filesystem::path& path, const std::string& grid);

}  // namespace vdbtools
