// SPDX-License-Identifier: Apache-2.0
#include "base/openvdb/exterior_trace.h"

#include <openvdb/tools/MeshToVolume.h>

namespace vdbtools {

void traceExterior(openvdb::FloatTree& tree) { openvdb::tools::traceExteriorBoundaries(tree); }

}  // namespace vdbtools
