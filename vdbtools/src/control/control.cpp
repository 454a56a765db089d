// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/control/control.h"

#include "control/control_kinds.h"

namespace vdbtools {

double Control::at(const openvdb::Vec3d& point) const {
  double value = 0;
  sample({&point, 1}, {&value, 1});
  return value;
}

std::shared_ptr<const ControlSource> parseControl(const RecipeReader& reader, const std::string& option) {
  // Grids come last, because they accept any text that ends like the name of a VDB.
  constexpr ControlSourcePtr (*kParsers[])(const RecipeReader&, const std::string&) = {
      parseNumberControl, parseRampControl,       parsePaintControl, parseTextureControl,
      parseNearControl,   parseExpressionControl, parseGridControl};
  for (const auto& parser : kParsers)
    if (ControlSourcePtr source = parser(reader, option)) return source;
  reader.refuse(
      option,
      "a number, a ramp such as x:10:300:smooth, FILE.vdb[:GRID], paint:NAME:LOW:HIGH, texture:FILE:LOW:HIGH, "
      "near:FILE:DISTANCE:NEAR:FAR, or expr:TEXT");
}

}  // namespace vdbtools
