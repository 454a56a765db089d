// SPDX-License-Identifier: Apache-2.0
/// @file fit_target.h
/// The room `fit` finds a rational map for a shape and measures how well it fits ([Kim15]). It uses the rooms up to
/// `surface`, and `picture` for the plot of a fit's report.
///
/// This header declares a shape as the fit sees it, with signed distances on the cells of a cube and, with increasing
/// coarseness, around it, and a smooth surface on which roots are placed. Positions and distances are in fractal space
/// (fractal_space.h) unless stated otherwise; phi < 0 inside.
#pragma once

#include "vdbtools/base/fractal_space.h"
#include "vdbtools/base/grids.h"
#include "vdbtools/base/monitor.h"
#include "vdbtools/mesh/mesh.h"
#include "vdbtools/repair/mend_options.h"

#include "julia/embedding.h"
#include "julia/fit/shape_energy.h"
#include "julia/fit/surface.h"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace vdbtools::fit {

struct FitTargetOptions {
  /// A mesh, or a VDB with a signed distance. The cavities of a mesh are those of mend.hollows; those of a VDB stay.
  std::filesystem::path input;
  std::shared_ptr<const Mesh> mesh;  ///< a target in memory, for which nothing is read; input is its name
  std::string grid;                  ///< the grid of the VDB, as in chooseFloatGrid()
  MendOptions mend;                  ///< how a solid is made of the file
  int resolution = 97;               ///< cells along the cube's side, 8 to 1000
  /// How far the surface on which roots are placed is smoothed, in cells, 0 to 4: details of this size vanish. The
  /// surface moves by at most half of it anywhere, so thicker parts remain.
  double smooth = 1;
  int triangles = 5000;  ///< maximum number of triangles of that surface, >= 100
};

/// The cube has resolution^3 cells about the centre of the shape's box; its side is 1.2 times the box's longest side.
/// Each level's lattice has every second node of the previous one, so the finest node spacing is one cell and, further
/// out, 2, 4, 8 cells and so on.
struct FitTarget {
  FractalSpace space;                          ///< the default space of `juliavdb fractal` for this input
  openvdb::BBoxd box;                          ///< bounds of the shape, world units
  int resolution = 0;                          ///< cells along the cube's side
  std::map<std::string, std::string> facts{};  ///< metadata that say how the target was read
  double cell = 0;                             ///< the edge length of a cell
  julia::Point cubeCentre;                     ///< the centre of the box

  /// Smooth, closed, 2-manifold, oriented outward.
  julia::TriangleSurface surface;

  /// Signed distances, world units, each level a narrow band; the first has the cells' centres as nodes. Level l has
  /// voxels of 2^l cells and is known up to kFitBand of its voxels from the surface. It has the values of level l - 1
  /// where that is known; farther out they come from fast sweeping. The last level is known in the whole cube of twice
  /// the side.
  std::vector<openvdb::FloatGrid::ConstPtr> levels;

  /// phi, trilinear in the finest level that is known there. Outside the cube of twice the side it is phi at the
  /// nearest point of that cube plus the distance to it.
  double distance(const julia::Point& x) const;
  /// As distance(), for many points at once, and faster. @pre both spans have the same size
  void distances(std::span<const julia::Point> x, std::span<double> phi) const;
  bool inside(const julia::Point& x) const { return distance(x) < 0; }
};

inline constexpr int kFitBand = 6;  ///< approximate number of voxels known on each side of the surface

/// @throw std::invalid_argument  options out of their domain
/// @throw DataError              no inside, or as readMesh(), readVdb(), chooseFloatGrid(), makeTarget() and
///                               meshToSdf()
/// @throw MissingInputError, Interrupted
FitTarget makeFitTarget(const FitTargetOptions& options, Monitor& monitor);

/// Cells that grow with the distance from the surface: nodes of the finest level where |phi| < @a bandWidth cells, of
/// level l where 2^(l-1) <= |phi| / (bandWidth cells) < 2^l, and of the last level everywhere beyond. Together they
/// fill the cube of twice the side, whose faces cut them. They are ordered by levels and by the levels' trees.
/// @throw std::invalid_argument  bandWidth is not 1 to 5
std::vector<julia::FitCell> adaptiveCells(const FitTarget& target, double bandWidth = 3);

/// The resolution^3 equal cells of the cube ([Kim15] Eq. 18), x slowest, with phi from distance().
/// @throw std::invalid_argument  resolution is not 1 to 1000
std::vector<julia::FitCell> denseCells(const FitTarget& target, int resolution);

/// Moves x along the gradient of phi by Newton's method to a point where phi = @a distance. Empty if the method does
/// not get within a tenth of a cell, because thin parts have no inner offset.
std::optional<julia::Point> movedTo(const FitTarget& target, julia::Point x, double distance);

/// Points near blue noise on the surface of phi = @a distance (Gamma+ of [Kim15] 4.4): @a count points of
/// julia::blueNoise() on the target's surface, moved by movedTo(). Points that cannot be moved there are left out.
/// @throw std::invalid_argument  as julia::blueNoise()
std::vector<julia::Point> offsetPoints(const FitTarget& target, std::size_t count, double distance, std::uint64_t seed);

}  // namespace vdbtools::fit
