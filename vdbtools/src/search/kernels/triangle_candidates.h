// SPDX-License-Identifier: Apache-2.0
/// @file triangle_candidates.h
/// The triangles that may be nearest at the nodes of a block: their packs and boxes about its centre, and which of them
/// remain for smaller cubes and for single nodes. Only triangle_bodies.h includes it.
#pragma once

#include "search/kernels/triangle_bounds.h"

namespace vdbtools::kernels {
namespace {

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

/// The number of the lane with the least value.
inline unsigned leastLane(Floats values) {
  unsigned least = 0;
  for (unsigned k = 1; k < kWide; ++k)
    if (values[k] < values[least]) least = k;
  return least;
}

/// Finds the vectors of candidates that may hold the triangle nearest to some point of the cube about @a about, at most
/// @a far from it.
/// @param packs  receives the packs that may hold that triangle, @a chosen in number
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
    const unsigned winner = leastLane(leasts);
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
  const unsigned winner = leastLane(leasts);
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

/// Upper bounds of half the diagonals of cubes of 4^3 and 2^3 nodes.
constexpr float kHalfDiagonal4 = 2.599F, kHalfDiagonal2 = 0.867F;

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
