// SPDX-License-Identifier: Apache-2.0
/// @file tile_plan.h
/// A fractal cut into tiles, boxes of lattice nodes, so that each can be made by itself.
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
  /// How many tiles of about equal work: the lattice is cut in two, and the parts again, between blocks of 8^3 nodes.
  std::optional<int> tiles;
  /// Or the nodes along the side of a cube: tiles begin at its multiples. Those without an undecided cell in them or
  /// within a few nodes of them are left out, except where islands are to be dropped and they lie inside the set.
  std::optional<int> tileNodes;
  std::vector<std::string> makes;  ///< as Manifest::makes
  bool survey = false;             ///< whether to find out where the surface is, for an estimate
};

struct TileBox {
  openvdb::CoordBBox nodes;  ///< that the tile owns
  double work = 0;           ///< the nodes of undecided boxes in it; where boxes overlap, nodes count several times
};

/// Cuts a box into at most @a count boxes, each of which holds about the same share of the boxes in @a work. There are
/// fewer where there are not so many blocks with work in them.
std::vector<TileBox> cutEvenly(const openvdb::CoordBBox& domain, std::span<const openvdb::CoordBBox> work, int count);

/// Those cubes of @a side nodes, clipped by the domain, that a box of @a work comes nearer to than @a margin nodes; by
/// x, then y, then z.
std::vector<TileBox> cutIntoCubes(const openvdb::CoordBBox& domain, std::span<const openvdb::CoordBBox> work, int side,
                                  int margin);

struct TilePlan {
  Manifest manifest;
  std::vector<TaskWork> work;  ///< of each tile; without its surface unless TilePlanOptions::survey
  /// Sentences on its voxels, as scene/voxel_advice.h has them; empty where there is nothing to say.
  std::string chosenResolution{}, finerThanVoxels{};
};

/// Makes the target and its exponent, cuts the lattice, and writes the prepared scene into @a folder.
/// @param recipe  of @a options, complete
/// @return the manifest, not written yet
/// @throw std::invalid_argument  neither or both of tiles and tileNodes, or out of range; options that tiles cannot
/// have
/// @throw what making the scene throws
TilePlan planTiles(const FractalOptions& options, const Recipe& recipe, const TilePlanOptions& tiles,
                   const std::filesystem::path& folder, Monitor& monitor);

}  // namespace vdbtools::farm
