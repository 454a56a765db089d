// SPDX-License-Identifier: Apache-2.0
/// @file placed_target.h
/// Places a target as the options say, and makes the exponent of its shell and the other grids that maps read over it.
/// Parts that several scenes over one target share are made once.
#pragma once

#include "vdbtools/distance/target.h"
#include "vdbtools/exponent/exponent_grid.h"
#include "vdbtools/grain/grain.h"
#include "vdbtools/scene/scene.h"
#include "vdbtools/target/target_input.h"
#include "vdbtools/target/target_survey.h"

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace vdbtools {

/// Everything from which the exponent of a scene over a target is made. The exponent depends on nothing else, so scenes
/// with equal sources share it.
struct ExponentSources {
  SpaceOptions space;
  ShellSettings shell;
  Metadata controlFiles;  ///< the SHA-256 of the files that the shell's controls read
  julia::OrbitOptions orbit;
  double interiorReach = 0;  ///< MapSettings::interiorReach()
  bool isSmooth = false;     ///< whether E is read quadratically, unless the distances are too coarse for that

  bool operator==(const ExponentSources&) const = default;
};

/// @param hashes  the hashes of all files of the options
ExponentSources exponentSources(const FractalOptions& options, const ShellSettings& shell, const Metadata& hashes);

/// A target with its space and, if the map has a shell, its exponent.
struct PlacedTarget {
  PlacedSpace placed{};
  Target target;
  std::optional<SceneShell> shell{};
  bool isSurveyed = false;  ///< whether the target's survey was used for it
};

/// The parts of a target that all scenes over it share, each made when it is first requested. A part depends only on
/// the request, and not on earlier requests.
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
  /// The latest grids of grains, by everything that they depend on (grainOf()).
  std::vector<std::pair<std::string, GrainGrids>> grains{};
  std::string hash{};  ///< SHA-256 of the target

 private:
  struct Known {
    BandWidths widths;
    Target target;
  };

  /// Distances that include a band of @a widths.
  Known distances(const BandWidths& widths, Monitor& monitor) {
    if (mDistances) {
      // A second request for wider distances is usually followed by more. The distances are therefore computed over a
      // much wider band than requested.
      constexpr double kMore = 4;
      const BandWidths& known = mDistances->widths;
      BandWidths wide{known.exterior, known.interior, known.wholeInside || widths.wholeInside};
      if (widths.exterior > known.exterior) wide.exterior = std::max(widths.exterior, kMore * known.exterior);
      if (widths.interior > known.interior) wide.interior = std::max(widths.interior, kMore * known.interior);
      mDistances.reset();
      try {
        return {wide, mInput->distances(wide, monitor)};
      } catch (const MemoryError&) {            // the requested widths may fit nevertheless
      } catch (const std::invalid_argument&) {  // too many nodes for a band
      }
    }
    return {widths, mInput->distances(widths, monitor)};
  }

  TargetOptions mOptions;
  std::unique_ptr<const TargetInput> mInput;
  std::optional<TargetSurvey> mSurvey;
  std::optional<Known> mDistances;  ///< the widest that were requested
  std::optional<Known> mBand;       ///< the latest
};

/// The orbit that the options give; the exponent adds its trap.
julia::OrbitOptions orbitOf(const FractalOptions& options);

/// The slope of the thickness that goes with a shell.
double slopeOf(const std::optional<SceneShell>& shell);

PlacedTarget placeShell(const ExponentSources& sources, SharedTarget& shared, Monitor& monitor);

/// Places the target of a map without a shell. Its distances reach as far as the default shell needs.
PlacedTarget placeTarget(const FractalOptions& options, SharedTarget& shared, Monitor& monitor);

/// How fine the texture is at each place of the target.
/// @param voxel  of the result, world units; none: it is chosen later
OctaveGrid octaveOf(const ControlSetting& frequency, SharedTarget& shared, const PlacedTarget& target,
                    const std::optional<double>& voxel, Monitor& monitor);

/// The controls that the map reads over the target, in addition to the exponent and the octave.
/// @param voxel  of the result, world units, if it is known already
ControlGrids controlsOf(const MapSettings& map, SharedTarget& shared, const PlacedTarget& target,
                        const std::optional<double>& voxel, Monitor& monitor);

/// The map of a scene whose target, domain and place are set.
std::shared_ptr<const MapInstance> mapInstance(const Scene& scene, const MapFiles& files);

}  // namespace vdbtools
