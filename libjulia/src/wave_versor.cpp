// SPDX-License-Identifier: Apache-2.0
#include "julia/wave_versor.h"

#include "batch_view.h"
#include "cone_arithmetic.h"
#include "number_text.h"
#include "wave_sums.h"
#include "wave_tables.h"

#include "julia/elementary.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace julia {
namespace {

constexpr double kLargest = 1e6;

void requireWaveNumbers(const Quaternion<double>& q, const char* what) {
  for (const double x : {q.a, q.b, q.c, q.d})
    if (!(std::abs(x) <= kLargest))
      throw std::invalid_argument("the " + std::string(what) + " of a wave is " + textOf(x) +
                                  "; it must be a number between -1e6 and 1e6");
}

/// Bounds of a factor over a ball, and of how fast it turns.
struct FactorBound : WaveSumBound {
  double reach = 0;  ///< the largest frequency, quadrants per unit
};

}  // namespace

void requireValid(const WaveTexture& texture) {
  requireWaveNumbers(texture.origin, "origin");
  if (texture.factors.empty()) throw std::invalid_argument("a texture of waves has no factor; it needs one or more");
  for (const WaveFactor& factor : texture.factors) {
    if (factor.waves.empty()) throw std::invalid_argument("a factor has no waves; it needs one or more");
    if (factor.power == 0 || std::abs(factor.power) > kMostWavePower)
      throw std::invalid_argument("the power of a factor of waves is " + std::to_string(factor.power) +
                                  "; it must be from -64 to 64 and not 0");
    for (const Wave& wave : factor.waves) {
      requireWaveNumbers(wave.frequency, "frequency");
      requireWaveNumbers(wave.cosine, "amplitude");
      requireWaveNumbers(wave.sine, "amplitude");
    }
  }
}

template <class Real>
struct WaveVersor<Real>::Plan {
  WaveTables<Real> tables;
  WaveTables<double> wide;  ///< the same in doubles
  std::vector<FactorBound> bounds;
  std::vector<kernels::WaveFactorBound> discBounds;
};

template <class Real>
WaveVersor<Real>::WaveVersor(const WaveTexture& texture, std::shared_ptr<const ScalarField<Real>> octave,
                             DropAxis dropped)
    : mTexture(texture), mOctave(std::move(octave)), mEmbedding{.dropped = dropped} {
  requireValid(texture);
  auto plan = std::make_unique<Plan>(Plan{WaveTables<Real>(texture), WaveTables<double>(texture), {}, {}});
  for (const WaveFactor& factor : texture.factors) {
    FactorBound bound{boundOf(factor)};
    double curvature = 0;
    for (const Wave& wave : factor.waves) {
      const double length = norm(wave.frequency);
      curvature += amplitudeOf(wave) * (length * kTurn) * (length * kTurn);
      bound.reach = std::max(bound.reach, 4 * length);
    }
    plan->bounds.push_back(bound);
    // An angle consists of four products and three sums of numbers of the size of a place; frequencies, the origin and
    // the difference to it are rounded. Then come the sine and cosine, their values for the doubled angle, and the sum.
    // A quadrant is pi/2 radians.
    const double rounding = bound.amplitude * 4 * kEpsilonOf<Real>;
    plan->discBounds.push_back({.curvature = curvature,
                                .rounding = rounding * (8 + static_cast<double>(factor.waves.size())),
                                .perSize = rounding * kQuadrant * 8 * bound.reach});
  }
  mPlan = std::move(plan);
}

template <class Real>
WaveVersor<Real>::~WaveVersor() = default;

template <class Real>
void WaveVersor<Real>::versor(const QuaternionBatch<Real>& q, QuaternionBatch<Real>& u) const {
  u.resize(q.size());
  std::vector<Real> octave(q.size());
  const auto [x, y, z] = mEmbedding.point(Quaternion<std::span<const Real>>{q.a, q.b, q.c, q.d});
  mOctave->sample(x, y, z, octave);
  constexpr Real kMost = static_cast<Real>(kMostOctave);
  for (Real& o : octave) o = std::clamp(o, -kMost, kMost);
  kernels::kernels<Real>().waveVersor(mPlan->tables.waves.data(), mPlan->tables.factors.data(),
                                      mPlan->tables.factors.size(), mPlan->tables.origin, view(q), octave.data(),
                                      view(u), q.size());
}

namespace {

// The largest phase whose sine is computed well, in quadrants.
constexpr double kMostQuadrants = 0x1p20;
constexpr double kUnbounded = std::numeric_limits<double>::infinity();

/// A texture's versor around a point at one octave.
struct Texel {
  Quaternion<double> versor = Quaternion<double>::one();
  double turning = 0;  ///< radians by which it may turn over the ball, with rounding; infinity: no bound
};

double blendAt(double octave, double k) {
  const double f = std::clamp(octave - k, 0., 1.);
  return f * f * (3 - 2 * f);
}

}  // namespace

/// A cone from the steepest slopes that the sums of waves can have anywhere.
template <class Real>
Cone WaveVersor<Real>::coneBySlopes(const Ball& ball, double low, double high, double slack) const {
  const double size = sizeOf(ball);
  const Quaternion<double> centre = ball.centre - mTexture.origin;
  const auto texel = [&](double scale) {
    Texel result;
    for (std::size_t f = 0; f < mTexture.factors.size(); ++f) {
      const WaveFactor& factor = mTexture.factors[f];
      const FactorBound& bound = mPlan->bounds[f];
      if (!(bound.reach * size * scale < kMostQuadrants)) return Texel{result.versor, kUnbounded};
      const kernels::WaveFactorBound& ofDisc = mPlan->discBounds[f];
      const double rounding = ofDisc.rounding + ofDisc.perSize * (size * scale);
      const Quaternion<double> g = sumOfWaves(factor, centre * scale);
      const double turn = arcSine((bound.slope * scale * ball.radius * (1 + kSlack) + rounding) / norm(g));
      result.turning += std::abs(factor.power) * (turn + 16 * kEpsilonOf<Real>);
      if (!(result.turning < kQuadrant)) return Texel{result.versor, kUnbounded};
      const Quaternion<double> u = factor.power < 0 ? conjugate(unit(g)) : unit(g);
      for (int times = 0; times < std::abs(factor.power); ++times) result.versor = unit(result.versor * u);
    }
    return result;
  };
  const double first = std::floor(low), last = std::floor(high);
  // One octave more than the range contains integers, and at most three.
  std::array<Texel, 3> texels;
  double turning = 0;
  for (std::size_t k = 0; k <= static_cast<std::size_t>(last - first) + 1; ++k) {
    texels[k] = texel(elementary::exp2(first + static_cast<double>(k)));
    turning = std::max(turning, texels[k].turning);
  }
  if (!(turning < kQuadrant)) return {};
  const auto mixed = [&](double k, double octave) {
    const auto& [coarse, fine] = std::pair(texels[static_cast<std::size_t>(k - first)].versor,
                                           texels[static_cast<std::size_t>(k - first) + 1].versor);
    return coarse + (fine - coarse) * blendAt(octave, k);
  };
  // Between two integers, the blends at the centre lie on a segment. Elsewhere in the ball they are within `turning` of
  // it.
  const double middle = (low + high) / 2;
  const Quaternion<double> axis = mixed(std::floor(middle), middle);
  double farthest = 0;
  for (double k = first; k <= last; ++k)
    for (const double octave : {low, high}) farthest = std::max(farthest, norm(mixed(k, octave) - axis));
  const double quadrants = arcSine((farthest + turning + slack) / norm(axis)) / kQuadrant;
  if (!(quadrants < 1)) return {};
  return {unit(axis), quadrants + slack};
}

template <class Real>
double WaveVersor<Real>::sizeOf(const Ball& ball) const {
  return norm(ball.centre) + norm(mTexture.origin) + ball.radius;
}

/// Cones from the derivatives at the centres of balls (kernels/wave_discs.h) are much narrower than those from slopes,
/// and useless for large balls.
template <class Real>
void WaveVersor<Real>::cones(std::span<const Ball> balls, std::span<Cone> cones) const {
  const std::vector<Ball> rounded = roundedTo<Real>(balls);
  std::vector<ValueRange> octaves(balls.size());
  BallsInSpace(rounded, mEmbedding).rangesOf(*mOctave, octaves);
  // Versors of unit length are off by a few ulp, and so are the factors' products and the blend.
  double lengths = 16, reach = 0;
  for (const WaveFactor& factor : mTexture.factors) lengths += 16 * std::abs(factor.power);
  for (const FactorBound& bound : mPlan->bounds) reach = std::max(reach, bound.reach);
  const double slack = kEpsilonOf<Real> * lengths;
  std::vector<kernels::WaveBall> asked;
  std::vector<std::size_t> numbers;
  for (std::size_t i = 0; i < balls.size(); ++i) {
    cones[i] = {};
    octaves[i].low = std::clamp(octaves[i].low, -kMostOctave, kMostOctave);
    octaves[i].high = std::clamp(octaves[i].high, -kMostOctave, kMostOctave);
    const double whole = std::floor(octaves[i].low);
    if (!(octaves[i].high < whole + 1)) continue;
    const double size = sizeOf(rounded[i]), scale = elementary::exp2(whole);
    if (!(reach * size * 2 * scale < kMostQuadrants)) continue;
    const Quaternion<double> place = rounded[i].centre - mTexture.origin;
    asked.push_back({.place = {place.a, place.b, place.c, place.d},
                     .radius = rounded[i].radius,
                     .size = size,
                     .scale = scale,
                     .least = blendAt(octaves[i].low, whole),
                     .most = blendAt(octaves[i].high, whole)});
    numbers.push_back(i);
  }
  std::vector<kernels::VersorDisc> discs(asked.size());
  const WaveTables<double>& tables = mPlan->wide;
  kernels::kernels<double>().waveDiscs(tables.waves.data(), tables.factors.data(), mPlan->discBounds.data(),
                                       tables.factors.size(), slack, asked.data(), discs.data(), discs.size());
  for (std::size_t k = 0; k < discs.size(); ++k) {
    const auto& [centre, radius] = discs[k];
    if (radius < 1) cones[numbers[k]] = coneOf({{centre[0], centre[1], centre[2], centre[3]}, radius}, slack);
  }
  for (std::size_t i = 0; i < balls.size(); ++i)
    if (!(cones[i].quadrants < 1) && octaves[i].high - octaves[i].low < 1)
      cones[i] = coneBySlopes(rounded[i], octaves[i].low, octaves[i].high, slack);
}

template <class Real>
double WaveVersor<Real>::usefulRadius() const {
  // Radians by which a factor's versor turns over such a ball where the waves are longest. Measured: with cubes of
  // 0.019 a field took less time, with cubes of 0.037 more.
  constexpr double kAngle = 0.025;
  const double turning = typicalTurning(mTexture);
  const double longest = mOctave->range({}, std::numeric_limits<float>::max()).low;
  if (!(turning > 0)) return 0;
  return kAngle / (turning * elementary::exp2(std::clamp(longest, -kMostOctave, kMostOctave)));
}

template class WaveVersor<float>;
template class WaveVersor<double>;

}  // namespace julia
