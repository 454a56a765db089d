// SPDX-License-Identifier: Apache-2.0
#include "julia/fit/surface.h"

#include "fit/vector3.h"
#include "number_text.h"
#include "random_numbers.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <queue>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>

namespace julia {
namespace {

constexpr double kFarthestSample = 1e9;  // as in requireFinite(const Rational&)
constexpr std::size_t kMostPoints = 100'000'000;
// Candidates for each point that is kept; more hardly increase the distances.
constexpr std::size_t kOversampling = 5;
// The limit along an axis, so that indices fit 64 bits.
constexpr double kMostGridCells = 0x1p60;

using SampleIndex = std::uint32_t;

double areaOf(const TriangleSurface& surface, const std::array<std::uint32_t, 3>& triangle) {
  const Point& a = surface.points[triangle[0]];
  return 0.5 * length(cross(surface.points[triangle[1]] - a, surface.points[triangle[2]] - a));
}

/// One point in each of @a count equal parts of the area, in the order of the triangles.
std::vector<Point> stratifiedSamples(const TriangleSurface& surface, double wholeArea, std::size_t count,
                                     std::uint64_t seed) {
  Random random(seed);
  std::vector<Point> samples;
  samples.reserve(count);
  std::size_t t = 0;
  double end = areaOf(surface, surface.triangles[0]);
  for (std::size_t i = 0; i < count; ++i) {
    const double place = (static_cast<double>(i) + random.unit()) / static_cast<double>(count) * wholeArea;
    while (place >= end && t + 1 < surface.triangles.size()) end += areaOf(surface, surface.triangles[++t]);
    // The square root makes the density uniform: the tip of a triangle up to u times its height has u^2 of its area.
    const double u = std::sqrt(random.unit()), v = random.unit();
    const auto& [a, b, c] = surface.triangles[t];
    samples.push_back((1 - u) * surface.points[a] + (u * (1 - v)) * surface.points[b] + (u * v) * surface.points[c]);
  }
  return samples;
}

/// Finds the neighbours of points within a radius, with the points sorted by the cells of a grid.
class HashGrid {
 public:
  HashGrid(std::span<const Point> samples, std::span<const SampleIndex> members, double radius)
      : mSamples(samples), mRadius(radius), mLow(samples[members[0]]) {
    Point high = mLow;
    for (const SampleIndex i : members)
      for (int axis = 0; axis < 3; ++axis) {
        mLow[axis] = std::min(mLow[axis], samples[i][axis]);
        high[axis] = std::max(high[axis], samples[i][axis]);
      }
    mCell = std::max({radius, (high[0] - mLow[0]) / kMostGridCells, (high[1] - mLow[1]) / kMostGridCells,
                      (high[2] - mLow[2]) / kMostGridCells});
    mEntries.reserve(members.size());
    for (const SampleIndex i : members) mEntries.emplace_back(cellOf(samples[i]), i);
    std::sort(mEntries.begin(), mEntries.end());
  }

  /// Calls visit(j, distance) for each other member, always in the same order.
  template <class Visit>
  void forNeighbours(SampleIndex i, Visit visit) const {
    const auto [cz, cy, cx] = cellOf(mSamples[i]);
    for (std::int64_t z = cz - 1; z <= cz + 1; ++z)
      for (std::int64_t y = cy - 1; y <= cy + 1; ++y) {
        const Cell last{z, y, cx + 1};
        auto entry = std::lower_bound(mEntries.begin(), mEntries.end(), Entry({z, y, cx - 1}, 0));
        for (; entry != mEntries.end() && entry->first <= last; ++entry) {
          const double distance = length(mSamples[entry->second] - mSamples[i]);
          if (entry->second != i && distance < mRadius) visit(entry->second, distance);
        }
      }
  }

 private:
  /// Cells are ordered by z, y, x, so that neighbours along x are adjacent.
  using Cell = std::array<std::int64_t, 3>;
  using Entry = std::pair<Cell, SampleIndex>;

  Cell cellOf(const Point& x) const {
    Cell cell;
    for (int axis = 0; axis < 3; ++axis) cell[2 - axis] = static_cast<std::int64_t>((x[axis] - mLow[axis]) / mCell);
    return cell;
  }

  std::span<const Point> mSamples;
  double mRadius, mCell;
  Point mLow;
  std::vector<Entry> mEntries;
};

/// Removes from @a members, one after another, the most crowded one, until @a count are left.
/// @return the removed members, in order of removal
std::vector<SampleIndex> eliminate(std::span<const Point> samples, std::vector<SampleIndex>& members, std::size_t count,
                                   double wholeArea) {
  // Yuksel's Eq. 3: half the distance of points in the densest packing. His weights, with alpha = 8, beta = 0.65 and
  // gamma = 1.5, do not distinguish distances below a fraction of it.
  const auto kept = static_cast<double>(count);
  const double diameter = 2 * std::sqrt(wholeArea / (2 * std::sqrt(3.0) * kept));
  const double ratio = kept / static_cast<double>(members.size());
  const double least = diameter * 0.65 * (1 - ratio * std::sqrt(ratio));
  const HashGrid grid(samples, members, diameter);
  const auto crowding = [&](double distance) {
    const double w = 1 - std::max(distance, least) / diameter;
    return (w * w) * (w * w) * ((w * w) * (w * w));
  };

  std::vector<double> weights(samples.size());
  std::vector<bool> gone(samples.size());
  using Entry = std::pair<double, SampleIndex>;
  std::vector<Entry> entries;
  entries.reserve(members.size());
  for (const SampleIndex i : members) {
    grid.forNeighbours(i, [&](SampleIndex, double distance) { weights[i] += crowding(distance); });
    entries.emplace_back(weights[i], i);
  }
  std::priority_queue<Entry> queue(std::less<Entry>(), std::move(entries));

  std::vector<SampleIndex> removed;
  while (removed.size() + count < members.size()) {
    const auto [weight, i] = queue.top();
    queue.pop();
    // Weights never grow, so an outdated entry can only be too near the top of the queue.
    if (weight != weights[i]) {
      queue.emplace(weights[i], i);
      continue;
    }
    gone[i] = true;
    removed.push_back(i);
    grid.forNeighbours(i, [&](SampleIndex j, double distance) { weights[j] -= crowding(distance); });
  }
  std::erase_if(members, [&](SampleIndex i) { return gone[i]; });
  return removed;
}

}  // namespace

void requireValid(const TriangleSurface& surface) {
  for (std::size_t t = 0; t < surface.triangles.size(); ++t)
    for (const std::uint32_t index : surface.triangles[t])
      if (index >= surface.points.size())
        throw std::invalid_argument("triangle " + std::to_string(t) + " uses point " + std::to_string(index) +
                                    " of a surface with " + std::to_string(surface.points.size()) + " points");
  for (std::size_t i = 0; i < surface.points.size(); ++i)
    for (const double coordinate : surface.points[i])
      if (!(std::abs(coordinate) <= kFarthestSample))
        throw std::invalid_argument("a coordinate of point " + std::to_string(i) + " of the surface is " +
                                    textOf(coordinate) + "; it must be a number between -1e9 and 1e9");
}

double area(const TriangleSurface& surface) {
  requireValid(surface);
  double sum = 0;
  for (const auto& triangle : surface.triangles) sum += areaOf(surface, triangle);
  return sum;
}

std::vector<Point> blueNoise(const TriangleSurface& surface, std::size_t count, std::uint64_t seed) {
  if (count < 1 || count > kMostPoints)
    throw std::invalid_argument("the number of points on the surface is " + std::to_string(count) +
                                "; it must be 1 to 100000000");
  const double wholeArea = area(surface);
  if (!(wholeArea > 0))
    throw std::invalid_argument("points cannot be spread over a surface without area; it has " +
                                std::to_string(surface.triangles.size()) + " triangles");
  const std::vector<Point> samples = stratifiedSamples(surface, wholeArea, kOversampling * count, seed);
  std::vector<SampleIndex> members(samples.size());
  for (std::size_t i = 0; i < members.size(); ++i) members[i] = static_cast<SampleIndex>(i);
  eliminate(samples, members, count, wholeArea);

  // Points that are removed first come last. Each round halves the remaining ones, with the larger radius for fewer
  // points.
  std::vector<Point> points(count);
  while (members.size() > 1) {
    std::size_t place = members.size();
    for (const SampleIndex i : eliminate(samples, members, members.size() / 2, wholeArea)) points[--place] = samples[i];
  }
  points[0] = samples[members[0]];
  return points;
}

}  // namespace julia
