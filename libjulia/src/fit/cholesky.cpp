// SPDX-License-Identifier: Apache-2.0
#include "fit/cholesky.h"

#include "kernels/kernels.h"

#include <tbb/parallel_for.h>
#include <Eigen/Cholesky>

#include <algorithm>
#include <cstddef>
#include <vector>

namespace julia {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using kernels::kTile;

constexpr auto kSide = static_cast<Index>(kTile);
using Tile = Eigen::Matrix<double, kSide, kSide>;
using TileVector = Eigen::Matrix<double, kSide, 1>;

// Columns whose products are summed at once: this many of two rows of tiles stay in the second-level cache.
constexpr std::size_t kDepth = 256;

/// The factor by rows of tiles, each row with its columns one after the other, as tileProduct() takes them at any
/// depth. Beyond the end of the matrix it continues as the unit matrix.
class Factor {
 public:
  explicit Factor(Index size) : mSide((size + kSide - 1) / kSide), mTiles(static_cast<std::size_t>(mSide * mSide)) {}

  Index side() const { return mSide; }
  Tile& tile(Index row, Index column) { return mTiles[static_cast<std::size_t>(row * mSide + column)]; }

  /// Subtracts the products of all columns to the left from a tile.
  void reduce(Index row, Index column) {
    alignas(64) Tile product;
    const std::size_t depth = static_cast<std::size_t>(column) * kTile;
    for (std::size_t k = 0; k < depth; k += kDepth) {
      kernels::kernels<double>().tileProduct(tile(column, 0).data() + k * kTile, tile(row, 0).data() + k * kTile,
                                             std::min(kDepth, depth - k), product.data());
      tile(row, column) -= product;
    }
  }

 private:
  Index mSide;
  std::vector<Tile> mTiles;
};

}  // namespace

std::optional<VectorXd> solveCholesky(const Eigen::MatrixXd& A, const VectorXd& b) {
  const Index size = b.size();
  Factor L(size);
  tbb::parallel_for(Index{0}, L.side(), [&](Index row) {
    const Index height = std::min(kSide, size - row * kSide);
    for (Index column = 0; column <= row; ++column) {
      const Index width = std::min(kSide, size - column * kSide);
      if (height < kSide || width < kSide) L.tile(row, column).setIdentity();
      if (height < kSide && row != column) L.tile(row, column).setZero();
      L.tile(row, column).topLeftCorner(height, width) = A.block(row * kSide, column * kSide, height, width);
    }
  });
  for (Index column = 0; column < L.side(); ++column) {
    tbb::parallel_for(column, L.side(), [&](Index row) { L.reduce(row, column); });
    const Eigen::LLT<Tile> diagonal(L.tile(column, column));
    if (diagonal.info() != Eigen::Success) return std::nullopt;
    L.tile(column, column) = diagonal.matrixL();
    tbb::parallel_for(column + 1, L.side(),
                      [&](Index row) { diagonal.matrixU().solveInPlace<Eigen::OnTheRight>(L.tile(row, column)); });
  }

  VectorXd x = VectorXd::Zero(L.side() * kSide);
  x.head(size) = b;
  for (Index row = 0; row < L.side(); ++row) {
    TileVector part = x.segment<kSide>(row * kSide);
    for (Index column = 0; column < row; ++column)
      part.noalias() -= L.tile(row, column) * x.segment<kSide>(column * kSide);
    L.tile(row, row).triangularView<Eigen::Lower>().solveInPlace(part);
    x.segment<kSide>(row * kSide) = part;
  }
  for (Index row = L.side() - 1; row >= 0; --row) {
    TileVector part = x.segment<kSide>(row * kSide);
    L.tile(row, row).triangularView<Eigen::Lower>().transpose().solveInPlace(part);
    x.segment<kSide>(row * kSide) = part;
    for (Index column = 0; column < row; ++column)
      x.segment<kSide>(column * kSide).noalias() -= L.tile(row, column).transpose() * part;
  }
  return VectorXd(x.head(size));
}

}  // namespace julia
