// SPDX-License-Identifier: Apache-2.0
#include "julia/cross_map.h"

#include "julia/expression_pair.h"

#include "batch_view.h"
#include "cartesian_balls.h"

namespace julia {

static_assert(static_cast<int>(CrossPair::User) == kernels::kCrossPairs);

template <class Real>
CrossMap<Real>::CrossMap(const CrossOptions& options)
    : mOptions(options), mConstant(Embedding{}.quaternion<Real>(options.constant)) {
  requireConstant(options.constant);
  if (options.pair == CrossPair::User) mUser = std::make_shared<const ExpressionPair>(options.f, options.g);
}

template <class Real>
void CrossMap<Real>::begin(const QuaternionBatch<Real>& start, QuaternionBatch<Real>& carried,
                           QuaternionBatch<Real>& next) const {
  switch (mOptions.scheme) {
    case CrossScheme::FixedFactor:
      second(start, carried);
      multiply(start, Quaternion<Real>{}, next);
      break;
    case CrossScheme::Mandelbrot:
      carried = start;
      multiply(start, carried, next);
      break;
    case CrossScheme::Julia: multiply(start, mConstant, next); break;
  }
}

template <class Real>
void CrossMap<Real>::step(const QuaternionBatch<Real>& p, const QuaternionBatch<Real>& carried,
                          QuaternionBatch<Real>& next) const {
  switch (mOptions.scheme) {
    case CrossScheme::FixedFactor:
      next.resize(p.size());
      kernels::kernels<Real>().crossProduct(addend(Quaternion<Real>{}), view(p), view(carried), view(next), p.size());
      break;
    case CrossScheme::Mandelbrot: multiply(p, carried, next); break;
    case CrossScheme::Julia: multiply(p, mConstant, next); break;
  }
}

template <class Real>
void CrossMap<Real>::direction(const QuaternionBatch<Real>& start, QuaternionBatch<Real>& direction) const {
  multiply(start, Quaternion<Real>{}, direction);
}

template <class Real>
std::optional<Ball> CrossMap<Real>::imageOf(const Ball& ball, const Ball& start, int number) const {
  if (mOptions.scheme == CrossScheme::FixedFactor && number > 1) {
    const std::optional<Ball> g = crossSecondOf<Real>(mOptions.pair, start);
    return g ? std::optional(crossProductOf<Real>(ball, *g)) : std::nullopt;
  }
  const std::optional<Ball> product = crossProductOf<Real>(mOptions.pair, ball);
  if (!product || mOptions.scheme == CrossScheme::FixedFactor) return product;
  return sumOf<Real>(*product,
                     mOptions.scheme == CrossScheme::Julia ? Ball{mConstant.template as<double>(), 0} : start);
}

template <class Real>
bool CrossMap<Real>::isDefinedEverywhere() const {
  return mOptions.pair != CrossPair::A && mOptions.pair != CrossPair::APrime && mOptions.pair != CrossPair::User;
}

template <class Real>
template <class Constant>
void CrossMap<Real>::multiply(const QuaternionBatch<Real>& p, const Constant& constant,
                              QuaternionBatch<Real>& next) const {
  const kernels::Kernels<Real>& table = kernels::kernels<Real>();
  next.resize(p.size());
  if (!mUser) return table.cross[static_cast<int>(mOptions.pair)](addend(constant), view(p), view(next), p.size());
  QuaternionBatch<Real> f, g;
  mUser->evaluate(p, f, g);
  table.crossProduct(addend(constant), view(f), view(g), view(next), p.size());
}

template <class Real>
void CrossMap<Real>::second(const QuaternionBatch<Real>& p, QuaternionBatch<Real>& g) const {
  g.resize(p.size());
  if (!mUser) return kernels::kernels<Real>().crossSecond[static_cast<int>(mOptions.pair)](view(p), view(g), p.size());
  QuaternionBatch<Real> f;
  mUser->evaluate(p, f, g);
}

template class CrossMap<float>;
template class CrossMap<double>;

}  // namespace julia
