// SPDX-License-Identifier: Apache-2.0
#include "julia/orbit_trace.h"

#include <stdexcept>

namespace julia {

void traceOrbits(const FieldEvaluator& evaluator, std::span<const Point> points, const OrbitTrace& trace) {
  const auto* const tracer = dynamic_cast<const OrbitTracer*>(&evaluator);
  if (!tracer) throw std::logic_error("the evaluator keeps no orbits");
  const std::size_t entries = points.size() * (static_cast<std::size_t>(evaluator.describe().orbit.maxIterations) + 1);
  if (trace.iterates.size() != entries || trace.logModuli.size() != entries || trace.steps.size() != points.size() ||
      trace.ends.size() != points.size())
    throw std::invalid_argument("the spans of an orbit's trace do not have the sizes of the points and their steps");
  tracer->trace(points, trace);
}

}  // namespace julia
