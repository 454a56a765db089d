// SPDX-License-Identifier: Apache-2.0
/// @file draco_decoder.h
/// Geometry that Draco has compressed, as glTF has it (KHR_draco_mesh_compression).
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace vdbtools {

/// An attribute that is wanted of each point.
struct DracoAttribute {
  std::uint32_t id = 0;  ///< Draco's own
  int components = 0;
  bool isWhole = false;  ///< unsigned integers of 32 bits; otherwise floats
};

struct DracoShape {
  std::string problem{};  ///< why it cannot be decoded, for a message; then the rest is empty
  std::uint64_t points = 0;
  std::vector<std::uint32_t> corners{};   ///< three for each triangle
  std::vector<std::string> attributes{};  ///< the bytes of each wanted one, point by point
};

/// Whether this build can decode it, which requires libdraco.
bool canDecodeDraco();

/// @param room  bytes that the result may have; what it takes is subtracted
/// @throw MemoryError  it does not fit
DracoShape decodeDraco(std::string_view bytes, std::span<const DracoAttribute> attributes, std::uint64_t& room);

}  // namespace vdbtools
