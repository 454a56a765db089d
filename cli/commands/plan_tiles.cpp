// SPDX-License-Identifier: Apache-2.0
#include "plan.h"

#include "exit_code.h"
#include "options.h"

#include "vdbtools/job/fractal_options.h"

#include <stdexcept>

namespace cli {

int planTiles(const Arguments& arguments) {
  CommandLine line({"plan tiles", "", "Plans tiles of a fractal.", ""}, vdbtools::fractalOptionTable());
  if (!line.parse(arguments)) return kDone;
  throw std::logic_error("plans of tiles are not written yet");
}

}  // namespace cli
