// SPDX-License-Identifier: Apache-2.0
/// @file instruction_set.h
/// The vector units that the kernels use. The choice changes no bit of any result; it serves tests and measurements.
#pragma once

#include <span>
#include <string_view>

namespace julia {

enum class InstructionSet { Portable, Avx2, Avx512 };

/// The instruction sets that this processor supports, the slowest first.
std::span<const InstructionSet> availableInstructionSets();

/// The instruction set in use: the last of those available, unless another was set.
InstructionSet instructionSet();

/// Selects the instruction set for evaluations that begin afterwards.
/// @throw std::invalid_argument if the processor does not support it
void setInstructionSet(InstructionSet set);

/// "portable", "avx2" or "avx512".
std::string_view nameOf(InstructionSet set);

}  // namespace julia
