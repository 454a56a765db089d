// SPDX-License-Identifier: Apache-2.0
/// @file log_matrix.h
/// The constant matrix of the fit (docs/design.md 2.6): ln|x - r| of every cell x, in the slice 0, and root r. With the
/// roots fixed the log-modulus of a rational is linear in the powers, so an energy and its gradient are one pass over
/// it.
#pragma once

#include <Eigen/Core>

#include "fit/cell_sample.h"
#include "julia/embedding.h"
#include "julia/quaternion.h"

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

namespace julia {

/// Cells stand in blocks, padded by cells that the visitors below do not see; a block holds one column a root. Sums are
/// formed block by block in a fixed order, so that threads do not change them.
class LogMatrix {
 public:
  static constexpr std::size_t kBlock = 256;

  /// @param memoryLimit  bytes; a larger matrix is not stored but made anew by each pass
  LogMatrix(std::span<const Point> cells, std::size_t memoryLimit);

  std::size_t cellCount() const { return mCellCount; }
  std::size_t rootCount() const { return mRoots.size(); }
  const std::vector<Quaternion<double>>& roots() const { return mRoots; }
  bool stored() const { return mStored; }

  void append(std::span<const Quaternion<double>> roots);
  /// Keeps the columns @a indices, ascending.
  void keep(std::span<const std::size_t> indices);

  /// Takes l = constant + sum of weights times logs of the cells begin to begin + size, and leaves in @a factors what
  /// they are multiplied by in the products. Called for blocks in many threads. @return a summand
  using Visitor = std::function<double(std::size_t begin, std::span<const double> l, std::span<double> factors)>;

  struct Pass {
    double sum = 0;                ///< of what the visitor returned
    std::vector<double> products;  ///< A^T factors, and last the sum of the factors
  };
  Pass pass(std::span<const double> weights, double constant, const Visitor& visit, bool wantProducts) const;

  void logModuli(std::span<const double> weights, double constant, std::span<double> l) const;

  /// [A 1]^T diag(w) [A 1] of the weighted cells, lower triangle and upper.
  /// @param gram  in: that of the first roots and the same cells, or empty; out: that of all roots. Only what is
  /// missing
  ///              is summed.
  void extendGram(const CellSample& sample, Eigen::MatrixXd& gram) const;

 private:
  std::size_t blockCount() const { return mX.size() / kBlock; }
  void logs(std::size_t root, const float* x, const float* y, const float* z, float* out) const;
  void fill(std::size_t block, std::size_t firstRoot, float* columns) const;
  void fillTiles(const CellSample& sample, std::size_t first, float* tiles) const;
  const float* columns(std::size_t block, std::vector<float>& scratch) const;
  void decideStorage();

  std::size_t mCellCount, mMemoryLimit;
  std::vector<float> mX, mY, mZ;  // padded
  std::vector<Quaternion<double>> mRoots;
  bool mStored = true;
  std::vector<std::vector<float>> mBlocks;  // if stored
};

}  // namespace julia
