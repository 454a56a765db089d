// SPDX-License-Identifier: Apache-2.0
/// @file elementary.h
/// libjulia's elementary functions, under a shorter name: elementary::log(x).
#pragma once

#include "julia/elementary.h"

namespace vdbtools {

namespace elementary = julia::elementary;

}  // namespace vdbtools
