// SPDX-License-Identifier: Apache-2.0
#include "julia/rational_map.h"

namespace julia {

template <class Real>
void RationalMap<Real>::logModulus(const QuaternionBatch<Real>& q, std::span<Real> l) const {
  for (std::size_t i = 0; i < q.size(); ++i) l[i] = mRational.logModulus(q.get(i));
}

template <class Real>
void RationalMap<Real>::versor(const QuaternionBatch<Real>& q, QuaternionBatch<Real>& u) const {
  u.resize(q.size());
  for (std::size_t i = 0; i < q.size(); ++i) u.set(i, mRational.versor(q.get(i)));
}

template class RationalMap<float>;
template class RationalMap<double>;

}  // namespace julia
