// SPDX-License-Identifier: Apache-2.0
/// @file sdf_job.h
/// Converts a mesh to a signed distance field, or gives a level set another band, as `juliavdb sdf` does.
#pragma once

#include "vdbtools/base/grids.h"
#include "vdbtools/base/monitor.h"
#include "vdbtools/base/voxel_choice.h"
#include "vdbtools/mesh/mesh.h"
#include "vdbtools/recipe/recipe.h"
#include "vdbtools/repair/mend_options.h"
#include "vdbtools/scene/attribute_options.h"
#include "vdbtools/scene/file_axes.h"

#include <cstddef>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>

namespace vdbtools {

struct SdfOptions {
  std::filesystem::path input;
  std::shared_ptr<const Mesh> mesh{};  ///< a mesh in memory, for which nothing is read; input is its name
  std::string grid{};                  ///< the grid of a VDB; empty: its only grid
  VoxelChoice voxels;
  MendOptions mend;
  double band = 3;  ///< voxels on each side, above 1
  bool half = false;
  FileAxes axes;
  GridNames gridNames{};  ///< for the only grid of the file, whose own name is "phi"
};

OptionTable sdfOptionTable();
/// @throw std::invalid_argument naming the option and the value
SdfOptions parseSdfOptions(const Recipe& recipe);

struct SdfResult {
  openvdb::FloatGrid::Ptr grid;
  std::optional<double> moved, closedGap;  ///< of a repair, world units
  std::size_t caps = 0;                    ///< holes that a repair capped
  std::map<std::string, std::string> metadata;
};

/// @throw what reading and repairing the mesh throw; for a VDB what readVdbTarget() and redistanced() throw
SdfResult runSdf(const SdfOptions& options, Monitor& monitor);

}  // namespace vdbtools
