// SPDX-License-Identifier: Apache-2.0
/// @file grain.h
/// The room `grain` lays directions over a target, which textures follow as fur follows a skin, and makes the phases of
/// waves along and across them. It uses the rooms up to `exponent`.
///
/// The surface is sampled at points whose distance is a third of the local thickness. A smooth field of tangents that
/// comes near the wishes is found there, and then the phases of two systems of stripes, along the grain and across it,
/// whose wavelength is a multiple of the local thickness (julia/grain/surface_graph.h). They are passed on to a lattice
/// about the surface, on which textures read them (julia/grain_versor.h).
#pragma once

#include "vdbtools/base/fractal_space.h"
#include "vdbtools/base/grids.h"
#include "vdbtools/base/monitor.h"
#include "vdbtools/control/control.h"
#include "vdbtools/exponent/local_thickness.h"

#include "julia/grain/surface_graph.h"

#include <array>
#include <complex>
#include <functional>
#include <span>
#include <vector>

namespace vdbtools {

enum class GrainKind {
  None,       ///< textures are fixed to the axes of space
  Along,      ///< along limbs, from thick parts to thin ones
  Around,     ///< around limbs, at right angles to Along
  Curvature,  ///< along the least bending
  Towards,    ///< along the tangential part of a vector
  Given,      ///< along vectors that are given at each point, as far as they are tangential
};

/// Vectors of any length at points in world units; a vector of length 0 means that nothing is wanted there.
using GrainVectors = std::function<void(std::span<const openvdb::Vec3d> points, std::span<openvdb::Vec3d> vectors)>;

struct GrainOptions {
  GrainKind kind = GrainKind::Along;
  openvdb::Vec3d towards{0, -1, 0};  ///< for Towards
  GrainVectors given{};              ///< for Given
  Control turn{0.0};                 ///< by which the directions are turned to the left, seen from outside, degrees
};

/// Points of a surface with what is known there.
struct GrainSurface {
  julia::SurfaceGraph graph;
  std::vector<double> thickness;  ///< tau, world units
  double voxel = 0;               ///< of the lattice of distances, world units
};

/// @param phi  world units, negative inside, known within two voxels of the surface (TargetInput::coarseDistances())
/// @throw DataError  phi is nowhere negative
/// @throw Interrupted
GrainSurface grainSurface(const openvdb::FloatGrid& phi, const LocalThickness& thickness, Monitor& monitor);

/// The direction of the grain at each point of the surface: tangents of length 1.
/// @throw DataError  nothing that is given has a tangential part, or a control is not finite
/// @throw Interrupted
std::vector<std::complex<double>> grainDirections(const GrainSurface& surface, const GrainOptions& options,
                                                  Monitor& monitor);

/// The phases of the waves along the grain and across it, at each point of the surface.
struct GrainPhases {
  std::vector<julia::SurfacePhase> along, across;
};
/// @param wavelength  of the waves at each point of the surface, world units, > 0
/// @throw Interrupted
GrainPhases grainPhases(const GrainSurface& surface, std::span<const std::complex<double>> directions,
                        std::span<const double> wavelength, Monitor& monitor);

/// Grids on the lattice of the thickness, in world space: cosine and sine of the phase along the grain, those of the
/// phase across it, and the distance from the surface in wavelengths. The squares of a cosine and a sine add up to 1,
/// and to less where the phase is not certain. Voxels that are too far from the surface are inactive and 0.
struct GrainGrids {
  openvdb::FloatGrid::Ptr alongCosine, alongSine, acrossCosine, acrossSine, depth;

  /// In the order of julia::GrainField.
  std::array<openvdb::FloatGrid::Ptr, 5> all() const {
    return {alongCosine, alongSine, acrossCosine, acrossSine, depth};
  }
};

/// What a texture must know about such grids, which the grid of depths holds as metadata.
struct GrainScale {
  int octave = 0;         ///< o: the waves of the texture are 2^o times as many as the lattice has
  double wavelength = 0;  ///< the longest, world units
};
void setGrainScale(openvdb::FloatGrid& depth, const GrainScale& scale);
/// @throw std::invalid_argument  the grid has no such metadata
GrainScale grainScale(const openvdb::FloatGrid& depth);

/// @param wavelength  as for the phases
/// @param reach  how far from the surface the grids reach, as a multiple of the local thickness
/// @throw Interrupted
GrainGrids grainGrids(const GrainSurface& surface, const GrainPhases& phases, std::span<const double> wavelength,
                      double reach, const LocalThickness& thickness, Monitor& monitor);

}  // namespace vdbtools
