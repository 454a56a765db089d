// SPDX-License-Identifier: Apache-2.0
#include "grid_file.h"

#include "options.h"
#include "report.h"

#include "vdbtools/base/text.h"
#include "vdbtools/files/file_bytes.h"

#include <algorithm>
#include <ostream>
#include <stdexcept>
#include <string>

namespace cli {

std::string gridsHelp() {
  std::string silent;
  for (const vdbtools::FileFormat* format : vdbtools::fileFormats())
    if (format->writesGrids && !format->recipe)
      silent += (silent.empty() ? "; " : ", ") + std::string(format->extension) + " is " + std::string(format->name);
  return "the grids to write: " + vdbtools::extensionsOf(&vdbtools::FileFormat::writesGrids) + silent +
         ", which holds no recipe";
}

void addNvdbOption(CommandLine& line) {
  line.addOptions()("nvdb-bits", boost::program_options::value<std::string>()->value_name("32|16|8|auto"),
                    "the bits of a number in a .nvdb (default: 32). With 16 and 8 each block of 512 voxels has a scale "
                    "of its own, and auto takes as few for each block as keep distances within 0.1 voxels and "
                    "densities within 0.01 (Fp16, Fp8 and FpN of NanoVDB). How far values are off is said at the end");
}

GridOutput gridOutput(const CommandLine& line) {
  const vdbtools::FileFormat* format = vdbtools::findFormat(line.text("output"));
  if (!format || !format->writesGrids) format = vdbtools::findFormat(".vdb");
  if (!format->nvdbBits)
    line.requireUse(false, {"nvdb-bits"}, "it goes with -o F.nvdb; --half stores 16 bits in a .vdb");
  vdbtools::requireBuilt(*format);
  const std::string name = "a " + std::string(format->extension);
  if (line.given().contains("half") && !format->half)
    throw std::invalid_argument("--half is for a .vdb; --nvdb-bits 16 stores 16 bits in a .nvdb");
  if (line.given().contains("target-up") && line.recipe().at("up") == "keep" && !line.has("mesh") && !format->recipe)
    throw std::invalid_argument("--target-up has no effect: " + name +
                                " does not say which axis points up; give --up too, or leave it out");
  if (line.given().contains("units") && !line.has("mesh") && !format->unit)
    throw std::invalid_argument("--units has no effect: " + name + " has no room for a unit; leave it out");
  if (!line.has("nvdb-bits")) return {format};
  return {format, line.choice<vdbtools::NvdbValues>("nvdb-bits", {{"32", vdbtools::NvdbValues::Full},
                                                                  {"16", vdbtools::NvdbValues::Fp16},
                                                                  {"8", vdbtools::NvdbValues::Fp8},
                                                                  {"auto", vdbtools::NvdbValues::Variable}})};
}

void tellNvdb(const std::vector<vdbtools::NvdbWritten>& grids) {
  double greatest = 0;
  for (const vdbtools::NvdbWritten& grid : grids) {
    if (!grid.quantized) continue;
    const auto short3 = [](double value) { return vdbtools::shortText(value, vdbtools::Rounding::Up); };
    report().text() << "grid " << vdbtools::inOneLine(grid.name) << " as " << grid.type
                    << ": values are off by at most " << short3(grid.greatestError);
    if (grid.levelSet) report().text() << ", " << short3(grid.greatestError / grid.voxelSize) << " voxels";
    report().text() << '\n';
    greatest = std::max(greatest, grid.greatestError);
  }
  if (!grids.empty()) report().count("greatestError", greatest);
}

void tellClamped(const std::vector<vdbtools::ClampedGrid>& grids) {
  for (const std::string& text : vdbtools::textsOf(grids)) report().text() << "warning: " << text << '\n';
}

}  // namespace cli
