// SPDX-License-Identifier: Apache-2.0
#include "fit/bounded_quadratic.h"

#include "fit/cholesky.h"

#include <cstddef>

namespace julia {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

std::optional<VectorXd> minimiseBounded(const MatrixXd& H, const VectorXd& b, const std::vector<char>& bounded,
                                        std::vector<char>& passive) {
  // Exchanges of all that violate their sign converge fast but may cycle; where their number does not fall this often,
  // single exchanges, which cannot cycle, take over until it does.
  constexpr int kPatience = 3;
  constexpr double kTolerance = 1e-10;  // of the largest |b|
  const Index n = b.size();
  const double tolerance = kTolerance * b.cwiseAbs().maxCoeff();
  for (Index i = 0; i < n; ++i)
    if (!bounded[static_cast<std::size_t>(i)]) passive[static_cast<std::size_t>(i)] = 1;
  VectorXd x;
  std::size_t fewest = static_cast<std::size_t>(n) + 1;
  int patience = kPatience;
  for (Index round = 0; round <= 3 * n; ++round) {
    std::vector<Index> free;
    for (Index i = 0; i < n; ++i)
      if (passive[static_cast<std::size_t>(i)]) free.push_back(i);
    x = VectorXd::Zero(n);
    if (!free.empty()) {
      const std::optional<VectorXd> solution = solveCholesky(H(free, free), b(free));
      if (!solution) return std::nullopt;
      x(free) = *solution;
    }
    const VectorXd slope = H * x - b;
    std::vector<std::size_t> wrong;
    for (Index i = 0; i < n; ++i) {
      const auto k = static_cast<std::size_t>(i);
      if (bounded[k] && (passive[k] ? x[i] < 0 : slope[i] < -tolerance)) wrong.push_back(k);
    }
    if (wrong.empty()) break;
    if (wrong.size() < fewest) {
      fewest = wrong.size();
      patience = kPatience;
    } else if (patience > 0) {
      --patience;
    } else {
      wrong.assign(1, wrong.back());
    }
    for (const std::size_t k : wrong) passive[k] = !passive[k];
  }
  for (Index i = 0; i < n; ++i)
    if (bounded[static_cast<std::size_t>(i)] && x[i] < 0) x[i] = 0;
  return x;
}

}  // namespace julia
