// SPDX-License-Identifier: Apache-2.0
/// @file commands.h
/// The commands of the program. Each takes the words after its name and returns an exit code, or throws.
#pragma once

#include <span>
#include <string>
#include <vector>

namespace cli {

using Arguments = std::vector<std::string>;

int runSdf(const Arguments& arguments);
int runFractalCommand(const Arguments& arguments);
int runMerge(const Arguments& arguments);
int runMesh(const Arguments& arguments);
int runFit(const Arguments& arguments);
int runVersor(const Arguments& arguments);
int runConvert(const Arguments& arguments);
int runPoints(const Arguments& arguments);
int runPrint(const Arguments& arguments);
int runSheet(const Arguments& arguments);
int runSlice(const Arguments& arguments);
int runStudy(const Arguments& arguments);
int runRender(const Arguments& arguments);
int runExplore(const Arguments& arguments);
int runTask(const Arguments& arguments);
int runStatus(const Arguments& arguments);
int runSubmit(const Arguments& arguments);
int runUsd(const Arguments& arguments);
int runInfo(const Arguments& arguments);
int runPlan(const Arguments& arguments);
int runRecipe(const Arguments& arguments);
int runMaps(const Arguments& arguments);
int runDevices(const Arguments& arguments);
int runMan(const Arguments& arguments);
int runCompletion(const Arguments& arguments);

struct Command {
  const char* name;
  int (*run)(const Arguments&);
  const char* summary;
  std::span<const Command> (*partsOf)() = nullptr;  ///< commands that follow its name, as in 'plan frames'

  std::span<const Command> parts() const { return partsOf ? partsOf() : std::span<const Command>(); }
};

std::span<const Command> commands();

}  // namespace cli
