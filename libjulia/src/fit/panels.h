// SPDX-License-Identifier: Apache-2.0
/// @file panels.h
/// A surface's triangles as uniformly charged panels: the integrals of 1 / |x - y| over each.
#pragma once

#include "julia/fit/surface.h"

#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace julia {

class Panels {
 public:
  /// Leaves out triangles of zero or nearly zero area. @throw as requireValid()
  explicit Panels(const TriangleSurface& surface);

  std::size_t size() const { return mPanels.size(); }
  /// The triangle of panel j.
  std::size_t triangle(std::size_t j) const { return mPanels[j].triangle; }
  Point centroid(std::size_t j) const { return {mNodes[0].x[j], mNodes[0].y[j], mNodes[0].z[j]}; }
  double area(std::size_t j) const { return mArea[j]; }

  /// Computes the integral over every panel, within a relative error of 2e-7. @pre integrals.size() == size()
  void integrate(const Point& x, std::span<double> integrals) const;

 private:
  struct Panel {
    std::size_t triangle;
    std::array<Point, 3> corners, along, outward;  ///< edges: unit vectors along and, in the plane, out of them
    std::array<double, 3> lengths;
    Point normal;
    double doubleArea, longest;
  };
  /// One node of the quadrature for all panels; the first is the centroid.
  struct Node {
    std::vector<double> x, y, z;
  };
  static constexpr std::size_t kNodes = 7;

  static double integral(const Panel& panel, const Point& x);

  std::vector<Panel> mPanels;
  std::vector<double> mArea, mNearSquared;
  std::array<Node, kNodes> mNodes;
};

}  // namespace julia
