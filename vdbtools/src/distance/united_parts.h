// SPDX-License-Identifier: Apache-2.0
/// @file united_parts.h
/// How the number of a target's parts that run into each other travels with its distances.
#pragma once

namespace vdbtools {

/// Metadata of a grid of distances, of its file, and a fact of a job: a whole number above 0. There is none if no parts
/// do.
inline constexpr const char* kUnitedParts = "julia_united_parts";

}  // namespace vdbtools
