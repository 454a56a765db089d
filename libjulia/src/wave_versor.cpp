// SPDX-License-Identifier: Apache-2.0
#include "julia/wave_versor.h"

#include "batch_view.h"
#include "cone_arithmetic.h"
#include "number_text.h"
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
struct FactorBound {
  double slope = 0;      ///< maximum change of g per unit, at octave 0
  double amplitude = 0;  ///< upper bound of |g|
  double reach = 0;      ///< the largest frequency, quadrants per unit
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
  std::vector<FactorBound> bounds;
};

template <class Real>
WaveVersor<Real>::WaveVersor(const WaveTexture& texture, std::shared_ptr<const ScalarField<Real>> octave,
                             DropAxis dropped)
    : mTexture(texture), mOctave(std::move(octave)), mEmbedding{.dropped = dropped} {
  requireValid(texture);
  auto plan = std::make_unique<Plan>(Plan{WaveTables<Real>(texture), {}});
  for (const WaveFactor& factor : texture.factors) {
    FactorBound bound;
    for (const Wave& wave : factor.waves) {
      // |c cos + s sin| is at most the square root of |c|^2 + |s|^2, and so is its derivative.
      const double size = std::sqrt(normSquared(wave.cosine) + normSquared(wave.sine));
      constexpr double kTurn = 6.28318530717958647693;
      const double length = norm(wave.frequency);
      bound.slope += size * length * kTurn;
      bound.amplitude += size;
      bound.reach = std::max(bound.reach, 4 * length);
    }
    plan->bounds.push_back(bound);
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

/// A texture's versor around a point at one octave.
struct Texel {
  Quaternion<double> versor = Quaternion<double>::one();
  double turning = 0;  ///< radians by which it may turn over the ball, with rounding; infinity: no bound
};

/// The versor of @a q; 1 for 0.
Quaternion<double> unit(const Quaternion<double>& q) {
  const double length = norm(q);
  return length > 0 ? q * (1 / length) : Quaternion<double>::one();
}

Quaternion<double> sumOfWaves(const WaveFactor& factor, const Quaternion<double>& p) {
  Quaternion<double> sum;
  for (const Wave& wave : factor.waves) {
    const Quaternion<double>& w = wave.frequency;
    double sine = 0, cosine = 1;
    kernels::sineCosine(4 * (w.a * p.a + w.b * p.b + w.c * p.c + w.d * p.d), &sine, &cosine);
    sum = sum + wave.cosine * cosine + wave.sine * sine;
  }
  return sum;
}

double blendAt(double octave, double k) {
  const double f = std::clamp(octave - k, 0., 1.);
  return f * f * (3 - 2 * f);
}

}  // namespace

template <class Real>
void WaveVersor<Real>::cones(std::span<const Ball> balls, std::span<Cone> cones) const {
  constexpr double kInfinity = std::numeric_limits<double>::infinity(), kHalfPi = 1.57079632679489661923;
  constexpr double eps = kEpsilonOf<Real>;
  const std::vector<Ball> rounded = roundedTo<Real>(balls);
  std::vector<ValueRange> octaves(balls.size());
  BallsInSpace(rounded, mEmbedding).rangesOf(*mOctave, octaves);

  // Versors of unit length are off by a few ulp, and so are the factors' products and the blend.
  double lengths = 16;
  for (const WaveFactor& factor : mTexture.factors) lengths += 16 * std::abs(factor.power);
  const double slack = eps * lengths;
  const auto texel = [&](const Ball& ball, double scale) {
    Texel result;
    const double size = norm(ball.centre) + norm(mTexture.origin) + ball.radius;
    const Quaternion<double> centre = ball.centre - mTexture.origin;
    for (std::size_t f = 0; f < mTexture.factors.size(); ++f) {
      const WaveFactor& factor = mTexture.factors[f];
      const FactorBound& bound = mPlan->bounds[f];
      // An angle consists of four products and three sums of numbers of this size; frequencies, the origin and the
      // difference to it are rounded. Then come the sine and cosine, those of the doubled angle, and the sum. A
      // quadrant is pi/2 radians.
      const double quadrants = bound.reach * size * scale, count = static_cast<double>(factor.waves.size());
      if (!(quadrants < 0x1p20)) return Texel{result.versor, kInfinity};
      const double rounding = bound.amplitude * 4 * eps * (kHalfPi * 8 * quadrants + 8 + count);
      const Quaternion<double> g = sumOfWaves(factor, centre * scale);
      const double turn = arcSine((bound.slope * scale * ball.radius * (1 + kSlack) + rounding) / norm(g));
      result.turning += std::abs(factor.power) * (turn + 16 * eps);
      if (!(result.turning < kHalfPi)) return Texel{result.versor, kInfinity};
      const Quaternion<double> u = factor.power < 0 ? conjugate(unit(g)) : unit(g);
      for (int times = 0; times < std::abs(factor.power); ++times) result.versor = unit(result.versor * u);
    }
    return result;
  };

  for (std::size_t i = 0; i < balls.size(); ++i) {
    cones[i] = {};
    const double low = std::clamp(octaves[i].low, -kMostOctave, kMostOctave);
    const double high = std::clamp(octaves[i].high, -kMostOctave, kMostOctave);
    const double first = std::floor(low), last = std::floor(high);
    if (!(high - low < 1)) continue;
    // One octave more than the range contains integers, and at most three.
    std::array<Texel, 3> texels;
    double turning = 0;
    for (std::size_t k = 0; k <= static_cast<std::size_t>(last - first) + 1; ++k) {
      texels[k] = texel(rounded[i], elementary::exp2(first + static_cast<double>(k)));
      turning = std::max(turning, texels[k].turning);
    }
    if (!(turning < kHalfPi)) continue;
    const auto mixed = [&](double k, double octave) {
      const auto& [coarse, fine] = std::pair(texels[static_cast<std::size_t>(k - first)].versor,
                                             texels[static_cast<std::size_t>(k - first) + 1].versor);
      return coarse + (fine - coarse) * blendAt(octave, k);
    };
    // The blends at the centre lie on a segment for each integer, and the others are as near to it as their versors.
    const double middle = (low + high) / 2;
    const Quaternion<double> axis = mixed(std::floor(middle), middle);
    double farthest = 0;
    for (double k = first; k <= last; ++k)
      for (const double octave : {low, high}) farthest = std::max(farthest, norm(mixed(k, octave) - axis));
    const double quadrants = arcSine((farthest + turning + slack) / norm(axis)) * (1 / kHalfPi);
    if (quadrants < 1) cones[i] = {unit(axis), quadrants + slack};
  }
}

template class WaveVersor<float>;
template class WaveVersor<double>;

}  // namespace julia
