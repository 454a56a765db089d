// SPDX-License-Identifier: Apache-2.0
#include "overall_share.h"

#include "vdbtools/base/numbered_monitor.h"

#include <algorithm>
#include <array>
#include <cstddef>

namespace cli {
namespace {

// The weights are roughly hundredths of a run on the bunny with 200 to 400 voxels along its longest side.

// Constants of the compiler: an allocation that fails before main() could not be reported.

/// The phases that make a target and its exponent, and then others.
template <std::size_t N>
constexpr std::array<PhaseWeight, N + 8> scenePhases(const PhaseWeight (&others)[N]) {
  std::array<PhaseWeight, N + 8> phases = {{{"reading", 2},
                                            {"thickening", 8},
                                            {"closing gaps", 20},
                                            {"sides", 5},
                                            {"distance field", 12},
                                            {"local thickness", 3},
                                            {"widening the band", 5},
                                            {"exponent", 5}}};
  std::copy(others, others + N, phases.begin() + 8);
  return phases;
}

constexpr PhaseWeight kSdf[] = {{"reading", 2}, {"thickening", 20},     {"closing gaps", 40},
                                {"sides", 15},  {"distance field", 35}, {"writing", 8}};
constexpr auto kFractal = scenePhases({{"proofs", 5},
                                       {"field", 15},
                                       {"seeds", 1},
                                       {"following the surface", 15},
                                       {"islands", 3},
                                       {"surface", 15},
                                       {"adapting", 30},
                                       {"level set", 15},
                                       {"versor", 5},
                                       {"attributes", 5},
                                       {"writing", 5},
                                       {"checking", 1}});
constexpr auto kPoints = scenePhases(
    {{"proofs", 5}, {"field", 15}, {"surface", 15}, {"points", 20}, {"gaps", 10}, {"elimination", 10}, {"writing", 2}});
constexpr auto kPrint = scenePhases({{"proofs", 5},
                                     {"field", 15},
                                     {"surface", 15},
                                     {"islands", 2},
                                     {"thickness", 20},
                                     {"thin parts", 10},
                                     {"adapting", 10},
                                     {"writing", 2}});
constexpr auto kPlan = scenePhases({{"sample", 100}});
constexpr PhaseWeight kMerge[] = {{"checking", 10}, {"merging", 60},   {"merging grids", 20},
                                  {"versor", 5},    {"attributes", 5}, {"writing", 10}};
constexpr auto kExplore = scenePhases({{"writing", 5}});
constexpr auto kSlice = scenePhases({{"slice", 20}, {"writing", 5}});
constexpr auto kStudy = scenePhases({{"distances", 5}, {"first versor", 2}, {"versors", 60}, {"writing", 2}});
constexpr auto kRender = scenePhases({{"ray tree", 5}, {"render", 60}, {"writing", 2}});
/// Of a cell; one that shows the field has only the last of these.
constexpr auto kSheet = scenePhases({{"proofs", 5},
                                     {"field", 15},
                                     {"islands", 3},
                                     {"surface", 15},
                                     {"adapting", 10},
                                     {"ray tree", 5},
                                     {"render", 60},
                                     {"writing", 2}});
constexpr PhaseWeight kUsd[] = {{"reading", 80}, {"writing", 20}};
constexpr PhaseWeight kFit[] = {{"reading", 1},   {"thickening", 3}, {"sides", 2},           {"distance field", 3},
                                {"surface", 2},   {"distances", 5},  {"electrostatics", 10}, {"monopoles", 5},
                                {"potential", 5}, {"fit", 60},       {"measure", 10},        {"writing", 1}};

bool names(const PhaseWeight& entry, std::string_view phase) {
  return phase.starts_with(entry.phase) && (phase.size() == entry.phase.size() || phase[entry.phase.size()] == ' ');
}

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
  return {};
}

void OverallShare::begin(std::string_view phase) {
  mDone += mWeight;
  mWeight = 0;
  const vdbtools::NumberedPhase numbered = vdbtools::numberedPhase(phase);
  if (numbered.number != mNumber && numbered.number != 0) {
    if (mNumber == 0) mBeforePieces = mShare;
    mNumber = numbered.number;
    mCount = numbered.count;
    mDone = 0;
    mNext = 0;
  }
  const auto at = std::find_if(mPhases.begin(), mPhases.end(),
                               [&](const PhaseWeight& entry) { return names(entry, numbered.phase); });
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
