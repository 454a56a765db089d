// SPDX-License-Identifier: Apache-2.0
#include "julia/instruction_set.h"

#include "kernels/kernel_tables.h"

#include <algorithm>
#include <atomic>
#include <stdexcept>
#include <string>
#include <vector>

namespace julia {
namespace {

std::vector<InstructionSet> detect() {
  std::vector<InstructionSet> sets{InstructionSet::Portable};
#ifdef JULIA_X86_KERNELS
  if (__builtin_cpu_supports("avx2")) sets.push_back(InstructionSet::Avx2);
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512bw") &&
      __builtin_cpu_supports("avx512vl"))
    sets.push_back(InstructionSet::Avx512);
#endif
  return sets;
}

const kernels::Tables& tablesOf(InstructionSet set) {
#ifdef JULIA_X86_KERNELS
  if (set == InstructionSet::Avx512) return kernels::kAvx512;
  if (set == InstructionSet::Avx2) return kernels::kAvx2;
#endif
  (void)set;
  return kernels::kPortable;
}

std::atomic<InstructionSet>& current() {
  static std::atomic<InstructionSet> set = availableInstructionSets().back();
  return set;
}

}  // namespace

std::span<const InstructionSet> availableInstructionSets() {
  static const std::vector<InstructionSet> sets = detect();
  return sets;
}

InstructionSet instructionSet() { return current(); }

void setInstructionSet(InstructionSet set) {
  const auto available = availableInstructionSets();
  if (std::find(available.begin(), available.end(), set) == available.end())
    throw std::invalid_argument("this processor does not have " + std::string(nameOf(set)) + "; use " +
                                std::string(nameOf(available.back())));
  current() = set;
}

std::string_view nameOf(InstructionSet set) {
  switch (set) {
    case InstructionSet::Avx2: return "avx2";
    case InstructionSet::Avx512: return "avx512";
    case InstructionSet::Portable: break;
  }
  return "portable";
}

namespace kernels {

template <>
const Kernels<float>& kernels() {
  return *tablesOf(instructionSet()).floats;
}
template <>
const Kernels<double>& kernels() {
  return *tablesOf(instructionSet()).doubles;
}

}  // namespace kernels
}  // namespace julia
