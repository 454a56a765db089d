// SPDX-License-Identifier: Apache-2.0
#include "commands.h"

#include "exit_code.h"
#include "options.h"
#include "output.h"
#include "report.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/formats/file_formats.h"
#include "vdbtools/records/recorded_recipe.h"

#include <iostream>
#include <stdexcept>

namespace po = boost::program_options;

namespace cli {
namespace {

constexpr Usage kRecipeUsage = {
    "recipe", "F.vdb|F.ply|F.obj|F.glb|SHEET.json#N [-o R.json]",
    "Writes the recipe that a file of this program holds, or that of a cell of a contact sheet, as JSON: on the "
    "standard output, or with -o into a file. 'juliavdb fractal --recipe R.json' makes the same fractal again, and "
    "'juliavdb sdf --recipe R.json' the same distances. The names of files stay as the recipe has them, and so do "
    "their SHA-256; delete the entry of a SHA-256 if you name another file.",
    "  juliavdb recipe bunny.vdb -o bunny.json\n"
    "  juliavdb recipe bunny.ply\n"};

}  // namespace

int runRecipe(const Arguments& arguments) {
  CommandLine line(kRecipeUsage, vdbtools::OptionTable());
  line.addPositional("made", 1, "the file that holds the recipe");
  line.addOptions()("output,o", po::value<std::string>()->value_name("R.json"), "the recipe to write");
  if (!line.parse(arguments)) return kDone;
  const std::string file = line.text("made");
  if (file.empty())
    throw std::invalid_argument("no file was given; name a " + vdbtools::namesOf(&vdbtools::FileFormat::recipe) +
                                " that juliavdb made");
  const vdbtools::RecordedRecipe recorded = vdbtools::readRecordedRecipe(file);
  if (recorded.command.empty()) throw vdbtools::DataError(vdbtools::noRecipeText(file));
  const std::string text = vdbtools::encodeRecipe(recorded);
  if (!line.has("output")) {
    std::cout << text;
    return kDone;
  }
  Outputs outputs(line, {});
  outputs.add("output", line.text("output"), ".json").stream() << text;
  outputs.commit();
  report().text() << "wrote " << outputs.names() << ": the recipe of 'juliavdb " << recorded.command << "' in " << file
                  << '\n';
  return kDone;
}

}  // namespace cli
