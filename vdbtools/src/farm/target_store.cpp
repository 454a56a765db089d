// SPDX-License-Identifier: Apache-2.0
#include "farm/target_store.h"

#include "base/elementary.h"
#include "distance/united_parts.h"
#include "repair/solid_input.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/base/memory.h"
#include "vdbtools/base/text.h"
#include "vdbtools/files/atomic_file.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/files/named_file.h"
#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/recipe/option_value.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <system_error>
#include <utility>

namespace vdbtools::farm {
namespace {

namespace fs = std::filesystem;
using openvdb::FloatGrid;

constexpr const char* kMoved = "julia_repair_moved";
constexpr const char *kLattice = "julia_lattice", *kWidths = "julia_band_widths";
constexpr const char *kInside = "inside", *kWholeInside = "whole";
constexpr const char* kGrid = "phi";
constexpr std::size_t kKeyDigits = 16;

/// The smallest power of the square root of 2 that is not below a width.
double rounded(double width) {
  if (!(width > 0) || !std::isfinite(width)) return width;
  return elementary::exp2(std::ceil(2 * elementary::log2(width)) / 2);
}

/// The width of a side of the band that also serves later tasks.
double generous(double wanted, double kept) { return rounded(wanted > kept ? std::max(wanted, 2 * kept) : kept); }

/// Distances in the store.
struct KeptBand {
  Target target;
  BandWidths widths;
};

/// A mesh's distances, read from a folder if they are there.
class KeptTarget final : public TargetInput {
 public:
  KeptTarget(std::unique_ptr<const TargetInput> input, fs::path folder, std::string key,
             std::function<bool(const std::string&)> keeps)
      : mInput(std::move(input)), mFolder(std::move(folder)), mKey(std::move(key)), mKeeps(std::move(keeps)) {}

  const openvdb::BBoxd& box() const override { return mInput->box(); }
  double usualDepth() const override { return mInput->usualDepth(); }
  std::optional<double> chosenSdfResolution(Monitor& monitor) const override {
    return mInput->chosenSdfResolution(monitor);
  }
  std::shared_ptr<const Mesh> solid() const override { return mInput->solid(); }
  std::shared_ptr<const Mesh> mesh() const override { return mInput->mesh(); }

  Target distances(const BandWidths& widths, Monitor& monitor) const override {
    std::optional<KeptBand> kept = readBand(pathOf("band"));
    if (kept && kept->widths.holds(widths)) return std::move(kept->target);
    const BandWidths before = kept ? kept->widths : BandWidths();
    kept.reset();
    // Nothing is stored if a band wider than requested takes too much.
    try {
      const BandWidths wide{generous(widths.exterior, before.exterior), generous(widths.interior, before.interior),
                            widths.wholeInside || before.wholeInside};
      Target target = mInput->distances(wide, monitor);
      keep(pathOf("band"), target, wide);
      return target;
    } catch (const MemoryError&) {
    } catch (const std::invalid_argument&) {
    }
    return mInput->distances(widths, monitor);
  }

  Target band(const Target& distances, const BandWidths& widths, Monitor& monitor) const override {
    return mInput->band(distances, widths, monitor);
  }
  Target bandOf(double voxel, const BandWidths& widths, Monitor& monitor) const override {
    return mInput->bandOf(voxel, widths, monitor);
  }

  CoarseDistances coarseDistances(Monitor& monitor) const override {
    const fs::path path = pathOf("survey");
    if (std::optional<KeptBand> kept = readBand(path)) return {kept->target.phi};
    CoarseDistances coarse = mInput->coarseDistances(monitor);
    keep(path, {.phi = std::const_pointer_cast<FloatGrid>(coarse.phi), .box = {}}, {});
    return coarse;
  }

 private:
  fs::path pathOf(const std::string& name) const { return mFolder / (mKey + '.' + name + ".vdb"); }
  static fs::path hashPathOf(const fs::path& path) { return fs::path(path).replace_extension(".sha256"); }

  std::optional<KeptBand> readBand(const fs::path& path) const {
    try {
      if (readWholeFile(hashPathOf(path)) != sha256OfFile(path) + '\n') return std::nullopt;
      const VdbFile file = readVdb(path);
      KeptBand kept{.target = {.phi = chooseFloatGrid(file, kGrid, path), .box = box()}, .widths = {}};
      placeOnLattice(*kept.target.phi, file.metadata.at(kLattice));
      if (const auto moved = file.metadata.find(kMoved); moved != file.metadata.end())
        kept.target.repairMoved = parseNumber(kMoved, moved->second);
      for (const char* fact : kPartFacts)
        if (const auto found = file.metadata.find(fact); found != file.metadata.end())
          kept.target.phi->insertMeta(fact, openvdb::StringMetadata(found->second));
      if (const auto found = file.metadata.find(kWidths); found != file.metadata.end()) {
        const std::vector<std::string> both = split(found->second, ',');
        const auto width = [&](std::size_t i) { return numberFromText(both.at(i)).value(); };
        kept.widths = {width(0), width(1), both.at(2) == kWholeInside};
      }
      return kept;
    } catch (const std::exception&) {
      return std::nullopt;  // missing, incomplete, or broken
    }
  }

  void keep(const fs::path& path, const Target& target, const BandWidths& widths) const {
    if (!mKeeps(mKey)) return;
    try {
      std::error_code error;
      fs::create_directories(mFolder, error);
      FloatGrid::Ptr grid = target.phi->copy();
      grid->setName(kGrid);
      VdbWriteOptions options{.metadata = {{kLattice, latticeText(*target.phi)}}};
      options.metadata[kWidths] =
          numbersText({widths.exterior, widths.interior}) + ',' + (widths.wholeInside ? kWholeInside : kInside);
      if (target.repairMoved) options.metadata[kMoved] = numbersText({*target.repairMoved});
      for (const char* fact : kPartFacts)
        if (const auto found = (*target.phi)[fact]) options.metadata[fact] = found->str();
      const std::string bytes = encodeVdb({grid}, options);
      AtomicFile file(path), hash(hashPathOf(path));
      file.stream() << bytes;
      hash.stream() << sha256Hex(bytes) << '\n';
      AtomicFile* const both[] = {&file, &hash};
      commitAll(both);
    } catch (const std::runtime_error&) {
      // The store only saves time.
    }
  }

  std::unique_ptr<const TargetInput> mInput;
  fs::path mFolder;
  std::string mKey;
  std::function<bool(const std::string&)> mKeeps;
};

std::string voxelsText(const std::optional<VoxelChoice>& voxels) {
  if (!voxels) return " voxels as needed";
  if (voxels->voxelSize) return " voxels of " + numbersText({*voxels->voxelSize});
  return " voxels " + numbersText({voxels->resolution.value()});
}

}  // namespace

std::string targetKey(const TargetOptions& options) {
  if (options.input.expectedHash.empty() || (!options.mesh && isVdbPath(options.input.path))) return {};
  const std::string text =
      options.input.expectedHash + lowerExtension(options.input.path) + voxelsText(options.sdfVoxels) + ' ' +
      mendText(options.mend) +
      (options.moment ? " at " + numbersText({options.moment->seconds}) + ' ' + options.moment->animation : "");
  return sha256Hex(text).substr(0, kKeyDigits);
}

TargetOpener targetsKeptIn(fs::path folder, std::function<bool(const std::string& key)> keeps) {
  return [folder = std::move(folder), keeps = std::move(keeps)](
             const TargetOptions& options, Monitor& monitor) -> std::unique_ptr<const TargetInput> {
    std::unique_ptr<const TargetInput> input = openTarget(options, monitor);
    std::string key = targetKey(options);
    if (key.empty()) return input;
    return std::make_unique<KeptTarget>(std::move(input), folder, std::move(key), keeps);
  };
}

std::set<std::string> keptTargets(const fs::path& folder) {
  std::set<std::string> keys;
  std::error_code error;
  const fs::directory_iterator end;
  for (fs::directory_iterator entry(folder, error); !error && entry != end; entry.increment(error)) {
    const std::string name = entry->path().filename().native();
    if (name.find('.') == kKeyDigits) keys.insert(name.substr(0, kKeyDigits));
  }
  return keys;
}

void removeKeptTargets(const fs::path& folder, const std::set<std::string>& keys) {
  std::error_code error;
  std::vector<fs::path> files;
  const fs::directory_iterator end;
  for (fs::directory_iterator entry(folder, error); !error && entry != end; entry.increment(error))
    if (keys.contains(entry->path().filename().native().substr(0, kKeyDigits))) files.push_back(entry->path());
  for (const fs::path& file : files) fs::remove(file, error);
  // Fails, as intended, if another process stores something there.
  fs::remove(folder, error);
}

}  // namespace vdbtools::farm
