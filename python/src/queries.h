// SPDX-License-Identifier: Apache-2.0
/// @file queries.h
/// What a field says of points: its value, and all that the value is made of. Points are in world units, and where no
/// node of a lattice is asked for, maps lie where their definition has them: nothing is shifted (MapSettings::
/// latticeShift()). Nothing here knows Python.
#pragma once

#include "made.h"

#include "julia/orbit_trace.h"

#include <cstdint>
#include <span>
#include <string>

/// How a query is answered.
struct QueryWork {
  int threads = 0;          ///< at most this many; 0: as many as there are. Not below 0
  std::string device = {};  ///< as --device has it; empty: where the process evaluates
};

// All of these throw vdbtools::Interrupted, and std::invalid_argument where the scene has no such thing.

/// F.
/// @throw std::invalid_argument, vdbtools::DeviceError  as vdbtools::chooseDevice()
void evaluateAt(const MadeScene& made, std::span<const openvdb::Vec3d> points, std::span<double> field,
                const QueryWork& work, vdbtools::Monitor& monitor);

/// The target's signed distance phi, world units, read trilinearly as far as the scene knows it: beyond, it is the
/// width of the band.
void distancesAt(const MadeScene& made, std::span<const openvdb::Vec3d> points, std::span<double> distances,
                 const QueryWork& work, vdbtools::Monitor& monitor);

/// The target's local thickness, world units: what the attribute "tau" of a mesh is.
void thicknessAt(const MadeScene& made, std::span<const openvdb::Vec3d> points, std::span<double> thickness,
                 const QueryWork& work, vdbtools::Monitor& monitor);

/// The same with a slope of kThicknessSlope, and not less where detail is deep.
void fullThicknessAt(const MadeScene& made, std::span<const openvdb::Vec3d> points, std::span<double> thickness,
                     const QueryWork& work, vdbtools::Monitor& monitor);

/// The octave of a texture that follows the thickness (octave_grid.h), read as the texture reads it.
void octavesAt(const MadeScene& made, std::span<const openvdb::Vec3d> points, std::span<double> octaves,
               const QueryWork& work, vdbtools::Monitor& monitor);

/// The exponent E as the map reads it, in doubles. Beyond the shell it is a constant.
void exponentsAt(const MadeScene& made, std::span<const openvdb::Vec3d> points, std::span<double> exponents,
                 const QueryWork& work, vdbtools::Monitor& monitor);

/// f/|f| at the points, four numbers each.
void versorsAt(const MadeScene& made, std::span<const openvdb::Vec3d> points,
               std::span<julia::Quaternion<double>> versors, const QueryWork& work, vdbtools::Monitor& monitor);

/// The smallest modulus among the iterates, fractal space; infinite where there is none.
void trapsAt(const MadeScene& made, std::span<const openvdb::Vec3d> points, std::span<double> traps,
             const QueryWork& work, vdbtools::Monitor& monitor);

/// The slope of F along the axes per world unit: central differences of F in doubles. It is NaN where the orbits of the
/// seven points do not take the same number of steps, since F jumps there.
/// @param step  to either side, world units; 0: a share of 1e-7 of the target's longest side
/// @pre 0 or above, and finite
void gradientsAt(const MadeScene& made, std::span<const openvdb::Vec3d> points, double step,
                 std::span<openvdb::Vec3d> gradients, const QueryWork& work, vdbtools::Monitor& monitor);

/// What ball arithmetic proves of balls: -1, F < 0 at each point; 1, F >= 0 at each point; 0, nothing.
/// @param radii  world units, one a ball, or one for all
/// @pre radii of 0 or above, and finite
void decideAt(const MadeScene& made, std::span<const openvdb::Vec3d> centres, std::span<const double> radii,
              std::span<std::int8_t> decisions, const QueryWork& work, vdbtools::Monitor& monitor);

/// Whole orbits. @pre the sizes of @a trace
void orbitsAt(const MadeScene& made, std::span<const openvdb::Vec3d> points, const julia::OrbitTrace& trace,
              const QueryWork& work, vdbtools::Monitor& monitor);
