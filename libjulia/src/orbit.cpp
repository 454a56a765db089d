// SPDX-License-Identifier: Apache-2.0
#include "julia/orbit.h"

#include "number_text.h"

#include "julia/embedding.h"

#include <cmath>
#include <stdexcept>
#include <string>

namespace julia {

void requireValid(const OrbitOptions& options) {
  if (options.maxIterations < 1 || options.maxIterations > kMaxIterations)
    throw std::invalid_argument("iterations is " + std::to_string(options.maxIterations) + "; it must be 1 to " +
                                std::to_string(kMaxIterations));
  if (!(options.escapeRadius > 1 && options.escapeRadius <= kMaxEscapeRadius))
    throw std::invalid_argument("escape radius is " + textOf(options.escapeRadius) +
                                "; it must be above 1 and at most 1e9");
  if (std::isnan(options.logTrap)) throw std::invalid_argument("the trap's logarithm is not a number");
}

void requireConstant(const Point& constant) {
  for (const double x : constant)
    if (!(std::abs(x) <= kMaxEscapeRadius))
      throw std::invalid_argument("a component of the constant is " + textOf(x) + "; it must be between -1e9 and 1e9");
}

}  // namespace julia
