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
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace vdbtools {

enum class RootFamily {
  Line,     ///< on a line
  Helix,    ///< on a helix, or on a circle where it has no length
  Lattice,  ///< on the nodes of a cubic lattice in the target's box, the others about the dynamics' origin
  Surface,  ///< on the target's own surface
  Fan,      ///< in one point, where the axis turns from factor to factor
};

struct Strand {
  RootFamily family = RootFamily::Line;
  int count = 1;                        ///< of points, and of axes of a fan; of a lattice the spacing decides
  int power = 1, repeats = 1;           ///< at each point: julia::appendRings()
  julia::Point axis{1, 0, 0};           ///< of the rings
  std::optional<julia::Point> along{};  ///< Line, Helix: the pattern's axis, where that is another
  double length = 0;                    ///< Line, Helix: along the pattern's axis
  double radius = 0, turns = 1;         ///< Helix
  double spacing = 0;                   ///< Lattice
  julia::Point towards{0, 0, 1};        ///< Fan: where to the axis turns
  double angle = 0;                     ///< Fan: radians from one factor to the next
  double shift = 0;                     ///< of the pattern's middle from the dynamics' origin, along its axis
  double jitter = 0;                    ///< standard deviation of a random displacement of each point
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

/// The waves of a texture that has them. @param scale  by what their lengths are multiplied, not 0
julia::WaveTexture placeWaves(const Texture& texture, double scale, std::uint64_t seed,
                              const julia::Embedding& embedding);

/// Where roots are placed.
struct TextureSite {
  julia::Point boxMin{-0.5, -0.5, -0.5}, boxMax{0.5, 0.5, 0.5};  ///< the target's, units of the map's space
  double longestSide = 1;                                        ///< of that box
  /// The target's signed distance in the map's space; needed by RootFamily::Surface.
  std::function<double(const julia::Point&)> distance;
};

/// How far from its surface the target's distance must be known to place a texture, as a share of its longest side.
double surfaceReach(const Texture& texture);

/// The texture's roots; C makes the moduli of its constant factors 1.
/// @throw std::invalid_argument  the texture needs a target and there is none, or the target has no surface
julia::Rational placeTexture(const Texture& texture, const TextureSite& site, std::uint64_t seed,
                             const julia::Embedding& embedding);

}  // namespace vdbtools
