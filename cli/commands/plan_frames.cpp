// SPDX-License-Identifier: Apache-2.0
#include "plan.h"

#include "exit_code.h"
#include "options.h"
#include "output.h"
#include "report.h"
#include "scene_recipe.h"
#include "sequence.h"

#include "vdbtools/base/text.h"
#include "vdbtools/farm/plans.h"
#include "vdbtools/scene/fractal_options.h"

#include <ostream>
#include <stdexcept>

namespace po = boost::program_options;

namespace cli {
namespace {

constexpr Usage kPlanFramesUsage = {
    "plan frames",
    "MESH|SDF.vdb --frames LIST -o DIR [--key NAME@FRAME=VALUE ...] [--ease smooth] [--make LIST] [options]",
    "Plans a fractal for each frame. The keys of an option say what it is at some frames; between them its numbers "
    "change gradually, and before the first key and after the last they stay. Of a list such as --origin-shift 0,0,1 "
    "or a ramp such as --detail x:0.05:0.6:smooth each number is blended by itself.\n\n"
    "  --ease linear    a + (b - a) t between the values a and b, at the share t of the way (the default)\n"
    "  --ease smooth    a + (b - a) (3 t^2 - 2 t^3), which starts and ends at rest\n"
    "  --ease step      a, up to the frame of b; for options that are no numbers\n\n"
    "The name of a target, a versor or another file may hold a place for the frame, as in in.####.obj, in.$F4.obj or "
    "in.%04d.obj. A glTF that is animated is played: each frame has its number as --target-frame, unless that is given "
    "or has keys. All files must exist; the plan holds their hashes, and a task whose file has changed fails.",
    "  juliavdb plan frames bunny.obj --frames 1-48 -o grow --key alpha@1=20 --key alpha@48=120 --resolution 100\n"
    "  juliavdb plan frames bunny.obj --frames 1-24 -o turn --key texture-translate@1=0,0,0 \\\n"
    "      --key texture-translate@24=0.2,0,0 --ease smooth --make vdb,ply --resolution 100\n",
    "fractal"};

}  // namespace

void addKeyOptions(CommandLine& line) {
  const auto texts = [](const char* name) { return po::value<std::vector<std::string>>()->value_name(name); };
  line.addOptions()("key", texts("NAME@FRAME=VALUE"), "what an option of 'fractal' is at a frame; any number of times")(
      "ease", texts("[NAME=]linear|smooth|step"),
      "how the numbers change between keys: of all options, or of the option NAME; any number of times");
}

vdbtools::farm::FramePlanOptions parseFrameOptions(const CommandLine& line, std::vector<int> frames,
                                                   const std::set<vdbtools::Product>& makes) {
  vdbtools::farm::FramePlanOptions options{
      .base = withFoundFiles(line, line.givenRecipe(), line.configHolder()),
      .keys = vdbtools::farm::parseKeys(line.texts("key"), line.texts("ease"), vdbtools::fractalOptionTable()),
      .frames = std::move(frames)};
  vdbtools::farm::playTarget(options);
  const vdbtools::OptionTable table = vdbtools::fractalOptionTable();
  const vdbtools::Recipe typed = line.given();
  std::set<std::string> names = line.typedNames();
  for (const vdbtools::farm::KeyedOption& keyed : options.keys) {
    if (typed.contains(keyed.name))
      throw std::invalid_argument("--" + keyed.name + " is given and has keys; give only one of them");
    names.insert(keyed.name);
  }
  for (const std::string& name : line.typedNames()) options.given[name] = options.base.at(name);
  vdbtools::RequiredEffects effects(table, std::move(names));
  for (const int frame : options.frames)
    if (effects.add({vdbtools::completeRecipe(vdbtools::farm::recipeAt(options, frame), table), makes})) return options;
  effects.require();
  return options;
}

void chooseForAllFrames(const CommandLine& line, vdbtools::farm::FrameRecipes& asked,
                        vdbtools::farm::FramePlanOptions& options) {
  checkFrames(line, asked.frames(), [&](int frame) { asked.look(frame, line.progress()); });
  vdbtools::farm::chooseResolution(options, line.progress());
  if (options.resolution)
    report().text() << "resolution " << vdbtools::shortText(*options.resolution)
                    << " for all frames: the most that the first, the middle and the last of them need\n";
  const std::optional<vdbtools::farm::SharedVoxel> shared = asked.sharedVoxel(options);
  if (!shared) return;
  options.voxelSize = shared->size;
  report().text() << "voxels of " << vdbtools::shortText(shared->size) << " for all frames: those of frame "
                  << shared->frame << ", whose target is the largest; --voxel-size sets another size\n";
}

int runPlanFrames(const Arguments& arguments) {
  CommandLine line(kPlanFramesUsage, vdbtools::fractalOptionTable());
  addVariantOptions(line);
  line.addOptions()(
      "frames", po::value<std::string>()->value_name("LIST"),
      "the frames: a list of numbers and ranges such as 7, 1-48, -5-5, or 1-48x2 or 1-48:2 for every second one");
  addKeyOptions(line);
  addSearchOption(line);
  if (!line.parse(arguments)) return kDone;
  if (!line.has("frames"))
    throw std::invalid_argument("no frames were given; use --frames LIST, such as --frames 1-48");
  const std::vector<std::string> makes = parseMakes(line);
  vdbtools::farm::FramePlanOptions options =
      parseFrameOptions(line, vdbtools::farm::parseFrames(line.text("frames")), productsOf(makes));
  options.name = line.text("name");
  options.makes = makes;
  vdbtools::farm::FrameRecipes asked(options);
  const std::filesystem::path folder = newPlanFolder(line);
  chooseForAllFrames(line, asked, options);
  return finishPlan(folder, vdbtools::farm::planFrames(options));
}

}  // namespace cli
