// SPDX-License-Identifier: Apache-2.0
#include "farm/target_store.h"

#include "target/solid_input.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/files/atomic_file.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/files/file_hash.h"
#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/recipe/option_value.h"

#include <cmath>
#include <limits>
#include <optional>
#include <system_error>
#include <utility>

namespace vdbtools {
namespace {

namespace fs = std::filesystem;
using openvdb::FloatGrid;

constexpr const char* kMoved = "julia_repair_moved";
constexpr const char* kGrid = "phi";

/// The least power of the square root of 2 that is not below a width.
double rounded(double width) {
  if (!(width > 0) || !std::isfinite(width)) return width;
  return std::exp2(std::ceil(2 * std::log2(width)) / 2);
}

/// A mesh's distances, from a folder where they are there.
class KeptTarget final : public TargetInput {
 public:
  KeptTarget(std::unique_ptr<const TargetInput> input, const TargetOptions& options, fs::path folder)
      : mInput(std::move(input)),
        mFolder(std::move(folder)),
        mKey(options.input.expectedHash + ' ' + numbersText({options.sdfVoxels.sizeFor(longestSide(mInput->box()))}) +
             ' ' + mendText(options.mend)) {}

  const openvdb::BBoxd& box() const override { return mInput->box(); }
  double usualDepth() const override { return mInput->usualDepth(); }
  std::shared_ptr<const Mesh> mesh() const override { return mInput->mesh(); }

  Target make(const BandWidths& widths, Monitor& monitor) const override {
    const BandWidths wide{rounded(widths.exterior), rounded(widths.interior)};
    const std::string name = "band " + numbersText({wide.exterior, wide.interior});
    if (std::optional<Target> kept = read(name)) return *std::move(kept);
    Target target = mInput->make(wide, monitor);
    keep(name, target.phi, target.repairMoved);
    return target;
  }

  Target deepened(const Target&, const BandWidths& widths, Monitor& monitor) const override {
    return make({widths.exterior, std::numeric_limits<double>::infinity()}, monitor);
  }

  FloatGrid::ConstPtr coarseDistances(Monitor& monitor) const override {
    if (std::optional<Target> kept = read("coarse")) return kept->phi;
    FloatGrid::ConstPtr coarse = mInput->coarseDistances(monitor);
    keep("coarse", openvdb::gridPtrCast<FloatGrid>(coarse->deepCopyGrid()), {});
    return coarse;
  }

 private:
  fs::path pathOf(const std::string& name) const {
    constexpr std::size_t kDigits = 16;
    return mFolder / (sha256Hex(mKey + ' ' + name).substr(0, kDigits) + ".vdb");
  }
  static fs::path hashPathOf(const fs::path& path) { return fs::path(path).replace_extension(".sha256"); }

  std::optional<Target> read(const std::string& name) const {
    const fs::path path = pathOf(name);
    try {
      if (readWholeFile(hashPathOf(path)) != sha256OfFile(path) + '\n') return std::nullopt;
      const VdbFile file = readVdb(path);
      Target target{.phi = chooseFloatGrid(file, kGrid, path), .box = box()};
      if (const auto moved = file.metadata.find(kMoved); moved != file.metadata.end())
        target.repairMoved = parseNumber(kMoved, moved->second);
      return target;
    } catch (const std::runtime_error&) {
      return std::nullopt;  // not there, or not whole yet
    }
  }

  void keep(const std::string& name, const FloatGrid::Ptr& phi, const std::optional<double>& moved) const {
    try {
      std::error_code error;
      fs::create_directories(mFolder, error);
      const fs::path path = pathOf(name);
      FloatGrid::Ptr grid = phi->copy();
      grid->setName(kGrid);
      VdbWriteOptions options;
      if (moved) options.metadata[kMoved] = numbersText({*moved});
      const std::string bytes = encodeVdb({grid}, options);
      AtomicFile file(path), hash(hashPathOf(path));
      file.stream() << bytes;
      hash.stream() << sha256Hex(bytes) << '\n';
      file.commit();
      hash.commit();
    } catch (const std::runtime_error&) {
      // It only saves time.
    }
  }

  std::unique_ptr<const TargetInput> mInput;
  fs::path mFolder;
  std::string mKey;
};

}  // namespace

TargetOpener targetsKeptIn(fs::path folder) {
  return [folder = std::move(folder)](const TargetOptions& options) -> std::unique_ptr<const TargetInput> {
    std::unique_ptr<const TargetInput> input = openTarget(options);
    if (!input->mesh() || options.input.expectedHash.empty()) return input;
    return std::make_unique<KeptTarget>(std::move(input), options, folder);
  };
}

}  // namespace vdbtools
