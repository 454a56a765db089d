// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/repair/mend_options.h"

#include "recipe/option_rows.h"
#include "vdbtools/formats/vdb_file.h"

#include <cmath>
#include <stdexcept>

namespace vdbtools {
namespace {

constexpr const char* kWays[] = {"solidify", "thicken", "points-radius"};

/// "DEPTH" or "AXIS:DEPTH".
SolidifyOptions parseSolidify(const RecipeReader& reader, const std::string& name) {
  const std::string text = reader.text(name);
  const std::vector<std::string> parts = split(text, ':');
  SolidifyOptions options;
  if (parts.size() == 2) {
    options.up = parts[0] == "x" ? 0 : parts[0] == "y" ? 1 : parts[0] == "z" ? 2 : -1;
    if (*options.up < 0) reader.refuse(name, "DEPTH, or the axis that is up and DEPTH, as in z:0.5");
  }
  const std::optional<double> depth = numberFromText(parts.back());
  if (parts.size() > 2 || !depth || !std::isfinite(*depth) || !(*depth > 0))
    reader.refuse(name, "a depth above 0, or the axis that is up and a depth, as in z:0.5");
  options.depth = *depth;
  return options;
}

const OptionRows<MendOptions>& mendRows() {
  static const OptionRows<MendOptions> rows{
      {{.name = "repair",
        .help =
            "close holes and gaps of an open mesh or a triangle soup: loops of open edges are capped, and what they "
            "leave open is spanned",
        .idle = idleWithoutMesh},
       flag(&MendOptions::repair)},
      {{.name = "repair-gap",
        .argument = "W",
        .help = "close gaps up to this width, in the mesh's units, and cap nothing else; 0 caps loops, and uses the "
                "smallest width that closes the mesh where that is not enough",
        .idle = idleByAny({idleWithoutMesh, idleWithoutFlag("repair")})},
       number(&MendOptions::gap, atLeast(0))},
      {{.name = "solidify",
        .argument = "[x|y|z:]DEPTH",
        .help = "make a block of open terrain: walls go from its open edges straight down to a flat base, DEPTH below "
                "its lowest point in the mesh's units. The axis that is up is found, or given as in z:0.5",
        .idle = idleWithoutMesh},
       parsed(&MendOptions::solidify, parseSolidify)},
      {{.name = "thicken",
        .argument = "W",
        .help = "make a plate of a sheet: everything within half of W from the mesh, in its units",
        .idle = idleWithoutMesh},
       withoutDefault(number(&MendOptions::thicken, above(0)))},
      {{.name = "points-radius",
        .argument = "R",
        .help =
            "make a solid of a cloud of points: everything within R of a point of the file, in its units; faces are "
            "not used",
        .idle = idleWithoutMesh},
       withoutDefault(number(&MendOptions::pointsRadius, above(0)))},
      {{.name = "hollows",
        .help = "what becomes of closed parts within others: fill makes one solid of them; keep leaves a cavity where "
                "the orientation of the inner part says that there is one",
        .idle = idleWithoutMesh},
       choice<Hollows>(&MendOptions::hollows, {{"fill", Hollows::Fill}, {"keep", Hollows::Keep}})},
      {{.name = "iso",
        .argument = "V",
        .help =
            "make a target of any grid of a VDB, such as a density: its surface is where the grid is V. Inside, the "
            "grid is larger; a level set is smaller, so that V moves its surface outwards",
        .defaultNote = "0, and half of the largest value of a fog volume",
        .idle = idleWithoutVdb},
       number([](auto& options) -> auto& { return options.volume.isovalue; })},
      {{.name = "invert",
        .help =
            "turn the sign of a VDB's level set, which must be negative inside; for --iso of other grids, the inside "
            "is where they are smaller",
        .idle = idleWithoutVdb},
       flag([](auto& options) -> auto& { return options.volume.invert; })},
  };
  return rows;
}

}  // namespace

std::vector<OptionSpec> mendOptionSpecs() { return mendRows().specs(); }

MendOptions parseMendOptions(const RecipeReader& reader) {
  const char* first = nullptr;
  for (const char* way : kWays) {
    if (!reader.has(way)) continue;
    if (first)
      throw std::invalid_argument("--" + std::string(first) + " and --" + way +
                                  " both make a solid of the mesh; give only one of them");
    first = way;
  }
  return mendRows().read(reader);
}

std::string idleWithoutMesh(const OptionRun& run) {
  const std::string input = run.text("input");
  if (input.empty()) return "it is for a mesh as the target, and there is no target; leave it out";
  if (!isVdbPath(input)) return {};
  return "it is for a mesh as the target, and the distances of a VDB are used as they are; leave it out, or give the "
         "mesh instead of '" +
         input + "'";
}

std::string idleWithoutVdb(const OptionRun& run) {
  const std::string input = run.text("input");
  if (!input.empty() && isVdbPath(input)) return {};
  return "it is for a VDB as the target, and " + (input.empty() ? "there is no target" : "'" + input + "' is a mesh") +
         "; leave it out";
}

std::string mendText(const MendOptions& options) {
  std::string text;
  if (options.repair) text += numbersText({options.gap});
  if (options.solidify)
    text +=
        " solidify " + std::to_string(options.solidify->up.value_or(-1)) + ' ' + numbersText({options.solidify->depth});
  if (options.thicken > 0) text += " thicken " + numbersText({options.thicken});
  if (options.pointsRadius > 0) text += " points " + numbersText({options.pointsRadius});
  if (options.hollows == Hollows::Keep) text += " hollows";
  if (options.volume.isovalue) text += " iso " + numbersText({*options.volume.isovalue});
  if (options.volume.invert) text += " invert";
  return text;
}

}  // namespace vdbtools
