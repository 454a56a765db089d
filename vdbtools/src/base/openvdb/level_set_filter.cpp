// SPDX-License-Identifier: Apache-2.0
#include "base/openvdb/level_set_filter.h"

#include <openvdb/tools/LevelSetFilter.h>

namespace vdbtools {

void meanCurvatureFlow(openvdb::FloatGrid& levelSet, int steps, const Monitor& monitor) {
  OpenVdbInterrupter interrupter(monitor);
  openvdb::tools::LevelSetFilter<openvdb::FloatGrid, openvdb::FloatGrid, OpenVdbInterrupter> filter(levelSet,
                                                                                                    &interrupter);
  for (int n = 0; n < steps; ++n) {
    filter.meanCurvature();
    monitor.throwIfCancelled();
  }
}

}  // namespace vdbtools
