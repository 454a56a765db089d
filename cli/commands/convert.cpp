// SPDX-License-Identifier: Apache-2.0
#include "commands.h"

#include "exit_code.h"
#include "grid_file.h"
#include "options.h"
#include "output.h"
#include "report.h"
#include "sequence.h"

#include "vdbtools/base/text.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/scene/attribute_options.h"
#include "vdbtools/scene/file_axes.h"

#include <algorithm>
#include <optional>
#include <ostream>
#include <stdexcept>
#include <string>
#include <vector>

namespace po = boost::program_options;

namespace cli {
namespace {

constexpr Usage kConvertUsage = {
    "convert", "F.vdb -o F.nvdb|G.vdb [--nvdb-bits 32|16|8|auto] [--grid-names NAMES]",
    "Writes the grids of a VDB as NanoVDB, for renderers and graphics processors, or as a VDB in which they have other "
    "names. The VDB may be of any program. A NanoVDB file holds no recipe and no other text, so keep the VDB.",
    "  juliavdb convert bunny.vdb -o bunny.nvdb\n"
    "  juliavdb convert bunny.vdb -o small.nvdb --nvdb-bits 8\n"
    "  juliavdb convert bunny.vdb -o blender.vdb --grid-names blender,surface=shape\n"
    "  juliavdb convert grow.####.vdb -o grow.####.nvdb --frames 1-2\n"};

/// The options with which a VDB is written again, with other names of its grids.
vdbtools::VdbWriteOptions writeOptions(const vdbtools::VdbFile& vdb, const vdbtools::GridNames& names) {
  vdbtools::VdbWriteOptions write{.metadata = vdb.metadata, .names = names};
  write.half = std::ranges::all_of(vdb.grids, [](const auto& grid) { return grid->saveFloatAsHalf(); });
  if (vdb.metadata.contains(vdbtools::kUpAxis)) write.up = vdbtools::recordedUpAxis(vdb.metadata);
  for (const std::string& distances : vdbtools::distanceGrids(vdb.metadata))
    if (names.contains(distances)) {
      write.metadata[vdbtools::kDistanceGrid] = names.at(distances);
      break;
    }
  return write;
}

/// @throw std::invalid_argument  a grid cannot be written again
void requireWritable(const vdbtools::VdbFile& vdb, const std::string& input) {
  for (const auto& grid : vdb.grids)
    if (grid->valueType() == "ptdataidx32")
      throw std::invalid_argument("'" + input + "' holds the points '" + vdbtools::inOneLine(grid->getName()) +
                                  "', which this program does not convert; make them again with 'juliavdb points'");
}

void convertVdb(const CommandLine& line, const std::string& input, const GridOutput& output, const FrameRun& run) {
  std::ostream& file = run.outputs.add("output", line.text("output"), &vdbtools::FileFormat::writesGrids).stream();
  run.monitor.begin(vdbtools::PhaseKind::Reading, 0);
  const vdbtools::VdbFile vdb = vdbtools::readVdb(input);
  std::vector<std::string> own;
  for (const auto& grid : vdb.grids) own.push_back(grid->getName());
  const vdbtools::GridNames names = vdbtools::parseGridNames(line.text("grid-names"), own, /*ofOthers=*/true);
  run.monitor.throwIfCancelled();
  run.monitor.begin(vdbtools::PhaseKind::Writing, 0);
  if (output.format->points) requireWritable(vdb, input);
  vdbtools::VdbWriteOptions write = writeOptions(vdb, names);
  std::vector<vdbtools::ClampedGrid> clamped;
  write.clamped = &clamped;
  const std::vector<vdbtools::NvdbWritten> written =
      vdbtools::writeGrids(file, *output.format, vdb.grids, write, output.values);
  run.monitor.throwIfCancelled();
  run.outputs.commit(run.isLast);
  report().count("grids", vdb.grids.size());
  report().text() << "wrote " << run.outputs.names() << ": " << vdb.grids.size()
                  << (vdb.grids.size() == 1 ? " grid" : " grids") << '\n';
  const auto changesName = [](const auto& pair) { return pair.first != pair.second; };
  if (line.has("grid-names") && std::ranges::none_of(names, changesName))
    report().text() << "note: the grids have these names already: " << vdbtools::inOneLine(vdbtools::joined(own))
                    << '\n';
  for (const vdbtools::VdbFile::UnreadGrid& grid : vdb.unread)
    report().text() << "note: the grid " << vdbtools::inOneLine(grid.name) << " of the unknown type "
                    << vdbtools::inOneLine(grid.type) << " was left out\n";
  tellNvdb(written);
  tellClamped(clamped);
}

}  // namespace

int runConvert(const Arguments& arguments) {
  CommandLine line(kConvertUsage, vdbtools::OptionTable());
  line.addPositional("vdb", 1, "the VDB");
  line.addOptions()("output,o", po::value<std::string>()->value_name("F.nvdb"),
                    "the file to write: .nvdb, or .vdb with --grid-names");
  addNvdbOption(line);
  line.addOptions({vdbtools::gridNamesOption()});
  addFramesOption(line);
  if (!line.parse(arguments)) return kDone;
  const std::string input = line.text("vdb");
  if (input.empty()) throw std::invalid_argument("no VDB was given");
  if (!line.has("output")) throw std::invalid_argument("no output was given; use -o F.nvdb");
  const GridOutput output = gridOutput(line);
  if (!line.has("grid-names") && vdbtools::isVdbPath(line.text("output")))
    throw std::invalid_argument("a VDB with the same names would be the same; give --grid-names, or -o F.nvdb");
  return runFrames(line, input, kOnlyOutput, [&line, output](const std::string& name) {
    return FrameJob{{}, [&line, output, name](const FrameRun& run) { convertVdb(line, name, output, run); }};
  });
}

}  // namespace cli
