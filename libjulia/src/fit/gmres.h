// SPDX-License-Identifier: Apache-2.0
/// @file gmres.h
/// The generalised minimal residual method [Saad & Schultz, SIAM J. Sci. Stat. Comput. 7(3), 1986], without restarts.
#pragma once

#include <Eigen/Core>

#include <cmath>
#include <vector>

namespace julia {

struct GmresResult {
  Eigen::VectorXd x;
  int iterations = 0;
};

/// Solves A x = b until |A x - b| <= tolerance |b| by its own estimate, or for @a maxIterations; one vector is kept for
/// each. @param apply  apply(v, Av) for vectors of b's size
template <class Apply>
GmresResult gmres(const Apply& apply, const Eigen::VectorXd& b, double tolerance, int maxIterations) {
  const double bNorm = b.norm();
  std::vector<Eigen::VectorXd> basis{b / bNorm};
  // The Hessenberg matrix, made triangular by rotations as it grows, a column an iteration.
  std::vector<Eigen::VectorXd> columns;
  std::vector<double> cosines, sines, rest{bNorm};
  while (static_cast<int>(columns.size()) < maxIterations && std::abs(rest.back()) > tolerance * bNorm) {
    const std::size_t k = columns.size();
    Eigen::VectorXd v(b.size());
    apply(basis[k], v);
    Eigen::VectorXd h(static_cast<Eigen::Index>(k) + 1);
    for (std::size_t i = 0; i <= k; ++i) {
      h[static_cast<Eigen::Index>(i)] = basis[i].dot(v);
      v -= h[static_cast<Eigen::Index>(i)] * basis[i];
    }
    const double below = v.norm();
    for (std::size_t i = 0; i < k; ++i) {
      const auto at = static_cast<Eigen::Index>(i);
      const double upper = h[at], lower = h[at + 1];
      h[at] = cosines[i] * upper + sines[i] * lower;
      h[at + 1] = cosines[i] * lower - sines[i] * upper;
    }
    const double last = h[static_cast<Eigen::Index>(k)], length = std::sqrt(last * last + below * below);
    if (!(length > 0)) break;
    cosines.push_back(last / length);
    sines.push_back(below / length);
    h[static_cast<Eigen::Index>(k)] = length;
    columns.push_back(std::move(h));
    rest.push_back(-sines[k] * rest[k]);
    rest[k] *= cosines[k];
    if (!(below > 0)) break;
    basis.push_back(v / below);
  }

  GmresResult result{Eigen::VectorXd::Zero(b.size()), static_cast<int>(columns.size())};
  for (std::size_t i = columns.size(); i-- > 0;) {
    const auto at = static_cast<Eigen::Index>(i);
    const double y = rest[i] / columns[i][at];
    for (std::size_t j = 0; j < i; ++j) rest[j] -= y * columns[i][static_cast<Eigen::Index>(j)];
    result.x += y * basis[i];
  }
  return result;
}

}  // namespace julia
