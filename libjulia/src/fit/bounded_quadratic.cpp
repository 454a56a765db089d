// SPDX-License-Identifier: Apache-2.0
#include "fit/bounded_quadratic.h"

#include <Eigen/LU>

#include <algorithm>
#include <cstddef>

namespace julia {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

// If more than this fraction of the variables changes, a new factor takes less time than the border of the old one.
constexpr double kMostChanged = 0.1;
constexpr double kTolerance = 1e-10;  // of slopes, relative to the largest |b|

std::vector<Index> indicesOf(const std::vector<char>& set) {
  std::vector<Index> indices;
  for (std::size_t i = 0; i < set.size(); ++i)
    if (set[i]) indices.push_back(static_cast<Index>(i));
  return indices;
}

}  // namespace

bool BoundedQuadratic::factor(const std::vector<char>& free) {
  mIsFactored = free;
  mFactored = indicesOf(free);
  mColumns.resize(static_cast<Index>(mFactored.size()), 0);
  mColumnOf.assign(free.size(), -1);
  mFactor = Cholesky::of(mH(mFactored, mFactored));
  return mFactor.has_value();
}

/// Appends columns of the border: columns of H for added variables, unit vectors for variables held at 0.
void BoundedQuadratic::appendColumns(const std::vector<Index>& changed) {
  std::vector<Index> missing;
  for (const Index i : changed)
    if (mColumnOf[static_cast<std::size_t>(i)] < 0) missing.push_back(i);
  if (missing.empty()) return;
  MatrixXd columns = MatrixXd::Zero(mColumns.rows(), static_cast<Index>(missing.size()));
  const Index before = mColumns.cols();
  for (std::size_t k = 0; k < missing.size(); ++k) {
    const auto i = static_cast<std::size_t>(missing[k]);
    const auto column = static_cast<Index>(k);
    mColumnOf[i] = before + column;
    if (mIsFactored[i])
      columns(std::lower_bound(mFactored.begin(), mFactored.end(), missing[k]) - mFactored.begin(), column) = 1;
    else
      columns.col(column) = mH(mFactored, missing[k]);
  }
  mColumns.conservativeResize(Eigen::NoChange, before + columns.cols());
  mColumns.rightCols(columns.cols()) = mFactor->forwardAll(columns);
}

/// Solves if the factor's variables and the free ones differ by @a changed. The unknowns are the factor's variables,
/// followed by the values of added variables and the multipliers of variables held at 0. @return empty if rounding
/// spoils it
std::optional<BoundedQuadratic::Solution> BoundedQuadratic::solveBordered(const std::vector<Index>& changed,
                                                                          const std::vector<char>& free,
                                                                          const VectorXd& b) {
  constexpr int kMostRefinements = 3;
  appendColumns(changed);
  std::vector<Index> columns, added, atAdded;
  for (const Index i : changed) {
    const auto k = static_cast<std::size_t>(i);
    if (free[k]) {
      added.push_back(i);
      atAdded.push_back(static_cast<Index>(columns.size()));
    }
    columns.push_back(mColumnOf[k]);
  }
  const MatrixXd border = mColumns(Eigen::all, columns);
  MatrixXd complement = MatrixXd::Zero(border.cols(), border.cols());
  complement(atAdded, atAdded) = mH(added, added);
  complement.noalias() -= border.transpose() * border;
  Eigen::PartialPivLU<MatrixXd> schur;
  if (!changed.empty()) schur.compute(complement);

  Solution solution{VectorXd::Zero(b.size()), -b};
  const double goal = kTolerance * b.cwiseAbs().maxCoeff();
  for (int pass = 0; pass <= kMostRefinements; ++pass) {
    VectorXd inner = mFactor->forward(-solution.slope(mFactored)), outer = -border.transpose() * inner;
    for (std::size_t k = 0; k < added.size(); ++k) outer[atAdded[k]] -= solution.slope[added[k]];
    if (!changed.empty()) outer = schur.solve(outer);
    inner.noalias() -= border * outer;
    solution.x(mFactored) += mFactor->backward(inner);
    for (std::size_t k = 0; k < added.size(); ++k) solution.x[added[k]] += outer[atAdded[k]];
    for (const Index i : changed)
      if (!free[static_cast<std::size_t>(i)]) solution.x[i] = 0;
    solution.slope = mH * solution.x - b;
    double error = 0;
    for (Index i = 0; i < b.size(); ++i)
      if (free[static_cast<std::size_t>(i)]) error = std::max(error, std::abs(solution.slope[i]));
    if (error <= goal / 4) return solution;
    if (!(error < 1e300)) break;
  }
  return std::nullopt;
}

/// The minimum over the free variables; the others are 0.
std::optional<BoundedQuadratic::Solution> BoundedQuadratic::solve(const std::vector<char>& free, const VectorXd& b) {
  if (mFactor) {
    std::vector<Index> changed;
    for (std::size_t i = 0; i < free.size(); ++i)
      if (!free[i] != !mIsFactored[i]) changed.push_back(static_cast<Index>(i));
    if (static_cast<double>(changed.size()) <= kMostChanged * static_cast<double>(mFactored.size()))
      if (std::optional<Solution> solution = solveBordered(changed, free, b)) return solution;
  }
  if (!factor(free)) return std::nullopt;
  Solution solution{VectorXd::Zero(b.size()), -b};
  if (!mFactored.empty()) {
    solution.x(mFactored) = mFactor->solve(b(mFactored));
    solution.slope = mH * solution.x - b;
  }
  return solution;
}

std::optional<VectorXd> BoundedQuadratic::minimise(const VectorXd& b, const std::vector<char>& bounded,
                                                   std::vector<char>& passive) {
  // Exchanging all variables that violate their sign converges fast but may cycle. If their number does not fall within
  // this many steps, single exchanges, which cannot cycle, take over until it does.
  constexpr int kPatience = 3;
  const Index n = b.size();
  const double tolerance = kTolerance * b.cwiseAbs().maxCoeff();
  for (std::size_t i = 0; i < bounded.size(); ++i)
    if (!bounded[i]) passive[i] = 1;
  VectorXd x;
  std::size_t fewest = static_cast<std::size_t>(n) + 1;
  int patience = kPatience;
  for (Index round = 0; round <= 3 * n; ++round) {
    std::optional<Solution> solution = solve(passive, b);
    if (!solution) return std::nullopt;
    x = std::move(solution->x);
    std::vector<std::size_t> wrong;
    for (Index i = 0; i < n; ++i) {
      const auto k = static_cast<std::size_t>(i);
      if (bounded[k] && (passive[k] ? x[i] < 0 : solution->slope[i] < -tolerance)) wrong.push_back(k);
    }
    if (wrong.empty()) break;
    if (wrong.size() < fewest) {
      fewest = wrong.size();
      patience = kPatience;
    } else if (patience > 0) {
      --patience;
    } else {
      wrong.assign(1, wrong.back());
    }
    for (const std::size_t k : wrong) passive[k] = !passive[k];
  }
  for (Index i = 0; i < n; ++i)
    if (bounded[static_cast<std::size_t>(i)] && x[i] < 0) x[i] = 0;
  return x;
}

}  // namespace julia
