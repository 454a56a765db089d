// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/exponent/local_thickness.h"

#include "base/elementary.h"
#include "base/in_parallel.h"
#include "exponent/thin_parts.h"

#include "vdbtools/base/text.h"
#include "vdbtools/distance/target.h"

#include <openvdb/tools/Dense.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <stdexcept>
#include <vector>

namespace vdbtools {
namespace {

using openvdb::Coord;
using openvdb::CoordBBox;
using openvdb::FloatGrid;

/// A dense lattice of floats, z fastest.
struct Lattice {
  explicit Lattice(const CoordBBox& nodes, float value)
      : box(nodes), size(nodes.dim()), values(nodes.volume(), value) {}

  std::size_t index(int x, int y, int z) const {
    return (static_cast<std::size_t>(x) * static_cast<std::size_t>(size[1]) + static_cast<std::size_t>(y)) *
               static_cast<std::size_t>(size[2]) +
           static_cast<std::size_t>(z);
  }
  bool holds(int x, int y, int z) const {
    return x >= 0 && y >= 0 && z >= 0 && x < size[0] && y < size[1] && z < size[2];
  }

  CoordBBox box;
  Coord size;
  std::vector<float> values;
};

/// One of the 13 lines through a node and its neighbours.
struct Line {
  int x, y, z;
  float length;
};
std::vector<Line> linesOfNeighbours() {
  std::vector<Line> lines;
  for (int i = 14; i < 27; ++i) {
    const int x = i / 9 - 1, y = i / 3 % 3 - 1, z = i % 3 - 1;
    lines.push_back({x, y, z, std::sqrt(static_cast<float>(x * x + y * y + z * z))});
  }
  return lines;
}

/// In voxels. In a box, nodes lie on faces, and balls end at nodes: this is more than the rounding that would decide
/// about them, so that a symmetrical target has a symmetrical tau.
constexpr float kTie = 1e-3f;

struct Ball {
  int x, y, z;
  float radius;  ///< voxels
};

/// An upper bound of the radius of a ball about the point that is @a t of a line's steps from a node: the ball must not
/// protrude from the target near the node. Behind a convex edge the slopes give a better bound, because the distance is
/// not linear there.
float largestBallAt(const Lattice& depth, const Coord& node, const Line& line, float t) {
  constexpr int kAround = 2;
  float radius = std::numeric_limits<float>::infinity();
  for (int x = -kAround; x <= kAround; ++x)
    for (int y = -kAround; y <= kAround; ++y)
      for (int z = -kAround; z <= kAround; ++z) {
        if (!depth.holds(node[0] + x, node[1] + y, node[2] + z)) continue;
        const float dx = static_cast<float>(x) - t * static_cast<float>(line.x),
                    dy = static_cast<float>(y) - t * static_cast<float>(line.y),
                    dz = static_cast<float>(z) - t * static_cast<float>(line.z);
        radius = std::min(radius, depth.values[depth.index(node[0] + x, node[1] + y, node[2] + z)] +
                                      std::sqrt(dx * dx + dy * dy + dz * dz));
      }
  return radius;
}

/// The balls that no ball about a neighbour contains: those about the nodes of the medial axis. A ball's radius is the
/// depth at the ridge itself, which runs between the nodes: along a line across the ridge the depth rises with one
/// slope and falls with another, and the ridge is where the two meet. Even in a wall one voxel thick the slopes can be
/// read, because phi continues beyond the surface.
std::vector<Ball> ridgeBalls(const Lattice& depth, Monitor& monitor) {
  // A ball that protrudes by less than this counts as contained, in voxels.
  constexpr float kSlack = 0.1f;
  // Slopes below this, in voxels per voxel, do not tell where they meet.
  constexpr float kLeastSlope = 0.3f;
  static const std::vector<Line> lines = linesOfNeighbours();
  const Coord size = depth.size;
  std::vector<std::vector<Ball>> layers(static_cast<std::size_t>(size[0]));
  inParallel(layers.size(), 1, monitor, [&](std::size_t begin, std::size_t end) {
    for (std::size_t layer = begin; layer != end; ++layer) {
      const int x = static_cast<int>(layer);
      for (int y = 0; y < size[1]; ++y)
        for (int z = 0; z < size[2]; ++z) {
          const float here = depth.values[depth.index(x, y, z)];
          if (!(here > 0)) continue;
          const auto at = [&](const Line& line, int steps) {
            const int i = x + steps * line.x, j = y + steps * line.y, k = z + steps * line.z;
            return depth.holds(i, j, k) ? depth.values[depth.index(i, j, k)] : -std::numeric_limits<float>::infinity();
          };
          float radius = here;
          bool contained = false;
          for (const Line& line : lines) {
            const float before = at(line, -1), after = at(line, 1);
            if (std::max(before, after) >= here + line.length - kSlack) {
              contained = true;
              break;
            }
            const float rise = before - at(line, -2), fall = after - at(line, 2);
            if (!(rise > kLeastSlope * line.length && fall > kLeastSlope * line.length)) continue;
            if (!std::isfinite(rise) || !std::isfinite(fall)) continue;
            // before + rise (t + 1) = after - fall (t - 1)
            const float t = (after + fall - before - rise) / (rise + fall);
            if (!(std::abs(t) <= 1 + kTie)) continue;
            const float found = before + rise * (t + 1);
            if (found > radius) radius = std::max(radius, std::min(found, largestBallAt(depth, {x, y, z}, line, t)));
          }
          if (!contained) layers[layer].push_back({x, y, z, radius});
        }
    }
  });
  std::vector<Ball> balls;
  for (const std::vector<Ball>& layer : layers) balls.insert(balls.end(), layer.begin(), layer.end());
  return balls;
}

/// How far a ball reaches from its centre: it also contains the nodes within half a voxel of it.
float reachOf(const Ball& ball) { return ball.radius + 0.5f + kTie; }

/// Whether a ball contains a node of a box; perhaps also if it ends just before it.
bool meets(const Ball& ball, const CoordBBox& box) {
  const auto apart = [](int at, int low, int high) { return static_cast<float>(std::max({low - at, at - high, 0})); };
  constexpr float kRounding = 1 + 1e-5f;
  const float dx = apart(ball.x, box.min()[0], box.max()[0]), dy = apart(ball.y, box.min()[1], box.max()[1]),
              dz = apart(ball.z, box.min()[2], box.max()[2]), reach = reachOf(ball);
  return dx * dx + dy * dy + dz * dz <= reach * reach * kRounding;
}

/// Sets the nodes inside the target that a ball contains and that have no value yet. @return how many these were
std::size_t paintBall(const Lattice& depth, const CoordBBox& box, const Ball& ball, Lattice& tau) {
  std::size_t painted = 0;
  const float reach = reachOf(ball);
  const int r = static_cast<int>(reach);
  for (int x = std::max(box.min()[0], ball.x - r); x <= std::min(box.max()[0], ball.x + r); ++x) {
    const float dx = static_cast<float>(x - ball.x);
    const float restX = reach * reach - dx * dx;
    if (restX < 0) continue;
    const int ry = static_cast<int>(std::sqrt(restX));
    for (int y = std::max(box.min()[1], ball.y - ry); y <= std::min(box.max()[1], ball.y + ry); ++y) {
      const float dy = static_cast<float>(y - ball.y);
      const float restY = restX - dy * dy;
      if (restY < 0) continue;
      const int rz = static_cast<int>(std::sqrt(restY));
      const std::size_t row = tau.index(x, y, 0);
      for (int z = std::max(box.min()[2], ball.z - rz); z <= std::min(box.max()[2], ball.z + rz); ++z) {
        const std::size_t node = row + static_cast<std::size_t>(z);
        if (tau.values[node] > 0 || !(depth.values[node] > 0)) continue;
        tau.values[node] = ball.radius;
        ++painted;
      }
    }
  }
  return painted;
}

/// Calls visit(box) for the boxes with sides of @a side nodes into which a box is cut.
template <class Visit>
void forEachBox(const CoordBBox& whole, int side, const Visit& visit) {
  for (int x = whole.min()[0]; x <= whole.max()[0]; x += side)
    for (int y = whole.min()[1]; y <= whole.max()[1]; y += side)
      for (int z = whole.min()[2]; z <= whole.max()[2]; z += side) {
        CoordBBox box = CoordBBox::createCube(Coord(x, y, z), side);
        box.intersect(whole);
        visit(box);
      }
}

/// Computes at each node inside the target the largest radius of the balls that contain it. Large balls come first, so
/// that a block of nodes is done as soon as each of them has a value.
Lattice paint(const Lattice& depth, std::vector<Ball> balls, Monitor& monitor) {
  constexpr int kRegion = 32, kBlock = 8;  // nodes
  std::stable_sort(balls.begin(), balls.end(), [](const Ball& a, const Ball& b) { return a.radius > b.radius; });
  Lattice tau(depth.box, 0);
  std::vector<CoordBBox> regions;
  forEachBox({Coord(0), depth.size - Coord(1)}, kRegion, [&](const CoordBBox& box) { regions.push_back(box); });
  inParallel(regions.size(), 1, monitor, [&](std::size_t begin, std::size_t end) {
    std::vector<Ball> near;
    for (std::size_t i = begin; i < end; ++i) {
      near.clear();
      std::copy_if(balls.begin(), balls.end(), std::back_inserter(near),
                   [&](const Ball& ball) { return meets(ball, regions[i]); });
      forEachBox(regions[i], kBlock, [&](const CoordBBox& block) {
        std::size_t left = 0;
        for (auto node = block.begin(); node; ++node)
          left += depth.values[depth.index((*node)[0], (*node)[1], (*node)[2])] > 0 ? 1 : 0;
        for (std::size_t k = 0; k < near.size() && left > 0; ++k)
          if (meets(near[k], block)) left -= paintBall(depth, block, near[k], tau);
      });
    }
  });
  return tau;
}

/// Sets tau to kLeastThickness near the surface of a part that contains no node.
void markThinParts(const Lattice& depth, Lattice& tau) {
  const Coord size = depth.size;
  for (int x = 1; x < size[0] - 1; ++x)
    for (int y = 1; y < size[1] - 1; ++y)
      for (int z = 1; z < size[2] - 1; ++z) {
        const auto distance = [&](int dx, int dy, int dz) {
          return -depth.values[depth.index(x + dx, y + dy, z + dz)];
        };
        if (isBesideThinPart(distance)) tau.values[depth.index(x, y, z)] = static_cast<float>(kLeastThickness);
      }
}

/// Calls body(here, neighbour, distance) for each node and its 26 neighbours, in two sweeps through the lattice, so
/// that what is passed from neighbour to neighbour reaches every node.
template <class Body>
void sweep(const Lattice& lattice, const Body& body) {
  static const std::vector<Line> lines = linesOfNeighbours();
  const Coord size = lattice.size;
  for (const int direction : {-1, 1}) {
    const auto order = [&](int i, int n) { return direction < 0 ? i : n - 1 - i; };
    for (int i = 0; i < size[0]; ++i)
      for (int j = 0; j < size[1]; ++j)
        for (int k = 0; k < size[2]; ++k) {
          const int x = order(i, size[0]), y = order(j, size[1]), z = order(k, size[2]);
          for (const Line& line : lines) {
            const int a = x + direction * line.x, b = y + direction * line.y, c = z + direction * line.z;
            if (lattice.holds(a, b, c)) body(lattice.index(x, y, z), lattice.index(a, b, c), line.length);
          }
        }
  }
}

/// Nodes where tau is infinite get the value of the nearest node where it is finite.
void extend(Lattice& tau) {
  Lattice distance(tau.box, 0);
  for (std::size_t i = 0; i < tau.values.size(); ++i)
    if (!std::isfinite(tau.values[i])) distance.values[i] = std::numeric_limits<float>::infinity();
  sweep(tau, [&](std::size_t here, std::size_t neighbour, float length) {
    const float through = distance.values[neighbour] + length;
    if (!(through < distance.values[here])) return;
    distance.values[here] = through;
    tau.values[here] = tau.values[neighbour];
  });
}

/// tau(x) <- the minimum of tau(y) + slope |x - y| over all nodes y, along steps between neighbours. The order is that
/// of sweep(); what comes from other rows is taken by whole rows, in vectors, because a minimum does not depend on the
/// order of its terms.
void limitSlope(Lattice& tau, float slope) {
  static const std::vector<Line> lines = linesOfNeighbours();
  const Coord size = tau.size;
  const int n = size[2];
  for (const int direction : {-1, 1})
    for (int i = 0; i < size[0]; ++i)
      for (int j = 0; j < size[1]; ++j) {
        const int x = direction < 0 ? i : size[0] - 1 - i, y = direction < 0 ? j : size[1] - 1 - j;
        float* row = &tau.values[tau.index(x, y, 0)];
        for (const Line& line : lines) {
          const int a = x + direction * line.x, b = y + direction * line.y, c = direction * line.z;
          if ((line.x == 0 && line.y == 0) || !tau.holds(a, b, 0)) continue;
          const float* from = &tau.values[tau.index(a, b, 0)];
          const float rise = slope * line.length;
          for (int z = std::max(0, -c); z < std::min(n, n - c); ++z) row[z] = std::min(row[z], from[z + c] + rise);
        }
        float before = std::numeric_limits<float>::infinity();
        for (int k = 0; k < n; ++k) {
          float& here = row[direction < 0 ? k : n - 1 - k];
          here = before = std::min(here, before + slope);
        }
      }
}

/// Averages over 3 nodes along each axis, which rounds the creases that the limit leaves.
void smooth(Lattice& tau, Monitor& monitor) {
  const Coord size = tau.size;
  for (int axis = 0; axis < 3; ++axis) {
    const Lattice from = tau;
    inParallel(static_cast<std::size_t>(size[0]), 4, monitor, [&](std::size_t begin, std::size_t end) {
      for (int x = static_cast<int>(begin); x < static_cast<int>(end); ++x)
        for (int y = 0; y < size[1]; ++y)
          for (int z = 0; z < size[2]; ++z) {
            int before[3] = {x, y, z}, after[3] = {x, y, z};
            before[axis] = std::max(before[axis] - 1, 0);
            after[axis] = std::min(after[axis] + 1, size[axis] - 1);
            const std::size_t here = from.index(x, y, z);
            tau.values[here] =
                0.5f * from.values[here] + 0.25f * (from.values[from.index(before[0], before[1], before[2])] +
                                                    from.values[from.index(after[0], after[1], after[2])]);
          }
    });
  }
}

}  // namespace

double thicknessSlope(double detail) {
  constexpr double kDepthSlope = 0.16;
  return std::min(kThicknessSlope, kDepthSlope / std::max(detail, kDepthSlope));
}

struct ThicknessFinder::Found {
  CoordBBox nodes;
  double voxel = 0;    ///< world units
  Lattice depth, tau;  ///< voxels; tau before the slope limit
  openvdb::math::Transform::Ptr transform;
};

ThicknessFinder::ThicknessFinder(const FloatGrid& phi, Monitor& monitor) {
  const double voxel = phi.voxelSize()[0];
  CoordBBox nodes = insideNodeBox(phi);
  // Slopes are read two nodes beyond the inside; farther away, the nearest face's value is read.
  constexpr int kMargin = 5;
  nodes.expand(kMargin);
  monitor.begin(PhaseKind::LocalThickness, 0);
  Lattice depth(nodes, 0);
  {
    // Dense in OpenVDB's own order, z fastest.
    openvdb::tools::Dense<float> dense(nodes, depth.values.data());
    openvdb::tools::copyToDense(phi, dense);
  }
  for (float& value : depth.values) {
    value = static_cast<float>(-value / voxel);
    if (std::abs(value) < kTie) value = 0;
  }
  Lattice tau = paint(depth, ridgeBalls(depth, monitor), monitor);
  for (std::size_t i = 0; i < tau.values.size(); ++i) {
    // Outside, and where no ball reaches, the neighbours decide.
    tau.values[i] = depth.values[i] > 0 && tau.values[i] > 0
                        ? std::max(tau.values[i], static_cast<float>(kLeastThickness))
                        : std::numeric_limits<float>::infinity();
  }
  markThinParts(depth, tau);
  extend(tau);
  mFound = std::make_shared<const Found>(Found{nodes, voxel, std::move(depth), std::move(tau), phi.transform().copy()});
}

LocalThickness ThicknessFinder::limitedTo(double slope, Monitor& monitor) const {
  const double voxel = mFound->voxel;
  const Lattice& depth = mFound->depth;
  Lattice tau = mFound->tau;
  limitSlope(tau, static_cast<float>(slope));
  monitor.throwIfCancelled();
  smooth(tau, monitor);
  float least = std::numeric_limits<float>::infinity(), greatest = 0, leastAnywhere = least;
  for (std::size_t i = 0; i < tau.values.size(); ++i) {
    tau.values[i] *= static_cast<float>(voxel);
    leastAnywhere = std::min(leastAnywhere, tau.values[i]);
    if (!(depth.values[i] > 0)) continue;
    least = std::min(least, tau.values[i]);
    greatest = std::max(greatest, tau.values[i]);
  }
  // The outside is never thicker than the inside.
  for (float& value : tau.values) value = std::min(value, greatest);
  LocalThickness result;
  result.least = least;
  result.greatest = greatest;
  result.leastAnywhere = leastAnywhere;
  result.tau = FloatGrid::create(greatest);
  result.tau->setTransform(mFound->transform->copy());
  result.tau->setName("tau");
  // A tolerance of -1 keeps every node active.
  openvdb::tools::copyFromDense(openvdb::tools::Dense<float>(mFound->nodes, tau.values.data()), *result.tau, -1.0f);
  return result;
}

std::optional<double> ThicknessFinder::leastThickness(double share, Monitor& monitor) const {
  constexpr float kSlope = 0.5f;
  Lattice tau = mFound->tau;
  // tau from above: it falls from a thick part no faster than with this slope.
  for (float& value : tau.values) value = -value;
  limitSlope(tau, kSlope);
  monitor.throwIfCancelled();
  std::vector<float> radii;
  for (std::size_t i = 0; i < tau.values.size(); ++i)
    if (std::abs(mFound->depth.values[i]) < 1) radii.push_back(-tau.values[i]);
  if (radii.empty()) return std::nullopt;
  const auto last = static_cast<double>(radii.size() - 1);
  const auto thin = radii.begin() + static_cast<std::ptrdiff_t>(share * last);
  std::nth_element(radii.begin(), thin, radii.end());
  return 2 * mFound->voxel * static_cast<double>(*thin);
}

LocalThickness localThickness(const FloatGrid& phi, Monitor& monitor, double slope) {
  return ThicknessFinder(phi, monitor).limitedTo(slope, monitor);
}

using openvdb::Vec3d;

OctaveGrid octaveGrid(const LocalThickness& thickness, const Control& frequency, const FractalSpace& space) {
  OctaveGrid result{thickness.tau->deepCopy(), space};
  result.grid->setGridClass(openvdb::GRID_UNKNOWN);
  std::vector<Vec3d> points;
  std::vector<double> values;
  for (auto leaf = result.grid->tree().beginLeaf(); leaf; ++leaf) {
    points.clear();
    for (auto node = leaf->cbeginValueOn(); node; ++node)
      points.push_back(result.grid->indexToWorld(node.getCoord().asVec3d()));
    values.resize(points.size());
    frequency.sample(points, values);
    std::size_t i = 0;
    for (auto node = leaf->beginValueOn(); node; ++node, ++i) {
      if (!(values[i] > 0 && std::isfinite(values[i])))
        throw std::invalid_argument("--frequency is " + shortText(values[i]) +
                                    " at a place of the target; it must be above 0 everywhere");
      const double tau = static_cast<double>(node.getValue()) / space.scale;
      node.setValue(static_cast<float>(elementary::log2(values[i] / (2 * tau))));
    }
  }
  return result;
}

}  // namespace vdbtools
