// SPDX-License-Identifier: Apache-2.0
/// @file chosen_instruction_set.h
/// A benchmark's instruction set, as one of its arguments.
#pragma once

#include "julia/instruction_set.h"

#include <benchmark/benchmark.h>

#include <cstddef>
#include <cstdint>
#include <string>

namespace bench {

/// Kernels run with the instruction set of that index while this lives. Skips the benchmark, and is false, where the
/// processor lacks it.
class ChosenInstructionSet {
 public:
  ChosenInstructionSet(benchmark::State& state, std::int64_t index) {
    const auto available = julia::availableInstructionSets();
    const auto set = static_cast<std::size_t>(index);
    mIsThere = set < available.size();
    if (!mIsThere) {
      state.SkipWithError("this processor lacks it");
      return;
    }
    julia::setInstructionSet(available[set]);
    state.SetLabel(std::string(julia::nameOf(available[set])));
  }
  ~ChosenInstructionSet() { julia::setInstructionSet(mBefore); }
  ChosenInstructionSet(const ChosenInstructionSet&) = delete;
  ChosenInstructionSet& operator=(const ChosenInstructionSet&) = delete;

  explicit operator bool() const { return mIsThere; }

 private:
  julia::InstructionSet mBefore = julia::instructionSet();
  bool mIsThere = false;
};

}  // namespace bench
