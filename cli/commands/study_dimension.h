// SPDX-License-Identifier: Apache-2.0
/// @file study_dimension.h
/// `juliavdb study --dimension`: it takes all options of a fractal, while other studies are of random versors alone.
#pragma once

#include "commands.h"

namespace cli {

int studyDimension(const Arguments& arguments);

}  // namespace cli
