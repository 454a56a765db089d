// SPDX-License-Identifier: Apache-2.0
/// @file test_controls.h
/// Controls as users write them, for an option of their own.
#pragma once

#include "vdbtools/control/control.h"
#include "vdbtools/recipe/recipe_reader.h"

#include <memory>
#include <string>

namespace test_controls {

/// The control that @a text gives to the option alpha.
inline std::shared_ptr<const vdbtools::ControlSource> source(const std::string& text) {
  static const vdbtools::OptionTable table(
      {{.name = "alpha", .argument = "A", .defaultValue = "40", .hash = "alpha-sha256"}});
  return vdbtools::parseControl(vdbtools::RecipeReader({{"alpha", text}}, table), "alpha");
}

}  // namespace test_controls
