// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/scene/feature_sizes.h"

#include "base/counter_random.h"
#include "base/elementary.h"
#include "base/in_parallel.h"

#include <openvdb/tools/Interpolation.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

namespace vdbtools {
namespace {

using openvdb::BBoxd;
using openvdb::Coord;
using openvdb::FloatGrid;
using openvdb::Vec3d;
using Leaf = FloatGrid::TreeType::LeafNodeType;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A place on the surface. The nodes whose distance is at most half a voxel fill a layer of one voxel about the
/// surface, so each of them represents the same area.
struct Place {
  Vec3d at;        ///< index space, on a node
  double phi = 0;  ///< the distance there, voxels
  Vec3d normal;    ///< outward, of length 1; 0 if there is none
};

/// Half the width of the layer, voxels; slightly more than 1/2, because a rounding error must not empty the layer.
constexpr float kHalfLayer = 0.500001F;

class SurfacePlaces {
 public:
  SurfacePlaces(const FloatGrid& phi, const std::optional<BBoxd>& box) : mPhi(phi), mVoxel(phi.voxelSize()[0]) {
    constexpr double kAbout = 2;  // voxels, so that a box between the nodes has places, too
    if (box) {
      mBox = phi.transform().worldToIndex(*box);
      mBox->expand(kAbout);
    }
    phi.tree().getNodes(mLeaves);
  }

  /// @param area  set to the area of the surface, square voxels
  std::vector<Place> choose(double& area, Monitor& monitor) const {
    std::vector<std::size_t> before(mLeaves.size() + 1, 0);
    inParallel(mLeaves.size(), 64, monitor, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i != end; ++i) forEach(*mLeaves[i], [&](openvdb::Index) { ++before[i + 1]; });
    });
    for (std::size_t i = 0; i < mLeaves.size(); ++i) before[i + 1] += before[i];
    // Divides the sequence of all nodes into equal pieces, and chooses one node from each.
    const std::size_t all = before.back(), count = std::min(all, kMeasuredPlaces);
    area = static_cast<double>(all);
    std::vector<std::size_t> chosen(count);
    for (std::size_t i = 0; i < count; ++i) {
      const double piece = static_cast<double>(all) / static_cast<double>(count);
      const double number = (static_cast<double>(i) + randomUnit(1, 0, i)) * piece;
      chosen[i] = std::min(all - 1, static_cast<std::size_t>(number));
    }
    std::vector<Place> places(count);
    inParallel(count, 64, monitor, [&](std::size_t begin, std::size_t end) {
      const FloatGrid::ConstAccessor access = mPhi.getConstAccessor();
      for (std::size_t i = begin; i != end; ++i) {
        const auto after = std::upper_bound(before.begin(), before.end(), chosen[i]);
        const auto leaf = static_cast<std::size_t>(after - before.begin()) - 1;
        std::size_t left = chosen[i] - before[leaf];
        Coord node;
        forEach(*mLeaves[leaf], [&](openvdb::Index offset) {
          if (left-- == 0) node = mLeaves[leaf]->offsetToGlobalCoord(offset);
        });
        places[i] = placeAt(node, access);
      }
    });
    return places;
  }

 private:
  template <class Body>
  void forEach(const Leaf& leaf, const Body& body) const {
    if (mBox && !mBox->hasOverlap(BBoxd(leaf.origin().asVec3d(), leaf.origin().offsetBy(Leaf::DIM - 1).asVec3d())))
      return;
    const float* const values = leaf.buffer().data();
    const float most = kHalfLayer * static_cast<float>(mVoxel);
    for (openvdb::Index i = 0; i < Leaf::SIZE; ++i) {
      if (!(std::abs(values[i]) <= most) || !leaf.isValueOn(i)) continue;
      if (mBox && !mBox->isInside(leaf.offsetToGlobalCoord(i).asVec3d())) continue;
      body(i);
    }
  }

  Place placeAt(const Coord& node, const FloatGrid::ConstAccessor& access) const {
    Place place{.at = node.asVec3d(), .phi = static_cast<double>(access.getValue(node)) / mVoxel, .normal = Vec3d(0)};
    for (int axis = 0; axis < 3; ++axis) {
      Coord one(0);
      one[axis] = 1;
      place.normal[axis] =
          static_cast<double>(access.getValue(node + one)) - static_cast<double>(access.getValue(node - one));
    }
    const double length = std::sqrt(place.normal.lengthSqr());
    place.normal = length > 0 ? place.normal / length : Vec3d(0);
    return place;
  }

  const FloatGrid& mPhi;
  double mVoxel;              ///< world units
  std::optional<BBoxd> mBox;  ///< index space
  std::vector<const Leaf*> mLeaves;
};

/// The largest factor by which a linear map of R^3 stretches a vector. @param columns  the images of the axes
double greatestStretch(const std::array<julia::Quaternion<double>, 3>& columns) {
  const auto dot = [](const julia::Quaternion<double>& p, const julia::Quaternion<double>& q) {
    return p.a * q.a + p.b * q.b + p.c * q.c + p.d * q.d;
  };
  double gram[3][3];
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t k = 0; k < 3; ++k) gram[i][k] = dot(columns[i], columns[k]);
  // Finds the largest eigenvalue by powers of the matrix. After eight squarings the trace is the 256th power of the
  // eigenvalue, up to a factor of 3, whose 256th root differs from 1 by less than 1/200.
  constexpr std::size_t kSquares = 8;
  std::array<double, kSquares + 1> traces{};
  for (std::size_t step = 0; step <= kSquares; ++step) {
    const double trace = traces[step] = gram[0][0] + gram[1][1] + gram[2][2];
    if (!(trace > 0)) return 0;
    double square[3][3];
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t k = 0; k < 3; ++k) {
        square[i][k] = 0;
        for (std::size_t j = 0; j < 3; ++j) square[i][k] += gram[i][j] / trace * (gram[j][k] / trace);
      }
    std::copy(&square[0][0], &square[0][0] + 9, &gram[0][0]);
  }
  double eigenvalue = traces[kSquares];
  for (std::size_t step = kSquares; step-- > 0;) eigenvalue = traces[step] * std::sqrt(eigenvalue);
  return std::sqrt(eigenvalue);
}

/// The width of the texture at points of fractal space, in its units; infinity where nothing turns.
std::vector<double> textureWidths(const std::vector<julia::Point>& points, const julia::FieldEvaluator& evaluator,
                                  double step, Monitor& monitor) {
  constexpr double kTurn = 6.28318530717958647693;
  constexpr std::size_t kEach = 4;  // versors
  std::vector<double> widths(points.size());
  inParallel(points.size(), 128, monitor, [&](std::size_t begin, std::size_t end) {
    std::vector<julia::Point> at;
    for (std::size_t i = begin; i != end; ++i)
      for (std::size_t k = 0; k < kEach; ++k) {
        at.push_back(points[i]);
        if (k > 0) at.back()[k - 1] += step;
      }
    std::vector<julia::Quaternion<double>> versors(at.size());
    evaluator.versors(at, versors);
    for (std::size_t i = begin; i != end; ++i) {
      const julia::Quaternion<double>* const u = versors.data() + kEach * (i - begin);
      std::array<julia::Quaternion<double>, 3> turned;
      for (std::size_t axis = 0; axis < 3; ++axis) turned[axis] = u[axis + 1] - u[0];
      // A chord of the unit sphere, and the angle that it spans.
      const double chord = std::min(1.0, greatestStretch(turned) / 2);
      const double angle = 2 * elementary::asin(chord);
      widths[i] = angle > 0 ? kTurn * step / angle : kInfinity;
    }
  });
  return widths;
}

/// The lengths of straight lines through the target, from places on its surface along the inward normal; voxels.
/// Infinity if a line is longer than the limit, or leaves the band in which the distances are known.
std::vector<double> chordsFrom(const std::vector<Place>& places, const FloatGrid& phi, double limit, Monitor& monitor) {
  const double voxel = phi.voxelSize()[0];
  // Farther away, nodes have the value of the background.
  const double known = std::abs(static_cast<double>(phi.background())) / voxel;
  constexpr double kStep = 0.5;  // voxels: steps over no wall that the lattice shows
  std::vector<double> lengths(places.size(), kInfinity);
  inParallel(places.size(), 64, monitor, [&](std::size_t begin, std::size_t end) {
    const FloatGrid::ConstAccessor access = phi.getConstAccessor();
    for (std::size_t i = begin; i != end; ++i) {
      const Place& place = places[i];
      if (place.normal == Vec3d(0)) continue;
      // The line enters at the distance phi behind the node.
      const double entry = place.phi;
      double at = entry + kStep, before = entry, depthBefore = 0;
      for (;;) {
        if (at - entry > limit) break;
        const double depth =
            -static_cast<double>(openvdb::tools::BoxSampler::sample(access, place.at - place.normal * at)) / voxel;
        if (depth <= 0) {
          lengths[i] = before + (at - before) * depthBefore / (depthBefore - depth) - entry;
          break;
        }
        if (depth >= 0.99 * known) break;
        before = at;
        depthBefore = depth;
        at += std::max(kStep, depth);
      }
    }
  });
  return lengths;
}

}  // namespace

SortedSizes::SortedSizes(std::vector<double> sizes) : mSizes(std::move(sizes)) {
  std::sort(mSizes.begin(), mSizes.end());
}

double SortedSizes::shareBelow(double size) const {
  if (mSizes.empty()) return 0;
  const auto below = std::lower_bound(mSizes.begin(), mSizes.end(), size) - mSizes.begin();
  return static_cast<double>(below) / static_cast<double>(mSizes.size());
}

double SortedSizes::quantile(double share) const {
  if (mSizes.empty()) return kInfinity;
  const auto below = static_cast<std::size_t>(share * static_cast<double>(mSizes.size()));
  return mSizes[std::min(below, mSizes.size() - 1)];
}

double SortedSizes::positiveQuantile(double share) const {
  const auto first = std::upper_bound(mSizes.begin(), mSizes.end(), 0.0);
  const auto count = static_cast<std::size_t>(mSizes.end() - first);
  if (count == 0) return 0;
  const auto below = static_cast<std::size_t>(share * static_cast<double>(count));
  return first[static_cast<std::ptrdiff_t>(std::min(below, count - 1))];
}

FeatureSizes measureFeatureSizes(const Target& target, const ExponentGridOptions& shell,
                                 const julia::FieldEvaluator& evaluator, const FractalSpace& space,
                                 const std::optional<BBoxd>& box, Monitor& monitor) {
  const FloatGrid& phi = *target.phi;
  FeatureSizes sizes;
  const std::vector<Place> places = SurfacePlaces(phi, box).choose(sizes.area, monitor);
  const double voxel = phi.voxelSize()[0];
  sizes.area *= voxel * voxel;
  std::vector<Vec3d> worldPoints;
  worldPoints.reserve(places.size());
  for (const Place& place : places) worldPoints.push_back(phi.indexToWorld(place.at - place.normal * place.phi));

  const double side = target.box.extents()[target.box.maxExtent()];
  std::vector<double> shown(places.size());  // above 0 where there is a texture
  shell.mask.sample(worldPoints, shown);
  if (shell.detail) {
    std::vector<double> inward(places.size()), outward(places.size());
    shell.detail->detail.sample(worldPoints, inward);
    shell.detail->outward.sample(worldPoints, outward);
    for (std::size_t i = 0; i < places.size(); ++i) shown[i] *= inward[i] + outward[i];
  }
  std::vector<julia::Point> textured;
  for (std::size_t i = 0; i < places.size(); ++i)
    if (shown[i] > 0) textured.push_back(space.toFractal(worldPoints[i]));
  constexpr double kStep = 0x1p-12;  // of the longest side
  std::vector<double> widths = textureWidths(textured, evaluator, kStep * side / space.scale, monitor);
  for (double& width : widths) width *= space.scale;
  sizes.texture = SortedSizes(std::move(widths));
  if (!shell.detail) return sizes;

  constexpr double kThick = 0.02;  // of the longest side
  const DetailOptions& detail = *shell.detail;
  const double deepest = std::clamp(detail.detail.range().second, 0.0, 1.0) * detail.greatestThickness;
  const std::vector<double> chords = chordsFrom(places, phi, (kThick * side + 2 * deepest) / voxel, monitor);
  std::vector<std::size_t> thin;
  std::vector<Vec3d> middles;
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (chords[i] == kInfinity) continue;
    thin.push_back(i);
    const Place& place = places[i];
    middles.push_back(phi.indexToWorld(place.at - place.normal * (place.phi + chords[i] / 2)));
  }
  std::vector<double> share(thin.size()), tau(thin.size()), masked(thin.size());
  detail.detail.sample(middles, share);
  detail.thickness.sample(middles, tau);
  shell.mask.sample(middles, masked);
  std::vector<double> core(places.size(), kInfinity);
  for (std::size_t i = 0; i < thin.size(); ++i) {
    const double eaten = 2 * std::clamp(masked[i], 0.0, 1.0) * std::clamp(share[i], 0.0, 1.0) * tau[i];
    const double thickness = std::max(0.0, chords[thin[i]] * voxel - eaten);
    core[thin[i]] = thickness > kThick * side ? kInfinity : thickness;
  }
  sizes.core = SortedSizes(std::move(core));
  return sizes;
}

}  // namespace vdbtools
