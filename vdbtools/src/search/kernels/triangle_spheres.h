// SPDX-License-Identifier: Apache-2.0
/// @file triangle_spheres.h
/// The candidates of a block whose triangles are much smaller than a voxel: spheres about them, and which of them
/// remain for smaller cubes and for single nodes. Only triangle_bodies.h includes it.
#pragma once

#include "search/kernels/triangle_candidates.h"

namespace vdbtools::kernels {
namespace {

/// Spheres about triangles, relative to a block's centre. The last vector is filled with spheres that are far away.
struct Spheres {
  static constexpr unsigned kArrays = 11;

  float* memory;     ///< kArrays of them
  std::size_t room;  ///< of each
  std::uint32_t count = 0;

  float* centre(unsigned axis) const { return memory + axis * room; }
  float* radius() const { return memory + 3 * room; }  ///< slightly larger, for rounding errors
  /// The vectors from the centre, which is the centroid, to the first two corners.
  float* edge(unsigned corner, unsigned axis) const { return memory + (4 + 3 * corner + axis) * room; }
  std::uint32_t* triangle() const { return reinterpret_cast<std::uint32_t*>(memory + 10 * room); }

  std::uint32_t vectors() const { return (count + kWide - 1) / kWide; }

  void fill() const {
    for (std::uint32_t i = count; i % kWide != 0; ++i) {
      for (unsigned l = 0; l + 1 < kArrays; ++l) memory[l * room + i] = l < 3 ? kFarAway : 0;
      triangle()[i] = triangle()[0];
    }
  }

  /// The vectors from the centres of a vector to a position.
  Away<Floats> away(std::uint32_t at, const float p[3]) const {
    Away<Floats> to;
    to.x = p[0] - load<Floats>(centre(0) + at);
    to.y = p[1] - load<Floats>(centre(1) + at);
    to.z = p[2] - load<Floats>(centre(2) + at);
    to.squared = to.x * to.x + to.y * to.y + to.z * to.z;
    return to;
  }

  /// Appends the spheres of some lanes of a vector.
  void append(unsigned lanes, const Spheres& from, std::uint32_t at) {
#if defined(__AVX512F__)
    for (unsigned l = 0; l < kArrays; ++l) {
      const auto some = load<Floats>(from.memory + l * from.room + at);
      store(_mm512_maskz_compress_ps(static_cast<__mmask16>(lanes), some), memory + l * room + count);
    }
    count += static_cast<std::uint32_t>(__builtin_popcount(lanes));
#else
    for (; lanes != 0; lanes &= lanes - 1, ++count) {
      const float* const one = from.memory + at + static_cast<unsigned>(__builtin_ctz(lanes));
      for (unsigned l = 0; l < kArrays; ++l)
        __builtin_memcpy(memory + l * room + count, one + l * from.room, sizeof(float));
    }
#endif
  }
};

/// A bound of the rounding errors of a test against a sphere of this radius.
template <class V>
inline V roundingOf(V radius) {
  return radius * 0.001F + 3e-5F;
}

/// The nearest of some positions, lane by lane.
struct NearestLanes {
  Floats squared = Floats{} + kHuge;
  Numbers first{};  ///< of the vectors in which they are

  void meet(Floats candidates, std::uint32_t at) {
    const auto nearer = candidates < squared;
    squared = nearer ? candidates : squared;
    first = nearer ? Numbers{} + static_cast<std::int32_t>(at) : first;
  }
  std::uint32_t number(unsigned lane) const { return static_cast<std::uint32_t>(first[lane]) + lane; }
  unsigned lane() const { return leastLane(squared); }
};

/// The candidates where most of them are far from any single node, because the triangles are much smaller than a voxel,
/// as those of scans. Each triangle is enclosed in a sphere about its centroid; tests of the spheres leave out most
/// triangles, and only the others are set up for exact distances.
/// The tests are those of triangle_bodies.h for the centroid m, with an allowance for the distance being less than |w|,
/// where w = p - m, and p is the position. The radius of the sphere is one allowance. A better one is the greatest w v
/// / |w| over the vectors v from m to the corners, because no point of the triangle is nearer to p along w than its
/// foremost corner.
class ManyCandidates {
 public:
  /// @param packs  of the block about @a middle
  ManyCandidates(const TreeView& tree, const double (&middle)[3], const std::uint32_t* packs, std::uint32_t count,
                 const Scratch& scratch)
      : mTree(tree), mMiddle(middle), mPacks(packs), mVectors(scratch.list[0]) {
    auto* memory = static_cast<float*>(scratch.candidates[0]);
    const std::size_t room = (std::size_t{count} + kWide) * kPack;
    static_assert((2 * Spheres::kArrays + 1) * sizeof(float) * kPack <= kCandidateBytes);
    mAll = {memory, room};
    mOfTwo = {memory + Spheres::kArrays * room, room};
    mChosen = reinterpret_cast<std::uint32_t*>(memory + 2 * Spheres::kArrays * room);
    memory = static_cast<float*>(scratch.candidates[1]);
    mOfFour = {memory, room};
    mGroups = {memory + Spheres::kArrays * room, room};
    for (std::uint32_t i = 0; i < count; ++i) prepare(i);
    mAll.count = count * kPack;
    mAll.fill();
    Floats most = {};
    for (std::uint32_t i = 0; i < mAll.count; i += kWide) most = greater(most, load<Floats>(mAll.radius() + i));
    for (unsigned k = 0; k < kWide; ++k) mMostRadius = most[k] > mMostRadius ? most[k] : mMostRadius;
  }

  /// A triangle near a position, of the packs whose boxes are nearest to it.
  Triangle<float> nearBoxes(const PackBoxes* boxes, std::uint32_t vectors, const float about[3]) const {
    NearestLanes packs;
    for (std::uint32_t i = 0; i < vectors; ++i) packs.meet(fromBoxes(boxes[i], about).squared, i * kWide);
    NearestLanes spheres;
    for (unsigned lane = 0; lane < kWide; ++lane)
      if (packs.squared[lane] < kHuge)
        for (unsigned k = 0; k < kPack; k += kWide) {
          const std::uint32_t at = (packs.number(lane) * kPack + k) / kWide * kWide;
          spheres.meet(mAll.away(at, about).squared, at);
        }
    return triangle(mAll.triangle()[spheres.number(spheres.lane())]);
  }

  /// Chooses those whose triangles may be nearest in a cube of 4^3 nodes about @a about.
  /// @param vectors  which to examine
  /// @return false if all of them are farther than @a far from the nodes
  bool chooseOfFour(const std::uint32_t* vectors, std::uint32_t vectorCount, const float about[3], float far) {
    NearestLanes centres;
    for (std::uint32_t i = 0; i < vectorCount; ++i)
      centres.meet(mAll.away(vectors[i] * kWide, about).squared, vectors[i] * kWide);
    const unsigned lane = centres.lane();
    if (std::sqrt(centres.squared[lane]) * 0.99999F - mMostRadius > far + kHalfDiagonal4) return false;
    choose(mAll, vectors, vectorCount, mAll.triangle()[centres.number(lane)], about, 1.5F, mOfFour);
    mGroups.count = mOfFour.vectors();
    for (std::uint32_t i = 0; i < mGroups.count; ++i) makeGroup(i);
    mGroups.fill();
    return true;
  }

  /// The same for one of its cubes of 2^3 nodes.
  bool chooseOfTwo(const float about[3], float far) {
    NearestLanes nearGroups;
    Floats lowest = Floats{} + kHuge;
    for (std::uint32_t at = 0; at < mGroups.count; at += kWide) {
      const Floats squared = mGroups.away(at, about).squared;
      nearGroups.meet(squared, at);
      lowest = lesser(lowest, squareRoot(squared) * 0.99999F - load<Floats>(mGroups.radius() + at));
    }
    if (lowest[leastLane(lowest)] > far + kHalfDiagonal2) return false;
    NearestLanes centres;
    for (unsigned lane = 0; lane < kWide; ++lane)
      if (nearGroups.squared[lane] < kHuge) {
        const std::uint32_t at = nearGroups.number(lane) * kWide;
        centres.meet(mOfFour.away(at, about).squared, at);
      }
    const std::uint32_t near = mOfFour.triangle()[centres.number(centres.lane())];
    const Triangle<float> t = triangle(near);
    const CornerBounds bounds = cornerBounds(t, about, 0.5F, slackOf(t) + 1e-5F);
    std::uint32_t chosen = 0;
    for (std::uint32_t at = 0; at < mGroups.count; at += kWide) {
      const Away<Floats> to = mGroups.away(at, about);
      chosen = append(excess(to.x, to.y, to.z, to.squared, 0.5F, load<Floats>(mGroups.radius() + at), bounds), at,
                      mVectors, chosen);
    }
    choose(mOfFour, mVectors, chosen, near, about, 0.5F, mOfTwo);
    return true;
  }

  /// Finds the nearest of those triangles at the nodes of the cube of 2^3; ties go to the smallest number.
  void decide(const float about[3], std::uint32_t (&numbers)[8]) {
    const Spheres& from = mOfTwo;
    for (unsigned k = 0; k < 8; k += kNodesWide) {
      NodeSearch search{corners(0, k, 0.5F, about[0]), corners(1, k, 0.5F, about[1]), corners(2, k, 0.5F, about[2])};
      // First the triangles whose centres are nearest to the nodes.
      NodeFloats leasts = search.squared;
      NodeNumbers nearest = {};
      for (std::uint32_t n = 0; n < from.count; ++n) {
        const NodeFloats squared = search.away(from, n).squared;
        const auto nearer = squared < leasts;
        leasts = nearer ? squared : leasts;
        nearest = nearer ? NodeNumbers{} + static_cast<std::int32_t>(n) : nearest;
      }
      for (unsigned lane = 0; lane < kNodesWide; ++lane) mChosen[lane] = from.triangle()[nearest[lane]];
      meet(kNodesWide, search);
      const NodeFloats reach = squareRoot(search.squared) * 1.00001F + 1e-5F;
      std::uint32_t chosen = 0;
      for (std::uint32_t n = 0; n < from.count; ++n) {
        const Away<NodeFloats> to = search.away(from, n);
        const NodeFloats most = reach + from.radius()[n];
        if (!anyUpTo0(to.squared - most * most)) continue;
        const auto along = [&](unsigned e) {
          return to.x * from.edge(e, 0)[n] + to.y * from.edge(e, 1)[n] + to.z * from.edge(e, 2)[n];
        };
        const NodeFloats first = along(0), second = along(1);
        const NodeFloats beyond = to.squared - greater(greater(first, second), -(first + second));
        const NodeFloats tight = reach + roundingOf(from.radius()[n]);
        mChosen[chosen] = from.triangle()[n];
        chosen += anyUpTo0(beyond - tight * squareRoot(to.squared));
      }
      for (std::uint32_t n = chosen; n % kNodesWide != 0; ++n) mChosen[n] = mChosen[chosen - 1];
      meet(chosen, search);
      store(search.number, numbers + k);
    }
  }

 private:
  /// The nodes of a cube as lanes, and the nearest triangles so far.
  struct NodeSearch {
    NodeFloats x, y, z;
    NodeFloats squared = NodeFloats{} + kHuge;
    NodeNumbers number{};

    Away<NodeFloats> away(const Spheres& spheres, std::uint32_t n) const {
      Away<NodeFloats> to{x - spheres.centre(0)[n], y - spheres.centre(1)[n], z - spheres.centre(2)[n], {}};
      to.squared = to.x * to.x + to.y * to.y + to.z * to.z;
      return to;
    }
  };

  /// A triangle relative to the block's centre.
  Triangle<float> triangle(std::uint32_t number) const {
    std::uint32_t numbers[kNodesWide];
    for (unsigned k = 0; k < kNodesWide; ++k) numbers[k] = number;
    return laneOf(trianglesAt(mTree, numbers, mMiddle), 0);
  }

  /// @param near  a triangle near the cube's centre
  void choose(const Spheres& from, const std::uint32_t* vectors, std::uint32_t vectorCount, std::uint32_t near,
              const float about[3], float half, Spheres& to) const {
    const Triangle<float> t = triangle(near);
    const Nearest nearest = nearestOf(t, about, half, slackOf(t) + 1e-5F);
    const bool isFar = isFarFrom(nearest.distance, half);
    to.count = 0;
    for (std::uint32_t i = 0; i < vectorCount; ++i) {
      const std::uint32_t at = vectors[i] * kWide;
      const Away<Floats> away = from.away(at, about);
      const auto lanesWithin = [&](Floats slack) {
        return lanesUpTo0(isFar ? farExcess(away.x, away.y, away.z, away.squared, half, slack, nearest)
                                : excess(away.x, away.y, away.z, away.squared, half, slack, nearest.bounds));
      };
      const Floats radius = load<Floats>(from.radius() + at);
      unsigned lanes = lanesWithin(radius);
      if (lanes == 0) continue;
      const auto along = [&](unsigned e) {
        return away.x * load<Floats>(from.edge(e, 0) + at) + away.y * load<Floats>(from.edge(e, 1) + at) +
               away.z * load<Floats>(from.edge(e, 2) + at);
      };
      const Floats first = along(0), second = along(1);
      lanes &= lanesWithin(greater(greater(first, second), -(first + second)) / (squareRoot(away.squared) + 1e-20F) +
                           roundingOf(radius));
      if (lanes != 0) to.append(lanes, from, at);
    }
    to.fill();
  }

  /// Makes the sphere about the spheres of a vector.
  void makeGroup(std::uint32_t vector) {
    const std::uint32_t first = vector * kWide, count = mOfFour.count - first < kWide ? mOfFour.count - first : kWide;
    float middle[3];
    for (unsigned axis = 0; axis < 3; ++axis) {
      const float* const centres = mOfFour.centre(axis) + first;
      float low = centres[0], high = centres[0];
      for (std::uint32_t k = 1; k < count; ++k) {
        low = low < centres[k] ? low : centres[k];
        high = high > centres[k] ? high : centres[k];
      }
      mGroups.centre(axis)[vector] = middle[axis] = 0.5F * (low + high);
    }
    const Floats reach =
        squareRoot(mOfFour.away(first, middle).squared) * 1.00001F + load<Floats>(mOfFour.radius() + first);
    float most = 0;
    for (std::uint32_t k = 0; k < count; ++k) most = reach[k] > most ? reach[k] : most;
    mGroups.radius()[vector] = most + 1e-5F;
    mGroups.triangle()[vector] = mOfFour.triangle()[first];
  }

  /// Meets the first of the chosen triangles, whose number is a multiple of the vector's width.
  void meet(std::uint32_t count, NodeSearch& search) const {
    for (std::uint32_t first = 0; first < count; first += kNodesWide) {
      const Triangle<NodeFloats> triangles = trianglesAt(mTree, mChosen + first, mMiddle);
      for (unsigned lane = 0; lane < kNodesWide; ++lane) {
        const auto squared = awayFrom<NodeFloats>(laneOf(triangles, lane), search.x, search.y, search.z).squared;
        const NodeNumbers number = NodeNumbers{} + static_cast<std::int32_t>(mChosen[first + lane]);
        const auto nearer = (squared < search.squared) | ((squared == search.squared) & (number < search.number));
        search.squared = nearer ? squared : search.squared;
        search.number = nearer ? number : search.number;
      }
    }
  }

  /// Makes the spheres of a pack.
  void prepare(std::uint32_t i) {
    const Spheres& to = mAll;
    const std::uint32_t* const numbers = mTree.numbers[mPacks[i]].triangle;
    __builtin_memcpy(to.triangle() + i * kPack, numbers, kPack * sizeof(*numbers));
    for (unsigned first = 0; first < kPack; first += kNodesWide) {
      const std::uint32_t at = i * kPack + first;
      NodeFloats corner[3][3];
      float shift[3] = {0, 0, 0};
      if (mTree.packs) {
        const TrianglePack& pack = mTree.packs[mPacks[i]];
        for (unsigned axis = 0; axis < 3; ++axis) {
          shift[axis] = static_cast<float>(pack.origin[axis] - mMiddle[axis]);
          for (unsigned c = 0; c < 3; ++c) corner[c][axis] = load<NodeFloats>(pack.corner[c][axis] + first);
        }
      } else {
        float points[3][3][kNodesWide];
        for (unsigned k = 0; k < kNodesWide; ++k)
          for (unsigned c = 0; c < 3; ++c) {
            const double* const point =
                mTree.points + 3 * std::size_t{mTree.triangles[3 * std::size_t{numbers[first + k]} + c]};
            for (unsigned axis = 0; axis < 3; ++axis)
              points[c][axis][k] = static_cast<float>(point[axis] - mMiddle[axis]);
          }
        __builtin_memcpy(corner, points, sizeof(corner));
      }
      NodeFloats squared[3] = {};
      for (unsigned axis = 0; axis < 3; ++axis) {
        const NodeFloats centre = (corner[0][axis] + corner[1][axis] + corner[2][axis]) * (1 / 3.0F);
        store(centre + shift[axis], to.centre(axis) + at);
        for (unsigned c = 0; c < 3; ++c) {
          const NodeFloats edge = corner[c][axis] - centre;
          if (c < 2) store(edge, to.edge(c, axis) + at);
          squared[c] += edge * edge;
        }
      }
      const NodeFloats radius = squareRoot(greater(greater(squared[0], squared[1]), squared[2]));
      store(radius + roundingOf(radius), to.radius() + at);
    }
  }

  static bool anyUpTo0(NodeFloats over) {
#if defined(__AVX__)
    return _mm256_movemask_ps(_mm256_cmp_ps(over, _mm256_setzero_ps(), _CMP_LE_OQ)) != 0;
#elif defined(__SSE2__)
    return _mm_movemask_ps(_mm_cmple_ps(over, _mm_setzero_ps())) != 0;
#else
    bool any = false;
    for (unsigned k = 0; k < kNodesWide; ++k) any |= over[k] <= 0.0F;
    return any;
#endif
  }

  const TreeView& mTree;
  const double (&mMiddle)[3];
  const std::uint32_t* mPacks;
  std::uint32_t* mVectors;
  Spheres mAll, mOfFour, mOfTwo;
  Spheres mGroups;  ///< about the vectors of mOfFour, without edges
  std::uint32_t* mChosen;
  float mMostRadius = 0;
};

}  // namespace
}  // namespace vdbtools::kernels
