// SPDX-License-Identifier: Apache-2.0
#include "julia/shape_modulus.h"

namespace julia {

template <class Real>
ShapeModulus<Real>::ShapeModulus(std::shared_ptr<const ScalarField<Real>> exponent, const Rational& versor,
                                 DropAxis dropped)
    : mExponent(std::move(exponent)), mVersor(versor), mDropped(dropped) {}

template <class Real>
void ShapeModulus<Real>::logModulus(const QuaternionBatch<Real>& q, std::span<Real> l) const {
  switch (mDropped) {
    case DropAxis::I: return mExponent->sample(q.a, q.c, q.d, l);
    case DropAxis::J: return mExponent->sample(q.a, q.b, q.d, l);
    case DropAxis::K: return mExponent->sample(q.a, q.b, q.c, l);
  }
}

template <class Real>
void ShapeModulus<Real>::versor(const QuaternionBatch<Real>& q, QuaternionBatch<Real>& u) const {
  mVersor.versor(q, u);
}

template class ShapeModulus<float>;
template class ShapeModulus<double>;

}  // namespace julia
