// SPDX-License-Identifier: Apache-2.0
#include "field/island_choice.h"

#include "distance/mesh_conversion.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/base/text.h"

#include <cstddef>
#include <string>

namespace vdbtools {
namespace {

/// In voxels.
int sizeOf(const Island& island) {
  const openvdb::Coord sides = island.box.dim();
  return std::max({sides[0], sides[1], sides[2]});
}

void dropSmall(std::vector<Island*>& islands, double minSize, double voxelSize) {
  // An island of exactly that size is kept, although the product of two decimal fractions may be rounded down.
  constexpr double kRounding = 1e-9;
  const double least = minSize / voxelSize * (1 - kRounding);
  int largest = 0;
  for (Island* island : islands) {
    largest = std::max(largest, sizeOf(*island));
    island->isKept = sizeOf(*island) >= least;
  }
  if (largest < least)
    throw DataError("no island is left: the largest of " + std::to_string(islands.size()) + " is " +
                        shortText(largest * voxelSize) + " across, and the smallest that was to be kept is " +
                        shortText(minSize) + "; keep smaller ones",
                    Remedy::SmallerIslands);
  std::erase_if(islands, [](const Island* island) { return !island->isKept; });
}

void keepLargest(std::vector<Island*>& islands, std::uint64_t count) {
  if (count >= islands.size()) return;
  const auto end = islands.begin() + static_cast<std::ptrdiff_t>(count);
  std::nth_element(islands.begin(), end, islands.end(), [](const Island* a, const Island* b) {
    return a->nodes != b->nodes ? a->nodes > b->nodes : a->first < b->first;
  });
  std::for_each(end, islands.end(), [](Island* island) { island->isKept = false; });
  islands.erase(end, islands.end());
}

}  // namespace

IslandReport chooseIslands(const std::vector<Island*>& islands, const IslandOptions& options, double voxelSize) {
  IslandReport report{.islands = islands.size()};
  if (islands.empty()) return report;
  std::vector<Island*> kept = islands;
  dropSmall(kept, options.minSize, voxelSize);
  if (options.largest) keepLargest(kept, options.largest);
  report.keptIslands = kept.size();
  for (const Island* island : islands)
    if (!island->isKept) report.droppedNodes += island->nodes;
  return report;
}

}  // namespace vdbtools
