// SPDX-License-Identifier: Apache-2.0
#include "shape_unit.h"

#include "options.h"

#include "vdbtools/scene/file_axes.h"

namespace cli {

void addUnitsOption(CommandLine& line) {
  line.addOptions()("units", boost::program_options::value<std::string>()->value_name("mm|cm|m|in"),
                    "the unit of the input's coordinates, as of 'fractal' (default: as the input says, or none)");
}

std::optional<vdbtools::LengthUnit> unitOf(const CommandLine& line, const std::string& input) {
  const auto asked = line.has("units") ? std::optional(vdbtools::parseLengthUnit(line.text("units"))) : std::nullopt;
  return vdbtools::agreedUnit(asked, vdbtools::unitOfFile(input), input);
}

}  // namespace cli
