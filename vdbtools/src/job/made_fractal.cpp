// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/job/fractal_job.h"

#include "vdbtools/files/file_bytes.h"
#include "vdbtools/formats/file_formats.h"
#include "vdbtools/mesh/mesh.h"
#include "vdbtools/mesh_files/mesh_reader.h"
#include "vdbtools/scene/fractal_options.h"

#include <algorithm>
#include <exception>
#include <fstream>
#include <system_error>

namespace vdbtools {
namespace {

/// Whether a file ends with a complete line. A line that was cut off may still be valid, such as a number without its
/// last digits.
bool endsWithItsLine(const std::filesystem::path& path) {
  std::ifstream file = openToRead(path);
  file.seekg(-1, std::ios::end);
  return file.get() == '\n';
}

}  // namespace

bool holdsFractal(const std::filesystem::path& path, const Recipe& recipe) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return false;
  const auto isTheRecipe = [&](const std::map<std::string, std::string>& metadata) {
    const std::map<std::string, std::string> expected = recipeToMetadata(recipe, "fractal");
    const bool hasAll = std::all_of(expected.begin(), expected.end(), [&](const auto& entry) {
      const auto found = metadata.find(entry.first);
      return found != metadata.end() && found->second == entry.second;
    });
    return hasAll && recipeFromMetadata(metadata, fractalOptionTable()) == recipe;
  };
  try {
    const FileFormat* const format = findFormat(path.native());
    if (!format || !format->recipe || (format->endsUnmarked && !endsWithItsLine(path))) return false;
    // The recipe stands at the beginning: it tells most other files before the rest is read.
    if (!isTheRecipe(readFileTexts(path))) return false;
    return format->readsGrids ? !readVdb(path).grids.empty() : !readMesh(path).triangles.empty();
  } catch (const std::exception&) {
    return false;  // broken, or not made by this program
  }
}

}  // namespace vdbtools
