// SPDX-License-Identifier: Apache-2.0
// A FloatGrid, read trilinearly in its own world space.
#include "target/control_kinds.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/formats/vdb_file.h"

#include <openvdb/tools/Interpolation.h>

#include <algorithm>
#include <cmath>

namespace vdbtools {
namespace {

using openvdb::FloatGrid;

class GridField final : public ControlField {
 public:
  explicit GridField(FloatGrid::ConstPtr grid) : mGrid(std::move(grid)) {
    mLeast = mMost = mGrid->background();
    for (auto value = mGrid->tree().cbeginValueAll(); value; ++value) {
      if (!std::isfinite(*value))
        throw DataError("the grid '" + mGrid->getName() + "' holds a value that is not finite");
      mLeast = std::min(mLeast, *value);
      mMost = std::max(mMost, *value);
    }
  }

  void sample(std::span<const openvdb::Vec3d> points, std::span<double> values) const override {
    const FloatGrid::ConstAccessor accessor = mGrid->getConstAccessor();
    for (std::size_t i = 0; i < points.size(); ++i)
      // Interpolation may leave the range by a rounding.
      values[i] =
          std::clamp(openvdb::tools::BoxSampler::sample(accessor, mGrid->worldToIndex(points[i])), mLeast, mMost);
  }
  std::pair<double, double> range() const override { return {mLeast, mMost}; }

 private:
  FloatGrid::ConstPtr mGrid;
  float mLeast = 0, mMost = 0;  ///< of the background, too, which lies anywhere
};

class GridSource final : public ControlSource {
 public:
  GridSource(NamedFile file, std::string grid, std::string text)
      : mFile(std::move(file)), mGrid(std::move(grid)), mText(std::move(text)) {}
  std::string text() const override { return mText; }
  std::vector<NamedFile> files() const override { return {mFile}; }
  Control bind(const ControlContext&) const override {
    return Control(FloatGrid::ConstPtr(chooseFloatGrid(readVdb(mFile.path), mGrid, mFile.path)));
  }

 private:
  NamedFile mFile;
  std::string mGrid;  ///< its name; empty: the only one
  std::string mText;
};

}  // namespace

Control::Control(FloatGrid::ConstPtr grid) : mField(std::make_shared<GridField>(std::move(grid))) {}

ControlSourcePtr parseGridControl(const RecipeReader& reader, const std::string& option) {
  const std::string text = reader.text(option);
  if (isVdbPath(text)) return std::make_shared<GridSource>(reader.file(option, text), "", text);
  const std::size_t colon = text.rfind(':');
  if (colon == std::string::npos || !isVdbPath(text.substr(0, colon))) return nullptr;
  return std::make_shared<GridSource>(reader.file(option, text.substr(0, colon)), text.substr(colon + 1), text);
}

}  // namespace vdbtools
