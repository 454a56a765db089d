// SPDX-License-Identifier: Apache-2.0
/// @file elementary.h
/// A shorter name for libjulia's elementary functions: elementary::log(x).
#pragma once

#include "julia/elementary.h"

namespace vdbtools {

namespace elementary = julia::elementary;

}  // namespace vdbtools
