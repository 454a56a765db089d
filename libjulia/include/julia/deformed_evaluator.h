// SPDX-License-Identifier: Apache-2.0
/// @file deformed_evaluator.h
/// The field of a set that a deformation carries along: F'(x) = F(rho(x)), where rho says where each point was before.
#pragma once

#include "julia/ball.h"
#include "julia/embedding.h"
#include "julia/evaluator.h"

#include <memory>
#include <span>

namespace julia {

/// A map rho of points, which is known in a part of space. Elsewhere the sign of the field is known instead.
class Deformation {
 public:
  virtual ~Deformation() = default;

  /// Sets carried[i] to rho(points[i]), and decisions[i] to Undecided; or, where rho is not known, decisions[i] to the
  /// sign of the field. Many threads may call it at once.
  virtual void carry(std::span<const Point> points, std::span<Point> carried, std::span<Decision> decisions) const = 0;

  /// What is known about a ball.
  struct Image {
    Decision decision = Decision::Undecided;  ///< of all points of the ball
    Point centre{};                           ///< if the ball is undecided: of a ball that contains its image
    double radius = 0;                        ///< of that ball; infinity if nothing is known
  };
  /// Sets images[i] to what is known about the ball of the radius about centres[i], rounding included.
  virtual void images(std::span<const Point> centres, double radius, std::span<Image> images) const = 0;
};

/// @param evaluator  of F
std::unique_ptr<FieldEvaluator> makeDeformedEvaluator(std::shared_ptr<const FieldEvaluator> evaluator,
                                                      std::shared_ptr<const Deformation> deformation);

}  // namespace julia
