// SPDX-License-Identifier: Apache-2.0
#include "slice_plane.h"

#include <algorithm>
#include <stdexcept>

namespace po = boost::program_options;

namespace cli {
namespace {

vdbtools::Axis parseAxis(const std::string& text) {
  if (text == "x") return vdbtools::Axis::X;
  if (text == "y") return vdbtools::Axis::Y;
  if (text == "z") return vdbtools::Axis::Z;
  throw std::invalid_argument("--axis is '" + text + "'; it must be one of x, y, z");
}

}  // namespace

void addPlaneOptions(CommandLine& line, const std::string& usual) {
  const std::string position = "where the plane cuts the axis, in the target's units (default: " + usual + ")";
  line.addOptions()("axis", po::value<std::string>()->default_value("z")->value_name("x|y|z"),
                    "the axis across the plane")("position", po::value<std::string>()->value_name("P"),
                                                 position.c_str())(
      "size", po::value<std::string>()->default_value("800")->value_name("N"), "pixels along the longer side");
}

PlanePlacement parsePlacement(const CommandLine& line) {
  PlanePlacement placement{parseAxis(line.text("axis")), {}, 0};
  if (line.has("position")) placement.position = vdbtools::parseNumber("position", line.text("position"));
  const double size = vdbtools::parseNumber("size", line.text("size"));
  if (!(size >= 1 && size <= 32768))
    throw std::invalid_argument("--size is '" + line.text("size") + "'; it must be 1 to 32768");
  placement.size = static_cast<int>(size);
  return placement;
}

openvdb::BBoxd frameOf(const vdbtools::Scene& scene) {
  constexpr double kAir = 0.08;  // of the target's longest side
  if (scene.options.box) return *scene.options.box;
  if (!scene.target) return scene.region;
  openvdb::BBoxd box = scene.target->box;
  const openvdb::Vec3d extents = box.extents();
  box.expand(kAir * std::max({extents[0], extents[1], extents[2]}));
  return box;
}

}  // namespace cli
