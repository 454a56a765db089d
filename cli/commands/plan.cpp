// SPDX-License-Identifier: Apache-2.0
#include "plan.h"

#include "exit_code.h"
#include "options.h"
#include "report.h"

#include "vdbtools/farm/plan_folder.h"

#include <iostream>
#include <stdexcept>

namespace po = boost::program_options;

namespace cli {
namespace {

constexpr Command kPlans[] = {
    {"tiles", planTiles, "cut one fractal into tiles, to be merged"},
    {"frames", planFrames, "a fractal for each frame, with options and inputs that change"},
    {"sheet", planSheet, "the fractals of cells of a contact sheet"},
};

void printHelp(std::ostream& stream) {
  stream << "Usage: juliavdb plan tiles|frames|sheet ... -o DIR [options]\n\n"
            "Cuts a large job into tasks that any number of machines can do in any order: DIR/manifest.json says what\n"
            "each task makes. 'juliavdb task' does a task, and 'juliavdb submit' hands all of them to Slurm or to GNU\n"
            "parallel.\n\nPlans:\n";
  for (const Command& plan : kPlans)
    stream << "  " << plan.name << std::string(10 - std::string_view(plan.name).size(), ' ') << plan.summary << '\n';
  stream << "\n'juliavdb plan tiles --help' and so on describe them.\n";
}

}  // namespace

void addVariantOptions(CommandLine& line) {
  const auto text = [](const char* name) { return po::value<std::string>()->value_name(name); };
  line.addOptions()("output,o", text("DIR"), "the folder of the plan, which is new or empty")(
      "make", text("LIST")->default_value("vdb"), "what each task makes, a list of vdb, ply, obj, stl")(
      "name", text("NAME"),
      "what the files are called: DIR/out/NAME.0001.vdb (default: after the target or the sheet)");
}

std::filesystem::path newPlanFolder(const CommandLine& line) {
  if (!line.has("output")) throw std::invalid_argument("no folder was given for the plan; use -o DIR");
  const std::filesystem::path folder = line.text("output");
  vdbtools::requireNewPlanFolder(folder);
  return folder;
}

std::vector<std::string> parseMakes(const CommandLine& line) { return vdbtools::split(line.text("make"), ','); }

int finishPlan(const std::filesystem::path& folder, const vdbtools::Manifest& manifest) {
  vdbtools::writePlan(folder, manifest);
  report().wrote(folder / vdbtools::kManifestName);
  report().count("tasks", static_cast<double>(manifest.tasks.size()));
  report().text() << "wrote " << (folder / vdbtools::kManifestName).string() << ": " << manifest.tasks.size()
                  << (manifest.tasks.size() == 1 ? " task\n" : " tasks\n");
  return kDone;
}

int runPlan(const Arguments& arguments) {
  if (arguments.empty())
    throw std::invalid_argument("no kind of plan was given; use 'juliavdb plan tiles', 'plan frames' or 'plan sheet'");
  const std::string& kind = arguments.front();
  if (kind == "--help" || kind == "-h") {
    printHelp(std::cout);
    return kDone;
  }
  for (const Command& plan : kPlans)
    if (kind == plan.name) return plan.run(Arguments(arguments.begin() + 1, arguments.end()));
  throw std::invalid_argument("'" + kind + "' is no kind of plan; use tiles, frames or sheet");
}

}  // namespace cli
