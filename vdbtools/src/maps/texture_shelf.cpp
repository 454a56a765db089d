// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/maps/texture_shelf.h"

#include "base/counter_random.h"

#include "julia/root_patterns.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace vdbtools {
namespace {

using julia::Point;

/// Bands that cross a direction. The longer the vector is, the narrower they are; their versor turns about an imaginary
/// axis.
WaveStrand bands(const Point& across, const Point& turn, int power = 1) {
  return {.power = power, .frequency = across, .turn = turn};
}

/// Waves in all directions, whose sum has roots and poles everywhere. @param stretch  factors of their frequencies
/// along the axes
WaveStrand field(int count, std::uint64_t stream, const Point& stretch = {1, 1, 1}, double along = 1, int power = 1) {
  return {.count = count, .power = power, .frequency = stretch, .fourth = along, .stream = stream};
}

// These were chosen by looking at many. Bands along a grain that sink along it (their third number is negative) make
// tips that lie towards its end. Rings about X take one root, however many they are; rings about other axes take two
// roots each.
std::vector<Texture> allTextures() {
  constexpr Point kI{1, 0, 0}, kJ{0, 1, 0}, kK{0, 0, 1};
  return {
      {.name = "scales",
       .description = "Overlapping plates with ragged tips, where two systems of slanting bands cross.",
       .waves = {bands({0.5, 0.8, 0.3}, kI), bands({0.5, -0.8, 0.3}, kJ), field(4, 1)},
       .grain = {bands({1, 1, -0.5}, kI, 2), bands({1, -1, -0.5}, kJ), field(4, 1, {0, 0, 0.8})}},
      {.name = "quills",
       .description = "Fine sharp spines in rows that lie along the body, like those of a hedgehog.",
       .waves = {bands({0, 0.5, 0}, kI, 3), bands({0.5, 0, 0}, kJ, 3)}},
      {.name = "woven",
       .description = "A weave of small studs, where three systems of bands cross.",
       .waves = {bands({1, 0, 1}, kI), bands({1, 0, -1}, kJ), bands({0, 1.4, 0}, kK)}},
      {.name = "ledges",
       .description = "Level shelves with torn edges, one above the other, like tree fungus.",
       .waves = {bands({0, 2, 0}, kI), field(4, 1, {0.5, 0.5, 0.5})},
       .grain = {bands({6, 0, 0}, kI), field(4, 1)}},
      {.name = "fur",
       .description = "Upright locks, long and matted.",
       .waves = {bands({2, 0, 0}, kI), bands({0, 0, 2}, kJ), field(4, 1, {0.5, 0.3, 0.5})}},
      {.name = "coral",
       .description = "Crumbling knobs, hooks and hollows without any order.",
       .waves = {field(12, 3, {1, 1, 1}, 1, 2), field(12, 4, {1, 1, 1}, 1, 2)}},
      {.name = "bark",
       .description = "Ridges and furrows that run upright, broken at even heights.",
       .waves = {field(6, 1, {1.6, 0.3, 1.6}, 1, 2), bands({0, 0.7, 0}, kK)}},
      {.name = "thorns",
       .description = "Swept folds that end in thorns, on a smooth skin.",
       .waves = {field(4, 5, {0.6, 0.6, 0.6}, 0.6, 4)}},
      {.name = "rings",
       .description = "Broad smooth rings about X, as in [SK23] Fig. 9.",
       .strands = {{.count = 5, .power = 6, .length = 1}},
       .grain = {bands({2, 0, 0}, kI), bands({0, 0, 1}, kJ)}},
      {.name = "shells",
       .description = "Toothed ridges that wind up like those of an ammonite.",
       .strands = {{.count = 20, .axis = {1, 0, 0}, .towards = Point{0, 0, 1}, .angle = 0.15}},
       .grain = {bands({2, 1, 0}, kI), bands({0, 0, 1}, kJ), bands({0, 6, 0}, kI)}},
  };
}

}  // namespace

bool Texture::varies() const {
  return std::any_of(waves.begin(), waves.end(), [](const WaveStrand& strand) { return strand.count > 1; });
}

const std::vector<Texture>& textureShelf() {
  static const std::vector<Texture> shelf = allTextures();
  return shelf;
}

const Texture* findTexture(const std::string& name) {
  for (const Texture& texture : textureShelf())
    if (texture.name == name) return &texture;
  return nullptr;
}

const Texture& defaultTexture() { return textureShelf().front(); }

namespace {

/// The random numbers of a strand.
class StrandRandom {
 public:
  StrandRandom(std::uint64_t seed, std::uint64_t stream) : mSeed(seed), mStream(stream) {}

  double unit() { return randomUnit(mSeed, mStream, mCounter++); }
  /// A point of the unit sphere of the quaternions, by rejection, which needs no elementary function.
  julia::Quaternion<double> direction() {
    for (;;) {
      const julia::Quaternion<double> q{2 * unit() - 1, 2 * unit() - 1, 2 * unit() - 1, 2 * unit() - 1};
      const double square = julia::normSquared(q);
      if (square > 0.01 && square <= 1) return q * (1 / std::sqrt(square));
    }
  }
  /// A quaternion of length 1 at a right angle to @a q.
  julia::Quaternion<double> across(const julia::Quaternion<double>& q) {
    for (;;) {
      const julia::Quaternion<double> p = direction();
      const double along = p.a * q.a + p.b * q.b + p.c * q.c + p.d * q.d;
      const julia::Quaternion<double> rest = p - q * along;
      if (const double square = julia::normSquared(rest); square > 0.01) return rest * (1 / std::sqrt(square));
    }
  }

 private:
  std::uint64_t mSeed, mStream, mCounter = 0;
};

julia::WaveFactor wavesOf(const WaveStrand& strand, std::uint64_t seed) {
  const auto frequency = [&](const julia::Quaternion<double>& way) {
    const Point& by = strand.frequency;
    return julia::Quaternion<double>{way.a * by[0], way.b * by[1], way.c * by[2], way.d * strand.fourth};
  };
  if (strand.count == 1) {
    const auto& [i, j, k] = strand.turn;
    return {{{frequency({1, 1, 1, 0}), julia::Quaternion<double>::one(), {0, i, j, k}}}, strand.power};
  }
  julia::WaveFactor factor{{}, strand.power};
  StrandRandom random(seed, strand.stream);
  for (int i = 0; i < strand.count; ++i) {
    const julia::Quaternion<double> way = random.direction();
    const double length = 0.75 + 0.5 * random.unit();
    const julia::Quaternion<double> cosine = random.direction();
    factor.waves.push_back({frequency(way * length), cosine, random.across(cosine)});
  }
  return factor;
}

}  // namespace

julia::WaveTexture wavesOf(const Texture& texture, std::uint64_t seed) {
  julia::WaveTexture made;
  for (const WaveStrand& strand : texture.waves) made.factors.push_back(wavesOf(strand, seed));
  return made;
}

namespace {

/// Makes the numbers along a grain and across it whole, and not both of them 0.
julia::Quaternion<double> wholeNumbers(const julia::Quaternion<double>& frequency, int octave) {
  const double finer = std::ldexp(1.0, octave);
  double along = std::round(frequency.a), across = std::round(frequency.b);
  if (along == 0 && across == 0 && (frequency.a != 0 || frequency.b != 0)) {
    if (std::abs(frequency.a) > std::abs(frequency.b))
      along = frequency.a < 0 ? -1 : 1;
    else
      across = frequency.b < 0 ? -1 : 1;
  }
  return {finer * along, finer * across, finer * frequency.c, 0};
}

}  // namespace

julia::WaveTexture alongGrain(const julia::WaveTexture& waves, int octave) {
  // The lattice has one wave across the thickness where a frequency of 1 would make two.
  constexpr double kPerCycle = 2;
  julia::WaveTexture made = waves;
  made.origin = {};
  for (julia::WaveFactor& factor : made.factors)
    for (julia::Wave& wave : factor.waves) {
      const julia::Quaternion<double>& f = wave.frequency;
      wave.frequency = wholeNumbers({kPerCycle * f.b, kPerCycle * f.a, kPerCycle * f.c, 0}, octave);
    }
  return made;
}

julia::WaveTexture grainWavesOf(const Texture& texture, std::uint64_t seed, int octave) {
  if (texture.grain.empty()) return alongGrain(wavesOf(texture, seed), octave);
  julia::WaveTexture made;
  for (const WaveStrand& strand : texture.grain) {
    julia::WaveFactor factor = wavesOf(strand, seed);
    for (julia::Wave& wave : factor.waves) wave.frequency = wholeNumbers(wave.frequency, octave);
    made.factors.push_back(std::move(factor));
  }
  return made;
}

julia::WaveTexture placedWaves(julia::WaveTexture waves, double scale, const julia::Embedding& embedding) {
  for (julia::WaveFactor& factor : waves.factors)
    for (julia::Wave& wave : factor.waves) {
      const julia::Quaternion<double>& f = wave.frequency;
      const julia::Embedding placed{f.d / scale, embedding.dropped};
      wave.frequency = placed.quaternion<double>({f.a / scale, f.b / scale, f.c / scale});
    }
  return waves;
}

julia::Rational placeTexture(const Texture& texture, double longestSide, const julia::Embedding& embedding) {
  julia::Rational rational;
  std::vector<julia::Root>& roots = rational.top.roots;
  for (const Strand& strand : texture.strands) {
    const auto count = static_cast<std::size_t>(strand.count);
    const std::vector<Point> points =
        strand.towards ? std::vector<Point>(count, Point{})
                       : julia::pointsOnLine({}, strand.axis, strand.length * longestSide, strand.count);
    const std::vector<Point> axes = strand.towards
                                        ? julia::fanOfAxes(strand.axis, *strand.towards, strand.angle, strand.count)
                                        : std::vector<Point>(count, strand.axis);
    for (std::size_t i = 0; i < count; ++i) julia::appendRings(roots, points[i], axes[i], strand.power, 1, embedding);
  }
  rational.logScale = julia::unitConstants(roots);
  return rational;
}

}  // namespace vdbtools
