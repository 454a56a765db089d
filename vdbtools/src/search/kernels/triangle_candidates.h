// SPDX-License-Identifier: Apache-2.0
/// @file triangle_candidates.h
/// The triangles that may be nearest at the nodes of a block: their packs and boxes about its centre, and which of them
/// remain for smaller cubes and for single nodes. Only triangle_bodies.h and triangle_spheres.h include it.
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

}  // namespace
}  // namespace vdbtools::kernels
