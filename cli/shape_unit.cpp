// SPDX-License-Identifier: Apache-2.0
#include "shape_unit.h"

#include "options.h"

#include "vdbtools/scene/file_axes.h"

namespace cli {

void addUnitsOption(CommandLine& line) {
  line.addOptions({{.name = "units",
                    .argument = "mm|cm|m|in",
                    .help = "the unit of the input's coordinates, as of 'fractal'",
                    .defaultNote = "what the input says, or none"}});
}

std::optional<vdbtools::LengthUnit> unitOf(const CommandLine& line, const std::string& input) {
  const auto asked = line.has("units") ? std::optional(vdbtools::parseLengthUnit(line.text("units"))) : std::nullopt;
  return vdbtools::agreedUnit(asked, vdbtools::unitOfFile(input), input);
}

}  // namespace cli
