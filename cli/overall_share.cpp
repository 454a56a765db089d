// SPDX-License-Identifier: Apache-2.0
#include "overall_share.h"

#include <algorithm>
#include <array>
#include <cstddef>

namespace cli {
namespace {

using vdbtools::PhaseKind;

// The weights are roughly hundredths of a run on the bunny with 200 to 400 voxels along its longest side.

// The tables are constexpr, because a failed allocation before main() could not be reported.

/// Combines the phases that make a target and its exponent with further ones.
template <std::size_t N>
constexpr std::array<PhaseWeight, N + 9> scenePhases(const PhaseWeight (&others)[N]) {
  std::array<PhaseWeight, N + 9> phases = {{{PhaseKind::Reading, 2},
                                            {PhaseKind::Thickening, 8},
                                            {PhaseKind::ClosingGaps, 20},
                                            {PhaseKind::Sides, 5},
                                            {PhaseKind::DistanceField, 12},
                                            {PhaseKind::LocalThickness, 3},
                                            {PhaseKind::WideningTheBand, 5},
                                            {PhaseKind::Exponent, 5},
                                            {PhaseKind::Grain, 5}}};
  std::copy(others, others + N, phases.begin() + 9);
  return phases;
}

constexpr PhaseWeight kSdf[] = {{PhaseKind::Reading, 2}, {PhaseKind::Thickening, 20}, {PhaseKind::ClosingGaps, 40},
                                {PhaseKind::Sides, 15},  {PhaseKind::Surface, 10},    {PhaseKind::DistanceField, 35},
                                {PhaseKind::Signs, 2},   {PhaseKind::Writing, 8}};
constexpr auto kFractal = scenePhases({{PhaseKind::Proofs, 5},
                                       {PhaseKind::Field, 15},
                                       {PhaseKind::Seeds, 1},
                                       {PhaseKind::FollowingTheSurface, 15},
                                       {PhaseKind::Islands, 3},
                                       {PhaseKind::Surface, 45},
                                       {PhaseKind::Adapting, 30},
                                       {PhaseKind::LevelSet, 5},
                                       {PhaseKind::Versor, 5},
                                       {PhaseKind::Attributes, 5},
                                       {PhaseKind::Writing, 5},
                                       {PhaseKind::Checking, 1}});
constexpr auto kPoints = scenePhases({{PhaseKind::Proofs, 5},
                                      {PhaseKind::Field, 15},
                                      {PhaseKind::Surface, 15},
                                      {PhaseKind::Points, 20},
                                      {PhaseKind::Gaps, 10},
                                      {PhaseKind::Elimination, 10},
                                      {PhaseKind::Writing, 2}});
constexpr auto kPrint = scenePhases({{PhaseKind::Proofs, 5},
                                     {PhaseKind::Field, 15},
                                     {PhaseKind::Surface, 15},
                                     {PhaseKind::Islands, 2},
                                     {PhaseKind::Thickness, 20},
                                     {PhaseKind::ThinParts, 10},
                                     {PhaseKind::Adapting, 10},
                                     {PhaseKind::Writing, 2}});
constexpr auto kPlan = scenePhases({{PhaseKind::Sample, 100}});
constexpr PhaseWeight kMerge[] = {{PhaseKind::Checking, 10}, {PhaseKind::Merging, 60},   {PhaseKind::MergingGrids, 20},
                                  {PhaseKind::Versor, 5},    {PhaseKind::Attributes, 5}, {PhaseKind::Writing, 10}};
constexpr auto kExplore = scenePhases({{PhaseKind::Writing, 5}});
constexpr auto kSlice = scenePhases({{PhaseKind::Slice, 20}, {PhaseKind::Writing, 5}});
constexpr auto kStudy = scenePhases(
    {{PhaseKind::Distances, 5}, {PhaseKind::FirstVersor, 2}, {PhaseKind::Versors, 60}, {PhaseKind::Writing, 2}});
constexpr auto kRender = scenePhases({{PhaseKind::RayTree, 5}, {PhaseKind::Render, 60}, {PhaseKind::Writing, 2}});
/// For one cell; a cell that shows the field has only the last of these.
constexpr auto kSheet = scenePhases({{PhaseKind::Proofs, 5},
                                     {PhaseKind::Field, 15},
                                     {PhaseKind::Islands, 3},
                                     {PhaseKind::Surface, 15},
                                     {PhaseKind::Adapting, 10},
                                     {PhaseKind::RayTree, 5},
                                     {PhaseKind::Render, 60},
                                     {PhaseKind::Writing, 2}});
constexpr PhaseWeight kConvert[] = {{PhaseKind::Reading, 50}, {PhaseKind::Writing, 50}};
constexpr PhaseWeight kUsd[] = {{PhaseKind::Reading, 80}, {PhaseKind::Writing, 20}};
constexpr PhaseWeight kFit[] = {{PhaseKind::Reading, 1},         {PhaseKind::Thickening, 3},
                                {PhaseKind::Sides, 2},           {PhaseKind::DistanceField, 3},
                                {PhaseKind::Surface, 2},         {PhaseKind::Distances, 5},
                                {PhaseKind::Electrostatics, 10}, {PhaseKind::Monopoles, 5},
                                {PhaseKind::Potential, 5},       {PhaseKind::Fit, 60},
                                {PhaseKind::Measure, 10},        {PhaseKind::Writing, 1}};

}  // namespace

std::span<const PhaseWeight> phasesOf(std::string_view command) {
  if (command == "sdf") return kSdf;
  if (command == "fractal" || command == "mesh" || command == "task") return kFractal;
  if (command == "points") return kPoints;
  if (command == "print") return kPrint;
  if (command == "plan") return kPlan;
  if (command == "merge") return kMerge;
  if (command == "explore") return kExplore;
  if (command == "slice") return kSlice;
  if (command == "study") return kStudy;
  if (command == "render") return kRender;
  if (command == "sheet") return kSheet;
  if (command == "fit") return kFit;
  if (command == "usd") return kUsd;
  if (command == "convert") return kConvert;
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
