// SPDX-License-Identifier: Apache-2.0
#include "fit/log_matrix.h"

#include "kernels/kernels.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>

namespace julia {

namespace {

// Blocks whose products are summed by one thread before they meet the others'.
constexpr std::size_t kBlocksPerPart = 8;

}  // namespace

LogMatrix::LogMatrix(std::span<const Point> cells, std::size_t memoryLimit)
    : mCellCount(cells.size()), mMemoryLimit(memoryLimit) {
  const std::size_t padded = (cells.size() + kBlock - 1) / kBlock * kBlock;
  mX.resize(padded);
  mY.resize(padded);
  mZ.resize(padded);
  for (std::size_t i = 0; i < cells.size(); ++i) {
    mX[i] = static_cast<float>(cells[i][0]);
    mY[i] = static_cast<float>(cells[i][1]);
    mZ[i] = static_cast<float>(cells[i][2]);
  }
  mBlocks.resize(blockCount());
}

void LogMatrix::fill(std::size_t block, std::size_t firstRoot, float* columns) const {
  const std::size_t at = block * kBlock;
  for (std::size_t j = firstRoot; j < mRoots.size(); ++j, columns += kBlock) {
    const Quaternion<float> r = mRoots[j].as<float>();
    const float root[3] = {r.a, r.b, r.c};
    kernels::kernels<float>().logDistances(root, r.d * r.d, &mX[at], &mY[at], &mZ[at], columns, kBlock);
  }
}

const float* LogMatrix::columns(std::size_t block, std::vector<float>& scratch) const {
  if (mStored) return mBlocks[block].data();
  scratch.resize(mRoots.size() * kBlock);
  fill(block, 0, scratch.data());
  return scratch.data();
}

void LogMatrix::decideStorage() {
  if (!mStored || mRoots.size() * mX.size() <= mMemoryLimit / sizeof(float)) return;
  mStored = false;
  mBlocks.clear();
  mBlocks.shrink_to_fit();
}

void LogMatrix::append(std::span<const Quaternion<double>> roots) {
  const std::size_t before = mRoots.size();
  mRoots.insert(mRoots.end(), roots.begin(), roots.end());
  decideStorage();
  if (!mStored) return;
  tbb::parallel_for(std::size_t{0}, blockCount(), [&](std::size_t block) {
    mBlocks[block].resize(mRoots.size() * kBlock);
    fill(block, before, mBlocks[block].data() + before * kBlock);
  });
}

void LogMatrix::keep(std::span<const std::size_t> indices) {
  for (std::size_t j = 0; j < indices.size(); ++j) mRoots[j] = mRoots[indices[j]];
  mRoots.resize(indices.size());
  if (!mStored) return;
  tbb::parallel_for(std::size_t{0}, blockCount(), [&](std::size_t block) {
    std::vector<float>& columns = mBlocks[block];
    for (std::size_t j = 0; j < indices.size(); ++j)
      if (indices[j] != j)
        std::copy_n(columns.begin() + static_cast<std::ptrdiff_t>(indices[j] * kBlock), kBlock,
                    columns.begin() + static_cast<std::ptrdiff_t>(j * kBlock));
    columns.resize(indices.size() * kBlock);
  });
}

LogMatrix::Pass LogMatrix::pass(std::span<const double> weights, double constant, const Visitor& visit,
                                bool wantProducts) const {
  const std::size_t roots = mRoots.size(), blocks = blockCount();
  const std::size_t parts = (blocks + kBlocksPerPart - 1) / kBlocksPerPart;
  std::vector<Pass> partial(parts);
  const kernels::Kernels<float>& kernel = kernels::kernels<float>();
  tbb::parallel_for(std::size_t{0}, parts, [&](std::size_t part) {
    Pass& sum = partial[part];
    if (wantProducts) sum.products.assign(roots + 1, 0);
    alignas(64) std::array<double, kBlock> l, factors;
    std::vector<float> scratch;
    std::vector<double> products(roots);
    for (std::size_t block = part * kBlocksPerPart; block < std::min(blocks, (part + 1) * kBlocksPerPart); ++block) {
      const float* const logs = columns(block, scratch);
      const std::size_t begin = block * kBlock, size = std::min(kBlock, mCellCount - begin);
      l.fill(constant);
      kernel.addColumns(logs, weights.data(), roots, l.data(), kBlock);
      factors.fill(0);
      sum.sum += visit(begin, {l.data(), size}, {factors.data(), size});
      if (!wantProducts) continue;
      kernel.dotColumns(logs, factors.data(), roots, products.data(), kBlock);
      for (std::size_t j = 0; j < roots; ++j) sum.products[j] += products[j];
      for (std::size_t i = 0; i < size; ++i) sum.products[roots] += factors[i];
    }
  });
  Pass result;
  if (wantProducts) result.products.assign(roots + 1, 0);
  for (const Pass& part : partial) {
    result.sum += part.sum;
    for (std::size_t j = 0; j < result.products.size(); ++j) result.products[j] += part.products[j];
  }
  return result;
}

void LogMatrix::logModuli(std::span<const double> weights, double constant, std::span<double> l) const {
  pass(
      weights, constant,
      [&](std::size_t begin, std::span<const double> block, std::span<double>) {
        std::copy(block.begin(), block.end(), l.begin() + static_cast<std::ptrdiff_t>(begin));
        return 0.0;
      },
      false);
}

Eigen::MatrixXd LogMatrix::gram(std::span<const double> d, std::size_t stride) const {
  using Index = Eigen::Index;
  using kernels::kTile;
  const std::size_t roots = mRoots.size(), blocks = blockCount();
  const std::size_t counted = (blocks + stride - 1) / stride;
  const double share = static_cast<double>(blocks) / static_cast<double>(std::max<std::size_t>(counted, 1));
  const std::size_t side = (roots + kTile) / kTile;  // of the column of ones too
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(static_cast<Index>(roots) + 1, static_cast<Index>(roots) + 1);
  // A panel of blocks at a time, in tiles: the columns as they are, and multiplied by d.
  constexpr std::size_t kTileSize = kBlock * kTile;
  std::vector<float> plain(kBlocksPerPart * side * kTileSize), scaled(plain.size());
  for (std::size_t first = 0; first < blocks; first += stride * kBlocksPerPart) {
    const std::size_t inPanel = std::min(kBlocksPerPart, (blocks - first + stride - 1) / stride);
    tbb::parallel_for(std::size_t{0}, inPanel, [&](std::size_t k) {
      std::vector<float> scratch;
      const std::size_t block = first + k * stride, begin = block * kBlock;
      const float* const logs = columns(block, scratch);
      std::array<float, kBlock> factors{};
      for (std::size_t i = begin; i < std::min(begin + kBlock, mCellCount); ++i)
        factors[i - begin] = static_cast<float>(d[i] * share);
      for (std::size_t j = 0; j <= roots; ++j) {
        const std::size_t at = (k * side + j / kTile) * kTileSize + j % kTile;
        for (std::size_t i = 0; i < kBlock; ++i) {
          const float value = j < roots ? logs[j * kBlock + i] : 1;
          plain[at + i * kTile] = value;
          scaled[at + i * kTile] = value * factors[i];
        }
      }
    });
    tbb::parallel_for(std::size_t{0}, side * (side + 1) / 2, [&](std::size_t pair) {
      std::size_t row = 0;
      while ((row + 1) * (row + 2) / 2 <= pair) ++row;
      const std::size_t column = pair - row * (row + 1) / 2;
      const std::size_t height = std::min(kTile, roots + 1 - row * kTile);
      const std::size_t width = std::min(kTile, roots + 1 - column * kTile);
      alignas(64) std::array<float, kTile * kTile> product;
      for (std::size_t k = 0; k < inPanel; ++k) {
        kernels::kernels<float>().tileProduct(&plain[(k * side + column) * kTileSize],
                                              &scaled[(k * side + row) * kTileSize], kBlock, product.data());
        for (std::size_t j = 0; j < width; ++j) {
          double* const to = &gram(static_cast<Index>(row * kTile), static_cast<Index>(column * kTile + j));
          for (std::size_t i = 0; i < height; ++i) to[i] += product[j * kTile + i];
        }
      }
    });
  }
  gram.triangularView<Eigen::StrictlyUpper>() = gram.transpose();
  return gram;
}

}  // namespace julia
