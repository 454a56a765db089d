// SPDX-License-Identifier: Apache-2.0
#include "device/field_check.h"

#include "device/same_bits.h"

#include "random_numbers.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace julia::device {
namespace {

/// Points on which the device is tested: in the ball in which orbits begin, and more of them near its centre. Points
/// outside the ball would test nothing, because the processor evaluates those.
std::vector<Point> pointsToTry(double escapeRadius) {
  constexpr std::size_t kCount = 4096;
  std::vector<Point> points(kCount);
  Random random(2);
  for (std::size_t i = 0; i < kCount; ++i) {
    const double scale = i % 8 == 0 ? 0.57 * escapeRadius : i % 8 == 1 ? 1e-3 : i % 2 == 0 ? 1 : 0.5;
    for (double& x : points[i]) x = scale * random.between(-1, 1);
  }
  points[0] = {0, 0, 0};
  return points;
}

bool sameNumbers(const std::vector<double>& a, const std::vector<double>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), [](double x, double y) { return sameBits(x, y); });
}

/// Edges of a block along x at whose ends F has different signs, of which nothing else is known.
void addCrossed(const SignBlock& block, std::vector<NodeEdge>& crossed) {
  const auto isInside = [&](std::size_t x, std::size_t y, std::size_t z) { return block.inside[x] >> (8 * y + z) & 1; };
  for (std::size_t x = 0; x < 7; ++x)
    for (std::size_t node = 0; node < 64; ++node) {
      const std::size_t y = node / 8, z = node % 8;
      if (isInside(x, y, z) == isInside(x + 1, y, z)) continue;
      NodeEdge edge{.node = block.origin, .axis = 0};
      const std::size_t offset[3] = {x, y, z};
      for (std::size_t axis = 0; axis < 3; ++axis) edge.node[axis] += static_cast<std::int32_t>(offset[axis]);
      const auto limit = static_cast<float>(kFieldLimit);
      edge.from = isInside(x, y, z) ? -limit : limit;
      edge.to = -edge.from;
      crossed.push_back(edge);
    }
}

/// Whether the device finds the signs of the processor in blocks about these edges, and its places on edges between
/// their nodes.
bool agreesOnNodes(const DeviceCalls& device, const FieldEvaluator& host, const std::vector<CrossedEdge>& edges,
                   const SearchLattice& lattice) {
  constexpr std::size_t kBlocks = 4;
  std::vector<SignBlock> here;
  for (std::size_t i = 0; i < kBlocks; ++i) {
    // Where there is no edge, blocks are as good anywhere.
    const Point at =
        edges.empty() ? Point{0.1 * static_cast<double>(i), 0, 0} : edges[i * edges.size() / kBlocks].begin;
    SignBlock block;
    for (std::size_t axis = 0; axis < 3; ++axis)
      block.origin[axis] = static_cast<std::int32_t>(
          std::clamp(std::floor((at[axis] * lattice.scale + lattice.centre[axis]) / lattice.voxelSize) - 4, -1e8, 1e8));
    here.push_back(block);
  }
  std::vector<SignBlock> there = here;
  device.findSignsThere(lattice, there);
  host.evaluateSigns(lattice, here);
  std::vector<NodeEdge> crossed;
  for (std::size_t i = 0; i < here.size(); ++i) {
    if (here[i].inside != there[i].inside) return false;
    addCrossed(here[i], crossed);
  }
  std::vector<double> placesHere(crossed.size()), placesThere(crossed.size());
  device.findThere(crossed, lattice, placesThere);
  host.findNodeCrossings(crossed, lattice, placesHere);
  return sameNumbers(placesHere, placesThere);
}

/// Whether the device finds the places of the processor on edges whose first ends are @a points.
bool agreesOnEdges(const DeviceCalls& device, const FieldEvaluator& host, const std::vector<Point>& points,
                   const std::vector<double>& field) {
  constexpr double kVoxel = 1e-2;
  const SearchLattice lattice{.voxelSize = kVoxel, .centre = {0.5, -0.25, 0}, .scale = 0.75};
  std::vector<CrossedEdge> edges;
  std::vector<Point> ends;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const int axis = static_cast<int>(i % 3);
    const double at = points[i][static_cast<std::size_t>(axis)];
    const double index = (at * lattice.scale + lattice.centre[static_cast<std::size_t>(axis)]) / kVoxel;
    edges.push_back({points[i], axis, index, storedField(field[i]), 0});
    ends.push_back(points[i]);
    ends.back()[static_cast<std::size_t>(axis)] = lattice.at(index + 1, axis);
  }
  std::vector<double> atEnds(ends.size());
  host.evaluate(ends, atEnds, {});
  std::size_t kept = 0;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    edges[i].to = storedField(atEnds[i]);
    // For some edges, F at one end is known by its sign alone.
    if (i % 4 == 0) (edges[i].to < 0 ? edges[i].from : edges[i].to) = static_cast<float>(kFieldLimit);
    if ((field[i] < 0) != (atEnds[i] < 0)) edges[kept++] = edges[i];
  }
  edges.resize(kept);
  std::vector<double> here(kept), there(kept);
  device.findThere(edges, lattice, there);
  host.findCrossings(edges, lattice, here);
  return sameNumbers(here, there) && agreesOnNodes(device, host, edges, lattice);
}

}  // namespace

bool agrees(const DeviceCalls& device, const FieldEvaluator& host) {
  const std::vector<Point> points = pointsToTry(host.describe().orbit.escapeRadius);
  std::vector<double> here(points.size()), there(points.size());
  std::vector<int> stepsHere(points.size()), stepsThere(points.size());
  device.evaluateThere(points, there, stepsThere);
  host.evaluate(points, here, stepsHere);
  if (!sameNumbers(here, there) || stepsHere != stepsThere) return false;
  return !device.searches() || agreesOnEdges(device, host, points, here);
}

bool agreesOnRays(const DeviceCalls& device, const FieldEvaluator& host) {
  constexpr int kRays = 256, kSamples = 64, kBisections = 12;
  const double radius = host.describe().orbit.escapeRadius, near = std::min(radius, 1.0);
  const RayMarch plain{.eye = {1.5 * near, 0.25 * near, -0.125 * near},
                       .alpha = 0.03,
                       .epsilon = 1e-4 * near,
                       .bisections = kBisections};
  // The sequence, which begins before the rays.
  std::vector<double> members = {0.25 * near};
  while (members.size() < kSamples + 2)
    members.push_back(members.back() + std::max(plain.alpha * members.back(), plain.epsilon));
  RayMarch march = plain;
  march.members = std::span(members).first(1);
  Random random(4);
  std::vector<MarchedRay> rays;
  std::vector<Point> points;
  std::vector<double> distances;
  for (int i = 0; i < kRays; ++i) {
    Point direction;
    double square = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      direction[axis] = 0.5 * near * random.between(-1, 1) - march.eye[axis];
      square += direction[axis] * direction[axis];
    }
    for (double& x : direction) x /= std::sqrt(square);
    const double begin = members[0] + 1e-3 * near * (1 + random.between(-1, 1)) + 1e-6 * near;
    rays.push_back({direction, begin, begin, members[kSamples]});
    // Where the ray begins, and then the members beyond it.
    std::vector<double> along = {begin};
    for (int k = 1; k <= kSamples; ++k)
      if (members[static_cast<std::size_t>(k)] > begin) along.push_back(members[static_cast<std::size_t>(k)]);
    along.resize(kSamples + 1, along.back());
    distances.insert(distances.end(), along.begin(), along.end());
    for (const double t : along) points.push_back(pointAlong(march.eye, t, direction));
  }
  std::vector<double> field(points.size());
  host.evaluate(points, field, {});
  std::vector<RayMeeting> met(rays.size());
  device.followThere(march, rays, met);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    if (met[i].end == RayEnd::Left) continue;
    const std::size_t first = i * (kSamples + 1), last = first + kSamples + 1;
    std::size_t sample = first;
    while (sample < last && !(field[sample] < 0)) ++sample;
    if ((met[i].end == RayEnd::Met) != (sample < last)) return false;
    if (sample == last) continue;
    double inside = distances[sample], outside = sample == first ? inside : distances[sample - 1];
    for (int k = 0; k < kBisections && outside < inside; ++k) {
      const double middle = 0.5 * (outside + inside);
      const Point at = pointAlong(march.eye, middle, rays[i].direction);
      double value = 0;
      host.evaluate({&at, 1}, {&value, 1}, {});
      (value < 0 ? inside : outside) = middle;
    }
    if (!sameBits(inside, met[i].inside) || !sameBits(outside, met[i].outside)) return false;
  }
  return true;
}

}  // namespace julia::device
