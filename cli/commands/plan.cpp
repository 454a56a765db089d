// SPDX-License-Identifier: Apache-2.0
#include "plan.h"

#include "exit_code.h"
#include "interruption.h"
#include "options.h"
#include "report.h"

#include "vdbtools/base/text.h"
#include "vdbtools/farm/manifest.h"
#include "vdbtools/formats/file_formats.h"

#include <stdexcept>

namespace po = boost::program_options;

namespace cli {
namespace {

constexpr Command kPlans[] = {
    {"tiles", runPlanTiles, "cut one fractal into tiles, to be merged"},
    {"frames", runPlanFrames, "a fractal for each frame, with options and inputs that change"},
    {"sheet", runPlanSheet, "the fractals of cells of a contact sheet"},
};

constexpr Usage kPlanUsage = {
    "plan",
    "tiles|frames|sheet ... -o DIR [options]",
    "Cuts a large job into tasks that any number of machines can do in any order: DIR/manifest.json says what each "
    "task makes. 'juliavdb task' does a task, and 'juliavdb submit' hands all of them to Slurm or to GNU parallel.\n\n"
    "  tiles     one fractal, cut into tiles that are merged\n"
    "  frames    a fractal for each frame, with options and inputs that change\n"
    "  sheet     the fractals of cells of a contact sheet\n\n"
    "'juliavdb plan tiles --help' and so on describe them.",
    "  juliavdb plan tiles bunny.obj -o tiles --tiles 16 --resolution 400\n"
    "  juliavdb plan frames bunny.obj -o grow --frames 1-48 --key alpha@1=20 --key alpha@48=120\n"
    "  juliavdb plan sheet seeds.json#3,5-7 -o chosen --resolution 200\n",
    "fractal",
    "tiles frames sheet"};

}  // namespace

void addVariantOptions(CommandLine& line) {
  const auto text = [](const char* name) { return po::value<std::string>()->value_name(name); };
  line.addOptions()("output,o", text("DIR"), "the folder of the plan, which is new or empty")(
      "make", text("LIST")->default_value("vdb"),
      ("what each task makes, a list of " + vdbtools::joined(vdbtools::writtenFormats())).c_str())(
      "name", text("NAME"),
      "what the files are called: DIR/out/NAME.0001.vdb (default: after the target or the sheet)");
}

std::filesystem::path newPlanFolder(const CommandLine& line) {
  if (!line.has("output")) throw std::invalid_argument("no folder was given for the plan; use -o DIR");
  std::filesystem::path folder = line.text("output");
  vdbtools::farm::requireNewPlanFolder(folder);
  return folder;
}

std::vector<std::string> parseMakes(const CommandLine& line) { return vdbtools::split(line.text("make"), ','); }

int finishPlan(const std::filesystem::path& folder, const vdbtools::farm::Manifest& manifest) {
  vdbtools::farm::writePlan(folder, manifest);
  report().wrote(folder / vdbtools::farm::kManifestName);
  workIsDone();
  report().count("tasks", manifest.tasks.size());
  report().text() << "wrote " << (folder / vdbtools::farm::kManifestName).string() << ": " << manifest.tasks.size()
                  << (manifest.tasks.size() == 1 ? " task\n" : " tasks\n");
  return kDone;
}

std::span<const Command> planKinds() { return kPlans; }

int runPlan(const Arguments& arguments) {
  for (const Command& plan : kPlans)
    if (!arguments.empty() && arguments.front() == plan.name)
      return plan.run(Arguments(arguments.begin() + 1, arguments.end()));
  CommandLine line(kPlanUsage, vdbtools::OptionTable());
  line.addPositional("words", -1, "what to plan");
  if (!line.parse(arguments)) return kDone;
  const std::vector<std::string> words = line.texts("words");
  std::vector<std::string> kinds;
  for (const Command& plan : kPlans) kinds.emplace_back(plan.name);
  const std::string use = "; use 'juliavdb plan tiles', 'plan frames' or 'plan sheet'";
  if (words.empty()) throw std::invalid_argument("no kind of plan was given" + use);
  throw std::invalid_argument("'" + words.front() + "' is no kind of plan" + use +
                              vdbtools::didYouMean(words.front(), kinds));
}

}  // namespace cli
