// SPDX-License-Identifier: Apache-2.0
#include "julia/grain_versor.h"

#include "batch_view.h"
#include "cone_arithmetic.h"
#include "joined_bricks.h"
#include "number_text.h"
#include "wave_sums.h"
#include "wave_tables.h"

#include "julia/elementary.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <mutex>
#include <stdexcept>
#include <utility>
#include <vector>

namespace julia {

static_assert(kGrainFields == kernels::kJoinedFields);

template <class Real>
struct GrainVersor<Real>::Plan {
  WaveTables<Real> tables;
  double turning = 0;  ///< radians by which the versor typically turns while u turns once
};

/// The copy takes memory and time, and not every versor is evaluated.
template <class Real>
struct GrainVersor<Real>::Joined {
  std::once_flag made;
  std::unique_ptr<const JoinedBricks<Real>> bricks;  ///< null if the fields cannot be joined
};

template <class Real>
GrainVersor<Real>::GrainVersor(const WaveTexture& texture, Fields fields, double wavelength, DropAxis dropped)
    : mTexture(texture),
      mFields(std::move(fields)),
      mWavelength(wavelength),
      mEmbedding{.dropped = dropped},
      mJoined(std::make_unique<Joined>()) {
  requireValid(texture);
  for (const WaveFactor& factor : texture.factors)
    for (const Wave& wave : factor.waves)
      for (const double number : {wave.frequency.a, wave.frequency.b})
        if (number != std::round(number))
          throw std::invalid_argument("a wave along a grain has the wave number " + textOf(number) +
                                      "; it must be whole");
  mPlan = std::make_unique<const Plan>(Plan{WaveTables<Real>(texture), typicalTurning(texture)});
}

template <class Real>
GrainVersor<Real>::~GrainVersor() = default;

template <class Real>
void GrainVersor<Real>::versor(const QuaternionBatch<Real>& q, QuaternionBatch<Real>& u) const {
  u.resize(q.size());
  const auto [x, y, z] = mEmbedding.point(Quaternion<std::span<const Real>>{q.a, q.b, q.c, q.d});
  std::vector<Real> read(kGrainFields * q.size());
  Real* rows[kGrainFields];
  for (std::size_t k = 0; k < kGrainFields; ++k) rows[k] = read.data() + k * q.size();
  std::call_once(mJoined->made, [this] { mJoined->bricks = JoinedBricks<Real>::of(mFields); });
  if (mJoined->bricks)
    mJoined->bricks->sample(x, y, z, rows);
  else
    for (std::size_t k = 0; k < kGrainFields; ++k) mFields[k]->sample(x, y, z, {rows[k], q.size()});
  kernels::kernels<Real>().grainVersor(mPlan->tables.waves.data(), mPlan->tables.factors.data(),
                                       mPlan->tables.factors.size(), rows, view(u), q.size());
}

namespace {

/// A phase that is read from a cosine and a sine within ranges.
struct PhaseRange {
  double middle = 0, half = std::numeric_limits<double>::infinity();  ///< quadrants
  double leastCertain = 0, mostCertain = 1;
};

double certaintyOf(double length) {
  const double t = std::clamp(2 * length * length, 0., 1.);
  return t * t * (3 - 2 * t);
}

PhaseRange phaseRange(const ValueRange& cosine, const ValueRange& sine, double rounding) {
  PhaseRange result;
  const double c = (cosine.low + cosine.high) / 2, s = (sine.low + sine.high) / 2;
  const double radius = elementary::hypot(cosine.high - cosine.low, sine.high - sine.low) / 2 * (1 + kSlack) + rounding;
  const double size = elementary::hypot(c, s);
  if (!std::isfinite(radius) || !std::isfinite(size)) return result;
  result.leastCertain = std::max(0., certaintyOf(std::max(0., size - radius)) - rounding);
  result.mostCertain = std::min(1., certaintyOf(size + radius) + rounding);
  if (!(radius < size)) return result;
  result.middle = elementary::atan2(s, c) / kQuadrant;
  result.half = arcSine(radius / size) / kQuadrant + rounding;
  return result;
}

}  // namespace

template <class Real>
void GrainVersor<Real>::cones(std::span<const Ball> balls, std::span<Cone> cones) const {
  const std::vector<Ball> rounded = roundedTo<Real>(balls);
  const BallsInSpace space(rounded, mEmbedding);
  std::array<std::vector<ValueRange>, kGrainFields> ranges;
  for (std::size_t k = 0; k < kGrainFields; ++k) {
    ranges[k].resize(balls.size());
    space.rangesOf(*mFields[k], ranges[k]);
  }
  constexpr double kEpsilon = kEpsilonOf<Real>;
  // An angle below 2^-40 is raised to it, and angles are off by a few ulp of a quadrant.
  constexpr double kRounding = 16 * kEpsilon + 0x1p-38;
  // Versors of unit length are off by a few ulp, and so are the factors' products and the blend.
  double lengths = 16;
  for (const WaveFactor& factor : mTexture.factors) lengths += 16 * std::abs(factor.power);
  for (std::size_t i = 0; i < balls.size(); ++i) {
    cones[i] = {};
    const PhaseRange along = phaseRange(ranges[kAlongCosine][i], ranges[kAlongSine][i], kRounding);
    const PhaseRange across = phaseRange(ranges[kAcrossCosine][i], ranges[kAcrossSine][i], kRounding);
    const auto [low, high] = ranges[kGrainDepth][i];
    const double most = along.mostCertain * across.mostCertain, least = along.leastCertain * across.leastCertain;
    Quaternion<double> versor = Quaternion<double>::one();
    double turning = 0;
    if (most > 0) {
      const double depth = (low + high) / 2, halfDepth = (high - low) / 2 * (1 + kSlack);
      const Quaternion<double> place{along.middle / 4, across.middle / 4, depth, 0};
      for (const WaveFactor& factor : mTexture.factors) {
        double change = 0;
        for (const Wave& wave : factor.waves) {
          const double size = amplitudeOf(wave);
          const double m = std::abs(wave.frequency.a), n = std::abs(wave.frequency.b), w = std::abs(wave.frequency.c);
          const double quadrants = m * along.half + n * across.half + 4 * w * halfDepth;
          const double rounding = kEpsilon * (32 + 8 * (2 * m + 2 * n + 4 * w * (std::abs(depth) + halfDepth)) +
                                              4 * static_cast<double>(factor.waves.size()));
          change += size * (kQuadrant * quadrants * (1 + kSlack) + rounding);
        }
        const Quaternion<double> g = sumOfWaves(factor, place);
        const double turn = arcSine(change / norm(g));
        turning += std::abs(factor.power) * (turn + 16 * kEpsilon);
        if (!(turning < kQuadrant)) break;
        const Quaternion<double> u = factor.power < 0 ? conjugate(unit(g)) : unit(g);
        for (int times = 0; times < std::abs(factor.power); ++times) versor = unit(versor * u);
      }
      if (!(turning < kQuadrant)) continue;
    }
    const Quaternion<double> one = Quaternion<double>::one(), apart = versor - one;
    const Ball blends{one + apart * ((least + most) / 2),
                      (most - least) / 2 * norm(apart) * (1 + kSlack) + most * turning * (1 + kSlack)};
    cones[i] = coneOf(blends, kEpsilon * lengths);
  }
}

template <class Real>
double GrainVersor<Real>::usefulRadius() const {
  constexpr double kAngle = 0.025;  // radians, as for WaveVersor
  return mPlan->turning > 0 ? kAngle * mWavelength / mPlan->turning : 0;
}

template <class Real>
std::any GrainVersor<Real>::describe() const {
  GrainVersorDescription description{mTexture, {}, mEmbedding.dropped};
  for (std::size_t k = 0; k < kGrainFields; ++k) description.fields[k] = mFields[k]->describe();
  return description;
}

template class GrainVersor<float>;
template class GrainVersor<double>;

}  // namespace julia
