// SPDX-License-Identifier: Apache-2.0
/// @file triangle_bodies.h
/// The code of the kernels. One source file for each instruction set includes it and defines JULIA_FLOATS, the number
/// of floats in its vectors.
///
/// They are fast because of one bound. The distance to a convex set is a convex function. Let c be the centre of a
/// cube, T a triangle, and n the unit vector to c from the point of T that is nearest to it: dist(p, T) >= dist(c, T) +
/// n (p - c). For another triangle B, dist(p, B) minus this bound is convex, so its maximum over the cube is at a
/// corner. If that maximum is below 0, T is not the nearest triangle of any point of the cube. The same holds for
/// boxes, and thus for everything in them. A cube of nodes starts with the candidates of the cube twice its size
/// that contains it.
///
/// Floats choose the nearest triangle; its distance is then computed in doubles. Each lane computes what a scalar
/// would, so the width of the vectors does not affect the result.
#pragma once

#include "search/kernels/triangle_candidates.h"
#include "search/kernels/triangle_spheres.h"

namespace vdbtools::kernels {
namespace {

struct Entry {
  std::uint32_t node;
  std::uint32_t level;  // the number of levels stands for a pack
  float squared;
};

/// For a depth-first traversal: on each level, all children but the visited one.
constexpr unsigned kStack = kPack * (kMostLevels + 1) + 1;

bool nearest(const TreeView& tree, const double position[3], std::uint32_t first, float& squared, Place& place) {
  float p[3];
  toCentre(tree, position, p);
  Entry stack[kStack];
  unsigned size = 0;
  stack[size++] = {0, tree.levelCount - 1, 0};
  if (first != kNoPack) stack[size++] = {first, tree.levelCount, 0};
  bool found = false;
  while (size > 0) {
    const Entry entry = stack[--size];
    if (entry.squared >= squared) continue;
    float each[kPack];
    if (entry.level == tree.levelCount) {
      const NodeFloats zero = {};
      for (unsigned k = 0; k < kPack; k += kNodesWide)
        store(awayFrom<NodeFloats>(trianglesOf<NodeFloats>(tree.packs[entry.node], k, position), zero, zero, zero)
                  .squared,
              each + k);
      for (unsigned k = 0; k < kPack; ++k)
        if (each[k] < squared) {
          squared = each[k];
          place = {entry.node, k};
          found = true;
        }
      continue;
    }
    const BoxNode& node = tree.levels[entry.level][entry.node];
    for (unsigned k = 0; k < kPack; k += kNodesWide) {
      const NodeFloats zero = {};
      NodeFloats sum = {};
      for (int axis = 0; axis < 3; ++axis) {
        const NodeFloats low = load<NodeFloats>(node.low[axis] + k), high = load<NodeFloats>(node.high[axis] + k);
        const NodeFloats d = greater(greater(low - p[axis], p[axis] - high), zero);
        sum += d * d;
      }
      store(sum, each + k);
    }
    // Push the nearest child last, so that it is popped first.
    const unsigned begin = size;
    const std::uint32_t below = entry.level == 0 ? tree.levelCount : entry.level - 1;
    for (unsigned k = 0; k < kPack; ++k) {
      if (!(each[k] < squared)) continue;
      unsigned at = size++;
      for (; at > begin && stack[at - 1].squared < each[k]; --at) stack[at] = stack[at - 1];
      stack[at] = {entry.node * kPack + k, below, each[k]};
    }
  }
  return found;
}

/// The vectors from the boxes of a node to a position, in lanes.
struct ToBoxes {
  NodeFloats d[3];
  NodeFloats squared;
};

/// @param first  of the lanes
inline ToBoxes toBoxes(const BoxNode& node, unsigned first, const float p[3]) {
  const NodeFloats zero = {};
  ToBoxes to;
  for (int axis = 0; axis < 3; ++axis)
    to.d[axis] = greater(p[axis] - load<NodeFloats>(node.high[axis] + first), zero) -
                 greater(load<NodeFloats>(node.low[axis] + first) - p[axis], zero);
  to.squared = to.d[0] * to.d[0] + to.d[1] * to.d[1] + to.d[2] * to.d[2];
  return to;
}

std::uint32_t collect(const TreeView& tree, const double middle[3], float half, Place best, std::uint32_t* packs,
                      std::uint32_t capacity) {
  constexpr float kNowhere[3] = {0, 0, 0};
  const Triangle<float> triangle = triangleAt(tree, best, middle);
  const CornerBounds bounds = cornerBounds(triangle, kNowhere, half, slackOf(triangle) + 2 * tree.boxSlack);
  float p[3];
  toCentre(tree, middle, p);
  struct Open {
    std::uint32_t node, level;
  };
  Open stack[kStack];
  unsigned size = 0;
  std::uint32_t count = 0;
  stack[size++] = {0, tree.levelCount - 1};
  while (size > 0) {
    const Open open = stack[--size];
    const BoxNode& node = tree.levels[open.level][open.node];
    float over[kPack];
    for (unsigned k = 0; k < kPack; k += kNodesWide) {
      const NodeFloats zero = {};
      const ToBoxes to = toBoxes(node, k, p);
      store(excess(to.d[0], to.d[1], to.d[2], to.squared, half, zero, bounds), over + k);
    }
    for (unsigned k = kPack; k-- > 0;) {
      if (over[k] > 0.0F) continue;
      const std::uint32_t child = open.node * kPack + k;
      if (open.level > 0) {
        stack[size++] = {child, open.level - 1};
      } else {
        if (count < capacity) packs[count] = child;
        ++count;
      }
    }
  }
  return count;
}

/// The triangle of a pack that is nearest to a position, relative to it.
inline Triangle<float> nearestOfPack(const TreeView& tree, std::uint32_t pack, const double position[3]) {
  const NodeFloats zero = {};
  Triangle<float> best{};
  float least = kHuge;
  for (unsigned first = 0; first < kPack; first += kNodesWide) {
    const Triangle<NodeFloats> lanes = trianglesAt(tree, tree.numbers[pack].triangle + first, position);
    const NodeFloats squared = awayFrom<NodeFloats>(lanes, zero, zero, zero).squared;
    for (unsigned k = 0; k < kNodesWide; ++k) {
      if (!(squared[k] < least)) continue;
      least = squared[k];
      best = laneOf(lanes, k);
    }
  }
  return best;
}

std::uint32_t gather(const TreeView& tree, const double middle[3], float half, float far, const std::uint32_t* nodes,
                     std::uint32_t nodeCount, std::uint32_t* packs, std::uint32_t capacity) {
  constexpr float kNowhere[3] = {0, 0, 0};
  float p[3];
  toCentre(tree, middle, p);
  float least = kHuge;
  std::uint32_t nearestPack = 0;
  for (std::uint32_t n = 0; n < nodeCount; ++n)
    for (unsigned first = 0; first < kPack; first += kNodesWide) {
      const NodeFloats squared = toBoxes(tree.levels[0][nodes[n]], first, p).squared;
      for (unsigned k = 0; k < kNodesWide; ++k) {
        if (!(squared[k] < least)) continue;
        least = squared[k];
        nearestPack = nodes[n] * kPack + first + k;
      }
    }
  const float reach = far * 1.00001F + 2 * tree.boxSlack;
  constexpr float kDiagonal = 1.7321F;
  if (std::sqrt(least) > reach + kDiagonal * half) return 0;
  const Triangle<float> triangle = nearestOfPack(tree, nearestPack, middle);
  const CornerBounds bounds = cornerBounds(triangle, kNowhere, half, slackOf(triangle) + 2 * tree.boxSlack);
  std::uint32_t count = 0;
  for (std::uint32_t n = 0; n < nodeCount; ++n) {
    float over[kPack];
    for (unsigned first = 0; first < kPack; first += kNodesWide) {
      const NodeFloats zero = {};
      const ToBoxes to = toBoxes(tree.levels[0][nodes[n]], first, p);
      store(greater(excess(to.d[0], to.d[1], to.d[2], to.squared, half, zero, bounds),
                    excessOver(reach, to.d[0], to.d[1], to.d[2], to.squared, half, zero)),
            over + first);
    }
    for (unsigned k = 0; k < kPack; ++k) {
      if (over[k] > 0.0F) continue;
      if (count < capacity) packs[count] = nodes[n] * kPack + k;
      ++count;
    }
  }
  return count;
}

void makeFrames(const TreeView& tree, std::uint32_t first, std::uint32_t count, PackFrames* frames) {
  static_assert(3 + kFrameArrays == kSlackAt);
  constexpr double kNowhere[3] = {0, 0, 0};
  for (std::uint32_t pack = first; pack < first + count; ++pack) {
    PackFrames& to = frames[pack];
    const std::uint32_t* const numbers = tree.numbers[pack].triangle;
    for (unsigned k = 0; k < kPack; ++k) {
      const double* const corner = tree.points + 3 * std::size_t{tree.triangles[3 * std::size_t{numbers[k]}]};
      for (unsigned axis = 0; axis < 3; ++axis) to.corner[axis][k] = corner[axis];
    }
    for (unsigned k = 0; k < kPack; k += kNodesWide) {
      const Triangle<NodeFloats> t = trianglesAt(tree, numbers + k, kNowhere);
      const auto* from = reinterpret_cast<const NodeFloats*>(&t);
      for (unsigned l = 0; l < kFrameArrays; ++l) store(from[3 + l], to.frame[l] + k);
      store(slackOf(t), to.slack + k);
    }
  }
}

/// The corners of a cube whose side is 1.
constexpr double kHalfCorner[3][8] = {{-0.5, -0.5, -0.5, -0.5, 0.5, 0.5, 0.5, 0.5},
                                      {-0.5, -0.5, 0.5, 0.5, -0.5, -0.5, 0.5, 0.5},
                                      {-0.5, 0.5, -0.5, 0.5, -0.5, 0.5, -0.5, 0.5}};

/// Some triangles in doubles, about their own corners.
struct ExactTriangles {
  std::uint32_t numbers[kDoublesWide];
  Doubles corner[3];
  Triangle<Doubles> about;
};

inline void frameExactly(const TreeView& tree, const std::uint32_t* numbers, ExactTriangles& to) {
  double at[3][3][kDoublesWide];
  for (unsigned k = 0; k < kDoublesWide; ++k) {
    const std::uint32_t* const points = tree.triangles + 3 * std::size_t{numbers[k]};
    for (unsigned c = 0; c < 3; ++c)
      for (unsigned axis = 0; axis < 3; ++axis) at[c][axis][k] = tree.points[3 * std::size_t{points[c]} + axis];
  }
  __builtin_memcpy(to.numbers, numbers, sizeof(to.numbers));
  const Doubles zero = {};
  Doubles p[3], q[3];
  for (int axis = 0; axis < 3; ++axis) {
    to.corner[axis] = load<Doubles>(at[0][axis]);
    p[axis] = load<Doubles>(at[1][axis]) - to.corner[axis];
    q[axis] = load<Doubles>(at[2][axis]) - to.corner[axis];
  }
  to.about = frameOf<Doubles>(zero, zero, zero, p[0], p[1], p[2], q[0], q[1], q[2]);
}

/// Computes the distances of the chosen triangles.
/// @param last  the triangles of the last call, which are often the same
/// @param corner  the number of the cube's first node
inline void finish(const TreeView& tree, const double middle[3], const float about[3], const std::uint32_t (&chosen)[8],
                   ExactTriangles& last, unsigned corner, float* distance, std::uint32_t* triangle) {
  float exact[8];
  for (unsigned k = 0; k < 8; k += kDoublesWide) {
    if (__builtin_memcmp(last.numbers, chosen + k, sizeof(last.numbers)) != 0) frameExactly(tree, chosen + k, last);
    Doubles x[3];
    for (int axis = 0; axis < 3; ++axis)
      x[axis] = load<Doubles>(kHalfCorner[axis] + k) + (middle[axis] + double{about[axis]}) - last.corner[axis];
    const Doubles found = squareRoot(awayFrom<Doubles>(last.about, x[0], x[1], x[2]).squared);
    for (unsigned lane = 0; lane < kDoublesWide; ++lane) exact[k + lane] = static_cast<float>(found[lane]);
  }
  for (unsigned k = 0; k < 8; ++k) {
    const unsigned node = corner + (k & 4 ? 64 : 0) + (k & 2 ? 8 : 0) + (k & 1);
    distance[node] = exact[k];
    triangle[node] = chosen[k];
  }
}

/// With fewer candidates, selecting again for a smaller cube does not pay off.
constexpr std::uint32_t kFew = 6;

/// More candidates than this are ManyCandidates.
constexpr std::uint32_t kMany = 4096;

/// The centres of cubes of 4^3 nodes, and of the cubes of 2^3 nodes in them.
struct CubeCentres {
  unsigned first[3];  ///< the first node
  float about[3];

  static CubeCentres of4(unsigned i) {
    CubeCentres cube{{i & 4, 2 * (i & 2), 4 * (i & 1)}, {}};
    for (int axis = 0; axis < 3; ++axis) cube.about[axis] = static_cast<float>(cube.first[axis]) - 2.0F;
    return cube;
  }
  CubeCentres of2(unsigned j) const {
    CubeCentres cube{{first[0] + (j & 4) / 2, first[1] + (j & 2), first[2] + 2 * (j & 1)}, {}};
    for (int axis = 0; axis < 3; ++axis) cube.about[axis] = static_cast<float>(cube.first[axis]) - 3.0F;
    return cube;
  }
  unsigned node() const { return first[0] * 64 + first[1] * 8 + first[2]; }
};

void resolveMany(const TreeView& tree, const double (&middle)[3], const std::uint32_t* packs, std::uint32_t count,
                 float far, const Scratch& scratch, float distance[kBlockNodes], std::uint32_t triangle[kBlockNodes]) {
  auto* const boxes = static_cast<PackBoxes*>(scratch.boxes);
  const std::uint32_t boxVectors = prepareBoxes(tree, middle, packs, count, boxes);
  ManyCandidates many(tree, middle, packs, count, scratch);
  ExactTriangles exact;
  frameExactly(tree, tree.numbers[packs[0]].triangle, exact);
  for (unsigned i = 0; i < 8; ++i) {
    const CubeCentres four = CubeCentres::of4(i);
    const Triangle<float> near = many.nearBoxes(boxes, boxVectors, four.about);
    const CornerBounds bounds = cornerBounds(near, four.about, 1.5F, slackOf(near) + 2 * tree.boxSlack + 1e-5F);
    std::uint32_t nearPacks = 0;
    const std::uint32_t vectors =
        chooseVectors(boxes, boxVectors, four.about, 1.5F, bounds, far * 1.00001F + 2 * tree.boxSlack, scratch.list[1],
                      scratch.list[0], nearPacks);
    if (vectors == 0 || !many.chooseOfFour(scratch.list[1], vectors, four.about, far)) continue;
    for (unsigned j = 0; j < 8; ++j) {
      const CubeCentres two = four.of2(j);
      if (!many.chooseOfTwo(two.about, far)) continue;
      std::uint32_t numbers[8];
      many.decide(two.about, numbers);
      finish(tree, middle, two.about, numbers, exact, two.node(), distance, triangle);
    }
  }
}

void resolve(const TreeView& tree, const double middle[3], const std::uint32_t* packs, std::uint32_t count, float far,
             const Scratch& scratch, float distance[kBlockNodes], std::uint32_t triangle[kBlockNodes]) {
  if (count * kPack > kMany) {
    const double about[3] = {middle[0], middle[1], middle[2]};
    resolveMany(tree, about, packs, count, far, scratch, distance, triangle);
    return;
  }
  auto* const all = static_cast<CandidatePack*>(scratch.candidates[0]);
  auto* const some = static_cast<CandidatePack*>(scratch.candidates[1]);
  auto* const boxes = static_cast<PackBoxes*>(scratch.boxes);
  const std::uint32_t total = prepare(tree, middle, packs, count, all);
  fill(all, total);
  const std::uint32_t vectors = (total + kWide - 1) / kWide;
  const std::uint32_t boxVectors = prepareBoxes(tree, middle, packs, count, boxes);
  ExactTriangles exact;
  frameExactly(tree, tree.numbers[packs[0]].triangle, exact);
  for (unsigned i = 0; i < 8; ++i) {
    const CubeCentres four = CubeCentres::of4(i);
    float least = 0;
    const float* const one = nearCandidate(all, vectors, four.about);
    const CornerBounds bounds =
        cornerBounds(triangleOf(one), four.about, 1.5F, one[kWide * kSlackAt] + 2 * tree.boxSlack + 1e-5F);
    std::uint32_t* const list = scratch.list[0];
    std::uint32_t nearPacks = 0;
    const std::uint32_t near = chooseVectors(boxes, boxVectors, four.about, 1.5F, bounds,
                                             far * 1.00001F + 2 * tree.boxSlack, scratch.list[1], list, nearPacks);
    if (near == 0) continue;
    const std::uint32_t of4 = choose(all, total, scratch.list[1], near, four.about, 1.5F, scratch, list, least);
    if (least > far + kHalfDiagonal4) continue;
    take(all, list, of4, some);
    for (unsigned j = 0; j < 8; ++j) {
      const CubeCentres two = four.of2(j);
      std::uint32_t of2 = of4;
      if (of4 > kFew) {
        of2 = choose(some, of4, nullptr, (of4 + kWide - 1) / kWide, two.about, 0.5F, scratch, list, least);
        if (least > far + kHalfDiagonal2) continue;
      } else {
        for (std::uint32_t n = 0; n < of4; ++n) list[n] = n;
      }
      std::uint32_t numbers[8];
      decide(some, list, of2, two.about, numbers);
      finish(tree, middle, two.about, numbers, exact, two.node(), distance, triangle);
    }
  }
}

}  // namespace
}  // namespace vdbtools::kernels
