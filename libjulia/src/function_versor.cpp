// SPDX-License-Identifier: Apache-2.0
#include "julia/function_versor.h"

#include "versor_arithmetic.h"

#include <stdexcept>
#include <utility>
#include <vector>

namespace julia {

template <class Real>
FunctionVersor<Real>::FunctionVersor(DirectionFunction function) : mFunction(std::move(function)) {
  if (!mFunction) throw std::invalid_argument("a versor of a function was given none");
}

template <class Real>
void FunctionVersor<Real>::versor(const QuaternionBatch<Real>& q, QuaternionBatch<Real>& u) const {
  std::vector<Quaternion<double>> points(q.size()), directions(q.size());
  for (std::size_t i = 0; i < q.size(); ++i) points[i] = q.get(i).template as<double>();
  mFunction(points, directions);
  u.resize(q.size());
  for (std::size_t i = 0; i < q.size(); ++i) u.set(i, directionOf(directions[i]).template as<Real>());
}

template class FunctionVersor<float>;
template class FunctionVersor<double>;

}  // namespace julia
