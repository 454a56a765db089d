// SPDX-License-Identifier: Apache-2.0
/// @file adaptivity.h
/// The option of the commands that write meshes of lattices.
#pragma once

#include "options.h"

namespace cli {

void addAdaptivity(CommandLine& line);

/// In voxels; 0 if it was not given. @throw std::invalid_argument
double parseAdaptivity(const CommandLine& line);

}  // namespace cli
