// SPDX-License-Identifier: Apache-2.0
#include "julia/fit/monopoles.h"

#include "julia/fit/cancelled.h"
#include "number_text.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <string>
#include <utility>

namespace julia {
namespace {

// As in requireFinite(const Rational&).
constexpr double kLargestNumber = 1e9;
constexpr std::size_t kMostMonopoles = 1'000'000;
// Candidates drawn at a time: enough to last a while, but quick to draw.
constexpr std::size_t kPool = 10'000;
// A column is skipped if less than this fraction of it is independent of the earlier columns. It would only add
// rounding errors, and large weights that cancel each other.
constexpr double kDependent = 1e-8;

using Eigen::Index;
using Eigen::VectorXd;

void requireNumber(double value, const char* what, std::size_t i) {
  if (!(std::abs(value) <= kLargestNumber))
    throw std::invalid_argument(std::string(what) + " of sample " + std::to_string(i) + " is " + textOf(value) +
                                "; it must be a number between -1e9 and 1e9");
}

void requireCount(std::size_t value, std::size_t most, const char* what) {
  if (value < 1 || value > most)
    throw std::invalid_argument(std::string(what) + " is " + std::to_string(value) + "; it must be 1 to " +
                                std::to_string(most));
}

void requireValidMonopoles(std::span<const Point> samples, std::span<const double> potentials,
                           const MonopoleOptions& options) {
  if (!(options.epsilon > 0 && options.epsilon < 1))
    throw std::invalid_argument("epsilon of the monopoles is " + textOf(options.epsilon) +
                                "; it must be between 0 and 1");
  requireCount(options.maxCount, kMostMonopoles, "the largest number of monopoles");
  requireCount(options.candidatesPerStep, kMostMonopoles, "the number of candidates for a monopole");
  if (samples.empty() || samples.size() != potentials.size())
    throw std::invalid_argument("there are " + std::to_string(potentials.size()) + " potentials for " +
                                std::to_string(samples.size()) + " samples; give one for each, and at least one");
  for (std::size_t i = 0; i < samples.size(); ++i) {
    for (const double coordinate : samples[i]) requireNumber(coordinate, "a coordinate", i);
    requireNumber(potentials[i], "the potential", i);
  }
  if (std::all_of(potentials.begin(), potentials.end(), [](double p) { return p == 0; }))
    throw std::invalid_argument("the potential is 0 at all of " + std::to_string(potentials.size()) +
                                " samples; there is nothing to fit monopoles to");
}

/// Slices of progressive blue noise, one after another.
class Candidates {
 public:
  Candidates(const TriangleSurface& surface, const MonopoleOptions& options)
      : mSurface(surface), mSize(options.candidatesPerStep), mSeed(options.seed) {}

  std::span<const Point> next() {
    if (mNext + mSize > mPool.size()) {
      mPool = blueNoise(mSurface, std::max(kPool / mSize, std::size_t{1}) * mSize, mSeed++);
      mNext = 0;
    }
    mNext += mSize;
    return {mPool.data() + mNext - mSize, mSize};
  }

  std::size_t slicesInPool() const { return mPool.size() / mSize; }

 private:
  const TriangleSurface& mSurface;
  std::size_t mSize, mNext = 0;
  std::uint64_t mSeed;
  std::vector<Point> mPool;
};

/// The potentials of unit monopoles at the samples: [Kim15] Eq. 16.
class Columns {
 public:
  explicit Columns(std::span<const Point> samples)
      : mX(static_cast<Index>(samples.size())), mY(mX.size()), mZ(mX.size()) {
    for (Index i = 0; i < mX.size(); ++i) {
      const Point& x = samples[static_cast<std::size_t>(i)];
      mX[i] = x[0], mY[i] = x[1], mZ[i] = x[2];
    }
  }

  VectorXd at(const Point& m) const {
    VectorXd column(mX.size());
    for (Index i = 0; i < mX.size(); ++i) {
      const double dx = mX[i] - m[0], dy = mY[i] - m[1], dz = mZ[i] - m[2];
      column[i] = 1 / std::sqrt(dx * dx + dy * dy + dz * dz);
    }
    return column;
  }

 private:
  VectorXd mX, mY, mZ;
};

/// Least squares with columns added one at a time: C = Q R, Q orthonormal.
class LeastSquares {
 public:
  explicit LeastSquares(VectorXd p) : mResidual(std::move(p)) {}

  const VectorXd& residual() const { return mResidual; }

  /// @return false, without changes, if the column depends on those before it or is not finite
  bool add(VectorXd column) {
    const double whole = column.norm();
    if (!std::isfinite(whole)) return false;
    VectorXd coefficients = VectorXd::Zero(static_cast<Index>(mQ.size()) + 1);
    // The Gram-Schmidt method loses orthogonality by rounding; a second pass restores it [Giraud et al., Numer. Math.
    // 101, 2005].
    for (int pass = 0; pass < 2; ++pass) coefficients.head(coefficients.size() - 1) += removeFrom(column);
    const double rest = column.norm();
    if (!(rest > kDependent * whole)) return false;
    coefficients[coefficients.size() - 1] = rest;
    column /= rest;
    const double share = column.dot(mResidual);
    mResidual -= share * column;
    mShares.push_back(share);
    mQ.push_back(std::move(column));
    mR.push_back(std::move(coefficients));
    return true;
  }

  std::vector<double> weights() const {
    std::vector<double> rest = mShares;
    for (std::size_t i = rest.size(); i-- > 0;) {
      rest[i] /= mR[i][static_cast<Index>(i)];
      for (std::size_t j = 0; j < i; ++j) rest[j] -= rest[i] * mR[i][static_cast<Index>(j)];
    }
    return rest;
  }

 private:
  /// Removes the components along Q from a column. @return their sizes
  VectorXd removeFrom(VectorXd& column) const {
    VectorXd parts(static_cast<Index>(mQ.size()));
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, mQ.size(), 8), [&](const auto& range) {
      for (std::size_t i = range.begin(); i < range.end(); ++i) parts[static_cast<Index>(i)] = mQ[i].dot(column);
    });
    tbb::parallel_for(tbb::blocked_range<Index>(0, column.size(), 1024), [&](const auto& range) {
      const Index size = range.end() - range.begin();
      for (std::size_t i = 0; i < mQ.size(); ++i)
        column.segment(range.begin(), size) -= parts[static_cast<Index>(i)] * mQ[i].segment(range.begin(), size);
    });
    return parts;
  }

  VectorXd mResidual;
  std::vector<VectorXd> mQ, mR;
  std::vector<double> mShares;
};

/// The candidates' indices in descending order of |c . r|; equal ones keep their order.
std::vector<std::size_t> ranked(std::span<const Point> candidates, const Columns& columns, const VectorXd& residual) {
  std::vector<double> projections(candidates.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, candidates.size(), 4), [&](const auto& range) {
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      const double projection = std::abs(columns.at(candidates[i]).dot(residual));
      // The potential of a monopole on a sample is infinite.
      projections[i] = std::isfinite(projection) ? projection : 0;
    }
  });
  std::vector<std::size_t> order(candidates.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return projections[a] > projections[b]; });
  return order;
}

}  // namespace

MonopoleFit fitMonopoles(const TriangleSurface& surface, std::span<const Point> samples,
                         std::span<const double> potentials, const MonopoleOptions& options) {
  requireValidMonopoles(samples, potentials, options);
  const Columns columns(samples);
  const VectorXd p = Eigen::Map<const VectorXd>(potentials.data(), static_cast<Index>(potentials.size()));
  const double whole = p.norm();
  LeastSquares squares(p);
  Candidates candidates(surface, options);

  MonopoleFit fit;
  std::size_t fruitless = 0;
  while (fit.monopoles.size() < options.maxCount && (fit.residuals.empty() || fit.residuals.back() > options.epsilon)) {
    if (options.cancelled && options.cancelled()) throw Cancelled();
    const std::span<const Point> slice = candidates.next();
    const std::vector<std::size_t> order = ranked(slice, columns, squares.residual());
    const auto chosen =
        std::find_if(order.begin(), order.end(), [&](std::size_t i) { return squares.add(columns.at(slice[i])); });
    if (chosen == order.end()) {
      // A whole pool has brought nothing: the columns so far span everything that the surface offers.
      if (++fruitless == candidates.slicesInPool()) break;
      continue;
    }
    fruitless = 0;
    fit.monopoles.push_back({slice[*chosen]});
    fit.residuals.push_back(squares.residual().norm() / whole);
  }
  const std::vector<double> weights = squares.weights();
  for (std::size_t i = 0; i < weights.size(); ++i) fit.monopoles[i].weight = weights[i];
  return fit;
}

Rational rationalFromMonopoles(std::span<const Monopole> monopoles, double powerPerWeight, bool rootsAtOrigin) {
  if (!(powerPerWeight > 0 && powerPerWeight <= kLargestNumber))
    throw std::invalid_argument("the power for a weight of 1 is " + textOf(powerPerWeight) +
                                "; it must be above 0 and at most 1e9");
  Rational rational;
  if (rootsAtOrigin)
    for (Polynomial* side : {&rational.top, &rational.bottom}) side->roots.push_back({{0, 0, 0, 0}, 1});
  for (const Monopole& monopole : monopoles) {
    if (monopole.weight == 0) continue;
    Polynomial& side = monopole.weight < 0 ? rational.bottom : rational.top;
    side.roots.push_back(
        {Embedding().quaternion<double>(monopole.position), std::abs(monopole.weight) * powerPerWeight});
  }
  requireFinite(rational);
  return rational;
}

}  // namespace julia
