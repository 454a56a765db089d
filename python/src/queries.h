// SPDX-License-Identifier: Apache-2.0
/// @file queries.h
/// Evaluates fields at points: the value, and everything from which it is made. Points are in world units. Unless a
/// node of a lattice is requested, maps are evaluated where their definition places them, without a shift
/// (MapSettings::latticeShift()). Nothing here depends on Python.
#pragma once

#include "made.h"

#include "julia/orbit_trace.h"

#include <cstdint>
#include <span>
#include <string>

/// How a query is answered.
struct QueryWork {
  int threads = 0;          ///< maximum number of threads, not negative; 0: all
  std::string device = {};  ///< a value of --device; empty: the device of the process
};

// All functions throw vdbtools::Interrupted, and std::invalid_argument if the scene does not have the quantity.

/// Sets @a field to F.
/// @throw std::invalid_argument, vdbtools::DeviceError  as vdbtools::chooseDevice()
void evaluateAt(const MadeScene& made, std::span<const openvdb::Vec3d> points, std::span<double> field,
                const QueryWork& work, vdbtools::Monitor& monitor);

/// The target's signed distance phi, world units, read trilinearly as far as the scene knows it; farther away it is the
/// width of the band.
void distancesAt(const MadeScene& made, std::span<const openvdb::Vec3d> points, std::span<double> distances,
                 const QueryWork& work, vdbtools::Monitor& monitor);

/// The target's local thickness, world units, as in the attribute "tau" of meshes.
void thicknessAt(const MadeScene& made, std::span<const openvdb::Vec3d> points, std::span<double> thickness,
                 const QueryWork& work, vdbtools::Monitor& monitor);

/// The same with a slope of kThicknessSlope, which is not reduced for deep detail.
void fullThicknessAt(const MadeScene& made, std::span<const openvdb::Vec3d> points, std::span<double> thickness,
                     const QueryWork& work, vdbtools::Monitor& monitor);

/// The octave of a texture that follows the thickness (local_thickness.h), interpolated as for the texture.
void octavesAt(const MadeScene& made, std::span<const openvdb::Vec3d> points, std::span<double> octaves,
               const QueryWork& work, vdbtools::Monitor& monitor);

/// The exponent E as the map reads it, in doubles. Beyond the shell it is a constant.
void exponentsAt(const MadeScene& made, std::span<const openvdb::Vec3d> points, std::span<double> exponents,
                 const QueryWork& work, vdbtools::Monitor& monitor);

/// f/|f| at the points, four numbers each.
void versorsAt(const MadeScene& made, std::span<const openvdb::Vec3d> points,
               std::span<julia::Quaternion<double>> versors, const QueryWork& work, vdbtools::Monitor& monitor);

/// The smallest modulus among the iterates, fractal space; infinite if there is none.
void trapsAt(const MadeScene& made, std::span<const openvdb::Vec3d> points, std::span<double> traps,
             const QueryWork& work, vdbtools::Monitor& monitor);

/// The slope of F along the axes per world unit: central differences of F in doubles. It is NaN where the orbits of the
/// seven points take different numbers of steps, because F jumps there.
/// @param step  to either side, world units; 0: 1e-7 of the target's longest side
/// @pre @a step is 0 or above, and finite
void gradientsAt(const MadeScene& made, std::span<const openvdb::Vec3d> points, double step,
                 std::span<openvdb::Vec3d> gradients, const QueryWork& work, vdbtools::Monitor& monitor);

/// What ball arithmetic proves about balls: -1: F < 0 at each point; 1: F >= 0 at each point; 0: nothing.
/// @param radii  world units, one per ball, or one for all
/// @pre all radii are 0 or above, and finite
void decideAt(const MadeScene& made, std::span<const openvdb::Vec3d> centres, std::span<const double> radii,
              std::span<std::int8_t> decisions, const QueryWork& work, vdbtools::Monitor& monitor);

/// Follows whole orbits. @pre the spans of @a trace have the right sizes
void orbitsAt(const MadeScene& made, std::span<const openvdb::Vec3d> points, const julia::OrbitTrace& trace,
              const QueryWork& work, vdbtools::Monitor& monitor);
