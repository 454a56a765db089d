// SPDX-License-Identifier: Apache-2.0
#include "fit/candidate_scores.h"

#include "fit/cell_sample.h"
#include "kernels/kernels.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace julia {
namespace {

constexpr std::size_t kBlock = 256;  // cells at a time

}  // namespace

CellSlopes sampledSlopes(std::span<const FitCell> cells, std::span<const double> slope,
                         std::span<const double> curvature, std::size_t most) {
  std::vector<double> importance(cells.size());
  for (std::size_t i = 0; i < cells.size(); ++i) importance[i] = std::abs(slope[i]) + curvature[i];
  const CellSample sample = sampleCells(importance, most);
  CellSlopes result;
  for (std::size_t k = 0; k < sample.cells.size(); ++k) {
    const std::size_t i = sample.cells[k];
    const double share = sample.weights[k] / importance[i];
    result.x.push_back(static_cast<float>(cells[i].x[0]));
    result.y.push_back(static_cast<float>(cells[i].x[1]));
    result.z.push_back(static_cast<float>(cells[i].x[2]));
    result.slope.push_back(share * slope[i]);
    result.curvature.push_back(share * curvature[i]);
    result.wholeCurvature += result.curvature.back();
  }
  const std::size_t size = (result.x.size() + kBlock - 1) / kBlock * kBlock;
  for (std::vector<float>* coordinate : {&result.x, &result.y, &result.z}) coordinate->resize(size);
  result.slope.resize(size);
  result.curvature.resize(size);
  return result;
}

void rankCandidates(std::span<CandidateScore> scores, std::span<const RootCandidate> candidates,
                    const CellSlopes& cells, double blur, double pull) {
  constexpr std::size_t kTogether = 4;
  const kernels::Kernels<float>& kernel = kernels::kernels<float>();
  tbb::parallel_for(std::size_t{0}, (scores.size() + kTogether - 1) / kTogether, [&](std::size_t part) {
    const std::span<CandidateScore> some =
        scores.subspan(part * kTogether, std::min(kTogether, scores.size() - part * kTogether));
    if (std::none_of(some.begin(), some.end(), [](const CandidateScore& score) { return score.gain > 0; })) return;
    alignas(64) float logs[kTogether * kBlock] = {}, squares[kTogether * kBlock];
    double bySlope[kTogether] = {}, mean[kTogether] = {}, square[kTogether] = {}, sums[kTogether];
    for (std::size_t begin = 0; begin < cells.x.size(); begin += kBlock) {
      for (std::size_t k = 0; k < some.size(); ++k) {
        const Point& at = candidates[some[k].candidate].x;
        const float root[3] = {static_cast<float>(at[0]), static_cast<float>(at[1]), static_cast<float>(at[2])};
        kernel.logDistances(root, static_cast<float>(blur), &cells.x[begin], &cells.y[begin], &cells.z[begin],
                            logs + k * kBlock, kBlock);
      }
      for (std::size_t i = 0; i < kTogether * kBlock; ++i) squares[i] = logs[i] * logs[i];
      const auto addProducts = [&](const float* columns, const double* factors, double* to) {
        kernel.dotColumns(columns, factors, kTogether, sums, kBlock);
        for (std::size_t k = 0; k < kTogether; ++k) to[k] += sums[k];
      };
      addProducts(logs, &cells.slope[begin], bySlope);
      addProducts(logs, &cells.curvature[begin], mean);
      addProducts(squares, &cells.curvature[begin], square);
    }
    for (std::size_t k = 0; k < some.size(); ++k) {
      using Side = RootCandidate::Side;
      CandidateScore& score = some[k];
      if (!(score.gain > 0)) continue;
      const double slope = bySlope[k] - pull;
      const double curvature = std::max(square[k] - mean[k] * mean[k] / cells.wholeCurvature, 0.0);
      const Side side = candidates[score.candidate].side;
      score.bottom = side == Side::Either ? slope > 0 : side == Side::Bottom;
      score.gain = (score.bottom ? -slope : slope) < 0 ? slope * slope / (curvature + 1e-300) : 0;
    }
  });
  std::stable_sort(scores.begin(), scores.end(),
                   [](const CandidateScore& a, const CandidateScore& b) { return a.gain > b.gain; });
}

}  // namespace julia
