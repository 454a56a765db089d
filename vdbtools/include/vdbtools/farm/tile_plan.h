// SPDX-License-Identifier: Apache-2.0
/// @file tile_plan.h
/// Cuts a fractal into tiles, i.e. boxes of lattice nodes, that can be computed independently.
#pragma once

#include "vdbtools/base/monitor.h"
#include "vdbtools/farm/estimate.h"
#include "vdbtools/farm/manifest.h"
#include "vdbtools/scene/fractal_options.h"

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace vdbtools::farm {

inline constexpr int kMostTiles = 1'000'000;

struct TilePlanOptions {
  /// The number of tiles, of about equal work: the lattice is bisected recursively, between blocks of 8^3 nodes.
  std::optional<int> tiles;
  /// Alternatively, the number of nodes along the side of a cube: tiles begin at its multiples. Tiles without an
  /// undecided cell in them or within a few nodes of them are left out, unless islands are to be dropped and the tile
  /// lies inside the set.
  std::optional<int> tileNodes;
  std::vector<std::string> makes;  ///< as Manifest::makes
  bool survey = false;             ///< whether to locate the surface, for an estimate
};

struct TileBox {
  openvdb::CoordBBox nodes;  ///< the nodes that the tile owns
  double work = 0;  ///< the number of nodes of undecided boxes in it; where boxes overlap, nodes count several times
};

/// Cuts a box into at most @a count boxes, each with about the same share of the boxes in @a work. There are fewer if
/// fewer blocks contain work.
std::vector<TileBox> cutEvenly(const openvdb::CoordBBox& domain, std::span<const openvdb::CoordBBox> work, int count);

/// Returns those cubes of @a side nodes, clipped by the domain, that are less than @a margin nodes away from a box of
/// @a work; ordered by x, then y, then z.
std::vector<TileBox> cutIntoCubes(const openvdb::CoordBBox& domain, std::span<const openvdb::CoordBBox> work, int side,
                                  int margin);

struct TilePlan {
  Manifest manifest;
  std::vector<TaskWork> work;  ///< of each tile; its surface is set only with TilePlanOptions::survey
  /// Sentences about its voxels, as in scene/voxel_advice.h; empty if there is nothing to report.
  std::string chosenResolution{}, finerThanVoxels{};
};

/// Makes the target and its exponent, cuts the lattice, and writes the prepared scene into @a folder.
/// @param recipe  the recipe of @a options, complete
/// @return the manifest, not written yet
/// @throw std::invalid_argument  neither or both of tiles and tileNodes, or out of range; options that tiles do not
///                               support
/// @throw what making the scene throws
TilePlan planTiles(const FractalOptions& options, const Recipe& recipe, const TilePlanOptions& tiles,
                   const std::filesystem::path& folder, Monitor& monitor);

}  // namespace vdbtools::farm
