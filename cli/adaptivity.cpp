// SPDX-License-Identifier: Apache-2.0
#include "adaptivity.h"

#include <cmath>

namespace po = boost::program_options;

namespace cli {

void addAdaptivity(CommandLine& line) {
  line.addOptions()(
      "adaptivity", po::value<std::string>()->value_name("E"),
      "make triangles of the mesh larger where the surface is flat: neither it nor the full mesh is anywhere farther "
      "than E voxels from the other, which is proved. The mesh is held in "
      "memory (default: 0)");
}

double parseAdaptivity(const CommandLine& line) {
  if (!line.has("adaptivity")) return 0;
  const double value = line.number("adaptivity");
  constexpr double kMost = 100;  // voxels
  if (!(value >= 0 && value <= kMost)) line.refuse("adaptivity", "a number of voxels from 0 to 100");
  return value;
}

}  // namespace cli
