// SPDX-License-Identifier: Apache-2.0
/// @file map.h
/// The interface between a map and the code that iterates it: a map takes a batch of quaternions and returns log-polar
/// values. Modulus and versor are separate calls, because the last iterate needs no versor.
#pragma once

#include "julia/ball.h"
#include "julia/map_description.h"
#include "julia/quaternion_batch.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <span>

namespace julia {

/// One step of a dynamical system on the quaternions. Evaluation is const and may run in many threads at once.
template <class Real>
class Map {
 public:
  virtual ~Map() = default;

  /// Sets l[i] = ln|f(q[i])|, in [-inf, inf], never NaN. @pre l.size() == q.size()
  virtual void logModulus(const QuaternionBatch<Real>& q, std::span<Real> l) const = 0;

  /// Sets u[i] = f(q[i]) / |f(q[i])|, or 1 where f(q[i]) = 0. @a u is resized.
  virtual void versor(const QuaternionBatch<Real>& q, QuaternionBatch<Real>& u) const = 0;

  /// The value of l on the surface, given ln(escape): 0 for maps with a super-attracting 0 and infinity, ln(escape) for
  /// maps whose bounded orbits may go anywhere (docs/design.md 2.3).
  virtual Real surfaceLevel(Real logEscape) const = 0;

  /// The map as a plain value; empty if it has no description.
  virtual MapDescription describe() const { return {}; }

  /// Sets l[i] to bounds of what logModulus() computes, rounding included, at every q of ball i. All spans have the
  /// same size. A map that can prove nothing inherits this function and the next.
  virtual void logModulusRanges(std::span<const Ball>, std::span<LogRange> l) const {
    std::fill(l.begin(), l.end(), LogRange{});
  }

  /// Sets images[i] to a ball that contains e^l u, as logModulus() and versor() compute them, for every q of ball i
  /// whose l lies in range i; it is empty if nothing is known.
  virtual void images(std::span<const Ball>, std::span<const LogRange>, std::span<std::optional<Ball>> images) const {
    std::fill(images.begin(), images.end(), std::nullopt);
  }

  /// Larger balls than this one are not worth sending through images() where a step of all their points is nearly as
  /// cheap. A map that can prove nothing inherits this function.
  virtual double usefulRadius() const { return 0; }

  /// Where escapeBounds() can prove that the step after the first one escapes, without taking that step.
  struct EscapeProof {
    Real least = std::numeric_limits<Real>::infinity();  ///< nothing is proved for a smaller l
    double radius = 0;                                   ///< the bounds of larger balls are not worth asking for
  };
  /// Returns the limits of escapeBounds(). A map that can prove nothing inherits both functions.
  /// @param wanted  the l that the next step must reach
  virtual EscapeProof escapeProof(double wanted) const {
    (void)wanted;
    return {};
  }

  /// Sets bounds[i] such that, wherever l >= bounds[i] at a q within @a radius of centre i, the l of the next step, as
  /// logModulus() computes it, is at least the @a wanted for which escapeProof() returned the proof; +inf if nothing is
  /// known.
  virtual void escapeBounds(const QuaternionBatch<Real>& /*centres*/, Real /*radius*/, const EscapeProof& /*proof*/,
                            std::span<Real> bounds) const {
    std::fill(bounds.begin(), bounds.end(), std::numeric_limits<Real>::infinity());
  }

  /// As logModulusRanges(), for one ball.
  LogRange logModulusRange(const Ball& ball) const {
    LogRange l;
    logModulusRanges({&ball, 1}, {&l, 1});
    return l;
  }
  std::optional<Ball> image(const Ball& ball, const LogRange& l) const {
    std::optional<Ball> result;
    images({&ball, 1}, {&l, 1}, {&result, 1});
    return result;
  }
};

}  // namespace julia
