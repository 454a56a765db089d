// SPDX-License-Identifier: Apache-2.0
/// @file solid_input.h
/// From a file to signed distances, as every command that takes a shape does it.
#pragma once

#include "vdbtools/target/exponent_grid.h"
#include "vdbtools/target/mesh_to_sdf.h"

#include <filesystem>
#include <optional>
#include <string>

namespace vdbtools {

/// Metadata of a file: the shape's box, six numbers, world units.
inline constexpr const char* kTargetBox = "julia_target_box";

double longestSide(const openvdb::BBoxd& box);

/// The report of a mesh that has an extent to measure voxels by.
/// @throw DataError  it has none
MeshReport reportOfSolid(const Mesh& mesh, const std::filesystem::path& path);

MeshToSdfOptions sdfBand(double voxelSize, double exteriorWidth, double interiorWidth);

struct MeshSdf {
  openvdb::FloatGrid::Ptr grid;
  std::optional<double> moved, closedGap;  ///< of a repair, world units
};

/// By meshToSdf(), or repairedMeshToSdf() if @a repair.
MeshSdf makeSdf(const Mesh& mesh, const MeshToSdfOptions& options, bool repair, double gap, Monitor& monitor);

/// The same on a lattice about the target's own middle: wherever it lies, the nodes sample it alike, and the fractal is
/// the same.
MeshSdf makeSdfAbout(const openvdb::Vec3d& middle, Mesh mesh, const MeshToSdfOptions& options, bool repair, double gap,
                     Monitor& monitor);

/// The target that a VDB holds, its box from the metadata where they have it.
/// @throw as readVdb(), chooseFloatGrid() and makeTarget()
Target readVdbTarget(const std::filesystem::path& path, const std::string& grid);

}  // namespace vdbtools
