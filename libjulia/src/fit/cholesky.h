// SPDX-License-Identifier: Apache-2.0
/// @file cholesky.h
/// Cholesky factorisation of dense matrices, in tiles that are shared between threads. Eigen's uses one thread, and
/// here only narrow vectors, because wide ones would sum in another order on another machine.
#pragma once

#include <Eigen/Core>

#include <optional>

namespace julia {

/// Solves A x = b. @a A is symmetric; only its lower triangle is read.
/// @return x, or nothing if A is not positive definite in floating point
std::optional<Eigen::VectorXd> solveCholesky(const Eigen::MatrixXd& A, const Eigen::VectorXd& b);

}  // namespace julia
