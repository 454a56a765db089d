// SPDX-License-Identifier: Apache-2.0
#include "julia/fit/electrostatics.h"

#include "fit/gmres.h"
#include "fit/panels.h"
#include "julia/fit/cancelled.h"
#include "number_text.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <string>

namespace julia {
namespace {

constexpr double kFarthest = 1e9;  // as in requireValid()

using Eigen::Index;
using Eigen::VectorXd;

/// The linear system: row i holds the integrals over all panels, seen from centroid i.
class Influence {
 public:
  Influence(const Panels& panels, const ElectrostaticsOptions& options) : mPanels(panels), mOptions(options) {}

  Index size() const { return static_cast<Index>(mPanels.size()); }

  void row(Index i, double* integrals) const {
    mPanels.integrate(mPanels.centroid(static_cast<std::size_t>(i)), {integrals, mPanels.size()});
  }

  /// Runs body(begin, end) over parts of the rows in threads. @throw Cancelled
  template <class Body>
  void forRows(const Body& body) const {
    const auto cancelled = [&] { return mOptions.cancelled && mOptions.cancelled(); };
    tbb::parallel_for(tbb::blocked_range<Index>(0, size(), 16), [&](const auto& range) {
      if (!cancelled()) body(range.begin(), range.end());
    });
    if (cancelled()) throw Cancelled();
  }

  /// |A s - 1| / |1|, from coefficients in full precision.
  double residual(const VectorXd& density) const {
    VectorXd difference(size());
    forRows([&](Index begin, Index end) {
      VectorXd integrals(size());
      for (Index i = begin; i < end; ++i) {
        row(i, integrals.data());
        difference[i] = integrals.dot(density) - 1;
      }
    });
    return difference.norm() / std::sqrt(static_cast<double>(size()));
  }

 private:
  const Panels& mPanels;
  const ElectrostaticsOptions& mOptions;
};

VectorXd solveDirectly(const Influence& influence) {
  // The rows of the system are stored as columns, which are contiguous.
  Eigen::MatrixXd transposed(influence.size(), influence.size());
  influence.forRows([&](Index begin, Index end) {
    for (Index i = begin; i < end; ++i) influence.row(i, transposed.col(i).data());
  });
  const Eigen::PartialPivLU<Eigen::Ref<Eigen::MatrixXd>> factors(transposed);
  return factors.transpose().solve(VectorXd::Ones(influence.size()));
}

/// The influence matrix with its columns scaled to a unit diagonal, with 32-bit coefficients whether they are stored or
/// not.
class ScaledInfluence {
 public:
  ScaledInfluence(const Influence& influence, std::size_t maxStoredBytes)
      : mInfluence(influence),
        mStoredRows(std::min(influence.size(), static_cast<Index>(maxStoredBytes / sizeof(float)) / influence.size())),
        mStored(std::make_unique_for_overwrite<float[]>(static_cast<std::size_t>(mStoredRows * influence.size()))),
        mDiagonal(influence.size()) {
    influence.forRows([&](Index begin, Index end) {
      VectorXd integrals(influence.size());
      for (Index i = begin; i < end; ++i) {
        influence.row(i, integrals.data());
        mDiagonal[i] = integrals[i];
        if (i < mStoredRows) storedRow(i) = integrals.cast<float>();
      }
    });
  }

  void operator()(const VectorXd& scaledDensity, VectorXd& potentials) const {
    const VectorXd density = this->density(scaledDensity);
    mInfluence.forRows([&](Index begin, Index end) {
      VectorXd integrals(mInfluence.size());
      for (Index i = begin; i < end; ++i) {
        if (i < mStoredRows) {
          integrals = storedRow(i).cast<double>();
        } else {
          mInfluence.row(i, integrals.data());
          integrals = integrals.cast<float>().cast<double>().eval();
        }
        potentials[i] = integrals.dot(density);
      }
    });
  }

  VectorXd density(const VectorXd& scaledDensity) const { return scaledDensity.cwiseQuotient(mDiagonal); }

 private:
  Eigen::Map<Eigen::VectorXf> storedRow(Index i) const {
    return {mStored.get() + i * mInfluence.size(), mInfluence.size()};
  }

  const Influence& mInfluence;
  Index mStoredRows;
  std::unique_ptr<float[]> mStored;
  VectorXd mDiagonal;
};

void requireValidElectrostatics(const ElectrostaticsOptions& options) {
  if (!(options.tolerance >= 1e-7 && options.tolerance < 1))
    throw std::invalid_argument("the tolerance of the charge is " + textOf(options.tolerance) +
                                "; it must be from 1e-7 to below 1");
  if (options.maxIterations < 1)
    throw std::invalid_argument("the most iterations of the charge are " + std::to_string(options.maxIterations) +
                                "; they must be 1 or more");
}

}  // namespace

SurfaceCharge solveExteriorDirichlet(const TriangleSurface& surface, const ElectrostaticsOptions& options) {
  requireValidElectrostatics(options);
  const Panels panels(surface);
  if (panels.size() == 0)
    throw std::invalid_argument("a surface needs a triangle with area to be charged; none of its " +
                                std::to_string(surface.triangles.size()) + " has");
  const Influence influence(panels, options);

  SurfaceCharge charge;
  VectorXd density;
  bool solved = false;
  if (panels.size() <= options.maxDense) {
    density = solveDirectly(influence);
    charge.residual = influence.residual(density);
    solved = charge.residual <= options.tolerance;
  }
  // Coincident triangles make the system singular, but it still has solutions, and the iteration finds one.
  if (!solved) {
    const ScaledInfluence scaled(influence, options.maxStoredBytes);
    // Half the tolerance; the other half allows for the rounding of the coefficients.
    const GmresResult result =
        gmres(scaled, VectorXd::Ones(influence.size()), 0.5 * options.tolerance, options.maxIterations);
    density = scaled.density(result.x);
    charge.iterations = result.iterations;
    charge.residual = influence.residual(density);
    if (!(charge.residual <= options.tolerance))
      throw std::invalid_argument(
          "the charge of the surface still has a residual of " + textOf(charge.residual) + " after " +
          std::to_string(charge.iterations) +
          " iterations; use a mesh with less thin triangles, a larger tolerance, or more iterations");
  }

  charge.density.resize(surface.triangles.size());
  for (std::size_t j = 0; j < panels.size(); ++j) {
    charge.density[panels.triangle(j)] = density[static_cast<Index>(j)];
    charge.capacitance += panels.area(j) * density[static_cast<Index>(j)];
  }
  return charge;
}

void potential(const TriangleSurface& surface, const SurfaceCharge& charge, std::span<const Point> x,
               std::span<double> p) {
  if (charge.density.size() != surface.triangles.size())
    throw std::invalid_argument("the surface has " + std::to_string(surface.triangles.size()) +
                                " triangles, but the charge is that of " + std::to_string(charge.density.size()));
  if (x.size() != p.size())
    throw std::invalid_argument("the potential is wanted at " + std::to_string(x.size()) +
                                " points, but there is room for " + std::to_string(p.size()));
  for (std::size_t i = 0; i < x.size(); ++i)
    for (const double coordinate : x[i])
      if (!(std::abs(coordinate) <= kFarthest))
        throw std::invalid_argument("a coordinate of point " + std::to_string(i) + " for the potential is " +
                                    textOf(coordinate) + "; it must be a number between -1e9 and 1e9");
  const Panels panels(surface);
  VectorXd density(static_cast<Index>(panels.size()));
  for (std::size_t j = 0; j < panels.size(); ++j) density[static_cast<Index>(j)] = charge.density[panels.triangle(j)];
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, x.size(), 16), [&](const auto& range) {
    VectorXd integrals(density.size());
    for (std::size_t i = range.begin(); i < range.end(); ++i) {
      panels.integrate(x[i], {integrals.data(), panels.size()});
      p[i] = integrals.dot(density);
    }
  });
}

}  // namespace julia
