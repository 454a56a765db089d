// SPDX-License-Identifier: Apache-2.0
/// @file counter_random.h
/// Random numbers that are a function of a seed and a counter, so they do not depend on the order of threads: the
/// output function of SplitMix64 (Steele, Lea and Flood, OOPSLA 2014).
#pragma once

#include <cstdint>

namespace vdbtools {

constexpr std::uint64_t mixedBits(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15U;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9U;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebU;
  return x ^ (x >> 31);
}

/// @param stream  distinguishes uses of the same counter
constexpr std::uint64_t randomBits(std::uint64_t seed, std::uint64_t stream, std::uint64_t counter) {
  return mixedBits(mixedBits(mixedBits(seed) + stream) + counter);
}

/// From 0 to below 1, in steps of 2^-53.
constexpr double randomUnit(std::uint64_t seed, std::uint64_t stream, std::uint64_t counter) {
  return static_cast<double>(randomBits(seed, stream, counter) >> 11) * 0x1p-53;
}

}  // namespace vdbtools
