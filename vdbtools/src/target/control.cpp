// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/target/control.h"

#include "target/control_kinds.h"

namespace vdbtools {

double Control::at(const openvdb::Vec3d& point) const {
  double value = 0;
  sample({&point, 1}, {&value, 1});
  return value;
}

std::shared_ptr<const ControlSource> parseControl(const RecipeReader& reader, const std::string& option) {
  constexpr ControlSourcePtr (*kParsers[])(const RecipeReader&, const std::string&) = {
      parseNumberControl, parseRampControl, parseGridControl};
  for (const auto& parser : kParsers)
    if (ControlSourcePtr source = parser(reader, option)) return source;
  reader.refuse(option, "a number, a ramp such as x:10:300:smooth, or FILE.vdb[:GRID]");
}

}  // namespace vdbtools
