// SPDX-License-Identifier: Apache-2.0
#include "formats/recorded_memory.h"

#include <algorithm>
#include <string_view>
#include <utility>
#include <vector>

namespace vdbtools {
namespace {

/// The size of the values of a grid's tree; 0 for trees of another kind.
std::uint64_t valueSizeOf(std::string_view type) {
  constexpr std::pair<std::string_view, std::uint64_t> kSizes[] = {
      {"Tree_float_5_4_3", 4},  {"Tree_double_5_4_3", 8}, {"Tree_int32_5_4_3", 4},
      {"Tree_int64_5_4_3", 8},  {"Tree_vec3s_5_4_3", 12}, {"Tree_vec3d_5_4_3", 24},
      {"Tree_vec3i_5_4_3", 12}, {"Tree_bool_5_4_3", 1},   {"Tree_mask_5_4_3", 1}};
  const auto found =
      std::find_if(std::begin(kSizes), std::end(kSizes), [&](const auto& one) { return one.first == type; });
  return found == std::end(kSizes) ? 0 : found->second;
}

constexpr std::uint64_t inWords(std::uint64_t bytes) { return (bytes + 7) / 8 * 8; }

/// An internal node of 8^log entries: a value or a pointer each, two masks, and its place.
constexpr std::uint64_t nodeBytes(int log, std::uint64_t value) {
  const std::uint64_t entries = std::uint64_t{1} << (3 * log);
  return entries * inWords(value) + 2 * entries / 8 + 12;
}

/// A leaf: its values, their mask, its place, and what belongs to loading and threads.
std::uint64_t leafBytes(std::string_view type, std::uint64_t value) {
  constexpr std::uint64_t kVoxels = 512, kMask = kVoxels / 8, kRest = 16;
  if (type == "Tree_mask_5_4_3") return kMask + kRest;
  if (type == "Tree_bool_5_4_3") return 2 * kMask + kRest;
  constexpr std::uint64_t kBuffer = 16;
  return kBuffer + kVoxels * value + kMask + kRest;
}

}  // namespace

std::uint64_t recordedMemoryOf(const openvdb::GridBase& grid) {
  const std::string type = grid.type();
  const std::uint64_t value = valueSizeOf(type);
  const std::vector<openvdb::Index32> nodes = grid.constBaseTree().nodeCount();  // leaves first
  if (value == 0 || nodes.size() != 4) return grid.memUsage();
  const std::uint64_t root = 64 + inWords(value), tree = 1160 + root;
  return tree + root + nodes[2] * nodeBytes(5, value) + nodes[1] * nodeBytes(4, value) +
         nodes[0] * leafBytes(type, value);
}

}  // namespace vdbtools
