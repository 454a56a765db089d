// SPDX-License-Identifier: Apache-2.0
/// @file texture_shelf.h
/// The shelf: versors with names. Most are textures of waves (julia/wave_versor.h), whose detail is as fine at each
/// place as the target is thin there. The others are recipes of roots in the target's own space: one or more strands,
/// whose factors are multiplied in their order; a strand puts rings of detail (julia/root_patterns.h) at the points of
/// a pattern. Lengths are shares of the target's longest side or of its local thickness, so that a texture is the same
/// for a target of any size and place. All powers are whole: the textures have no seam, and their signs can be proved
/// in blocks.
#pragma once

#include "julia/embedding.h"
#include "julia/rational.h"
#include "julia/wave_versor.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace vdbtools {

/// Rings at points on a line through the dynamics' origin, or at the origin alone where the axis turns from factor to
/// factor.
struct Strand {
  int count = 1;                          ///< number of points, or of axes
  int power = 1;                          ///< the power at each of them: julia::appendRings()
  julia::Point axis{1, 0, 0};             ///< direction of the first rings, and of the line
  double length = 0;                      ///< length of the line
  std::optional<julia::Point> towards{};  ///< the direction towards which the axis turns; without a line then
  double angle = 0;                       ///< radians from one factor to the next
};

/// One factor of a texture of waves (julia/wave_versor.h).
struct WaveStrand {
  int count = 1;                    ///< number of waves: one makes bands, many make a field of roots and poles
  int power = 1;                    ///< as julia::WaveFactor
  julia::Point frequency{1, 1, 1};  ///< for bands, along X, Y and Z; for many waves, a factor of their frequencies
  double fourth = 1;                ///< the same along the fourth component; bands do not depend on it
  julia::Point turn{1, 0, 0};       ///< for bands, the imaginary axis about which they turn, of length 1
  std::uint64_t stream = 1;         ///< for many waves, gives strands of one seed different random numbers
};

struct Texture {
  std::string name{};         ///< one word
  std::string description{};  ///< one sentence
  /// Strands of roots, whose features have the scale of the target where the roots lie.
  std::vector<Strand> strands{};
  /// Alternatively, factors of waves, whose features follow the target's local thickness.
  std::vector<WaveStrand> waves{};

  /// Factors of waves that follow a grain (julia/grain_versor.h); empty: those of `waves`, laid along it. Their
  /// frequencies are along the grain, across it and away from the surface, in cycles for each wave of the lattice.
  std::vector<WaveStrand> grain{};

  bool followsThickness() const { return !waves.empty(); }
  /// Whether the seed has an effect.
  bool varies() const;
};

/// All textures, in the order of the documentation.
const std::vector<Texture>& textureShelf();
/// Returns nullptr if there is no texture of that name.
const Texture* findTexture(const std::string& name);
/// The texture of a fractal without any option: the one that suits most shapes best.
const Texture& defaultTexture();

/// The waves of a texture that consists of waves, along the axes of the target.
julia::WaveTexture wavesOf(const Texture& texture, std::uint64_t seed);
/// The waves of a texture along a grain, from any texture of the shelf: Y becomes the direction along it, X across it,
/// and Z away from the surface. @param octave  by how many octaves they are finer than the lattice's waves
julia::WaveTexture grainWavesOf(const Texture& texture, std::uint64_t seed, int octave);
/// The same of waves along the axes of the target.
julia::WaveTexture alongGrain(const julia::WaveTexture& waves, int octave);
/// Moves such waves to the axes of an embedding. @param scale  factor of their lengths, not 0
julia::WaveTexture placedWaves(julia::WaveTexture waves, double scale, const julia::Embedding& embedding);

/// The texture's roots; C makes the moduli of its constant factors 1.
/// @param longestSide  of the target, units of the map's space
julia::Rational placeTexture(const Texture& texture, double longestSide, const julia::Embedding& embedding);

}  // namespace vdbtools
