// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/base/monitor.h"

#include <stdexcept>

namespace vdbtools {

const char* nameOf(PhaseKind kind) {
  switch (kind) {
    case PhaseKind::Reading: return "reading";
    case PhaseKind::Thickening: return "thickening";
    case PhaseKind::ClosingGaps: return "closing gaps";
    case PhaseKind::Sides: return "sides";
    case PhaseKind::DistanceField: return "distance field";
    case PhaseKind::LocalThickness: return "local thickness";
    case PhaseKind::Grain: return "grain";
    case PhaseKind::Motion: return "motion";
    case PhaseKind::WideningTheBand: return "widening the band";
    case PhaseKind::Exponent: return "exponent";
    case PhaseKind::Proofs: return "proofs";
    case PhaseKind::Field: return "field";
    case PhaseKind::Seeds: return "seeds";
    case PhaseKind::FollowingTheSurface: return "following the surface";
    case PhaseKind::Islands: return "islands";
    case PhaseKind::JoiningIslands: return "joining islands";
    case PhaseKind::Surface: return "surface";
    case PhaseKind::Adapting: return "adapting";
    case PhaseKind::LevelSet: return "level set";
    case PhaseKind::Versor: return "versor";
    case PhaseKind::Attributes: return "attributes";
    case PhaseKind::Writing: return "writing";
    case PhaseKind::Checking: return "checking";
    case PhaseKind::Points: return "points";
    case PhaseKind::Gaps: return "gaps";
    case PhaseKind::Elimination: return "elimination";
    case PhaseKind::Thickness: return "thickness";
    case PhaseKind::ThinParts: return "thin parts";
    case PhaseKind::Sample: return "sample";
    case PhaseKind::Merging: return "merging";
    case PhaseKind::MergingGrids: return "merging grids";
    case PhaseKind::Signs: return "signs";
    case PhaseKind::Slice: return "slice";
    case PhaseKind::Distances: return "distances";
    case PhaseKind::FirstVersor: return "first versor";
    case PhaseKind::Versors: return "versors";
    case PhaseKind::RayTree: return "ray tree";
    case PhaseKind::Render: return "render";
    case PhaseKind::Electrostatics: return "electrostatics";
    case PhaseKind::Monopoles: return "monopoles";
    case PhaseKind::Potential: return "potential";
    case PhaseKind::Fit: return "fit";
    case PhaseKind::Measure: return "measure";
    case PhaseKind::Evaluating: return "evaluating";
  }
  throw std::logic_error("a phase has no name");
}

std::string Phase::text() const {
  std::string text = nameOf(kind);
  if (!detail.empty()) text += ' ' + detail;
  if (count > 0) text += ", " + piece + ' ' + std::to_string(number) + " of " + std::to_string(count);
  return text;
}

}  // namespace vdbtools
