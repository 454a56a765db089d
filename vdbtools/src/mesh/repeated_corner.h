// SPDX-License-Identifier: Apache-2.0
/// @file repeated_corner.h
/// Triangles that are lines or points by their indices alone.
#pragma once

#include <openvdb/Types.h>

namespace vdbtools {

/// Whether two corners of a triangle are one point.
inline bool repeatsCorner(const openvdb::Vec3I& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; }

}  // namespace vdbtools
