// SPDX-License-Identifier: Apache-2.0
/// @file shell_command.h
/// Recipes as commands that can be pasted into a shell.
#pragma once

#include "vdbtools/farm/plans.h"
#include "vdbtools/recipe/option_table.h"

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace vdbtools::explore {

/// The command that makes what a recipe describes: "juliavdb fractal bunny.obj --detail 0.6 -o look.vdb".
/// @param recipe   the given options; entries for hashes, flags that are off, and options without an effect on the
///                 outputs are left out
/// @param table    the options of the command
/// @param outputs  options and files, such as ("-o", "look.vdb")
std::string fractalCommand(const Recipe& recipe, const OptionTable& table,
                           const std::vector<std::pair<std::string, std::string>>& outputs);

/// The command that makes a picture of what a recipe describes:
/// "juliavdb render --field bunny.obj --detail 0.6 --material bronze -o look.png".
/// @param picture  the options of the camera and the light
std::string pictureCommand(const Recipe& recipe, const OptionTable& table, const Recipe& picture,
                           const std::string& file);

/// The command that plans a sequence: "juliavdb plan frames bunny.obj --frames 1-48 --key detail@1=0.2 ... -o look".
/// @param options  the keys, and the other options as their base
/// @param list     the list of the frames as text, from which options.frames was read
/// @param folder   the folder of the plan
std::string framesCommand(const farm::FramePlanOptions& options, const std::string& list, const OptionTable& table,
                          const std::string& folder);

/// The shortest recipe that completeRecipe() completes to the same one.
Recipe shortestRecipe(const Recipe& recipe, const OptionTable& table);

}  // namespace vdbtools::explore
