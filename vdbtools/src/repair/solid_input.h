// SPDX-License-Identifier: Apache-2.0
/// @file solid_input.h
/// Reads a file and computes signed distances, in the same way for every command that takes a shape.
#pragma once

#include "vdbtools/distance/mesh_to_sdf.h"
#include "vdbtools/distance/target.h"
#include "vdbtools/mesh_files/mesh_reader.h"
#include "vdbtools/repair/mend_options.h"

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

namespace vdbtools {

/// Metadata of a file: the shape's box, six numbers, world units.
inline constexpr const char* kTargetBox = "julia_target_box";
/// Metadata of a file, and a fact of a job: Mesh::pointsLeftOut of the target, if it is not 0.
inline constexpr const char* kPointsLeftOut = "julia_points_left_out";

std::string boxText(const openvdb::BBoxd& box);

/// A mesh in the form from which its distances are computed.
struct SolidSource {
  /// The mesh of the file, or the one in memory; a point cloud as converted by asPoints(). Painted attributes belong to
  /// it.
  std::shared_ptr<const Mesh> mesh;
  std::shared_ptr<const Mesh> solid;  ///< the same mesh, or the block made from it
  MeshReport report;                  ///< report on solid, except for its box
  openvdb::BBoxd box;                 ///< bounds of the shape, including what thickening adds, world units
};

/// @param given  a mesh in memory, or nullptr to read @a path
/// @throw as readMesh(), readPoints() and solidified()
/// @throw DataError  a mesh in memory has no triangle, a coordinate that is not finite, or an index out of range; or
///                   the shape has no extent from which a voxel size could follow
SolidSource openSolid(const std::filesystem::path& path, const std::shared_ptr<const Mesh>& given,
                      const MendOptions& mend);
/// The same at a moment of an animation.
SolidSource openSolid(const std::filesystem::path& path, const std::shared_ptr<const Mesh>& given,
                      const MendOptions& mend, const std::optional<MeshMoment>& moment);

/// @throw std::invalid_argument  a plate or balls that are too thin for voxels of this size
void requireResolved(const MendOptions& mend, double voxelSize);

MeshToSdfOptions sdfBand(double voxelSize, double exteriorWidth, double interiorWidth);

struct MeshSdf {
  openvdb::FloatGrid::Ptr grid{};
  std::optional<double> moved{}, closedGap{};  ///< results of a repair, world units
  std::size_t caps = 0;                        ///< holes that a repair capped
  PartCounts parts{};                          ///< as in meshToSdf()
};

/// Uses meshToSdf() or repairedMeshToSdf(), on the mesh or on the surface at a distance from it, with the hollows of
/// @a mend.
MeshSdf makeSdf(const Mesh& solid, const MeshToSdfOptions& options, const MendOptions& mend, Monitor& monitor);

/// As makeSdf(), on a lattice centred on the target. Its nodes sample the shape in the same way wherever the shape
/// lies, so the fractal is the same.
MeshSdf makeSdfAbout(const openvdb::Vec3d& middle, Mesh solid, const MeshToSdfOptions& options, const MendOptions& mend,
                     Monitor& monitor);

/// The numbers of the lattice of a grid from makeSdfAbout(), from which placeOnLattice() reproduces its transform. The
/// copy of a transform in a file differs by rounding.
std::string latticeText(const openvdb::FloatGrid& grid);
/// @throw DataError  @a text was not made by latticeText()
void placeOnLattice(openvdb::FloatGrid& grid, const std::string& text);

/// Metadata of a file: the value at the surface of a fog volume, if the program chose it.
inline constexpr const char* kChosenIsovalue = "julia_chosen_iso";
/// Metadata of a file: the three sides of the target's voxels, if these were not cubes and were replaced by cubes.
inline constexpr const char* kUnequalSides = "julia_unequal_voxels";

/// The target in a VDB, with its box from the metadata, if it is recorded there, and with the facts above.
/// @param needsCubes  whether voxels must be cubes even where all distances are known
/// @throw as readVdb(), chooseFloatGrid(), levelSetOfVolume() and makeTarget()
/// @throw std::invalid_argument  the sign is to be reversed although it is right
/// @throw Interrupted
Target readVdbTarget(const std::filesystem::path& path, const std::string& grid, const VolumeOptions& volume,
                     Monitor& monitor, bool needsCubes = false);

}  // namespace vdbtools
