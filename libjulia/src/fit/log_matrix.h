// SPDX-License-Identifier: Apache-2.0
/// @file log_matrix.h
/// The constant matrix of the fit (docs/design.md 2.6): ln|x - r| for every cell x, in the slice 0, and root r. With
/// the roots fixed the log-modulus of a rational is linear in the powers, so an energy and its gradient take one pass
/// over the matrix.
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

/// Cells are stored in blocks, padded by cells that the visitors below do not see; a block holds one column per root.
/// Sums are accumulated block by block in a fixed order, so they do not depend on the threads.
class LogMatrix {
 public:
  static constexpr std::size_t kBlock = 256;

  /// @param memoryLimit  bytes; a larger matrix is not stored but recomputed in each pass
  LogMatrix(std::span<const Point> cells, std::size_t memoryLimit);

  std::size_t cellCount() const { return mCellCount; }
  std::size_t rootCount() const { return mRoots.size(); }
  const std::vector<Quaternion<double>>& roots() const { return mRoots; }
  bool stored() const { return mStored; }

  void append(std::span<const Quaternion<double>> roots);
  /// Keeps the columns @a indices, ascending.
  void keep(std::span<const std::size_t> indices);
  /// Moves every root. @pre as many places as there are roots
  void move(std::span<const Quaternion<double>> places);

  /// Receives l = constant + sum of weights times logs for the cells begin to begin + size, and writes to @a factors
  /// the factors of the cells in the products. Many threads call it for different blocks. @return a summand
  using Visitor = std::function<double(std::size_t begin, std::span<const double> l, std::span<double> factors)>;

  enum class Products { None, Logs, LogsAndPlaces };
  struct Pass {
    double sum = 0;                ///< sum of the visitor's results
    std::vector<double> products;  ///< A^T factors, followed by the sum of the factors
    /// For each root the sum over the cells of the factor times the derivatives of the cell's logarithm by the
    /// coordinates of the root.
    std::vector<Quaternion<double>> places;
  };
  Pass pass(std::span<const double> weights, double constant, const Visitor& visit, Products products) const;

  void logModuli(std::span<const double> weights, double constant, std::span<double> l) const;

  /// Computes [A 1]^T diag(w) [A 1] of the weighted cells, both triangles.
  /// @param gram  in: the matrix of the first roots and the same cells, or empty; out: the matrix of all roots.
  ///              Only the missing entries are summed.
  void extendGram(const CellSample& sample, Eigen::MatrixXd& gram) const;

 private:
  std::size_t blockCount() const { return mX.size() / kBlock; }
  void logs(std::size_t root, const float* x, const float* y, const float* z, float* out) const;
  void fill(std::size_t block, std::size_t firstRoot, float* columns) const;
  void addPlaces(std::size_t block, const double* factors, std::span<Quaternion<double>> sums) const;
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
