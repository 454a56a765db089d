// SPDX-License-Identifier: Apache-2.0
/// @file usable_points.h
/// Points whose coordinates are not finite: scanners write them where they measured nothing, and exporters leave some
/// that no face uses.
#pragma once

#include "vdbtools/mesh/mesh.h"

#include <cstdint>
#include <filesystem>

namespace vdbtools {

/// Leaves out the points whose coordinates are not finite, with their attributes, and counts them in
/// Mesh::pointsLeftOut.
/// @param firstNumber  the number that the format gives to the first point, for the message
/// @throw DataError  a triangle uses one of them
void leaveOutUnusable(const std::filesystem::path& path, Mesh& mesh, std::uint64_t firstNumber = 0);

}  // namespace vdbtools
