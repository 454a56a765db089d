// SPDX-License-Identifier: Apache-2.0
/// @file glb_format.h
/// The numbers of glTF and of GLB, the binary form of glTF 2.0 (Khronos Group, 2017 to 2021), little-endian.
#pragma once

#include <cstddef>
#include <cstdint>

namespace vdbtools::glb {

inline constexpr std::uint32_t kMagic = 0x46546C67;  ///< "glTF"
inline constexpr std::uint32_t kVersion = 2;
inline constexpr std::uint32_t kJsonChunk = 0x4E4F534A, kBinaryChunk = 0x004E4942;
inline constexpr std::size_t kFileHead = 12, kChunkHead = 8;  ///< bytes

/// The types of the components of accessors, in the JSON of every glTF.
inline constexpr int kByte = 5120, kUnsignedByte = 5121, kShort = 5122, kUnsignedShort = 5123, kUnsignedInt = 5125,
                     kFloat = 5126;

}  // namespace vdbtools::glb
