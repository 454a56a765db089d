// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/farm/plans.h"

#include "scene/file_hashes.h"

#include "vdbtools/files/frames.h"
#include "vdbtools/scene/fractal_options.h"
#include "vdbtools/scene/scene.h"

#include <stdexcept>
#include <utility>

namespace vdbtools::farm {

struct FrameRecipes::Hashes {
  FileHashes files;
};

FrameRecipes::FrameRecipes(FramePlanOptions options)
    : mOptions(std::move(options)), mHashes(std::make_unique<Hashes>()) {
  requireKeysWithoutPatterns(mOptions);
  const OptionTable table = fractalOptionTable();
  FrameInputs files;
  for (const int frame : mOptions.frames) {
    try {
      const FractalOptions fractal = parseFractalOptions(completeRecipe(recipeAt(mOptions, frame), table));
      requireTarget(fractal);
      for (const NamedFile& file : filesOf(fractal)) files.add(file.path, frame);
    } catch (const std::invalid_argument& error) {
      throw std::invalid_argument("frame " + std::to_string(frame) + ": " + error.what());
    }
  }
  files.requireNoneMissing();
  mInputs = files.files();
}

FrameRecipes::~FrameRecipes() = default;

Recipe FrameRecipes::at(int frame) const {
  Recipe recipe = completeRecipe(recipeAt(mOptions, frame), fractalOptionTable());
  for (const auto& [name, hash] : mHashes->files.of(parseFractalOptions(recipe))) recipe[name] = hash;
  return recipe;
}

}  // namespace vdbtools::farm
