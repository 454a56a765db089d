// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/search/solid_meter.h"

#include <algorithm>
#include <functional>
#include <numeric>

namespace vdbtools {

double SolidMeasure::shareOfLargest(std::size_t count) const {
  const double all = std::accumulate(islands.begin(), islands.end(), 0.0);
  const auto end = islands.begin() + static_cast<std::ptrdiff_t>(std::min(count, islands.size()));
  return all > 0 ? std::accumulate(islands.begin(), end, 0.0) / all : 0;
}

void SolidMeter::addPoints(const PointBatch& batch) {
  if (mFirst == 0 && mPoints.empty() && !batch.positions.empty()) mOrigin = batch.positions.front();
  for (const openvdb::Vec3d& point : batch.positions) mPoints.push_back({point - mOrigin, kNoPart});
  if (mNext) mNext->addPoints(batch);
}

void SolidMeter::addTriangles(std::span<const openvdb::Vec3I> triangles, std::uint64_t firstPoint) {
  for (; mFirst < firstPoint; ++mFirst) mPoints.pop_front();
  for (const openvdb::Vec3I& triangle : triangles) {
    Point* const corners[3] = {&mPoints[triangle[0] - mFirst], &mPoints[triangle[1] - mFirst],
                               &mPoints[triangle[2] - mFirst]};
    std::uint32_t part = kNoPart;
    for (const Point* corner : corners)
      if (corner->part != kNoPart) part = std::min(part, rootOf(corner->part));
    if (part == kNoPart) {
      part = static_cast<std::uint32_t>(mParts.size());
      mParts.push_back({part, 0});
    }
    for (Point* corner : corners) {
      if (corner->part == kNoPart) {
        corner->part = part;
        continue;
      }
      const std::uint32_t other = rootOf(corner->part);
      if (other == part) continue;
      mParts[other].parent = part;
      mParts[part].volume += mParts[other].volume;
    }
    mParts[part].volume += corners[0]->position.dot(corners[1]->position.cross(corners[2]->position));
  }
  if (mNext) mNext->addTriangles(triangles, firstPoint);
}

std::uint32_t SolidMeter::rootOf(std::uint32_t part) {
  while (mParts[part].parent != part) {
    mParts[part].parent = mParts[mParts[part].parent].parent;
    part = mParts[part].parent;
  }
  return part;
}

SolidMeasure SolidMeter::measure() const {
  SolidMeasure measure;
  for (std::uint32_t i = 0; i < mParts.size(); ++i) {
    if (mParts[i].parent != i) continue;
    const double volume = mParts[i].volume / 6;
    measure.volume += volume;
    if (volume > 0) measure.islands.push_back(volume);
  }
  std::sort(measure.islands.begin(), measure.islands.end(), std::greater<>());
  return measure;
}

SolidMeasure measureSolid(const Mesh& mesh) {
  SolidMeter meter;
  meter.addPoints({mesh.points});
  meter.addTriangles(mesh.triangles, 0);
  return meter.measure();
}

}  // namespace vdbtools
