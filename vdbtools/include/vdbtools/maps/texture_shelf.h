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
  int count = 1;                          ///< of points or of axes
  int power = 1;                          ///< at each: julia::appendRings()
  julia::Point axis{1, 0, 0};             ///< of the rings, and of the line
  double length = 0;                      ///< of the line
  std::optional<julia::Point> towards{};  ///< where to the axis turns; then there is no line
  double angle = 0;                       ///< radians from one factor to the next
};

/// One factor of a texture of waves (julia/wave_versor.h).
struct WaveStrand {
  int count = 1;                    ///< of waves: one makes bands, many make a field of roots and poles
  int power = 1;                    ///< as julia::WaveFactor
  julia::Point frequency{1, 1, 1};  ///< of bands, along X, Y and Z; of many waves, by what theirs are multiplied
  double fourth = 1;                ///< the same along the fourth component; bands do not depend on it
  julia::Point turn{1, 0, 0};       ///< of bands: the imaginary axis of their turn, of length 1
  std::uint64_t stream = 1;         ///< of many: tells apart what the seed gives to the strands
};

struct Texture {
  std::string name{};         ///< one word
  std::string description{};  ///< one sentence
  /// Of roots: as large everywhere as it is at its place.
  std::vector<Strand> strands{};
  /// Of waves, instead: it follows the target's local thickness.
  std::vector<WaveStrand> waves{};

  bool followsThickness() const { return !waves.empty(); }
  /// Whether a seed changes it.
  bool varies() const;
};

/// All of them, in the order of the documentation.
const std::vector<Texture>& textureShelf();
/// nullptr: there is none of that name.
const Texture* findTexture(const std::string& name);
/// The one that a fractal has without any option: the one that serves most shapes best.
const Texture& defaultTexture();

/// The waves of a texture that has them, along the axes of the target.
julia::WaveTexture wavesOf(const Texture& texture, std::uint64_t seed);
/// Such waves where an embedding has those axes. @param scale  by what their lengths are multiplied, not 0
julia::WaveTexture placedWaves(julia::WaveTexture waves, double scale, const julia::Embedding& embedding);

/// The texture's roots; C makes the moduli of its constant factors 1.
/// @param longestSide  of the target, units of the map's space
julia::Rational placeTexture(const Texture& texture, double longestSide, const julia::Embedding& embedding);

}  // namespace vdbtools
