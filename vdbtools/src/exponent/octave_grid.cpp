// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/exponent/local_thickness.h"

#include "base/elementary.h"
#include "vdbtools/base/text.h"

#include <cmath>
#include <stdexcept>
#include <vector>

namespace vdbtools {

using openvdb::FloatGrid;
using openvdb::Vec3d;

OctaveGrid octaveGrid(const LocalThickness& thickness, const Control& frequency, const FractalSpace& space) {
  OctaveGrid result{thickness.tau->deepCopy(), space};
  result.grid->setGridClass(openvdb::GRID_UNKNOWN);
  std::vector<Vec3d> points;
  std::vector<double> values;
  for (auto leaf = result.grid->tree().beginLeaf(); leaf; ++leaf) {
    points.clear();
    for (auto node = leaf->cbeginValueOn(); node; ++node)
      points.push_back(result.grid->indexToWorld(node.getCoord().asVec3d()));
    values.resize(points.size());
    frequency.sample(points, values);
    std::size_t i = 0;
    for (auto node = leaf->beginValueOn(); node; ++node, ++i) {
      if (!(values[i] > 0 && std::isfinite(values[i])))
        throw std::invalid_argument("--frequency is " + shortText(values[i]) +
                                    " at a place of the target; it must be above 0 everywhere");
      const double tau = static_cast<double>(node.getValue()) / space.scale;
      node.setValue(static_cast<float>(elementary::log2(values[i] / (2 * tau))));
    }
  }
  return result;
}

}  // namespace vdbtools
