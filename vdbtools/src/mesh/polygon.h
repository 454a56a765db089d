// SPDX-License-Identifier: Apache-2.0
/// @file polygon.h
/// Splitting the polygons of a mesh file into triangles.
#pragma once

#include <openvdb/Types.h>

#include <cstdint>
#include <span>
#include <vector>

namespace vdbtools {

/// Appends the triangles of one polygon to @a triangles: corners.size() - 2 of them, with the polygon's orientation. A
/// convex polygon becomes a fan about its first corner. A concave one is clipped ear by ear in the plane of its mean
/// normal; one that has no ear there (it crosses itself, or is very large) becomes a fan all the same.
/// @param corners  indices into @a points, three or more
void triangulatePolygon(std::span<const std::uint32_t> corners, const std::vector<openvdb::Vec3d>& points,
                        std::vector<openvdb::Vec3I>& triangles);

}  // namespace vdbtools
