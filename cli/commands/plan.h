// SPDX-License-Identifier: Apache-2.0
/// @file plan.h
/// The parts of the command `plan`. Each takes the words after its name.
#pragma once

#include "commands.h"

#include "vdbtools/farm/plans.h"

#include <filesystem>
#include <set>
#include <span>
#include <string>
#include <vector>

namespace cli {

class CommandLine;

/// The kinds of plans, which follow the word 'plan'.
std::span<const Command> planKinds();

int runPlanTiles(const Arguments& arguments);
int runPlanFrames(const Arguments& arguments);
int runPlanSheet(const Arguments& arguments);

/// --key and --ease of 'plan frames' and 'fractal'.
void addKeyOptions(CommandLine& line);
/// The values of the key options. @param frames  the frames of --frames  @param makes  the products of each frame
/// @throw std::invalid_argument  also if an option or a key has an effect in no frame
vdbtools::farm::FramePlanOptions parseFrameOptions(const CommandLine& line, std::vector<int> frames,
                                                   const std::set<vdbtools::Product>& makes);

/// Opens the files of all frames, so that a broken one is found before the first frame is made, and chooses and reports
/// the voxels that all frames share. With --keep-going, a broken file fails its own frame later.
/// @throw FailedWith  names the frame of a broken file
void chooseForAllFrames(const CommandLine& line, vdbtools::farm::FrameRecipes& asked,
                        vdbtools::farm::FramePlanOptions& options);

/// The options of plans whose tasks are whole fractals: -o, --make and --name.
void addVariantOptions(CommandLine& line);
/// The value of -o, after a check that the plan can be written there. @throw std::invalid_argument,
/// vdbtools::CreateError  there is none, or no plan can be written there
std::filesystem::path newPlanFolder(const CommandLine& line);
/// The value of --make.
std::vector<std::string> parseMakes(const CommandLine& line);

/// Writes the plan and reports it. @return the exit code
int finishPlan(const std::filesystem::path& folder, const vdbtools::farm::Manifest& manifest);

}  // namespace cli
