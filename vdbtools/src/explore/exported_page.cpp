// SPDX-License-Identifier: Apache-2.0
#include "explore/export_page.h"
#include "explore/scene_data.h"
#include "vdbtools/explore/explore_server.h"

namespace vdbtools::explore {

std::string exportedPage(const Recipe& given, Monitor& monitor) {
  const Recipe completed = completeRecipe(given, fractalOptionTable());
  const Scene scene = makeScene(shownOptions(parseFractalOptions(completed)), monitor);
  return exportPage(scene, given, {}, monitor);
}

}  // namespace vdbtools::explore
