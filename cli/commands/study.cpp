// SPDX-License-Identifier: Apache-2.0
#include "commands.h"

#include "exit_code.h"
#include "options.h"
#include "output.h"
#include "report.h"
#include "scene_recipe.h"
#include "slice_plane.h"
#include "study_grain.h"
#include "target_text.h"

#include "vdbtools/base/text.h"
#include "vdbtools/maps/texture_shelf.h"
#include "vdbtools/scene/fractal_options.h"
#include "vdbtools/scene/scene.h"
#include "vdbtools/study/study.h"

#include "julia/elementary.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <iostream>
#include <ostream>

namespace po = boost::program_options;

namespace cli {
namespace {

constexpr Usage kStudyUsage = {
    "study", "MESH|SDF.vdb|FRACTAL.vdb -o F.png [--curve F.png] [--csv F.csv] [--versors N] [--axis x|y|z] [options]",
    "Shows on a plane what a target decides by itself and what is left to the versor: the average of the sets of many "
    "random versors. It is black where all sets contain the pixel and white where none does (Schor and Kim 2023, Fig. "
    "8). Versors are counted from 0; versor k has the seed S + k if S is --texture-seed, and 'juliavdb slice --texture "
    "random' shows it alone.\n\n"
    "  --curve  the target's distance phi on circles about the dynamics' origin: mean, least and greatest, by radius.\n"
    "           Where phi lies in the shaded range, the versor decides\n"
    "  --csv    the same as numbers, in the target's units: radius; mean, least and greatest phi on the circle; mean "
    "phi\n"
    "           on the sphere of that radius; and the mean membership of the circle, from 0 to 1",
    "  juliavdb study bunny.obj -o study.png --curve curve.png --csv study.csv --versors 200\n"
    "  juliavdb study bunny.obj -o rough.png --alpha 10 --versors 100 --size 400\n"
    "  juliavdb study bunny.vdb -o side.png --axis x --texture-seed 5000\n"};

constexpr Usage kStudyDimensionUsage = {
    "study", "MESH|SDF.vdb --dimension N,N,N[,...] [--json] [options]",
    "Measures how the mesh of a fractal grows with the resolution N. The slope of log(triangles) over log N is an "
    "estimate of the surface's fractal dimension over that range of N (Kim and Duff 2020); a smooth surface has 2. "
    "Shown are the triangles at each N, the slope between each N and the one before, and the slope over all by least "
    "squares, with its standard error and its 95 % interval.",
    "  juliavdb study bunny.obj --dimension 40,80,160\n"
    "  juliavdb study bunny.obj --detail 0.8 --iterations 8 --dimension 40,60,80,120 --json\n",
    "fractal"};

std::vector<int> parseResolutions(const CommandLine& line) {
  using vdbtools::kLeastGrowthResolution, vdbtools::kMostGrowthResolution;
  std::vector<int> resolutions;
  for (const std::string& part : vdbtools::split(line.text("dimension"), ',')) {
    const auto resolution = vdbtools::wholeFromText<int>(part);
    if (!resolution || *resolution < kLeastGrowthResolution || *resolution > kMostGrowthResolution ||
        (!resolutions.empty() && *resolution <= resolutions.back()))
      line.refuse("dimension", "a list of resolutions from " + std::to_string(kLeastGrowthResolution) + " to " +
                                   std::to_string(kMostGrowthResolution) +
                                   ", the smallest first, such as 50,100,200,400");
    resolutions.push_back(*resolution);
  }
  if (resolutions.size() < vdbtools::kLeastGrowthRows) line.refuse("dimension", "a list of at least three resolutions");
  return resolutions;
}

double slopeBetween(const vdbtools::GrowthRow& a, const vdbtools::GrowthRow& b) {
  return julia::elementary::log(static_cast<double>(b.triangles) / static_cast<double>(a.triangles)) /
         julia::elementary::log(static_cast<double>(b.resolution) / a.resolution);
}

nlohmann::ordered_json jsonOf(const std::vector<vdbtools::GrowthRow>& rows, const vdbtools::PowerLaw& law) {
  nlohmann::ordered_json json{{"dimension", law.exponent},
                              {"standardError", law.standardError},
                              {"interval", {law.interval.first, law.interval.second}},
                              {"factor", law.factor},
                              {"rows", nlohmann::ordered_json::array()}};
  for (const vdbtools::GrowthRow& row : rows)
    json["rows"].push_back({{"resolution", row.resolution},
                            {"triangles", row.triangles},
                            {"points", row.points},
                            {"evaluatedNodes", row.evaluatedNodes}});
  return json;
}

void writeText(const std::vector<vdbtools::GrowthRow>& rows, const vdbtools::PowerLaw& law) {
  std::cout << std::setw(10) << "N" << std::setw(14) << "triangles" << std::setw(10) << "slope" << '\n'
            << std::fixed << std::setprecision(4);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    std::cout << std::setw(10) << rows[i].resolution << std::setw(14) << rows[i].triangles;
    if (i > 0) std::cout << std::setw(10) << slopeBetween(rows[i - 1], rows[i]);
    std::cout << '\n';
  }
  std::cout << "dimension " << law.exponent << ", standard error " << law.standardError << ", 95 % interval "
            << law.interval.first << " to " << law.interval.second << "\ntriangles = " << law.factor << " N^"
            << law.exponent << '\n';
}

int studyDimension(const Arguments& arguments) {
  CommandLine line(kStudyDimensionUsage, vdbtools::fractalOptionTable());
  line.addOptions()("dimension", po::value<std::string>()->value_name("N,N,N"), "the resolutions, the smallest first")(
      "json", "write the numbers as JSON");
  for (const std::string& word : arguments)
    for (const char* option : {"-o", "--output", "--curve", "--csv", "--versors", "--axis", "--position", "--size"})
      if (word == option || word.starts_with(std::string(option) + '='))
        throw std::invalid_argument(
            std::string(option) +
            " has no effect: with --dimension a study makes no picture and no curve, but prints "
            "its numbers; leave it out");
  if (!line.parse(arguments)) return kDone;
  const std::vector<int> resolutions = parseResolutions(line);
  for (const char* option : {"resolution", "voxel-size"})
    if (line.given().contains(option))
      throw std::invalid_argument("--" + std::string(option) +
                                  " is given, but --dimension has the resolutions; leave it out");
  line.requireEffect({vdbtools::Product::MeshCount});
  const std::vector<vdbtools::GrowthRow> rows =
      vdbtools::measureGrowth(vdbtools::parseFractalOptions(line.recipe()), resolutions, line.progress());
  const vdbtools::PowerLaw law = vdbtools::growthLaw(rows);
  if (line.has("json"))
    std::cout << jsonOf(rows, law).dump(1) << '\n';
  else
    writeText(rows, law);
  report().count("dimension", law.exponent);
  return kDone;
}

}  // namespace

int runStudy(const Arguments& arguments) {
  const auto asks = [&](const std::string& option) {
    return std::any_of(arguments.begin(), arguments.end(),
                       [&](const std::string& word) { return word == option || word.starts_with(option + '='); });
  };
  if (asks("--dimension")) return studyDimension(arguments);
  if (asks("--strokes")) return studyGrain(arguments);
  CommandLine line(kStudyUsage, vdbtools::studyOptionTable());
  line.addOptions()("output,o", po::value<std::string>()->value_name("F.png"), "the average to write: .png or .exr")(
      "curve", po::value<std::string>()->value_name("F.png"), "the distance over circles to write: .png, .svg or .exr")(
      "csv", po::value<std::string>()->value_name("F.csv"), "the numbers of the circles to write")(
      "versors", po::value<std::string>()->default_value("1000")->value_name("N"), "the number of random versors")(
      "dimension", po::value<std::string>()->value_name("N,N,N"),
      "instead, measure how the mesh of a fractal grows with its resolution, and the fractal dimension of its surface; "
      "see 'juliavdb study --dimension N --help'")(
      "strokes", po::value<std::string>()->value_name("F.ply"),
      "instead, draw the directions that a texture follows; see 'juliavdb study --strokes F.ply --help'");
  addPlaneOptions(line, "through the dynamics' origin");
  addSearchOption(line);
  if (!line.parse(arguments)) return kDone;
  const vdbtools::StudyOptions study{.versors = line.integer("versors", 1, vdbtools::kMostVersors),
                                     .circles = line.has("curve") || line.has("csv")};
  const PlanePlacement placement = parsePlacement(line);
  if (!line.has("output")) throw std::invalid_argument("no output was given; use -o F.png");
  const auto input = line.recipe().find("input");
  if (input == line.recipe().end()) throw std::invalid_argument("no target was given");
  vdbtools::Recipe recipe = sceneRecipe(line, input->second);
  // A study uses random versors, even for a fractal with a texture.
  if (const auto versor = recipe.find("texture"); versor != recipe.end() && vdbtools::findTexture(versor->second))
    recipe = vdbtools::overridden(recipe, {{"texture", "random"}}, vdbtools::fractalOptionTable());
  const vdbtools::FractalOptions options = vdbtools::parseFractalOptions(recipe);
  line.requireEffect({{recipe, {vdbtools::Product::Slice}}});
  Outputs outputs(line, vdbtools::inputsOf(options));
  std::ostream& file = outputs.add("output", line.text("output"), ".png .exr").stream();
  std::ostream* const curve =
      line.has("curve") ? &outputs.add("curve", line.text("curve"), ".png .svg .exr").stream() : nullptr;
  std::ostream* const csv = line.has("csv") ? &outputs.add("csv", line.text("csv"), ".csv").stream() : nullptr;
  const vdbtools::Scene scene = vdbtools::makeScene(options, line.progress());
  const vdbtools::SlicePlane plane = placement.plane(vdbtools::sliceFrame(scene), scene.field.space.centre);
  const vdbtools::Study result = vdbtools::runStudy(scene, plane, study, line.progress());
  line.progress().begin(vdbtools::PhaseKind::Writing, 0);
  file << vdbtools::encodeImage(vdbtools::studyImage(plane, result), formatOf(line.text("output"), ".png"));
  if (curve) *curve << vdbtools::encodePlot(vdbtools::studyPlot(result), formatOf(line.text("curve"), ".png"));
  if (csv) *csv << vdbtools::studyCsv(result);
  line.progress().throwIfCancelled();
  outputs.commit();
  report().count("width", plane.width());
  report().count("height", plane.height());
  report().count("versors", result.versors);
  report().text() << "wrote " << outputs.names() << ": " << plane.width() << " x " << plane.height() << ", "
                  << result.versors << " versors from seed " << vdbtools::VersorSeeds(scene).first() << " on";
  if (result.undecided)
    report().text() << ", open where phi is between " << vdbtools::shortText(result.undecided->first) << " and "
                    << vdbtools::shortText(result.undecided->second);
  if (!result.originInside) report().text() << ", the dynamics' origin lies outside the target";
  report().text() << '\n';
  tellTarget(scene.metadata);
  return kDone;
}

}  // namespace cli
