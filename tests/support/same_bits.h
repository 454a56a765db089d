// SPDX-License-Identifier: Apache-2.0
/// @file same_bits.h
/// The law of all kernels: each instruction set gives the same bits.
#pragma once

#include "julia/instruction_set.h"

#include <gtest/gtest.h>

#include <bit>
#include <cstdint>
#include <functional>
#include <type_traits>
#include <vector>

namespace law_tests {

/// Puts back the instruction set that was in use.
class KeepInstructionSet {
 public:
  KeepInstructionSet() : mSet(julia::instructionSet()) {}
  ~KeepInstructionSet() { julia::setInstructionSet(mSet); }

 private:
  julia::InstructionSet mSet;
};

template <class Real>
using Bits = std::conditional_t<sizeof(Real) == 4, std::uint32_t, std::uint64_t>;

template <class Real>
std::vector<Bits<Real>> bitsOf(const std::vector<Real>& values) {
  std::vector<Bits<Real>> bits;
  for (const Real value : values) bits.push_back(std::bit_cast<Bits<Real>>(value));
  return bits;
}

/// What @a work gives is the same to the bit for each instruction set that this processor has.
template <class Real>
void expectSameBits(const std::function<std::vector<Real>()>& work) {
  const KeepInstructionSet keep;
  julia::setInstructionSet(julia::InstructionSet::Portable);
  const auto expected = bitsOf<Real>(work());
  for (const julia::InstructionSet set : julia::availableInstructionSets()) {
    julia::setInstructionSet(set);
    EXPECT_EQ(bitsOf<Real>(work()), expected) << julia::nameOf(set);
  }
}

}  // namespace law_tests
