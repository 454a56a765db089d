// SPDX-License-Identifier: Apache-2.0
/// @file cholesky.h
/// Cholesky's factors of dense matrices, in tiles that threads share. Eigen's work on one thread, and must do without
/// wide vectors, which sum in another order on another machine.
#pragma once

#include "fit/eigen_setup.h"

#include <optional>

namespace julia {

/// x of A x = b. Of @a A, which is symmetric, the lower triangle is read.
/// @return nothing where A is not positive definite in floating point
std::optional<Eigen::VectorXd> solveCholesky(const Eigen::MatrixXd& A, const Eigen::VectorXd& b);

}  // namespace julia
