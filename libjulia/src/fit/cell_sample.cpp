// SPDX-License-Identifier: Apache-2.0
#include "fit/cell_sample.h"

#include <algorithm>
#include <functional>

namespace julia {
namespace {

/// The t for which sum min(1, d / t) = @a most; 0 if all cells can be taken.
double thresholdOf(std::span<const double> d, std::size_t most) {
  std::vector<double> sorted;
  double rest = 0;
  for (const double value : d)
    if (value > 0) {
      sorted.push_back(value);
      rest += value;
    }
  if (sorted.size() <= most) return 0;
  // The cells with the largest d are always taken, until the rest is spread over enough places.
  const auto largest = sorted.begin() + static_cast<std::ptrdiff_t>(most);
  std::partial_sort(sorted.begin(), largest, sorted.end(), std::greater<>());
  std::size_t certain = 0;
  while (certain + 1 < most && sorted[certain] * static_cast<double>(most - certain) > rest) rest -= sorted[certain++];
  return rest / static_cast<double>(most - certain);
}

}  // namespace

CellSample sampleCells(std::span<const double> d, std::size_t most) {
  CellSample sample;
  const double threshold = thresholdOf(d, most);
  double passed = 0.5;
  for (std::size_t i = 0; i < d.size(); ++i) {
    if (!(d[i] > 0)) continue;
    if (d[i] < threshold) {
      passed += d[i] / threshold;
      if (passed < 1) continue;
      passed -= 1;
    }
    sample.cells.push_back(i);
    sample.weights.push_back(std::max(d[i], threshold));
  }
  return sample;
}

}  // namespace julia
