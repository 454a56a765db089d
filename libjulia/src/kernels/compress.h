// SPDX-License-Identifier: Apache-2.0
/// @file compress.h
/// Moves the kept entries of a vector together, where the instruction set has a fast way to do so. See kernel_bodies.h
/// for the restrictions on this code.
#pragma once

#include "elementary.h"

#include <cstddef>
#include <cstdint>

#if defined(__AVX2__)
#include <immintrin.h>
#endif

namespace julia::kernels {
namespace {

#if defined(__AVX512F__)

/// The number of entries that one compress() takes.
constexpr std::size_t kCompressed = 16;
using KeptMask = __mmask16;

/// The mask of the entries whose byte is 1; the others are 0.
JULIA_INLINE KeptMask keptMask(const std::uint8_t* isKept) {
  const __m128i flags = _mm_load_si128(reinterpret_cast<const __m128i*>(isKept));
  return _mm_test_epi8_mask(flags, flags);
}

/// Writes the kept entries to @a to. What follows them up to a whole vector is overwritten. @a from is read first.
JULIA_INLINE void compress(float* to, KeptMask kept, const float* from) {
  _mm512_storeu_ps(to, _mm512_maskz_compress_ps(kept, _mm512_loadu_ps(from)));
}
JULIA_INLINE void compress(double* to, KeptMask kept, const double* from) {
  const auto low = static_cast<__mmask8>(kept), high = static_cast<__mmask8>(kept >> 8);
  const __m512d second = _mm512_loadu_pd(from + 8);
  _mm512_storeu_pd(to, _mm512_maskz_compress_pd(low, _mm512_loadu_pd(from)));
  _mm512_storeu_pd(to + __builtin_popcount(low), _mm512_maskz_compress_pd(high, second));
}
JULIA_INLINE void compress(std::uint32_t* to, KeptMask kept, const std::uint32_t* from) {
  _mm512_storeu_si512(to, _mm512_maskz_compress_epi32(kept, _mm512_loadu_si512(from)));
}

#elif defined(__AVX2__)

constexpr std::size_t kCompressed = 8;
using KeptMask = std::uint32_t;

/// For each mask of eight entries, the numbers of the kept ones, in order; the rest is 0.
struct KeptEntries {
  std::uint8_t of[256][8];
};
constexpr KeptEntries kKeptEntries = [] {
  KeptEntries table{};
  for (unsigned mask = 0; mask < 256; ++mask)
    for (unsigned entry = 0, count = 0; entry < 8; ++entry)
      if (mask >> entry & 1) table.of[mask][count++] = static_cast<std::uint8_t>(entry);
  return table;
}();

JULIA_INLINE KeptMask keptMask(const std::uint8_t* isKept) {
  const __m128i flags = _mm_loadl_epi64(reinterpret_cast<const __m128i*>(isKept));
  return static_cast<KeptMask>(_mm_movemask_epi8(_mm_cmpgt_epi8(flags, _mm_setzero_si128())));
}

JULIA_INLINE __m256i keptEntries(KeptMask kept) {
  return _mm256_cvtepu8_epi32(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(kKeptEntries.of[kept])));
}

JULIA_INLINE void compress(float* to, KeptMask kept, const float* from) {
  _mm256_storeu_ps(to, _mm256_permutevar8x32_ps(_mm256_loadu_ps(from), keptEntries(kept)));
}
JULIA_INLINE void compress(double* to, KeptMask kept, const double* from) {
  // An entry is two numbers of 32 bits.
  const KeptMask low = kept & 15, high = kept >> 4;
  const auto permuted = [](__m256d entries, KeptMask mask) __attribute__((always_inline)) {
    const __m256i first = _mm256_slli_epi64(_mm256_cvtepu32_epi64(_mm256_castsi256_si128(keptEntries(mask))), 1);
    const __m256i both = _mm256_or_si256(first, _mm256_slli_epi64(_mm256_add_epi64(first, _mm256_set1_epi64x(1)), 32));
    return _mm256_castps_pd(_mm256_permutevar8x32_ps(_mm256_castpd_ps(entries), both));
  };
  const __m256d second = _mm256_loadu_pd(from + 4);
  _mm256_storeu_pd(to, permuted(_mm256_loadu_pd(from), low));
  _mm256_storeu_pd(to + __builtin_popcount(low), permuted(second, high));
}
JULIA_INLINE void compress(std::uint32_t* to, KeptMask kept, const std::uint32_t* from) {
  const __m256i entries = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(from));
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(to), _mm256_permutevar8x32_epi32(entries, keptEntries(kept)));
}

#endif

}  // namespace
}  // namespace julia::kernels
