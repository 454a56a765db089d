// SPDX-License-Identifier: Apache-2.0
// A FloatGrid, read trilinearly in its own world space.
#include "control/control_kinds.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/control/control.h"
#include "vdbtools/formats/vdb_file.h"

#include <cmath>

namespace vdbtools {
namespace {

using openvdb::FloatGrid;

FloatGrid::ConstPtr finite(FloatGrid::ConstPtr grid) {
  for (auto value = grid->tree().cbeginValueAll(); value; ++value)
    if (!std::isfinite(*value)) throw DataError("the grid '" + grid->getName() + "' holds a value that is not finite");
  return grid;
}

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

Control::Control(FloatGrid::ConstPtr grid) : Control(clampedControl(finite(std::move(grid)), std::nullopt)) {}

ControlSourcePtr parseGridControl(const RecipeReader& reader, const std::string& option) {
  const std::string text = reader.text(option);
  if (isVdbPath(text)) return std::make_shared<GridSource>(reader.file(option, text), "", text);
  const std::size_t colon = text.rfind(':');
  if (colon == std::string::npos || !isVdbPath(text.substr(0, colon))) return nullptr;
  return std::make_shared<GridSource>(reader.file(option, text.substr(0, colon)), text.substr(colon + 1), text);
}

}  // namespace vdbtools
