// SPDX-License-Identifier: Apache-2.0
/// @file study_grain.h
/// `juliavdb study --strokes`. It takes all options of a fractal, as --dimension does.
#pragma once

#include "commands.h"

namespace cli {

int studyGrain(const Arguments& arguments);

}  // namespace cli
