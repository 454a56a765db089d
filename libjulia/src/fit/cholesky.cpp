// SPDX-License-Identifier: Apache-2.0
#include "fit/cholesky.h"

#include <tbb/parallel_for.h>
#include <Eigen/Cholesky>

#include <algorithm>

namespace julia {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using kernels::kTile;

namespace {

// Columns whose products are summed at a time: this many of two rows of tiles fit in the second-level cache.
constexpr std::size_t kDepth = 256;

}  // namespace

Cholesky::Cholesky(Index size)
    : mSize(size), mSide((size + kSide - 1) / kSide), mTiles(static_cast<std::size_t>(mSide * (mSide + 1) / 2)) {}

/// Subtracts the products of a row's first tiles with the factor's row @a column, up to its diagonal.
void Cholesky::reduce(const Tile* row, Index column, Tile& reduced) const {
  alignas(64) Tile product;
  const std::size_t depth = static_cast<std::size_t>(column) * kTile;
  for (std::size_t k = 0; k < depth; k += kDepth) {
    kernels::kernels<double>().tileProduct(tile(column, 0).data() + k * kTile, row->data() + k * kTile,
                                           std::min(kDepth, depth - k), product.data());
    reduced -= product;
  }
}

std::optional<Cholesky> Cholesky::of(const MatrixXd& A) {
  const Index size = A.rows();
  Cholesky L(size);
  tbb::parallel_for(Index{0}, L.mSide, [&](Index row) {
    const Index height = std::min(kSide, size - row * kSide);
    for (Index column = 0; column <= row; ++column) {
      const Index width = std::min(kSide, size - column * kSide);
      if (height < kSide || width < kSide) L.tile(row, column).setIdentity();
      if (height < kSide && row != column) L.tile(row, column).setZero();
      L.tile(row, column).topLeftCorner(height, width) = A.block(row * kSide, column * kSide, height, width);
    }
  });
  for (Index column = 0; column < L.mSide; ++column) {
    tbb::parallel_for(column, L.mSide, [&](Index row) { L.reduce(&L.tile(row, 0), column, L.tile(row, column)); });
    const Eigen::LLT<Tile> diagonal(L.tile(column, column));
    if (diagonal.info() != Eigen::Success) return std::nullopt;
    L.tile(column, column) = diagonal.matrixL();
    tbb::parallel_for(column + 1, L.mSide,
                      [&](Index row) { diagonal.matrixU().solveInPlace<Eigen::OnTheRight>(L.tile(row, column)); });
  }
  return L;
}

VectorXd Cholesky::forward(const VectorXd& b) const {
  VectorXd x = VectorXd::Zero(mSide * kSide);
  x.head(mSize) = b;
  for (Index row = 0; row < mSide; ++row) {
    TileVector part = x.segment<kSide>(row * kSide);
    for (Index column = 0; column < row; ++column)
      part.noalias() -= tile(row, column) * x.segment<kSide>(column * kSide);
    tile(row, row).triangularView<Eigen::Lower>().solveInPlace(part);
    x.segment<kSide>(row * kSide) = part;
  }
  return VectorXd(x.head(mSize));
}

VectorXd Cholesky::backward(const VectorXd& b) const {
  VectorXd x = VectorXd::Zero(mSide * kSide);
  x.head(mSize) = b;
  for (Index row = mSide - 1; row >= 0; --row) {
    TileVector part = x.segment<kSide>(row * kSide);
    tile(row, row).triangularView<Eigen::Lower>().transpose().solveInPlace(part);
    x.segment<kSide>(row * kSide) = part;
    for (Index column = 0; column < row; ++column)
      x.segment<kSide>(column * kSide).noalias() -= tile(row, column).transpose() * part;
  }
  return VectorXd(x.head(mSize));
}

MatrixXd Cholesky::forwardAll(const MatrixXd& B) const {
  MatrixXd X = MatrixXd::Zero(B.rows(), B.cols());
  // The transposed columns are computed like further rows of the factor.
  tbb::parallel_for(Index{0}, (B.cols() + kSide - 1) / kSide, [&](Index strip) {
    const Index begin = strip * kSide, width = std::min(kSide, B.cols() - begin);
    std::vector<Tile> row(static_cast<std::size_t>(mSide), Tile::Zero());
    for (Index column = 0; column < mSide; ++column) {
      const Index top = column * kSide, height = std::min(kSide, mSize - top);
      Tile& at = row[static_cast<std::size_t>(column)];
      at.topLeftCorner(width, height) = B.block(top, begin, height, width).transpose();
      reduce(row.data(), column, at);
      tile(column, column).triangularView<Eigen::Lower>().transpose().solveInPlace<Eigen::OnTheRight>(at);
      X.block(top, begin, height, width) = at.topLeftCorner(width, height).transpose();
    }
  });
  return X;
}

}  // namespace julia
