// SPDX-License-Identifier: Apache-2.0
#include "study_dimension.h"

#include "exit_code.h"
#include "options.h"
#include "report.h"

#include "vdbtools/study/study.h"

#include "julia/elementary.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <iostream>

namespace po = boost::program_options;

namespace cli {
namespace {

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

}  // namespace

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

}  // namespace cli
