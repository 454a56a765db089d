// SPDX-License-Identifier: Apache-2.0
/// @file recorded_memory.h
/// The entry "file_mem_bytes" of a grid in a VDB file, which OpenVDB computes from the sizes of its classes in memory.
/// They differ between builds of 32 and 64 bits, and the bytes of a file must not.
#pragma once

#include <openvdb/Grid.h>

#include <cstdint>

namespace vdbtools {

/// The bytes that a grid takes in memory in a build of 64 bits (OpenVDB 10 to 13), for trees of the usual depth whose
/// values are booleans, numbers or vectors; for any other grid, what this build needs.
std::uint64_t recordedMemoryOf(const openvdb::GridBase& grid);

}  // namespace vdbtools
