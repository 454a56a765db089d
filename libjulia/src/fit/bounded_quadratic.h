// SPDX-License-Identifier: Apache-2.0
/// @file bounded_quadratic.h
/// Convex quadratic programs whose only constraints are signs.
#pragma once

#include <Eigen/Core>

#include <optional>
#include <vector>

namespace julia {

/// The x that minimises x^T H x / 2 - b^T x with x_i >= 0 where @a bounded, by block principal pivoting [Portugal,
/// Júdice & Vicente, A comparison of block pivoting and interior-point algorithms for linear least squares problems
/// with nonnegative variables, Math. Comp. 63, 1994].
/// @param H        symmetric
/// @param passive  in: a guess of which variables are not at their bound; out: which are not
/// @return nothing where H is not positive definite in floating point
std::optional<Eigen::VectorXd> minimiseBounded(const Eigen::MatrixXd& H, const Eigen::VectorXd& b,
                                               const std::vector<char>& bounded, std::vector<char>& passive);

}  // namespace julia
