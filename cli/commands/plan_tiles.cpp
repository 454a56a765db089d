// SPDX-License-Identifier: Apache-2.0
#include "plan.h"

#include <stdexcept>

namespace cli {

int planTiles(const Arguments&) { throw std::logic_error("plans of tiles are not written yet"); }

}  // namespace cli
