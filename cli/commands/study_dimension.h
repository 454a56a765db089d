// SPDX-License-Identifier: Apache-2.0
/// @file study_dimension.h
/// `juliavdb study --dimension`. It takes all options of a fractal, whereas other studies use random versors only.
#pragma once

#include "commands.h"

namespace cli {

int studyDimension(const Arguments& arguments);

}  // namespace cli
