// SPDX-License-Identifier: Apache-2.0
#include "fit/panels.h"

#include "fit/vector3.h"
#include "kernels/elementary.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace julia {
namespace {

// A triangle thinner than this fraction of its longest edge has no reliable normal.
constexpr double kThinnest = 1e-9;
// Quadrature is used beyond this multiple of the distance between the centroid and the farthest corner: of 20 000
// triangles with aspect ratios up to 1 : 1000, none had a larger error there than 1.2e-7.
constexpr double kNear = 6;

// Radon's rule of degree 5: the centroid and two triples of nodes, one at barycentric coordinates (1 - 2b, b, b) and
// its permutations each.
constexpr double kRoot15 = 3.8729833462074169;
constexpr double kCentreWeight = 9.0 / 40;
constexpr double kTripleCoordinate[] = {(6 + kRoot15) / 21, (6 - kRoot15) / 21};
constexpr double kTripleWeight[] = {(155 + kRoot15) / 1200, (155 - kRoot15) / 1200};

}  // namespace

Panels::Panels(const TriangleSurface& surface) {
  requireValid(surface);
  const auto addNode = [](Node& node, const Point& x) {
    node.x.push_back(x[0]);
    node.y.push_back(x[1]);
    node.z.push_back(x[2]);
  };
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    Panel panel;
    panel.triangle = t;
    for (std::size_t k = 0; k < 3; ++k) panel.corners[k] = surface.points[surface.triangles[t][k]];
    const auto& [a, b, c] = panel.corners;
    const Point normal = cross(b - a, c - a);
    panel.doubleArea = length(normal);
    for (std::size_t k = 0; k < 3; ++k) panel.lengths[k] = length(panel.corners[(k + 1) % 3] - panel.corners[k]);
    panel.longest = std::max({panel.lengths[0], panel.lengths[1], panel.lengths[2]});
    if (!(panel.doubleArea > kThinnest * panel.longest * panel.longest)) continue;

    panel.normal = (1 / panel.doubleArea) * normal;
    for (std::size_t k = 0; k < 3; ++k) {
      panel.along[k] = (1 / panel.lengths[k]) * (panel.corners[(k + 1) % 3] - panel.corners[k]);
      panel.outward[k] = cross(panel.along[k], panel.normal);
    }
    const Point centroid = (1.0 / 3) * (a + b + c);
    double radius = 0;
    for (const Point& corner : panel.corners) radius = std::max(radius, length(corner - centroid));
    mNearSquared.push_back(kNear * radius * (kNear * radius));
    mArea.push_back(0.5 * panel.doubleArea);
    addNode(mNodes[0], centroid);
    std::size_t node = 1;
    for (const double coordinate : kTripleCoordinate)
      for (const Point& corner : panel.corners)
        addNode(mNodes[node++], (3 * coordinate) * centroid + (1 - 3 * coordinate) * corner);
    mPanels.push_back(panel);
  }
}

void Panels::integrate(const Point& x, std::span<double> integrals) const {
  const auto distanceSquared = [&](const Node& node, std::size_t j) {
    const double dx = node.x[j] - x[0], dy = node.y[j] - x[1], dz = node.z[j] - x[2];
    return dx * dx + dy * dy + dz * dz;
  };
  const std::size_t count = size();
  for (std::size_t j = 0; j < count; ++j) integrals[j] = kCentreWeight / std::sqrt(distanceSquared(mNodes[0], j));
  for (std::size_t k = 1; k < kNodes; ++k) {
    const double weight = kTripleWeight[(k - 1) / 3];
    const Node& node = mNodes[k];
    for (std::size_t j = 0; j < count; ++j) integrals[j] += weight / std::sqrt(distanceSquared(node, j));
  }
  for (std::size_t j = 0; j < count; ++j) integrals[j] *= mArea[j];
  for (std::size_t j = 0; j < count; ++j)
    if (distanceSquared(mNodes[0], j) < mNearSquared[j]) integrals[j] = integral(mPanels[j], x);
}

// In the panel's plane, 1 / |x - y| is the divergence of a field that is radial about the foot of x, except at that
// point. Gauss' theorem leaves an integral over each edge, and the point contributes the solid angle:
//
//   integral = sum over edges of t ln((r0 + r1 + l) / (r0 + r1 - l)) - |h| |solid angle|
//
// with h the height of x, r0, r1 its distances from an edge's ends, l the edge's length, and t the distance of the foot
// from the edge's line, positive inwards.
double Panels::integral(const Panel& panel, const Point& x) {
  const std::array<Point, 3> to = {panel.corners[0] - x, panel.corners[1] - x, panel.corners[2] - x};
  const std::array<double, 3> r = {length(to[0]), length(to[1]), length(to[2])};
  const double height = std::abs(dot(to[0], panel.normal));
  double sum = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t next = (k + 1) % 3;
    const double t = dot(to[k], panel.outward[k]);
    const double begin = dot(to[k], panel.along[k]), end = dot(to[next], panel.along[k]);
    // Computes r - s, for a point's distance r and its component s along the edge, without cancellation.
    const double lineSquared = t * t + height * height;
    const auto excess = [&](double distance, double s) { return s > 0 ? lineSquared / (distance + s) : distance - s; };
    const double gap = excess(r[next], end) + excess(r[k], -begin);
    // On the edge itself t is 0 and dominates the logarithm.
    if (gap > 0) sum += t * kernels::logarithm((r[k] + r[next] + panel.lengths[k]) / gap);
  }
  // Van Oosterom and Strackee's tangent of half the solid angle.
  if (height > 1e-16 * panel.longest) {
    const double cosine =
        r[0] * r[1] * r[2] + dot(to[0], to[1]) * r[2] + dot(to[1], to[2]) * r[0] + dot(to[2], to[0]) * r[1];
    double unused;
    const double quadrants = kernels::angleInQuadrants(cosine, height * panel.doubleArea, &unused);
    sum -= height * (std::numbers::pi * quadrants);
  }
  return sum;
}

}  // namespace julia
