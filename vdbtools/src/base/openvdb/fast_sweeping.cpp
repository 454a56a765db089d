// SPDX-License-Identifier: Apache-2.0
#include "base/openvdb/fast_sweeping.h"

#include <openvdb/tools/FastSweeping.h>

namespace vdbtools {

using openvdb::FloatGrid;

FloatGrid::Ptr extendSdf(const FloatGrid& sdf, const openvdb::MaskGrid& mask, int sweeps) {
  return openvdb::tools::maskSdf(sdf, mask, /*ignoreActiveTiles=*/false, sweeps);
}

FloatGrid::Ptr dilateSdf(const FloatGrid& sdf, int layers, bool anyInside) {
  openvdb::tools::FastSweeping<FloatGrid> sweeping;
  sweeping.initDilate(sdf, layers, openvdb::tools::NN_FACE_EDGE_VERTEX);
  sweeping.sweep(1, anyInside);
  return sweeping.sdfGrid();
}

FloatGrid::Ptr sdfOfField(const FloatGrid& field) { return openvdb::tools::sdfToSdf(field, 0.0f); }

}  // namespace vdbtools
