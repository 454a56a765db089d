// SPDX-License-Identifier: Apache-2.0
/// @file expression_pair.h
/// A pair of functions for the cross-product maps of [ZB25] (cross_map.h), given by the user as text: three components
/// each, separated by commas, such as f = "x*x, y*y, z*z" and g = "cos(x), cos(y), cos(z)".
///
/// The variables are x y z, r = |p|, and cos2phi sin2phi cos2theta sin2theta as defined in cross_map.h. The constants
/// are pi and e. The functions are sin cos tan asin acos atan atan2 sinh cosh tanh exp ln log (also the natural
/// logarithm) log2 log10 sqrt abs sign min max. The operators are those of muParser, including the power a ^ b and the
/// choice a ? b : c, but without assignments.
///
/// Expressions are computed in double for either precision. Where a value is not finite, for example after a division
/// by 0, the pair is not defined and the orbit has escaped. sin and cos are those of the built-in pairs; the power and
/// the other functions are those of elementary.h.
#pragma once

#include "julia/quaternion_batch.h"

#include <memory>
#include <string>

namespace julia {

/// A parsed pair. Many threads may evaluate it at once.
class ExpressionPair {
 public:
  /// @throw std::invalid_argument with the text and the position, if there are not three components, if one does not
  ///                              parse or contains an unknown name, or if one is not finite at any of the points where
  ///                              it is tried (up to |p| = 100)
  ExpressionPair(const std::string& f, const std::string& g);
  ~ExpressionPair();

  /// Sets f and g to the values at the points [x y z 0]; their fourth components are 0. Both are resized.
  template <class Real>
  void evaluate(const QuaternionBatch<Real>& p, QuaternionBatch<Real>& f, QuaternionBatch<Real>& g) const;

 private:
  class Pool;
  std::unique_ptr<Pool> mPool;
};

extern template void ExpressionPair::evaluate(const QuaternionBatch<float>&, QuaternionBatch<float>&,
                                              QuaternionBatch<float>&) const;
extern template void ExpressionPair::evaluate(const QuaternionBatch<double>&, QuaternionBatch<double>&,
                                              QuaternionBatch<double>&) const;

}  // namespace julia
