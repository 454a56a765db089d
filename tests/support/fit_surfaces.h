// SPDX-License-Identifier: Apache-2.0
/// @file fit_surfaces.h
/// Triangle surfaces whose areas, potentials and charges are known.
#pragma once

#include "julia/fit/surface.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <numbers>
#include <utility>

namespace law_tests {

using julia::Point;
using julia::TriangleSurface;

inline double norm(const Point& x) { return std::sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]); }
inline double distance(const Point& a, const Point& b) { return norm({a[0] - b[0], a[1] - b[1], a[2] - b[2]}); }

/// The unit sphere from an icosahedron, 20 * 4^refinements triangles.
inline TriangleSurface sphere(int refinements) {
  const double g = std::numbers::phi;
  TriangleSurface surface{{{-1, g, 0},
                           {1, g, 0},
                           {-1, -g, 0},
                           {1, -g, 0},
                           {0, -1, g},
                           {0, 1, g},
                           {0, -1, -g},
                           {0, 1, -g},
                           {g, 0, -1},
                           {g, 0, 1},
                           {-g, 0, -1},
                           {-g, 0, 1}},
                          {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                           {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                           {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}}};
  const auto toSphere = [&] {
    for (Point& x : surface.points) {
      const double r = norm(x);
      for (double& coordinate : x) coordinate /= r;
    }
  };
  toSphere();
  for (int i = 0; i < refinements; ++i) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto [place, isNew] = middles.try_emplace(std::minmax(a, b), surface.points.size());
      if (isNew) {
        const Point p = surface.points[a], q = surface.points[b];
        surface.points.push_back({(p[0] + q[0]) / 2, (p[1] + q[1]) / 2, (p[2] + q[2]) / 2});
      }
      return place->second;
    };
    decltype(surface.triangles) finer;
    for (const auto& [a, b, c] : surface.triangles) {
      const std::uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    surface.triangles = finer;
    toSphere();
  }
  return surface;
}

/// Every point times @a factors, an axis each.
inline TriangleSurface stretched(TriangleSurface surface, const Point& factors) {
  for (Point& x : surface.points)
    for (int axis = 0; axis < 3; ++axis) x[axis] *= factors[axis];
  return surface;
}

/// The unit cube, @a n by @a n rectangles a face, two triangles each. @a grading 1 is even; larger ones crowd the
/// rectangles towards the edges, where charge does.
inline TriangleSurface cube(std::size_t n, double grading = 1) {
  TriangleSurface surface;
  std::vector<double> ticks;
  for (std::size_t i = 0; i <= n; ++i) {
    const double t = 2. * static_cast<double>(i) / static_cast<double>(n);
    ticks.push_back(t <= 1 ? std::pow(t, grading) / 2 : 1 - std::pow(2 - t, grading) / 2);
  }
  for (int axis = 0; axis < 3; ++axis)
    for (const double side : {0., 1.}) {
      const auto first = static_cast<std::uint32_t>(surface.points.size()), row = static_cast<std::uint32_t>(n + 1);
      for (const double u : ticks)
        for (const double v : ticks) {
          Point x;
          x[axis] = side, x[(axis + 1) % 3] = u, x[(axis + 2) % 3] = v;
          surface.points.push_back(x);
        }
      for (std::uint32_t i = 0; i + 1 < row; ++i)
        for (std::uint32_t j = 0; j + 1 < row; ++j) {
          const std::uint32_t a = first + i * row + j, b = a + row;
          surface.triangles.push_back({a, b, b + 1});
          surface.triangles.push_back({a, b + 1, a + 1});
        }
    }
  return surface;
}

}  // namespace law_tests
