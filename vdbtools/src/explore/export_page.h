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

/// The exponent is stored coarser than the server gives it, at most 160 nodes along an axis, as 16-bit floats; the page
/// says so.
/// @param recipe  what was given, for the page to show
/// @param look    the camera, colours and light, as the page writes them into its address; null: the page's defaults
/// @throw as sceneData()
std::string exportPage(const Scene& scene, const Recipe& recipe, const nlohmann::json& look, Monitor& monitor);

/// The modules of the page as one script: what each imports stands before it, without the words import and export. A
/// module imports by lines `import {...} from "./name.js";` and exports what it declares; no two declare one name at
/// their top level.
std::string bundledScript();

}  // namespace vdbtools::explore
