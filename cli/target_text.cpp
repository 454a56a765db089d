// SPDX-License-Identifier: Apache-2.0
#include "target_text.h"

#include "report.h"

#include <set>
#include <sstream>

namespace cli {
namespace {

std::string targetText(const std::map<std::string, std::string>& metadata) {
  std::string text;
  if (const auto left = metadata.find("julia_points_left_out"); left != metadata.end())
    text += left->second == "1"
                ? "1 point of the target is left out: its coordinates are not finite, and no face uses it\n"
                : left->second +
                      " points of the target are left out: their coordinates are not finite, and no face uses them\n";
  if (const auto united = metadata.find("julia_united_parts"); united != metadata.end())
    text += united->second == "1"
                ? "the target runs into itself; its outer surface is what counts\n"
                : united->second +
                      " parts of the target run into each other; the outer surface of their union is what counts\n";
  const auto addParts = [&](const char* fact, const char* one, const char* several) {
    if (const auto found = metadata.find(fact); found != metadata.end())
      text += found->second + (found->second == "1" ? one : several) + '\n';
  };
  addParts("julia_hollows_filled", " hollow of the target is filled; --hollows keep makes it a cavity",
           " hollows of the target are filled; --hollows keep makes them cavities");
  addParts("julia_hollows_kept", " hollow of the target is a cavity", " hollows of the target are cavities");
  addParts("julia_inner_parts", " part of the target lies inside another and changes nothing",
           " parts of the target lie inside others and change nothing");
  if (const auto chosen = metadata.find("julia_chosen_iso"); chosen != metadata.end())
    text += "the target is a fog volume, and its surface is where it is " + chosen->second +
            ", half of its largest value; --iso sets another\n";
  if (const auto sides = metadata.find("julia_unequal_voxels"); sides != metadata.end())
    text += "the target's voxels have the sides " + sides->second + "; they were resampled to cubes of the smallest\n";
  return text;
}

}  // namespace

void tellTarget(const std::map<std::string, std::string>& metadata) {
  static std::set<std::string> told;
  std::istringstream lines(targetText(metadata));
  for (std::string line; std::getline(lines, line);)
    if (told.insert(line).second) report().text() << line << '\n';
}

}  // namespace cli
