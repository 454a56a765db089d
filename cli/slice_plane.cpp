// SPDX-License-Identifier: Apache-2.0
#include "slice_plane.h"

namespace po = boost::program_options;

namespace cli {
void addPlaneOptions(CommandLine& line, const std::string& usual) {
  const std::string position = "where the plane cuts the axis, in the target's units (default: " + usual + ")";
  line.addOptions()("axis", po::value<std::string>()->default_value("z")->value_name("x|y|z"),
                    "the axis that is perpendicular to the plane")(
      "position", po::value<std::string>()->value_name("P"), position.c_str())(
      "size", po::value<std::string>()->default_value("800")->value_name("N"), "pixels along the longer side");
}

PlanePlacement parsePlacement(const CommandLine& line) {
  using vdbtools::Axis;
  PlanePlacement placement;
  placement.axis = line.choice<Axis>("axis", {{"x", Axis::X}, {"y", Axis::Y}, {"z", Axis::Z}});
  if (line.has("position")) placement.position = line.number("position");
  placement.size = line.integer("size", 1, vdbtools::kMostSlicePixels);
  return placement;
}

}  // namespace cli
