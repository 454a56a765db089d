// SPDX-License-Identifier: Apache-2.0
#include "overall_share.h"

#include <algorithm>
#include <cstddef>

namespace cli {

std::vector<PhaseWeight> phasesOf(std::string_view command) {
  using enum vdbtools::PhaseKind;
  const std::vector<PhaseWeight> scene{{Reading, 2},        {Thickening, 8},     {ClosingGaps, 20},    {Sides, 5},
                                       {DistanceField, 12}, {LocalThickness, 3}, {WideningTheBand, 5}, {Exponent, 5},
                                       {Grain, 5},          {Motion, 5}};
  // Behind the phases that make a target and its exponent.
  const auto ofScene = [&](std::vector<PhaseWeight> others) {
    others.insert(others.begin(), scene.begin(), scene.end());
    return others;
  };
  // Hundredths of a run, roughly, on the bunny with 200 to 400 voxels along its longest side.
  if (command == "sdf")
    return {{Reading, 2},  {Thickening, 20},    {ClosingGaps, 40}, {Sides, 15},
            {Surface, 10}, {DistanceField, 35}, {Signs, 2},        {Writing, 8}};
  if (command == "fractal" || command == "mesh" || command == "task")
    return ofScene({{Proofs, 5},
                    {Field, 15},
                    {Seeds, 1},
                    {FollowingTheSurface, 15},
                    {Islands, 3},
                    {Surface, 45},
                    {Adapting, 30},
                    {LevelSet, 5},
                    {Versor, 5},
                    {Attributes, 5},
                    {Writing, 5},
                    {Checking, 1}});
  if (command == "points")
    return ofScene(
        {{Proofs, 5}, {Field, 15}, {Surface, 15}, {Points, 20}, {Gaps, 10}, {Elimination, 10}, {Writing, 2}});
  if (command == "print")
    return ofScene({{Proofs, 5},
                    {Field, 15},
                    {Surface, 15},
                    {Islands, 2},
                    {Thickness, 20},
                    {ThinParts, 10},
                    {Adapting, 10},
                    {Writing, 2}});
  if (command == "plan") return ofScene({{Sample, 100}});
  if (command == "merge")
    return {{Checking, 10}, {Merging, 60}, {MergingGrids, 20}, {Versor, 5}, {Attributes, 5}, {Writing, 10}};
  if (command == "explore") return ofScene({{Writing, 5}});
  if (command == "slice") return ofScene({{Slice, 20}, {Writing, 5}});
  if (command == "study") return ofScene({{Distances, 5}, {FirstVersor, 2}, {Versors, 60}, {Writing, 2}});
  if (command == "render") return ofScene({{RayTree, 5}, {Render, 60}, {Writing, 2}});
  // For one cell; a cell that shows the field has only the last of these.
  if (command == "sheet")
    return ofScene({{Proofs, 5},
                    {Field, 15},
                    {Islands, 3},
                    {Surface, 15},
                    {Adapting, 10},
                    {RayTree, 5},
                    {Render, 60},
                    {Writing, 2}});
  if (command == "fit")
    return {{Reading, 1},         {Thickening, 3}, {Sides, 2},     {DistanceField, 3}, {Surface, 2},  {Distances, 5},
            {Electrostatics, 10}, {Monopoles, 5},  {Potential, 5}, {Fit, 60},          {Measure, 10}, {Writing, 1}};
  if (command == "usd") return {{Reading, 80}, {Writing, 20}};
  if (command == "convert") return {{Reading, 50}, {Writing, 50}};
  return {};
}

void OverallShare::begin(const vdbtools::Phase& phase) {
  mDone += mWeight;
  mWeight = 0;
  if (phase.number != mNumber && phase.number != 0) {
    if (mNumber == 0) mBeforePieces = mShare;
    mNumber = phase.number;
    mCount = phase.count;
    mDone = 0;
    mNext = 0;
  }
  const auto at =
      std::find_if(mPhases.begin(), mPhases.end(), [&](const PhaseWeight& entry) { return entry.phase == phase.kind; });
  if (at == mPhases.end()) return;
  mWeight = at->weight;
  mNext = static_cast<std::size_t>(at - mPhases.begin()) + 1;
}

double OverallShare::ofPiece(double fraction) const {
  double left = mWeight;
  for (std::size_t i = mNext; i < mPhases.size(); ++i) left += mPhases[i].weight;
  return mDone + left > 0 ? (mDone + mWeight * fraction) / (mDone + left) : 0;
}

double OverallShare::at(double fraction) {
  double share = ofPiece(fraction);
  if (mNumber != 0)
    share =
        mBeforePieces + (1 - mBeforePieces) * (static_cast<double>(mNumber - 1) + share) / static_cast<double>(mCount);
  mShare = std::clamp(share, mShare, 1.0);
  return mShare;
}

}  // namespace cli
