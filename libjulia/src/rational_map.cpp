// SPDX-License-Identifier: Apache-2.0
#include "julia/rational_map.h"

#include "ball_arithmetic.h"

namespace julia {

template <class Real>
void RationalMap<Real>::logModulus(const QuaternionBatch<Real>& q, std::span<Real> l) const {
  mRational.logModulus(q, l);
}

template <class Real>
void RationalMap<Real>::versor(const QuaternionBatch<Real>& q, QuaternionBatch<Real>& u) const {
  mRational.versor(q, u);
}

template <class Real>
void RationalMap<Real>::logModulusRanges(std::span<const Ball> balls, std::span<LogRange> l) const {
  mRational.logModulusRanges(balls, l);
}

template <class Real>
void RationalMap<Real>::images(std::span<const Ball> balls, std::span<const LogRange> l,
                               std::span<std::optional<Ball>> images) const {
  imagesOf<Real>(mRational, balls, l, images, nullptr);
}

template class RationalMap<float>;
template class RationalMap<double>;

}  // namespace julia
