// SPDX-License-Identifier: Apache-2.0
/// @file triangle_bodies.h
/// The code of the kernels. One source file for each instruction set includes it and defines JULIA_FLOATS, the number
/// of floats in its vectors.
///
/// They are fast because of one bound. The distance to a convex set is a convex function. Let c be the centre of a
/// cube, T a triangle, and n the unit vector to c from the point of T that is nearest to it: dist(p, T) >= dist(c, T) +
/// n (p - c). For another triangle B, dist(p, B) minus this bound is convex, so its maximum over the cube is at a
/// corner. If that maximum is below 0, T is not the nearest triangle of any point of the cube. The same holds for
/// boxes, and thus for everything in them. A cube of nodes starts with the candidates of the cube of which it is an
/// eighth.
///
/// Floats choose the nearest triangle; its distance is then computed in doubles. Each lane computes what a scalar
/// would, so the width of the vectors does not affect the result.
#pragma once

#include "search/kernels/triangle_lanes.h"

namespace vdbtools::kernels {
namespace {

inline void toCentre(const TreeView& tree, const double position[3], float (&p)[3]) {
  for (int axis = 0; axis < 3; ++axis) p[axis] = static_cast<float>(position[axis] - tree.centre[axis]);
}

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

/// Upper bounds of the distances from a cube's corners to a triangle.
struct CornerBounds {
  float at[8];
};

/// The corners of a cube whose half side is 1.
constexpr float kCorner[3][8] = {
    {-1, -1, -1, -1, 1, 1, 1, 1}, {-1, -1, 1, 1, -1, -1, 1, 1}, {-1, 1, -1, 1, -1, 1, -1, 1}};

/// Eight corners relative to another point, as lanes first to first + kNodesWide.
inline NodeFloats corners(int axis, unsigned first, float half, float about) {
  return load<NodeFloats>(kCorner[axis] + first) * half + about;
}

/// @param slack  error bound of the triangle's distances
inline CornerBounds cornerBounds(const Triangle<float>& triangle, const float about[3], float half, float slack) {
  CornerBounds bounds;
  for (unsigned k = 0; k < 8; k += kNodesWide) {
    const NodeFloats squared = awayFrom<NodeFloats>(triangle, corners(0, k, half, about[0]),
                                                    corners(1, k, half, about[1]), corners(2, k, half, about[2]))
                                   .squared;
    store(squareRoot(squared) * 1.00001F + slack, bounds.at + k);
  }
  return bounds;
}

/// By how much something is too far to be nearest anywhere in a cube; if at most 0, it may be nearest.
/// @param x, y, z  the vector from its nearest point to the cube's centre
/// @param slack  by how much its distance may be overestimated
template <class V>
inline V excess(V x, V y, V z, V squared, float half, V slack, const CornerBounds& bounds) {
  const V distance = squareRoot(squared);
  const V scale = half / (distance + 1e-20F);
  x *= scale, y *= scale, z *= scale;
  const V base = distance * 0.999998F - slack;
  const V ll = base - x - y, lh = base - x + y, hl = base + x - y, hh = base + x + y;
  return lesser(lesser(lesser(ll - z - bounds.at[0], ll + z - bounds.at[1]),
                       lesser(lh - z - bounds.at[2], lh + z - bounds.at[3])),
                lesser(lesser(hl - z - bounds.at[4], hl + z - bounds.at[5]),
                       lesser(hh - z - bounds.at[6], hh + z - bounds.at[7])));
}

/// By how much something is farther than @a far everywhere in a cube, with the arguments of excess().
template <class V>
inline V excessOver(float far, V x, V y, V z, V squared, float half, V slack) {
  const V distance = squareRoot(squared);
  const V scale = half / (distance + 1e-20F);
  const auto absolute = [](V v) { return greater(v, -v); };
  return distance * 0.999998F - slack - scale * (absolute(x) + absolute(y) + absolute(z)) - far;
}

/// The triangle nearest to a cube's centre, with the data for comparing others with it.
struct Nearest {
  CornerBounds bounds;
  float distance;   ///< an upper bound
  float x, y, z;    ///< the unit vector to the cube's centre
  float curvature;  ///< an upper bound of how far the distance exceeds its tangent at the corners
};

/// A lower bound of excess(). From the nearest point q of B, dist(p, B) is at most |p - q|, which is at most dist(c, B)
/// + n (p - c) + |p - c|^2 / (2 dist(c, B)). This is much cheaper, and as good far from the surface.
template <class V>
inline V farExcess(V x, V y, V z, V squared, float half, V slack, const Nearest& b) {
  const V distance = squareRoot(squared);
  const V scale = 1 / (distance + 1e-20F);
  const auto absolute = [](V v) { return greater(v, -v); };
  return distance * 0.999998F - slack - b.distance - b.curvature -
         half * (absolute(x * scale - b.x) + absolute(y * scale - b.y) + absolute(z * scale - b.z));
}

/// The error bound of a triangle's distances in floats.
template <class V>
inline V slackOf(const Triangle<V>& t) {
  return 4e-6F * (t.b + t.d);
}

/// One of several triangles.
inline Triangle<float> laneOf(const Triangle<NodeFloats>& lanes, unsigned lane) {
  Triangle<float> triangle;
  float* const to = &triangle.ax;
  const auto* from = reinterpret_cast<const NodeFloats*>(&lanes);
  for (unsigned l = 0; l < sizeof(triangle) / sizeof(float); ++l) to[l] = from[l][lane];
  return triangle;
}

/// A triangle relative to a position.
inline Triangle<float> triangleAt(const TreeView& tree, Place place, const double position[3]) {
  const unsigned first = place.lane / kNodesWide * kNodesWide;
  return laneOf(trianglesOf<NodeFloats>(tree.packs[place.pack], first, position), place.lane - first);
}

/// @param slack  error bound of the triangle's distances
inline Nearest nearestOf(const Triangle<float>& t, const float about[3], float half, float slack) {
  Nearest result;
  result.bounds = cornerBounds(t, about, half, slack);
  const NodeFloats zero = {};
  const Away<NodeFloats> away = awayFrom<NodeFloats>(t, zero + about[0], zero + about[1], zero + about[2]);
  const float distance = std::sqrt(away.squared[0]), scale = 1 / (distance + 1e-20F);
  const float x = away.x[0] * scale, y = away.y[0] * scale, z = away.z[0] * scale;
  result.distance = distance * 1.00001F + slack;
  result.x = x * t.ux + y * t.vx + z * t.nx;
  result.y = x * t.uy + y * t.vy + z * t.ny;
  result.z = x * t.uz + y * t.vz + z * t.nz;
  result.curvature = 1.5F * half * half / (distance + 1e-20F);
  return result;
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

/// Candidates in lanes, and their numbers in the mesh.
struct CandidatePack {
  Triangle<Floats> triangle;
  Floats slack;
  Numbers number;
};
constexpr unsigned kArrays = sizeof(CandidatePack) / sizeof(Floats);
static_assert(kArrays * 4 * kPack <= kCandidateBytes);

/// Candidate number @a i.
inline const float* candidate(const CandidatePack* packs, std::uint32_t i) {
  return reinterpret_cast<const float*>(packs + i / kWide) + i % kWide;
}
inline Triangle<float> triangleOf(const float* candidate) {
  Triangle<float> t;
  float* const to = &t.ax;
  for (unsigned l = 0; l < sizeof(t) / sizeof(float); ++l) to[l] = candidate[kWide * l];
  return t;
}
constexpr unsigned kSlackAt = sizeof(Triangle<float>) / sizeof(float);
constexpr unsigned kNumberAt = kSlackAt + 1;

inline std::int32_t numberOf(const float* candidate) {
  std::int32_t number;
  __builtin_memcpy(&number, candidate + kWide * kNumberAt, sizeof(number));
  return number;
}

/// Some triangles relative to a position. Their floats depend only on the triangle and the position, so a node gets the
/// same distance from any part of the mesh that contains its nearest triangle.
inline Triangle<NodeFloats> trianglesAt(const TreeView& tree, const std::uint32_t* numbers, const double position[3]) {
  float at[3][3][kNodesWide];
  for (unsigned k = 0; k < kNodesWide; ++k) {
    const std::uint32_t* const corner = tree.triangles + 3 * std::size_t{numbers[k]};
    const double* const a = tree.points + 3 * std::size_t{corner[0]};
    const double* const b = tree.points + 3 * std::size_t{corner[1]};
    const double* const c = tree.points + 3 * std::size_t{corner[2]};
    for (unsigned axis = 0; axis < 3; ++axis) {
      at[0][axis][k] = static_cast<float>(a[axis] - position[axis]);
      at[1][axis][k] = static_cast<float>(b[axis] - a[axis]);
      at[2][axis][k] = static_cast<float>(c[axis] - a[axis]);
    }
  }
  const auto v = [&](unsigned of, unsigned axis) { return load<NodeFloats>(at[of][axis]); };
  return frameOf<NodeFloats>(v(0, 0), v(0, 1), v(0, 2), v(1, 0), v(1, 1), v(1, 2), v(2, 0), v(2, 1), v(2, 2));
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

/// Converts the candidates of packs to coordinates about a centre. @return their number
inline std::uint32_t prepare(const TreeView& tree, const double middle[3], const std::uint32_t* packs,
                             std::uint32_t count, CandidatePack* to) {
  for (std::uint32_t i = 0; i < count; ++i) {
    for (unsigned first = 0; first < kPack; first += kNodesWide) {
      const std::uint32_t* const numbers = tree.numbers[packs[i]].triangle + first;
      const std::uint32_t at = i * kPack + first;
      float* const lanes = reinterpret_cast<float*>(to + at / kWide) + at % kWide;
      __builtin_memcpy(lanes + kWide * kNumberAt, numbers, kNodesWide * sizeof(*numbers));
      if (tree.frames) {
        const PackFrames& made = tree.frames[packs[i]];
        for (unsigned axis = 0; axis < 3; ++axis)
          for (unsigned k = 0; k < kNodesWide; ++k)
            lanes[kWide * axis + k] = static_cast<float>(made.corner[axis][first + k] - middle[axis]);
        for (unsigned l = 0; l < kFrameArrays; ++l)
          store(load<NodeFloats>(made.frame[l] + first), lanes + kWide * (3 + l));
        store(load<NodeFloats>(made.slack + first), lanes + kWide * kSlackAt);
      } else {
        const Triangle<NodeFloats> t = trianglesAt(tree, numbers, middle);
        const auto* from = reinterpret_cast<const NodeFloats*>(&t);
        for (unsigned l = 0; l < kSlackAt; ++l) store(from[l], lanes + kWide * l);
        store(slackOf(t), lanes + kWide * kSlackAt);
      }
    }
  }
  return count * kPack;
}

/// Fills the last vector with copies of the last candidate.
inline void fill(CandidatePack* packs, std::uint32_t count) {
  const float* const from = candidate(packs, count - 1);
  for (std::uint32_t i = count; i % kWide != 0; ++i) {
    float* const to = reinterpret_cast<float*>(packs + i / kWide) + i % kWide;
    for (unsigned l = 0; l < kArrays; ++l) __builtin_memcpy(to + kWide * l, from + kWide * l, sizeof(float));
  }
}

/// The boxes of the candidates' packs, relative to the block's centre; unused boxes are far away.
struct PackBoxes {
  Floats low[3], high[3];
};

/// @return the number of vectors
inline std::uint32_t prepareBoxes(const TreeView& tree, const double middle[3], const std::uint32_t* packs,
                                  std::uint32_t count, PackBoxes* to) {
  float p[3];
  toCentre(tree, middle, p);
  const std::uint32_t vectors = (count + kWide - 1) / kWide;
  for (std::uint32_t i = 0; i < vectors * kWide; ++i) {
    float* const box = reinterpret_cast<float*>(to + i / kWide) + i % kWide;
    for (unsigned axis = 0; axis < 3; ++axis) {
      const BoxNode& node = tree.levels[0][packs[i < count ? i : 0] / kPack];
      const unsigned lane = packs[i < count ? i : 0] % kPack;
      box[kWide * axis] = i < count ? node.low[axis][lane] - p[axis] : kFarAway;
      box[kWide * (3 + axis)] = i < count ? node.high[axis][lane] - p[axis] : kFarAway;
    }
  }
  return vectors;
}

/// A bit for each lane that is at most 0.
inline unsigned lanesUpTo0(Floats over) {
#if defined(__AVX512F__)
  return _mm512_cmp_ps_mask(over, _mm512_setzero_ps(), _CMP_LE_OQ);
#elif defined(__AVX2__)
  return static_cast<unsigned>(_mm256_movemask_ps(_mm256_cmp_ps(over, _mm256_setzero_ps(), _CMP_LE_OQ)));
#elif defined(__SSE2__)
  return static_cast<unsigned>(_mm_movemask_ps(_mm_cmple_ps(over, _mm_setzero_ps())));
#else
  unsigned bits = 0;
  for (unsigned k = 0; k < kWide; ++k) bits |= (over[k] <= 0.0F ? 1U : 0U) << k;
  return bits;
#endif
}

/// Appends the numbers of the lanes that are at most 0, and returns the new number of entries.
inline std::uint32_t append(Floats over, std::uint32_t first, std::uint32_t* list, std::uint32_t count) {
  for (unsigned bits = lanesUpTo0(over); bits != 0; bits &= bits - 1)
    list[count++] = first + static_cast<unsigned>(__builtin_ctz(bits));
  return count;
}

/// The vectors from boxes to a position.
struct FromBoxes {
  Floats d[3];
  Floats squared;
};

inline FromBoxes fromBoxes(const PackBoxes& boxes, const float p[3]) {
  const Floats zero = {};
  FromBoxes from;
  for (int axis = 0; axis < 3; ++axis)
    from.d[axis] = greater(p[axis] - boxes.high[axis], zero) - greater(boxes.low[axis] - p[axis], zero);
  from.squared = from.d[0] * from.d[0] + from.d[1] * from.d[1] + from.d[2] * from.d[2];
  return from;
}

/// Finds the vectors of candidates that may hold the triangle nearest to some point of the cube about @a about, at most
/// @a far from it.
/// @param packs  receives the packs of which that is so, @a chosen in number
inline std::uint32_t chooseVectors(const PackBoxes* boxes, std::uint32_t count, const float about[3], float half,
                                   const CornerBounds& bounds, float far, std::uint32_t* list, std::uint32_t* packs,
                                   std::uint32_t& chosen) {
  const Floats zero = {};
  chosen = 0;
  for (std::uint32_t i = 0; i < count; ++i) {
    const FromBoxes to = fromBoxes(boxes[i], about);
    const Floats over = greater(excess(to.d[0], to.d[1], to.d[2], to.squared, half, zero, bounds),
                                excessOver(far, to.d[0], to.d[1], to.d[2], to.squared, half, zero));
    chosen = append(over, i * kWide, packs, chosen);
  }
  // A pack may be several vectors, or a vector several packs.
  std::uint32_t vectors = 0;
  for (std::uint32_t n = 0; n < chosen; ++n)
    for (unsigned k = 0; k < kPack; k += kNodesWide) {
      list[vectors] = (packs[n] * kPack + k) / kWide;
      vectors += vectors == 0 || list[vectors - 1] != list[vectors];
    }
  return vectors;
}

/// A candidate near a position: the nearest of few candidates; if there are many, one of those next to the nearest
/// corner.
inline const float* nearCandidate(const CandidatePack* from, std::uint32_t vectors, const float about[3]) {
  constexpr std::uint32_t kFew = 64 / kWide;
  const Floats zero = {};
  const Floats px = zero + about[0], py = zero + about[1], pz = zero + about[2];
  Floats leasts = zero + kHuge;
  Numbers firsts = {};
  const auto meetAll = [&](std::uint32_t begin, std::uint32_t end, const auto& squaredOf) {
    for (std::uint32_t i = begin; i < end; ++i) {
      const Floats squared = squaredOf(from[i].triangle);
      const auto nearer = squared < leasts;
      leasts = nearer ? squared : leasts;
      firsts = nearer ? Numbers{} + static_cast<std::int32_t>(i * kWide) : firsts;
    }
    unsigned winner = 0;
    for (unsigned k = 1; k < kWide; ++k)
      if (leasts[k] < leasts[winner]) winner = k;
    return static_cast<std::uint32_t>(firsts[winner]) + winner;
  };
  const auto toTriangle = [&](const Triangle<Floats>& t) { return awayFrom<Floats>(t, px, py, pz).squared; };
  if (vectors <= kFew) return candidate(from, meetAll(0, vectors, toTriangle));
  const std::uint32_t byCorner = meetAll(0, vectors, [&](const Triangle<Floats>& t) {
    const Floats x = px - t.ax, y = py - t.ay, z = pz - t.az;
    return x * x + y * y + z * z;
  });
  leasts = zero + kHuge;
  return candidate(from, meetAll(byCorner / kWide, byCorner / kWide + 1, toTriangle));
}

/// Whether candidates may be nearest in a cube: they may if the result is at most 0.
inline Floats excessOf(const CandidatePack& pack, const Away<Floats>& f, float half, const Nearest& nearest,
                       bool isFar) {
  const Triangle<Floats>& t = pack.triangle;
  const Floats x = f.x * t.ux + f.y * t.vx + f.z * t.nx;
  const Floats y = f.x * t.uy + f.y * t.vy + f.z * t.ny;
  const Floats z = f.x * t.uz + f.y * t.vz + f.z * t.nz;
  return isFar ? farExcess(x, y, z, f.squared, half, pack.slack, nearest)
               : excess(x, y, z, f.squared, half, pack.slack, nearest.bounds);
}

/// Whether the cheaper bound is nearly as good.
inline bool isFarFrom(float distance, float half) { return distance > 8 * half; }

/// Finds the candidates that may be nearest somewhere in the cube about @a about.
/// @param vectors  which of their vectors to examine; null: all
/// @param list  receives their numbers, in order
/// @param least  receives the distance of the nearest one to the centre
inline std::uint32_t choose(const CandidatePack* from, std::uint32_t count, const std::uint32_t* vectors,
                            std::uint32_t vectorCount, const float about[3], float half, const Scratch& scratch,
                            std::uint32_t* list, float& least) {
  auto* const found = static_cast<Away<Floats>*>(scratch.found);
  const Floats zero = {};
  const Floats px = zero + about[0], py = zero + about[1], pz = zero + about[2];
  Floats leasts = zero + kHuge;
  Numbers firsts = {};
  for (std::uint32_t i = 0; i < vectorCount; ++i) {
    const std::uint32_t v = vectors ? vectors[i] : i;
    found[i] = awayFrom<Floats>(from[v].triangle, px, py, pz);
    const auto nearer = found[i].squared < leasts;
    leasts = nearer ? found[i].squared : leasts;
    firsts = nearer ? Numbers{} + static_cast<std::int32_t>(v * kWide) : firsts;
  }
  unsigned winner = 0;
  for (unsigned k = 1; k < kWide; ++k)
    if (leasts[k] < leasts[winner]) winner = k;
  least = std::sqrt(leasts[winner]);
  const float* const one = candidate(from, static_cast<std::uint32_t>(firsts[winner]) + winner);
  const Nearest nearest = nearestOf(triangleOf(one), about, half, one[kWide * kSlackAt] + 1e-5F);
  const bool isFar = isFarFrom(nearest.distance, half);
  std::uint32_t kept = 0;
  for (std::uint32_t i = 0; i < vectorCount; ++i) {
    const std::uint32_t v = vectors ? vectors[i] : i;
    kept = append(excessOf(from[v], found[i], half, nearest, isFar), v * kWide, list, kept);
  }
  // Copies that fill the last vector come last.
  while (kept > 0 && list[kept - 1] >= count) --kept;
  return kept;
}

/// Copies the candidates of a list.
inline void take(const CandidatePack* from, const std::uint32_t* list, std::uint32_t count, CandidatePack* to) {
#if defined(__AVX512F__)
  // All candidates of one vector at a time: together they fill the end of a vector and the beginning of the next one.
  std::uint32_t taken = 0;
  for (std::uint32_t i = 0; i < count;) {
    const std::uint32_t vector = list[i] / kWide;
    __mmask16 lanes = 0;
    unsigned more = 0;
    for (; i < count && list[i] / kWide == vector; ++i, ++more) lanes |= static_cast<__mmask16>(1U << list[i] % kWide);
    const unsigned at = taken % kWide;
    const auto* const source = reinterpret_cast<const Floats*>(from + vector);
    auto* const target = reinterpret_cast<Floats*>(to + taken / kWide);
    const auto here = static_cast<__mmask16>(0xffffU << at);
    const bool flows = at + more > kWide;
    const __m512i turn = _mm512_sub_epi32(_mm512_set_epi32(15, 14, 13, 12, 11, 10, 9, 8, 7, 6, 5, 4, 3, 2, 1, 0),
                                          _mm512_set1_epi32(static_cast<int>(at)));
    for (unsigned l = 0; l < kArrays; ++l) {
      const __m512 packed = _mm512_maskz_permutexvar_ps(0xffff, turn, _mm512_maskz_compress_ps(lanes, source[l]));
      target[l] = _mm512_mask_mov_ps(target[l], here, packed);
      if (flows) target[kArrays + l] = packed;
    }
    taken += more;
  }
#else
  for (std::uint32_t i = 0; i < count; ++i) {
    const float* const source = candidate(from, list[i]);
    float* const target = reinterpret_cast<float*>(to + i / kWide) + i % kWide;
    for (unsigned l = 0; l < kArrays; ++l) __builtin_memcpy(target + kWide * l, source + kWide * l, sizeof(float));
  }
#endif
  fill(to, count);
}

/// Finds the nearest of the listed candidates at the nodes of a cube of 2^3; ties go to the smallest number.
inline void decide(const CandidatePack* from, const std::uint32_t* list, std::uint32_t count, const float about[3],
                   std::uint32_t (&numbers)[8]) {
  for (unsigned k = 0; k < 8; k += kNodesWide) {
    const NodeFloats px = corners(0, k, 0.5F, about[0]), py = corners(1, k, 0.5F, about[1]),
                     pz = corners(2, k, 0.5F, about[2]);
    NodeFloats least = {};
    least += kHuge;
    NodeNumbers who = {};
    for (std::uint32_t n = 0; n < count; ++n) {
      const float* const one = candidate(from, list[n]);
      const NodeFloats squared = awayFrom<NodeFloats>(triangleOf(one), px, py, pz).squared;
      const NodeNumbers number = NodeNumbers{} + numberOf(one);
      const auto nearer = (squared < least) | ((squared == least) & (number < who));
      least = nearer ? squared : least;
      who = nearer ? number : who;
    }
    store(who, numbers + k);
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

/// The number of the lane with the least value.
inline unsigned leastLane(Floats values) {
  unsigned least = 0;
  for (unsigned k = 1; k < kWide; ++k)
    if (values[k] < values[least]) least = k;
  return least;
}

/// Many candidates, of which most are far from any single node: triangles much smaller than a voxel, as those of scans.
/// Each node then asks the boxes of packs first, which costs less than to select the triangles of a cube.
class ManyCandidates {
 public:
  /// @param vectors  of @a all
  /// @param squares  memory for a number per box
  ManyCandidates(const CandidatePack* all, std::uint32_t vectors, const PackBoxes* boxes, float boxSlack,
                 float* squares)
      : mAll(all), mBoxes(boxes), mSquares(squares) {
    const Floats zero = {};
    Floats slack = zero;
    for (std::uint32_t i = 0; i < vectors; ++i) slack = greater(slack, all[i].slack);
    mSlack = 2 * boxSlack + 1e-5F;
    float most = 0;
    for (unsigned k = 0; k < kWide; ++k) most = most < slack[k] ? slack[k] : most;
    mSlack += 2 * most;
  }

  struct Found {
    float squared;
    std::int32_t number;
    std::uint32_t candidate;
  };

  /// The candidate nearest to a position; ties go to the smallest number.
  /// @param list  the vectors of boxes in which to look
  Found nearest(const std::uint32_t* list, std::uint32_t count, const float p[3]) const {
    const Floats zero = {};
    Floats leasts = zero + kHuge;
    Numbers firsts = {};
    for (std::uint32_t n = 0; n < count; ++n) {
      const Floats squared = fromBoxes(mBoxes[list[n]], p).squared;
      store(squared, mSquares + n * kWide);
      const auto nearer = squared < leasts;
      leasts = nearer ? squared : leasts;
      firsts = nearer ? Numbers{} + static_cast<std::int32_t>(list[n] * kWide) : firsts;
    }
    const unsigned winner = leastLane(leasts);
    Search search{.p = {zero + p[0], zero + p[1], zero + p[2]}, .leasts = zero + kHuge};
    meet(static_cast<std::uint32_t>(firsts[winner]) + winner, search);
    float reach = reachOf(search.leasts);
    for (std::uint32_t n = 0; n < count; ++n) {
      const Floats squared = load<Floats>(mSquares + n * kWide);
      for (unsigned bits = lanesUpTo0(squared - reach); bits != 0; bits &= bits - 1)
        if (meet(list[n] * kWide + static_cast<unsigned>(__builtin_ctz(bits)), search)) reach = reachOf(search.leasts);
    }
    Found found{search.leasts[0], search.numbers[0], static_cast<std::uint32_t>(search.vectors[0])};
    for (unsigned k = 1; k < kWide; ++k)
      if (search.leasts[k] < found.squared || (search.leasts[k] == found.squared && search.numbers[k] < found.number))
        found = {search.leasts[k], search.numbers[k], static_cast<std::uint32_t>(search.vectors[k]) + k};
    return found;
  }

  /// Of some vectors of boxes, those that may hold the triangle nearest to some point of a cube.
  /// @param near  a candidate near the cube
  std::uint32_t choose(const std::uint32_t* list, std::uint32_t count, const float about[3], float half,
                       std::uint32_t near, std::uint32_t* chosen) const {
    const CornerBounds bounds = cornerBounds(triangleOf(candidate(mAll, near)), about, half, mSlack);
    const Floats zero = {};
    std::uint32_t kept = 0;
    for (std::uint32_t n = 0; n < count; ++n) {
      const FromBoxes to = fromBoxes(mBoxes[list[n]], about);
      chosen[kept] = list[n];
      kept += lanesUpTo0(excess(to.d[0], to.d[1], to.d[2], to.squared, half, zero, bounds)) != 0;
    }
    return kept;
  }

 private:
  struct Search {
    Floats p[3];
    Floats leasts;
    Numbers numbers{}, vectors{};
  };

  /// Meets the candidates of a pack. @return whether one is nearer than those of its lane were
  bool meet(std::uint32_t pack, Search& search) const {
    bool isNearer = false;
    for (unsigned k = 0; k < kPack; k += kWide) {
      const std::uint32_t vector = (pack * kPack + k) / kWide;
      const CandidatePack& some = mAll[vector];
      const Floats squared = awayFrom<Floats>(some.triangle, search.p[0], search.p[1], search.p[2]).squared;
      const auto nearer = (squared < search.leasts) | ((squared == search.leasts) & (some.number < search.numbers));
      isNearer = isNearer || lanesUpTo0(squared - search.leasts) != 0;
      search.leasts = nearer ? squared : search.leasts;
      search.numbers = nearer ? some.number : search.numbers;
      search.vectors = nearer ? Numbers{} + static_cast<std::int32_t>(vector * kWide) : search.vectors;
    }
    return isNearer;
  }

  /// The square of the distance beyond which a box has nothing nearer.
  float reachOf(Floats leasts) const {
    const float reach = std::sqrt(leasts[leastLane(leasts)]) * 1.00001F + mSlack;
    return reach * reach * 1.00001F;
  }

  const CandidatePack* mAll;
  const PackBoxes* mBoxes;
  float* mSquares;
  float mSlack;
};

/// With fewer candidates, selecting again for a smaller cube does not pay off.
constexpr std::uint32_t kFew = 6;

/// With more candidates near a cube of 4^3 nodes, they are ManyCandidates.
constexpr std::uint32_t kMany = 2048;

/// Upper bounds of half the diagonals of cubes of 4^3 and 2^3 nodes.
constexpr float kHalfDiagonal4 = 2.599F, kHalfDiagonal2 = 0.867F;

void resolve(const TreeView& tree, const double middle[3], const std::uint32_t* packs, std::uint32_t count, float far,
             const Scratch& scratch, float distance[kBlockNodes], std::uint32_t triangle[kBlockNodes]) {
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
    const unsigned at4[3] = {i & 4, 2 * (i & 2), 4 * (i & 1)};
    float about4[3], least = 0;
    for (int axis = 0; axis < 3; ++axis) about4[axis] = static_cast<float>(at4[axis]) - 2.0F;
    const float* const one = nearCandidate(all, vectors, about4);
    const CornerBounds bounds =
        cornerBounds(triangleOf(one), about4, 1.5F, one[kWide * kSlackAt] + 2 * tree.boxSlack + 1e-5F);
    std::uint32_t* const list = scratch.list[0];
    std::uint32_t nearPacks = 0;
    const std::uint32_t near = chooseVectors(boxes, boxVectors, about4, 1.5F, bounds,
                                             far * 1.00001F + 2 * tree.boxSlack, scratch.list[1], list, nearPacks);
    if (near == 0) continue;
    if (nearPacks * kPack > kMany) {
      const ManyCandidates many(all, vectors, boxes, tree.boxSlack, static_cast<float*>(scratch.found));
      std::uint32_t boxCount = 0;
      for (std::uint32_t n = 0; n < nearPacks; ++n) {
        const std::uint32_t vector = list[n] / kWide;
        if (boxCount == 0 || list[boxCount - 1] != vector) list[boxCount++] = vector;
      }
      if (std::sqrt(many.nearest(list, boxCount, about4).squared) > far + kHalfDiagonal4) continue;
      for (unsigned j = 0; j < 8; ++j) {
        const unsigned at2[3] = {at4[0] + (j & 4) / 2, at4[1] + (j & 2), at4[2] + 2 * (j & 1)};
        float about2[3];
        for (int axis = 0; axis < 3; ++axis) about2[axis] = static_cast<float>(at2[axis]) - 3.0F;
        const ManyCandidates::Found middle2 = many.nearest(list, boxCount, about2);
        if (std::sqrt(middle2.squared) > far + kHalfDiagonal2) continue;
        const std::uint32_t of2 = many.choose(list, boxCount, about2, 0.5F, middle2.candidate, scratch.list[1]);
        std::uint32_t numbers[8];
        for (unsigned k = 0; k < 8; ++k) {
          float p[3];
          for (int axis = 0; axis < 3; ++axis) p[axis] = about2[axis] + 0.5F * kCorner[axis][k];
          numbers[k] = static_cast<std::uint32_t>(many.nearest(scratch.list[1], of2, p).number);
        }
        finish(tree, middle, about2, numbers, exact, at2[0] * 64 + at2[1] * 8 + at2[2], distance, triangle);
      }
      continue;
    }
    const std::uint32_t of4 = choose(all, total, scratch.list[1], near, about4, 1.5F, scratch, list, least);
    if (least > far + kHalfDiagonal4) continue;
    take(all, list, of4, some);
    for (unsigned j = 0; j < 8; ++j) {
      const unsigned at2[3] = {at4[0] + (j & 4) / 2, at4[1] + (j & 2), at4[2] + 2 * (j & 1)};
      float about2[3];
      for (int axis = 0; axis < 3; ++axis) about2[axis] = static_cast<float>(at2[axis]) - 3.0F;
      std::uint32_t of2 = of4;
      if (of4 > kFew) {
        of2 = choose(some, of4, nullptr, (of4 + kWide - 1) / kWide, about2, 0.5F, scratch, list, least);
        if (least > far + kHalfDiagonal2) continue;
      } else {
        for (std::uint32_t n = 0; n < of4; ++n) list[n] = n;
      }
      std::uint32_t numbers[8];
      decide(some, list, of2, about2, numbers);
      finish(tree, middle, about2, numbers, exact, at2[0] * 64 + at2[1] * 8 + at2[2], distance, triangle);
    }
  }
}

}  // namespace
}  // namespace vdbtools::kernels
