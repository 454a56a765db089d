// SPDX-License-Identifier: Apache-2.0
#include "scene/placed_target.h"

#include "control/control_lattice.h"
#include "scene/scene_grain.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/base/fractal_space.h"
#include "vdbtools/base/text.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/maps/versor_options.h"

#include "julia/detail.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace vdbtools {
namespace {

using openvdb::FloatGrid;

/// Binds a control to the target. If the control is a grid from a file, checks its values against @a range here,
/// because wrong values are then the file's fault (DataError). The values of all other controls are checked where they
/// are used, and are reported as a wrong option.
/// @throw DataError  a value of the grid is outside the range
Control bound(const ControlSource& source, const ControlContext& context, const std::string& name,
              const std::pair<double, double>& range) {
  Control control = source.bind(context);
  const std::vector<NamedFile> files = source.files();
  if (files.size() != 1 || !isVdbPath(files.front().path)) return control;
  const auto [least, most] = control.range();
  if (least < range.first || most > range.second)
    throw DataError(name + " is " + shortText(least < range.first ? least : most) + " somewhere in '" +
                    inOneLine(files.front().path.string()) + "'; it must be " +
                    (std::isfinite(range.second) ? "from 0 to 1" : "above 0") + " everywhere");
  return control;
}

/// Whether a control of the shell depends on the target's distances.
bool readsTarget(const ShellSettings& shell) {
  const std::vector<ControlSetting> controls = shell.controls();
  return std::any_of(controls.begin(), controls.end(), [](const auto& control) { return control->needsTarget(); });
}

/// Binds the controls of a shell to the target.
ExponentGridOptions bindControls(const ExponentSources& sources, SharedTarget& shared, const PlacedSpace& placed,
                                 Monitor& monitor) {
  const ShellSettings& shell = sources.shell;
  const ControlContext context = controlContext(readsTarget(shell), shared, placed, monitor);
  const std::pair positive(std::numeric_limits<double>::min(), std::numeric_limits<double>::infinity());
  constexpr double kRounding = 1e-5;  // of values that are read between nodes
  const std::pair share(-kRounding, 1 + kRounding);
  ExponentGridOptions exponent{.orbit = sources.orbit,
                               .interpolation = shell.interpolation.value(),
                               .mask = bound(*shell.mask, context, "the mask", share)};
  if (!shell.detail) {
    exponent.alpha = bound(*shell.alpha, context, "alpha", positive);
    exponent.beta = shell.beta->bind(context);
    return exponent;
  }
  Control detail = bound(*shell.detail, context, "the detail", share);
  const double slope = thicknessSlope(detail.range().second);
  const LocalThickness thickness = shared.survey(monitor).thickness(monitor, slope);
  exponent.detail = DetailOptions{.detail = std::move(detail),
                                  .outward = bound(*shell.outward, context, "the outward reach", share),
                                  .thickness = thicknessControl(thickness),
                                  .greatestThickness = thickness.greatest,
                                  .origin = placed.unmoved.centre};
  return exponent;
}

/// How far from the surface distances are computed at first.
/// @param mapReach  MapSettings::interiorReach()
BandWidths widthsOf(const SpaceOptions& space, double mapReach, const TargetInput& input,
                    const ExponentGridOptions& shell) {
  const double others = mapReach * longestSide(input.box());
  if (shell.detail) {
    const DetailReach reach = detailReach(shell);
    return {.exterior = reach.outside, .interior = std::max(reach.inside, others)};
  }
  const double scale = spaceScale(space, input.box());
  return {.exterior = exteriorReach(shell) * scale,
          .interior = std::max(interiorReach(shell, input.usualDepth()) * scale, others)};
}

}  // namespace

ControlContext controlContext(bool needsTarget, SharedTarget& shared, const PlacedSpace& placed, Monitor& monitor) {
  ControlContext context{.targetBox = shared.input().box(), .mesh = shared.input().mesh()};
  if (!needsTarget) return context;
  context.space = placed.unmoved;
  context.phi = shared.survey(monitor).phi();
  context.tau = [&] { return FloatGrid::ConstPtr(shared.survey(monitor).thickness(monitor).tau); };
  return context;
}

julia::OrbitOptions orbitOf(const FractalOptions& options) {
  julia::OrbitOptions orbit = options.map->orbit();
  orbit.confirmTrap = options.lattice.exhaustive;
  return orbit;
}

ExponentSources exponentSources(const FractalOptions& options, const ShellSettings& shell, const Metadata& hashes) {
  ExponentSources sources{.space = options.space,
                          .shell = shell,
                          .controlFiles = {},
                          .orbit = orbitOf(options),
                          .interiorReach = options.map->interiorReach()};
  sources.isSmooth = options.picture;
  if (!shell.interpolation)
    sources.shell.interpolation = sources.isSmooth ? julia::Interpolation::Quadratic : julia::Interpolation::Trilinear;
  for (const ControlSetting& control : shell.controls())
    for (const NamedFile& file : control->files())
      sources.controlFiles[metadataName(file.recordedAs)] = hashes.at(metadataName(file.recordedAs));
  return sources;
}

double slopeOf(const std::optional<SceneShell>& shell) {
  const bool hasDetail = shell && shell->made && shell->made->options.detail;
  return hasDetail ? thicknessSlope(shell->made->options.detail->detail.range().second) : kThicknessSlope;
}

OctaveGrid octaveOf(const ControlSetting& frequency, SharedTarget& shared, const PlacedTarget& target,
                    const std::optional<double>& voxel, Monitor& monitor) {
  const ControlContext context = controlContext(frequency->needsTarget(), shared, target.placed, monitor);
  const std::pair positive(std::numeric_limits<double>::min(), std::numeric_limits<double>::infinity());
  const Control control = bound(*frequency, context, "the frequency", positive);
  const LocalThickness thickness = shared.survey(monitor).thickness(monitor, slopeOf(target.shell));
  constexpr double kLeast = 2;  // voxels across a feature that is visible
  constexpr double kFine = 4;   // a part may be thinner than the voxels, but a higher frequency than this was requested
  const double coarsest = 2 * thickness.greatest / control.range().first;
  if (voxel && control.range().first > kFine && !(coarsest >= kLeast * *voxel))
    throw std::invalid_argument("--frequency is " + frequency->text() + ", whose features are " +
                                shortText(coarsest / *voxel) +
                                " voxels wide where the target is thickest, so that none of them shows; make the "
                                "frequency lower, or the voxels smaller than " +
                                shortText(coarsest / kLeast));
  return octaveGrid(thickness, control, target.placed.space);
}

ControlGrids controlsOf(const MapSettings& map, SharedTarget& shared, const PlacedTarget& target,
                        const std::optional<double>& voxel, Monitor& monitor) {
  ControlGrids grids;
  constexpr double kRounding = 1e-5;  // as of the shell's shares
  const std::pair share(-kRounding, 1 + kRounding);
  const std::pair any(-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity());
  for (const MapControl& control : map.controls()) {
    const std::string option = "--" + control.option;
    if (control.kind == MapControl::Kind::Grain) {
      const auto all = grainOf(*control.grain, control.control, shared, target, monitor).all();
      const std::vector<std::string> names = gridNames(control);
      for (std::size_t k = 0; k < names.size(); ++k) grids[names[k]] = {all[k], target.placed.space};
      continue;
    }
    if (control.kind == MapControl::Kind::Frequency) {
      const OctaveGrid octave = octaveOf(control.control, shared, target, voxel, monitor);
      grids[control.name] = {octave.grid, octave.space};
      continue;
    }
    const ControlContext context = controlContext(control.control->needsTarget(), shared, target.placed, monitor);
    const bool isShare = control.kind == MapControl::Kind::Share;
    try {
      grids[control.name] = controlGrid(bound(*control.control, context, "the control", isShare ? share : any), context,
                                        target.placed.space);
    } catch (const DataError& error) {
      if (std::string(error.what()).find(option) != std::string::npos) throw;
      throw DataError(option + " '" + control.control->text() + "': " + error.what(), error.remedy());
    }
  }
  return grids;
}

PlacedTarget placeShell(const ExponentSources& sources, SharedTarget& shared, Monitor& monitor) {
  if (shared.placed && shared.placed->sources == sources) return shared.placed->target;
  const TargetInput& input = shared.input();
  const bool needsBall = needsInscribedBall(sources.space);
  PlacedTarget result;
  result.isSurveyed = needsBall || sources.shell.detail || readsTarget(sources.shell);
  const TargetSurvey* survey = needsBall ? &shared.survey(monitor) : nullptr;
  result.placed = placeSpace(sources.space, input.box(), survey);
  ExponentGridOptions options = bindControls(sources, shared, result.placed, monitor);
  BandWidths widths = widthsOf(sources.space, sources.interiorReach, input, options);
  const auto make = [&] {
    result.target = shared.band(widths, monitor);
    const auto exponent = [&] { return exponentGrid(result.target, result.placed.space, options, monitor); };
    try {
      try {
        return exponent();
      } catch (const julia::NoDetail&) {
        // A B-spline reads farther about the origin, for which coarse distances may have no room.
        if (!sources.isSmooth) throw;
        options.interpolation = julia::Interpolation::Trilinear;
        return exponent();
      }
    } catch (const julia::NoDetail&) {
      if (sources.space.origin != OriginKind::Auto) throw;  // another origin would work
      throw DataError(
          "the target leaves no room for detail: about its deepest point it is too thin for the voxels of its "
          "distances; make these finer, or the target thicker",
          Remedy::FinerDistances);
    }
  };
  ExponentGrid exponent = make();
  if (exponent.tooShallow) {
    widths.wholeInside = true;
    exponent = make();
  }
  result.shell = SceneShell{std::move(exponent), SceneShell::Made{std::move(options)}};
  shared.placed = {sources, result};
  return result;
}

PlacedTarget placeTarget(const FractalOptions& options, SharedTarget& shared, Monitor& monitor) {
  BandWidths widths = widthsOf(options.space, options.map->interiorReach(), shared.input(),
                               ExponentGridOptions{.orbit = orbitOf(options)});
  PlacedTarget result{.target = shared.band(widths, monitor)};
  if (needsDeepestPoint(options.space, result.target)) {
    widths.wholeInside = true;
    result.target = shared.band(widths, monitor);
  }
  result.placed = placeSpace(options.space, result.target);
  return result;
}

}  // namespace vdbtools
