// SPDX-License-Identifier: Apache-2.0
/// @file cholesky.h
/// Cholesky factorisation of dense matrices, in tiles that threads share. Eigen's factorisation uses one thread and, in
/// this project, only narrow vectors, because wide ones would sum in a different order on other machines.
#pragma once

#include "kernels/kernels.h"

#include <Eigen/Core>

#include <cstddef>
#include <optional>
#include <vector>

namespace julia {

/// The lower triangular L of A = L L^T.
class Cholesky {
 public:
  /// @param A  symmetric; only its lower triangle is read
  /// @return empty if A is not positive definite in floating point
  static std::optional<Cholesky> of(const Eigen::MatrixXd& A);

  Eigen::Index size() const { return mSize; }
  /// A^-1 b.
  Eigen::VectorXd solve(const Eigen::VectorXd& b) const { return backward(forward(b)); }
  /// L^-1 b.
  Eigen::VectorXd forward(const Eigen::VectorXd& b) const;
  /// L^-T b.
  Eigen::VectorXd backward(const Eigen::VectorXd& b) const;
  /// L^-1 B, columns in parallel.
  Eigen::MatrixXd forwardAll(const Eigen::MatrixXd& B) const;

 private:
  static constexpr auto kSide = static_cast<Eigen::Index>(kernels::kTile);
  using Tile = Eigen::Matrix<double, kSide, kSide>;
  using TileVector = Eigen::Matrix<double, kSide, 1>;

  explicit Cholesky(Eigen::Index size);
  /// Tiles are stored in rows, each with its columns up to the diagonal, in the layout that tileProduct() needs for any
  /// depth. Beyond the end of the matrix the factor continues as the identity matrix.
  Tile& tile(Eigen::Index row, Eigen::Index column) {
    return mTiles[static_cast<std::size_t>(row * (row + 1) / 2 + column)];
  }
  const Tile& tile(Eigen::Index row, Eigen::Index column) const {
    return mTiles[static_cast<std::size_t>(row * (row + 1) / 2 + column)];
  }
  void reduce(const Tile* row, Eigen::Index column, Tile& reduced) const;

  Eigen::Index mSize, mSide;
  std::vector<Tile> mTiles;
};

}  // namespace julia
