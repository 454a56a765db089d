// SPDX-License-Identifier: Apache-2.0
/// @file random_numbers.h
/// Random numbers that are the same with every standard library, because the standard specifies the engine but not the
/// distributions.
#pragma once

#include <cstdint>
#include <random>

namespace julia {

class Random {
 public:
  explicit Random(std::uint64_t seed) : mEngine(seed) {}

  /// In [0, 1), 53 bits.
  double unit() { return static_cast<double>(mEngine() >> 11) * 0x1p-53; }
  double between(double low, double high) { return low + (high - low) * unit(); }
  /// Irwin-Hall distribution: the sum of twelve uniforms has mean 6 and variance 1, and needs no elementary function.
  double normal() {
    double sum = -6;
    for (int i = 0; i < 12; ++i) sum += unit();
    return sum;
  }

 private:
  std::mt19937_64 mEngine;
};

}  // namespace julia
