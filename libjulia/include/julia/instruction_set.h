// SPDX-License-Identifier: Apache-2.0
/// @file instruction_set.h
/// Which vector units the kernels use. The choice changes no bit of any result; it is there for tests and measurements.
#pragma once

#include <span>
#include <string_view>

namespace julia {

enum class InstructionSet { Portable, Avx2, Avx512 };

/// Those that this processor can run, the slowest first.
std::span<const InstructionSet> availableInstructionSets();

/// The one in use: the last of those available, unless another was set.
InstructionSet instructionSet();

/// For evaluations that begin after this. @throw std::invalid_argument if the processor lacks it
void setInstructionSet(InstructionSet set);

/// "portable", "avx2", "avx512".
std::string_view nameOf(InstructionSet set);

}  // namespace julia
