// SPDX-License-Identifier: Apache-2.0
/// @file export_page.h
/// A look as one HTML file that shows it in any browser with WebGL 2: without a server, and without a request to
/// anywhere.
#pragma once

#include "vdbtools/base/monitor.h"
#include "vdbtools/recipe/option_table.h"
#include "vdbtools/scene/scene.h"

#include <nlohmann/json.hpp>

#include <string>

namespace vdbtools::explore {

/// The exponent is stored more coarsely than the server sends it, with at most 160 nodes along an axis, as 16-bit
/// floats; the page mentions this.
/// @param recipe  the given options, which the page shows
/// @param look    the camera, colours and light, as the page writes them into its address; null: the page's defaults
/// @throw as sceneData()
std::string exportPage(const Scene& scene, const Recipe& recipe, const nlohmann::json& look, Monitor& monitor);

/// Joins the modules of the page into one script: each module follows those that it imports, and the words import and
/// export are removed. Modules must import by lines of the form `import {...} from "./name.js";`, export where they
/// declare, and declare no name twice at their top levels.
std::string bundledScript();

}  // namespace vdbtools::explore
