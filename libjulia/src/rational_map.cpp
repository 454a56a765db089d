// SPDX-License-Identifier: Apache-2.0
#include "julia/rational_map.h"

namespace julia {

template <class Real>
void RationalMap<Real>::logModulus(const QuaternionBatch<Real>& q, std::span<Real> l) const {
  mRational.logModulus(q, l);
}

template <class Real>
void RationalMap<Real>::versor(const QuaternionBatch<Real>& q, QuaternionBatch<Real>& u) const {
  mRational.versor(q, u);
}

template class RationalMap<float>;
template class RationalMap<double>;

}  // namespace julia
