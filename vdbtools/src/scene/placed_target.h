// SPDX-License-Identifier: Apache-2.0
/// @file placed_target.h
/// A target where the options place it, with the exponent of its shell and with what maps read over it. What several
/// scenes share of one target is made once.
#pragma once

#include "vdbtools/distance/target.h"
#include "vdbtools/exponent/exponent_grid.h"
#include "vdbtools/scene/scene.h"
#include "vdbtools/target/target_input.h"
#include "vdbtools/target/target_survey.h"

#include <memory>
#include <optional>
#include <string>
#include <utility>

namespace vdbtools {

/// All of a scene that its exponent over a target is made from, and nothing else is used to make it: so two scenes with
/// equal sources share one exponent.
struct ExponentSources {
  SpaceOptions space;
  ShellSettings shell;
  Metadata controlFiles;  ///< the SHA-256 of the files that the shell's controls read
  julia::OrbitOptions orbit;
  double interiorReach = 0;  ///< as MapSettings has it
  bool isSmooth = false;     ///< E is read quadratically unless the distances are too coarse for that

  bool operator==(const ExponentSources&) const = default;
};

/// @param hashes  those of all files of the options
ExponentSources exponentSources(const FractalOptions& options, const ShellSettings& shell, const Metadata& hashes);

/// A target with its space and, if the map has a shell, its exponent.
struct PlacedTarget {
  PlacedSpace placed{};
  Target target;
  std::optional<SceneShell> shell{};
  bool isSurveyed = false;  ///< the target's survey was used for it
};

/// What one target gives to all scenes over it, each part made when it is first asked for. What it gives depends on
/// what is asked for alone, and not on what was asked for before.
class SharedTarget {
 public:
  SharedTarget(const TargetOptions& options, const TargetOpener& open, Monitor& monitor)
      : mOptions(options), mInput(open(options, monitor)) {}

  const TargetOptions& options() const { return mOptions; }
  const TargetInput& input() const { return *mInput; }

  TargetSurvey& survey(Monitor& monitor) {
    if (!mSurvey) {
      CoarseDistances coarse = mInput->coarseDistances(monitor);
      mSurvey.emplace(std::move(coarse.phi), mInput->solid(), std::move(coarse.thickness));
    }
    return *mSurvey;
  }

  /// The fine distances in a band of these widths.
  const Target& band(const BandWidths& widths, Monitor& monitor) {
    if (mBand && mBand->widths == widths) return mBand->target;
    mBand.reset();
    if (!mDistances || !mDistances->widths.holds(widths)) mDistances = distances(widths, monitor);
    mBand = Known{widths, mInput->band(mDistances->target, widths, monitor)};
    return mBand->target;
  }

  /// The latest exponent, for scenes that differ in their maps only.
  struct Placed {
    ExponentSources sources;
    PlacedTarget target;
  };
  std::optional<Placed> placed{};
  std::string hash{};  ///< SHA-256 of the target

 private:
  struct Known {
    BandWidths widths;
    Target target;
  };

  /// Distances that hold a band of @a widths.
  Known distances(const BandWidths& widths, Monitor& monitor) {
    if (mDistances) {
      // Whoever asks again will ask for more once more: what is made again is made much wider.
      constexpr double kMore = 4;
      const BandWidths& known = mDistances->widths;
      BandWidths wide{known.exterior, known.interior, known.wholeInside || widths.wholeInside};
      if (widths.exterior > known.exterior) wide.exterior = std::max(widths.exterior, kMore * known.exterior);
      if (widths.interior > known.interior) wide.interior = std::max(widths.interior, kMore * known.interior);
      mDistances.reset();
      try {
        return {wide, mInput->distances(wide, monitor)};
      } catch (const MemoryError&) {            // what is asked for may fit nevertheless
      } catch (const std::invalid_argument&) {  // more nodes than a band may have
      }
    }
    return {widths, mInput->distances(widths, monitor)};
  }

  TargetOptions mOptions;
  std::unique_ptr<const TargetInput> mInput;
  std::optional<TargetSurvey> mSurvey;
  std::optional<Known> mDistances;  ///< the widest that were asked for
  std::optional<Known> mBand;       ///< the latest
};

/// The orbit that the options give; the exponent adds its trap.
julia::OrbitOptions orbitOf(const FractalOptions& options);

/// The slope of the thickness that goes with a shell.
double slopeOf(const std::optional<SceneShell>& shell);

PlacedTarget placeShell(const ExponentSources& sources, SharedTarget& shared, Monitor& monitor);

/// For a map without a shell, which gets the distances of the usual one.
PlacedTarget placeTarget(const FractalOptions& options, SharedTarget& shared, Monitor& monitor);

/// How fine the texture is at each place of the target.
/// @param voxel  of the result, world units; none: it is chosen later
OctaveGrid octaveOf(const ControlSetting& frequency, SharedTarget& shared, const PlacedTarget& target,
                    const std::optional<double>& voxel, Monitor& monitor);

/// What the map reads over the target, besides the exponent and the octave.
/// @param voxel  of the result, world units, if it is known already
ControlGrids controlsOf(const MapSettings& map, SharedTarget& shared, const PlacedTarget& target,
                        const std::optional<double>& voxel, Monitor& monitor);

/// The map at work in a scene that has its target, its domain and its place.
std::shared_ptr<const MapInstance> mapInstance(const Scene& scene, const MapFiles& files);

}  // namespace vdbtools
