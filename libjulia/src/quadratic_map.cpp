// SPDX-License-Identifier: Apache-2.0
#include "julia/quadratic_map.h"

#include "julia/log_polar.h"

#include <cmath>

namespace julia {

template <class Real>
void QuadraticMap<Real>::logModulus(const QuaternionBatch<Real>& q, std::span<Real> l) const {
  for (std::size_t i = 0; i < q.size(); ++i) l[i] = logNorm(q.get(i) * q.get(i) + mC);
}

template <class Real>
void QuadraticMap<Real>::versor(const QuaternionBatch<Real>& q, QuaternionBatch<Real>& u) const {
  u.resize(q.size());
  for (std::size_t i = 0; i < q.size(); ++i) u.set(i, versorOf(q.get(i) * q.get(i) + mC));
}

template class QuadraticMap<float>;
template class QuadraticMap<double>;

double quadraticBound(const Quaternion<double>& c, int iterations, double escapeRadius) {
  const double shift = std::sqrt(normSquared(c));
  double radius = escapeRadius;
  for (int i = 0; i < iterations; ++i) {
    const double before = std::sqrt(radius + shift);
    // Past the fixed point the bound falls no further.
    if (before >= radius) break;
    radius = before;
  }
  return radius;
}

}  // namespace julia
