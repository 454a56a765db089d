// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/farm/frame_recipes.h"

#include "scene/file_hashes.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/files/standard_streams.h"
#include "vdbtools/scene/fractal_options.h"
#include "vdbtools/scene/scene.h"

#include <filesystem>
#include <set>
#include <stdexcept>
#include <system_error>
#include <utility>

namespace vdbtools::farm {
namespace {

/// The files of all frames and, for missing ones, the first frame that names each.
class FilesOfFrames {
 public:
  explicit FilesOfFrames(InputFiles& inputs) : mInputs(inputs) {}

  void add(const NamedFile& file, int frame) {
    if (!mKnown.insert(file.path).second) return;
    mInputs.add(file.path);
    std::error_code error;
    if (std::filesystem::exists(pathToOpen(file.path), error)) return;
    ++mCount;
    constexpr std::size_t kMostNamed = 3;
    if (mCount <= kMostNamed)
      mNames += (mNames.empty() ? "'" : ", '") + file.path.string() + "' (frame " + std::to_string(frame) + ")";
  }
  /// @throw MissingInputError
  void requireNoneMissing() const {
    if (mCount == 0) return;
    throw MissingInputError(mCount == 1 ? "an input of the sequence is missing: " + mNames
                                        : std::to_string(mCount) +
                                              " inputs of the sequence are missing, the first of "
                                              "them " +
                                              mNames);
  }

 private:
  InputFiles& mInputs;
  std::set<std::filesystem::path> mKnown;
  std::size_t mCount = 0;
  std::string mNames;
};

}  // namespace

struct FrameRecipes::Hashes {
  FileHashes files;
};

FrameRecipes::FrameRecipes(FramePlanOptions options)
    : mOptions(std::move(options)), mHashes(std::make_unique<Hashes>()) {
  requireChange(mOptions);
  const OptionTable table = fractalOptionTable();
  FilesOfFrames files(mInputs);
  for (const int frame : mOptions.frames) {
    try {
      const FractalOptions fractal = parseFractalOptions(completeRecipe(recipeAt(mOptions, frame), table));
      requireTarget(fractal);
      for (const NamedFile& file : filesOf(fractal)) files.add(file, frame);
    } catch (const std::invalid_argument& error) {
      throw std::invalid_argument("frame " + std::to_string(frame) + ": " + error.what());
    }
  }
  files.requireNoneMissing();
}

FrameRecipes::~FrameRecipes() = default;

Recipe FrameRecipes::at(int frame) const {
  Recipe recipe = completeRecipe(recipeAt(mOptions, frame), fractalOptionTable());
  for (const auto& [name, hash] : mHashes->files.of(parseFractalOptions(recipe))) recipe[name] = hash;
  return recipe;
}

}  // namespace vdbtools::farm
