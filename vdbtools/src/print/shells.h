// SPDX-License-Identifier: Apache-2.0
/// @file shells.h
/// The shells of a closed mesh, and those of them that run into each other.
#pragma once

#include "vdbtools/base/monitor.h"
#include "vdbtools/mesh/mesh.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace vdbtools {

/// The surfaces of a closed mesh that are connected through points.
struct Shells {
  std::vector<std::uint32_t> ofTriangle;
  std::vector<double> volumes;  ///< negative: the surface of a cavity
};

/// @pre there is a triangle
Shells shellsOf(const Mesh& mesh);

/// Orients the shells of a closed mesh: those that no other one encloses outwards, the others inwards.
/// @param voxel    of the lattice on which the union of shells would be made
/// @param meeting  receives how many shells run into others or stand on them; 0 if none but the largest would be missed
///                 in a part. A tiny one that hardly touches another would not: islands of a fractal may meet in a
///                 place that no lattice resolves.
/// @return empty if @a meeting is not 0: only the union of the shells is one part
/// @throw Interrupted
std::optional<Mesh> withShellsOriented(const Mesh& mesh, double voxel, std::size_t& meeting, Monitor& monitor);

}  // namespace vdbtools
