// SPDX-License-Identifier: Apache-2.0
#include "render/occupancy.h"

#include "base/in_parallel.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <vector>

namespace vdbtools {

using openvdb::Coord;
using openvdb::CoordBBox;
using openvdb::Vec3d;

namespace {

/// Balls reach slightly beyond their cubes, because a sample on a face may belong to either cube.
constexpr double kReach = 1 + 1e-3;
constexpr int kLargestCube = 32;  ///< cells; the subdivision begins at this size
constexpr std::size_t kGrain = 512;

struct Cube {
  Coord corner;
  julia::Point centre;
};

}  // namespace

Occupancy::Occupancy(const julia::FieldEvaluator& evaluator, const openvdb::BBoxd& box, int cells, Monitor& monitor)
    : mOrigin(box.min()), mCell(box.extents()[static_cast<int>(openvdb::math::MaxIndex(box.extents()))] / cells) {
  Coord& count = mCount;
  for (int axis = 0; axis < 3; ++axis)
    count[axis] = std::max(1, static_cast<int>(std::ceil(box.extents()[axis] / mCell)));
  // One more cell on each side, for samples that rounding moves beyond a face.
  const CoordBBox domain(Coord(-1), count);
  std::vector<Coord> corners;
  const auto low = [](int i) { return i & ~(kLargestCube - 1); };
  for (int i = low(-1); i <= count[0]; i += kLargestCube)
    for (int j = low(-1); j <= count[1]; j += kLargestCube)
      for (int k = low(-1); k <= count[2]; k += kLargestCube) corners.emplace_back(i, j, k);

  for (int size = kLargestCube; !corners.empty(); size /= 2) {
    std::vector<julia::Point> centres(corners.size());
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Vec3d centre = mOrigin + mCell * (corners[i].asVec3d() + Vec3d(0.5 * size));
      centres[i] = {centre[0], centre[1], centre[2]};
    }
    const double radius = 0.5 * std::numbers::sqrt3 * size * mCell * kReach;
    std::vector<julia::Decision> decisions(corners.size());
    inParallel(corners.size(), kGrain, monitor, [&](std::size_t begin, std::size_t end) {
      evaluator.decide(std::span(centres).subspan(begin, end - begin), radius,
                       std::span(decisions).subspan(begin, end - begin));
    });
    std::vector<Coord> next;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      if (decisions[i] == julia::Decision::Outside) continue;
      if (decisions[i] == julia::Decision::Inside || size == 1) {
        mCells.fill(CoordBBox::createCube(corners[i], size), true, true);
        continue;
      }
      const int half = size / 2;
      for (int child = 0; child < 8; ++child) {
        const Coord corner = corners[i].offsetBy(child & 1 ? half : 0, child & 2 ? half : 0, child & 4 ? half : 0);
        if (domain.hasOverlap(CoordBBox::createCube(corner, half))) next.push_back(corner);
      }
    }
    corners = std::move(next);
  }
  mCells.prune();
}

std::vector<std::uint32_t> Occupancy::bits() const {
  const auto place = [&](int x, int y, int z) {
    return (static_cast<std::size_t>(x) * static_cast<std::size_t>(mCount[1]) + static_cast<std::size_t>(y)) *
               static_cast<std::size_t>(mCount[2]) +
           static_cast<std::size_t>(z);
  };
  std::vector<std::uint32_t> bits(place(mCount[0], 0, 0) / 32 + 1);
  const CoordBBox inside(Coord(0), mCount.offsetBy(-1));
  for (auto value = mCells.cbeginValueOn(); value; ++value) {
    CoordBBox box = value.getBoundingBox();
    box.intersect(inside);
    for (int x = box.min()[0]; x <= box.max()[0]; ++x)
      for (int y = box.min()[1]; y <= box.max()[1]; ++y)
        for (int z = box.min()[2]; z <= box.max()[2]; ++z) {
          const std::size_t n = place(x, y, z);
          bits[n / 32] |= std::uint32_t{1} << n % 32;
        }
  }
  return bits;
}

Occupancy::Walker::Span Occupancy::Walker::at(const Vec3d& eye, const Vec3d& direction, double t) {
  const Vec3d place = (eye + t * direction - mOrigin) * mPerCell;
  const Coord cell = Coord::floor(place);
  // The tree node that is constant here: a cube, or a tile of many cubes.
  using Lower = openvdb::MaskTree::LeafNodeType;
  constexpr int kTiles[] = {4096, 128, Lower::DIM, 1};
  const bool occupied = mCells.isValueOn(cell);
  const int depth = mCells.getValueDepth(cell);
  const int size = kTiles[depth < 0 ? 0 : depth];
  double end = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    if (direction[axis] == 0) continue;
    const int low = cell[axis] & ~(size - 1);
    const double face = direction[axis] > 0 ? low + size : low;
    end = std::min(end, t + (face - place[axis]) * mCell / direction[axis]);
  }
  return {occupied, std::max(end, std::nextafter(t, std::numeric_limits<double>::infinity()))};
}

}  // namespace vdbtools
