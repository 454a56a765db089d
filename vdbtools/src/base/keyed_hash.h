// SPDX-License-Identifier: Apache-2.0
/// @file keyed_hash.h
/// A hash of integers that come from a file. Its key is random, so that nobody can construct a file whose numbers
/// collide in a hash table and make every search linear. No result may depend on the order of such a table.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <random>

namespace vdbtools {

/// Multilinear hashing of the halves of @a Count numbers of 64 bits, modulo 2^64, of which the upper 32 bits are kept.
/// For any two different inputs and a random key, every pair of results is equally likely.
template <std::size_t Count>
class KeyedHash {
 public:
  KeyedHash() {
    std::random_device random;
    for (std::uint64_t& key : mKeys) key = std::uint64_t{random()} << 32 | random();
  }

  template <class Integer>
  std::size_t operator()(const std::array<Integer, Count>& numbers) const {
    static_assert(sizeof(Integer) == sizeof(std::uint64_t));
    std::uint64_t sum = mKeys[2 * Count];
    for (std::size_t i = 0; i < Count; ++i) {
      const auto bits = static_cast<std::uint64_t>(numbers[i]);
      sum += mKeys[2 * i] * (bits & 0xFFFFFFFFU) + mKeys[2 * i + 1] * (bits >> 32);
    }
    return sum >> 32;
  }

 private:
  std::array<std::uint64_t, 2 * Count + 1> mKeys;
};

}  // namespace vdbtools
