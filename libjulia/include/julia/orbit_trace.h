// SPDX-License-Identifier: Apache-2.0
/// @file orbit_trace.h
/// Whole orbits: every iterate of a point, and why its orbit ended. FieldEvaluator::evaluate() keeps the last logarithm
/// alone; here the same steps are taken with the same bits, and written down.
#pragma once

#include "julia/evaluator.h"

#include <cstddef>
#include <cstdint>
#include <span>

namespace julia {

enum class OrbitEnd : std::uint8_t {
  Steps,    ///< it took all steps that OrbitOptions::maxIterations allows
  Escaped,  ///< an iterate, or the point itself, reached the escape radius
  Trapped,  ///< an iterate entered the trapped ball
};

/// What the orbits of some points are written to: each point has a row of maxIterations + 1 entries, and the iterate k
/// of a point is entry k of its row. The entry 0 is the point itself, embedded. Entries after the last iterate are left
/// unchanged.
struct OrbitTrace {
  std::span<Quaternion<double>> iterates;  ///< units of the map's space. NaN where one is too large for the arithmetic
  std::span<double> logModuli;             ///< their logarithms, clamped to kFieldLimit
  std::span<int> steps;                    ///< one a point: how many steps its orbit took
  std::span<OrbitEnd> ends;                ///< one a point
};

/// An evaluator that can follow orbits. All evaluators of this library can.
class OrbitTracer {
 public:
  virtual ~OrbitTracer() = default;

  /// @pre the spans of @a trace have the sizes that its description says
  virtual void trace(std::span<const Point> points, const OrbitTrace& trace) const = 0;
};

/// Follows the orbits of points as @a evaluator evaluates them. Evaluators that confirm their trap follow all orbits to
/// their ends.
/// @throw std::invalid_argument  the size of a span differs from its description
/// @throw std::logic_error       the evaluator is not an OrbitTracer
void traceOrbits(const FieldEvaluator& evaluator, std::span<const Point> points, const OrbitTrace& trace);

}  // namespace julia
