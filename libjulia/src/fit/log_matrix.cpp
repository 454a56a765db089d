// SPDX-License-Identifier: Apache-2.0
#include "fit/log_matrix.h"

#include "kernels/kernels.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace julia {

namespace {

// Blocks whose products one thread sums before they are added to the others'.
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

/// Computes the logarithms for a block of cells.
void LogMatrix::logs(std::size_t root, const float* x, const float* y, const float* z, float* out) const {
  const Quaternion<float> r = mRoots[root].as<float>();
  const float place[3] = {r.a, r.b, r.c};
  kernels::kernels<float>().logDistances(place, r.d * r.d, x, y, z, out, kBlock);
}

void LogMatrix::fill(std::size_t block, std::size_t firstRoot, float* columns) const {
  const std::size_t at = block * kBlock;
  for (std::size_t j = firstRoot; j < mRoots.size(); ++j, columns += kBlock)
    logs(j, &mX[at], &mY[at], &mZ[at], columns);
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

void LogMatrix::move(std::span<const Quaternion<double>> places) {
  mRoots.assign(places.begin(), places.end());
  if (!mStored) return;
  tbb::parallel_for(std::size_t{0}, blockCount(), [&](std::size_t block) { fill(block, 0, mBlocks[block].data()); });
}

/// Adds to @a sums what the cells of a block contribute to Pass::places.
void LogMatrix::addPlaces(std::size_t block, const double* factors, std::span<Quaternion<double>> sums) const {
  constexpr std::size_t kCoordinates = 4;
  const kernels::Kernels<float>& kernel = kernels::kernels<float>();
  const std::size_t at = block * kBlock;
  alignas(64) std::array<float, kCoordinates * kBlock> columns;
  std::array<double, kCoordinates> products;
  for (std::size_t j = 0; j < mRoots.size(); ++j) {
    const Quaternion<float> r = mRoots[j].as<float>();
    const float root[kCoordinates] = {r.a, r.b, r.c, r.d};
    kernel.logSlopes(root, &mX[at], &mY[at], &mZ[at], columns.data(), kBlock);
    kernel.dotColumns(columns.data(), factors, kCoordinates, products.data(), kBlock);
    sums[j] = sums[j] + Quaternion<double>{products[0], products[1], products[2], products[3]};
  }
}

LogMatrix::Pass LogMatrix::pass(std::span<const double> weights, double constant, const Visitor& visit,
                                Products want) const {
  const std::size_t roots = mRoots.size(), blocks = blockCount();
  const std::size_t parts = (blocks + kBlocksPerPart - 1) / kBlocksPerPart;
  std::vector<Pass> partial(parts);
  const kernels::Kernels<float>& kernel = kernels::kernels<float>();
  tbb::parallel_for(std::size_t{0}, parts, [&](std::size_t part) {
    Pass& sum = partial[part];
    if (want != Products::None) sum.products.assign(roots + 1, 0);
    if (want == Products::LogsAndPlaces) sum.places.assign(roots, {});
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
      if (want == Products::None) continue;
      kernel.dotColumns(logs, factors.data(), roots, products.data(), kBlock);
      for (std::size_t j = 0; j < roots; ++j) sum.products[j] += products[j];
      for (std::size_t i = 0; i < size; ++i) sum.products[roots] += factors[i];
      if (want == Products::LogsAndPlaces) addPlaces(block, factors.data(), sum.places);
    }
  });
  Pass result;
  if (want != Products::None) result.products.assign(roots + 1, 0);
  if (want == Products::LogsAndPlaces) result.places.assign(roots, {});
  for (const Pass& part : partial) {
    result.sum += part.sum;
    for (std::size_t j = 0; j < result.products.size(); ++j) result.products[j] += part.products[j];
    for (std::size_t j = 0; j < result.places.size(); ++j) result.places[j] = result.places[j] + part.places[j];
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
      Products::None);
}

/// Fills the tiles for a block of the sample's cells from @a first on, in the layout of tileProduct(): a tile for each
/// kTile columns, where the last column consists of ones, times the square roots of the weights.
void LogMatrix::fillTiles(const CellSample& sample, std::size_t first, float* tiles) const {
  using kernels::kTile;
  constexpr std::size_t kRun = 16;  // cells whose part of a tile stays in the first-level cache
  static_assert(kBlock % kRun == 0);
  alignas(64) std::array<float, kBlock> x{}, y{}, z{}, roots{};
  for (std::size_t i = 0; i < std::min(kBlock, sample.cells.size() - first); ++i) {
    const std::size_t cell = sample.cells[first + i];
    x[i] = mX[cell];
    y[i] = mY[cell];
    z[i] = mZ[cell];
    roots[i] = static_cast<float>(std::sqrt(sample.weights[first + i]));
  }
  std::vector<float> columns(kTile * kBlock);
  for (std::size_t j = 0; j <= mRoots.size(); j += kTile, tiles += kTile * kBlock) {
    for (std::size_t k = 0; k < kTile; ++k) {
      float* const column = &columns[k * kBlock];
      if (j + k < mRoots.size())
        logs(j + k, x.data(), y.data(), z.data(), column);
      else
        std::fill_n(column, kBlock, j + k == mRoots.size() ? 1.0f : 0.0f);
    }
    for (std::size_t run = 0; run < kBlock; run += kRun)
      for (std::size_t k = 0; k < kTile; ++k)
        for (std::size_t i = run; i < run + kRun; ++i) tiles[i * kTile + k] = columns[k * kBlock + i] * roots[i];
  }
}

void LogMatrix::extendGram(const CellSample& sample, Eigen::MatrixXd& gram) const {
  using Eigen::Index;
  using kernels::kTile;
  const std::size_t size = mRoots.size() + 1, side = (size + kTile - 1) / kTile;
  // The known part is kept, without the row and the column of the ones, which move to the end.
  const auto known = static_cast<std::size_t>(std::max<Index>(gram.rows(), 1)) - 1;
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(static_cast<Index>(size), static_cast<Index>(size));
  // Processes several blocks of cells at a time.
  const std::size_t blocks = (sample.cells.size() + kBlock - 1) / kBlock, firstRow = known / kTile;
  constexpr std::size_t kTileSize = kBlock * kTile;
  std::vector<float> tiles(std::min(kBlocksPerPart, blocks) * side * kTileSize);
  for (std::size_t first = 0; first < blocks; first += kBlocksPerPart) {
    const std::size_t inPanel = std::min(kBlocksPerPart, blocks - first);
    tbb::parallel_for(std::size_t{0}, inPanel,
                      [&](std::size_t k) { fillTiles(sample, (first + k) * kBlock, &tiles[k * side * kTileSize]); });
    const std::size_t before = firstRow * (firstRow + 1) / 2;
    tbb::parallel_for(before, side * (side + 1) / 2, [&](std::size_t pair) {
      std::size_t row = firstRow;
      while ((row + 1) * (row + 2) / 2 <= pair) ++row;
      const std::size_t column = pair - row * (row + 1) / 2;
      const std::size_t height = std::min(kTile, size - row * kTile), width = std::min(kTile, size - column * kTile);
      alignas(64) std::array<float, kTile * kTile> product;
      for (std::size_t k = 0; k < inPanel; ++k) {
        kernels::kernels<float>().tileProduct(&tiles[(k * side + column) * kTileSize],
                                              &tiles[(k * side + row) * kTileSize], kBlock, product.data());
        for (std::size_t j = 0; j < width; ++j) {
          double* const to = &sum(static_cast<Index>(row * kTile), static_cast<Index>(column * kTile + j));
          for (std::size_t i = 0; i < height; ++i) to[i] += product[j * kTile + i];
        }
      }
    });
  }
  if (known > 0) {
    const auto n = static_cast<Index>(known);
    sum.topLeftCorner(n, n) = gram.topLeftCorner(n, n);
  }
  sum.triangularView<Eigen::StrictlyUpper>() = sum.transpose();
  gram = std::move(sum);
}

}  // namespace julia
