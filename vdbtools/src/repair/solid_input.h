// SPDX-License-Identifier: Apache-2.0
/// @file solid_input.h
/// From a file to signed distances, in the same way for every command that takes a shape.
#pragma once

#include "vdbtools/distance/mesh_to_sdf.h"
#include "vdbtools/distance/target.h"
#include "vdbtools/repair/mend_options.h"

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

namespace vdbtools {

/// Metadata of a file: the shape's box, six numbers, world units.
inline constexpr const char* kTargetBox = "julia_target_box";

std::string boxText(const openvdb::BBoxd& box);

double longestSide(const openvdb::BBoxd& box);

/// A mesh as it is made into distances.
struct SolidSource {
  /// The file's, or the one in memory; of a cloud of points as asPoints() has it. What is painted is painted on it.
  std::shared_ptr<const Mesh> mesh;
  std::shared_ptr<const Mesh> solid;  ///< the same, or the block that was made of it
  MeshReport report;                  ///< of the latter, but for its box
  openvdb::BBoxd box;                 ///< of the shape, with what thickening adds, world units
};

/// @param given  a mesh in memory, or nullptr to read @a path
/// @throw as readMesh(), readPoints() and solidified()
/// @throw DataError  a mesh in memory has no triangle, a coordinate that is not finite, or an index out of range; or
///                   the shape has no extent to measure voxels by
SolidSource openSolid(const std::filesystem::path& path, const std::shared_ptr<const Mesh>& given,
                      const MendOptions& mend);

/// @throw std::invalid_argument  a plate or balls too thin for voxels of this size
void requireResolved(const MendOptions& mend, double voxelSize);

MeshToSdfOptions sdfBand(double voxelSize, double exteriorWidth, double interiorWidth);

struct MeshSdf {
  openvdb::FloatGrid::Ptr grid{};
  std::optional<double> moved{}, closedGap{};  ///< of a repair, world units
  std::size_t caps = 0;                        ///< holes that a repair capped
  std::size_t united = 0;                      ///< parts that run into each other, as of meshToSdf()
};

/// By meshToSdf() or repairedMeshToSdf(), of the mesh or of the surface at a distance from it.
MeshSdf makeSdf(const Mesh& solid, const MeshToSdfOptions& options, const MendOptions& mend, Monitor& monitor);

/// The same on a lattice centred on the target: its nodes sample the shape in the same way wherever the shape lies, so
/// the fractal is the same.
MeshSdf makeSdfAbout(const openvdb::Vec3d& middle, Mesh solid, const MeshToSdfOptions& options, const MendOptions& mend,
                     Monitor& monitor);

/// The numbers of the lattice of a grid of makeSdfAbout(), from which placeOnLattice() makes its transform again. A
/// file holds the copy of a transform, which is another one by a rounding.
std::string latticeText(const openvdb::FloatGrid& grid);
/// @throw DataError  @a text is none of latticeText()
void placeOnLattice(openvdb::FloatGrid& grid, const std::string& text);

/// The target that a VDB holds, its box from the metadata where they have it.
/// @throw as readVdb(), chooseFloatGrid() and makeTarget()
Target readVdbTarget(const std::filesystem::path& path, const std::string& grid);

}  // namespace vdbtools
