// SPDX-License-Identifier: Apache-2.0
#include "julia/quadratic_map.h"

#include "batch_view.h"
#include "careful.h"

#include <cmath>
#include <limits>

namespace julia {

namespace {

template <class Real>
QuaternionBatch<Real> squaresPlus(const Quaternion<Real>& c, const QuaternionBatch<Real>& q) {
  QuaternionBatch<Real> f;
  f.resize(q.size());
  const Real constant[4] = {c.a, c.b, c.c, c.d};
  kernels::kernels<Real>().quadratic(constant, view(q), view(f), q.size());
  return f;
}

template <class Real>
bool isNormal(const Quaternion<Real>& q) {
  const Real squared = normSquared(q);
  return squared >= kernels::Ieee<Real>::kTiny && squared <= std::numeric_limits<Real>::max();
}

}  // namespace

template <class Real>
void QuadraticMap<Real>::logModulus(const QuaternionBatch<Real>& q, std::span<Real> l) const {
  const QuaternionBatch<Real> f = squaresPlus(mC, q);
  kernels::kernels<Real>().logNorm(view(f), l.data(), f.size());
  for (std::size_t i = 0; i < f.size(); ++i)
    if (!isNormal(f.get(i))) l[i] = careful::logNorm(f.get(i));
}

template <class Real>
void QuadraticMap<Real>::versor(const QuaternionBatch<Real>& q, QuaternionBatch<Real>& u) const {
  const QuaternionBatch<Real> f = squaresPlus(mC, q);
  u = f;
  kernels::kernels<Real>().normalise(view(u), u.size());
  for (std::size_t i = 0; i < f.size(); ++i)
    if (!isNormal(f.get(i))) u.set(i, careful::versorOf(f.get(i)));
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
