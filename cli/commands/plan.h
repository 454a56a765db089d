// SPDX-License-Identifier: Apache-2.0
/// @file plan.h
/// The parts of the command `plan`. Each takes the words after its name.
#pragma once

#include "commands.h"

#include "vdbtools/farm/frame_plan.h"

#include <filesystem>
#include <set>
#include <span>
#include <string>
#include <vector>

namespace cli {

class CommandLine;

/// What may follow 'plan'.
std::span<const Command> planKinds();

int planTiles(const Arguments& arguments);
int planFrames(const Arguments& arguments);
int planSheet(const Arguments& arguments);

/// --key and --ease of 'plan frames' and 'fractal'.
void addKeyOptions(CommandLine& line);
/// Their values. @param frames  those of --frames  @param makes  what is made of each of them
/// @throw std::invalid_argument  also where an option or a key has an effect in no frame
vdbtools::farm::FramePlanOptions parseFrameOptions(const CommandLine& line, std::vector<int> frames,
                                                   const std::set<vdbtools::Product>& makes);

/// Of options whose resolution was chosen: what it is, in a sentence.
std::string frameResolutionText(const vdbtools::farm::FramePlanOptions& options);

/// The options of plans whose tasks are whole fractals: -o, --make and --name.
void addVariantOptions(CommandLine& line);
/// The value of -o, where the plan can be written. @throw std::invalid_argument, vdbtools::CreateError  none, or no
/// place for a plan
std::filesystem::path newPlanFolder(const CommandLine& line);
/// The value of --make.
std::vector<std::string> parseMakes(const CommandLine& line);

/// Writes the plan and says so. @return the exit code
int finishPlan(const std::filesystem::path& folder, const vdbtools::farm::Manifest& manifest);

}  // namespace cli
