// SPDX-License-Identifier: Apache-2.0
#include "commands.h"

#include "exit_code.h"
#include "grid_file.h"
#include "options.h"
#include "output.h"
#include "report.h"
#include "sequence.h"

#include "vdbtools/files/file_bytes.h"
#include "vdbtools/formats/vdb_file.h"

#include <ostream>
#include <string>
#include <vector>

namespace po = boost::program_options;

namespace cli {
namespace {

constexpr Usage kConvertUsage = {
    "convert", "F.vdb -o F.nvdb [--nvdb-bits 32|16|8|auto]",
    "Writes the grids of a VDB as NanoVDB, for renderers and graphics processors. The VDB may be of any program. A "
    "NanoVDB file holds no recipe and no other text, so keep the VDB.",
    "  juliavdb convert bunny.vdb -o bunny.nvdb\n"
    "  juliavdb convert bunny.vdb -o small.nvdb --nvdb-bits 8\n"
    "  juliavdb convert grow.####.vdb -o grow.####.nvdb --frames 1-2\n"};

constexpr const char* kConvertOutput[] = {"output"};

void convertVdb(const CommandLine& line, const std::string& input, const FrameRun& run) {
  std::ostream& file = run.outputs.add("output", line.text("output"), ".nvdb").stream();
  const vdbtools::NvdbValues values = nvdbValues(line).value_or(vdbtools::NvdbValues::Full);
  run.monitor.begin(vdbtools::PhaseKind::Reading, 0);
  const vdbtools::VdbFile vdb = vdbtools::readVdb(input);
  run.monitor.throwIfCancelled();
  run.monitor.begin(vdbtools::PhaseKind::Writing, 0);
  const std::vector<vdbtools::NvdbWritten> written = vdbtools::writeNvdb(file, vdb.grids, {.values = values});
  run.monitor.throwIfCancelled();
  run.outputs.commit(run.isLast);
  report().count("grids", written.size());
  report().text() << "wrote " << run.outputs.names() << ": " << written.size()
                  << (written.size() == 1 ? " grid" : " grids") << '\n';
  for (const vdbtools::VdbFile::UnreadGrid& grid : vdb.unread)
    report().text() << "note: the grid " << vdbtools::inOneLine(grid.name) << " of the unknown type "
                    << vdbtools::inOneLine(grid.type) << " was left out\n";
  tellNvdb(written);
}

}  // namespace

int runConvert(const Arguments& arguments) {
  CommandLine line(kConvertUsage, vdbtools::OptionTable());
  line.addPositional("vdb", 1, "the VDB");
  line.addOptions()("output,o", po::value<std::string>()->value_name("F.nvdb"), "the NanoVDB file to write");
  addNvdbOption(line);
  addFramesOption(line);
  if (!line.parse(arguments)) return kDone;
  const std::string input = line.text("vdb");
  if (input.empty()) throw std::invalid_argument("no VDB was given");
  if (!line.has("output")) throw std::invalid_argument("no output was given; use -o F.nvdb");
  nvdbValues(line);
  return runFrames(line, input, kConvertOutput, [&line](const std::string& name) {
    return FrameJob{{}, [&line, name](const FrameRun& run) { convertVdb(line, name, run); }};
  });
}

}  // namespace cli
