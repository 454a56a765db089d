// SPDX-License-Identifier: Apache-2.0
/// @file united_parts.h
/// The record of the number of a target's parts that intersect each other, which accompanies its distances.
#pragma once

namespace vdbtools {

/// A metadatum of a grid of distances and of its file, and a fact of a job: a positive integer. It is absent if no
/// parts intersect.
inline constexpr const char* kUnitedParts = "julia_united_parts";

}  // namespace vdbtools
