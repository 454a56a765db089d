// SPDX-License-Identifier: Apache-2.0
#include "surface/true_surface.h"

#include <vector>

namespace vdbtools {
namespace {

/// A bracket of the sign change, in world units along the way: F has the sign of the point itself at @a low, and the
/// opposite sign at @a high.
struct Way {
  std::size_t point;
  openvdb::Vec3d direction;
  bool inside;  ///< whether the point itself is inside
  double low = 0, high = 0;
};

class Mover {
 public:
  Mover(const FieldSource& source, double reach, double tolerance)
      : mSource(source), mReach(reach), mTolerance(tolerance) {}

  void operator()(std::span<PlacedPoint> points) const {
    std::vector<Way> ways, found;
    ways.reserve(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) ways.push_back({i, openvdb::Vec3d(points[i].normal), false});
    const std::vector<bool> inside = insideAt(points, ways, [](const Way&) { return 0.0; });
    for (std::size_t i = 0; i < ways.size(); ++i) {
      ways[i].inside = inside[i];
      if (!inside[i]) ways[i].direction = -ways[i].direction;
    }
    constexpr int kSteps = 8;
    for (int step = 1; step <= kSteps && !ways.empty(); ++step) {
      const double at = mReach * step / kSteps;
      const std::vector<bool> there = insideAt(points, ways, [at](const Way&) { return at; });
      std::vector<Way> left;
      for (std::size_t i = 0; i < ways.size(); ++i) {
        Way& way = ways[i];
        (there[i] == way.inside ? way.low : way.high) = at;
        (there[i] == way.inside ? left : found).push_back(way);
      }
      ways.swap(left);
    }
    for (const Way& way : ways) points[way.point].lost = true;
    // All brackets have the same width, so all are narrow enough after the same number of halvings.
    for (double width = mReach / kSteps; width > 2 * mTolerance && !found.empty(); width /= 2) {
      const std::vector<bool> there = insideAt(points, found, [](const Way& way) { return middleOf(way); });
      for (std::size_t i = 0; i < found.size(); ++i)
        (there[i] == found[i].inside ? found[i].low : found[i].high) = middleOf(found[i]);
    }
    for (const Way& way : found) points[way.point].position += way.direction * middleOf(way);
  }

 private:
  static double middleOf(const Way& way) { return way.low + (way.high - way.low) / 2; }

  template <class At>
  std::vector<bool> insideAt(std::span<const PlacedPoint> points, const std::vector<Way>& ways, const At& at) const {
    std::vector<julia::Point> places;
    places.reserve(ways.size());
    for (const Way& way : ways)
      places.push_back(mSource.space.toFractal(points[way.point].position + way.direction * at(way)));
    std::vector<double> field(places.size());
    if (!places.empty()) mSource.evaluator.evaluate(places, field, {});
    std::vector<bool> inside;
    inside.reserve(field.size());
    for (const double value : field) inside.push_back(value < 0);
    return inside;
  }

  FieldSource mSource;
  double mReach, mTolerance;
};

}  // namespace

PointMover toTrueSurface(const FieldSource& source, double reach, double tolerance) {
  return Mover(source, reach, tolerance);
}

}  // namespace vdbtools
