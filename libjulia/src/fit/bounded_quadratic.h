// SPDX-License-Identifier: Apache-2.0
/// @file bounded_quadratic.h
/// Convex quadratic programs whose only constraints are signs.
#pragma once

#include "fit/cholesky.h"

#include <Eigen/Core>

#include <optional>
#include <vector>

namespace julia {

/// Minimises x^T H x / 2 - b^T x with x_i >= 0 where bounded, by block principal pivoting [Portugal, Júdice & Vicente,
/// A comparison of block pivoting and interior-point algorithms for linear least squares problems with nonnegative
/// variables, Math. Comp. 63, 1994].
///
/// H is factored for one set of free variables. For other sets that differ little, here or in later programs with the
/// same H, the factor is bordered: each variable that is freed or fixed at 0 adds a row and a column to a small dense
/// system, the Schur complement.
class BoundedQuadratic {
 public:
  /// @param H  symmetric
  explicit BoundedQuadratic(Eigen::MatrixXd H) : mH(std::move(H)) {}

  const Eigen::MatrixXd& matrix() const { return mH; }

  /// @param passive  in: a guess of which variables are not at their bound; out: those that are not
  /// @return empty if H is not positive definite in floating point
  std::optional<Eigen::VectorXd> minimise(const Eigen::VectorXd& b, const std::vector<char>& bounded,
                                          std::vector<char>& passive);

 private:
  struct Solution {
    Eigen::VectorXd x, slope;
  };
  bool factor(const std::vector<char>& free);
  void appendColumns(const std::vector<Eigen::Index>& changed);
  std::optional<Solution> solve(const std::vector<char>& free, const Eigen::VectorXd& b);
  std::optional<Solution> solveBordered(const std::vector<Eigen::Index>& changed, const std::vector<char>& free,
                                        const Eigen::VectorXd& b);

  Eigen::MatrixXd mH;
  std::optional<Cholesky> mFactor;
  std::vector<char> mIsFactored;
  std::vector<Eigen::Index> mFactored;
  /// The solutions of the factor for the columns of variables whose state (free or at 0) has differed from the
  /// factor's.
  Eigen::MatrixXd mColumns;
  std::vector<Eigen::Index> mColumnOf;  ///< the column of each variable in mColumns; -1 for none
};

}  // namespace julia
