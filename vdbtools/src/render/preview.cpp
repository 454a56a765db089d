// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/render/preview.h"

#include <openvdb/math/DDA.h>
#include <openvdb/math/Ray.h>
#include <openvdb/tools/Interpolation.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace vdbtools {
namespace {

using openvdb::Coord;
using openvdb::Vec3d;
using Ray = openvdb::math::Ray<double>;

// The lights, in linear RGB. A warm key from the upper left, a cool sky with a warm floor, and a rim from behind.
const Vec3d kClay(0.55, 0.32, 0.21);
const Vec3d kKeyColour(1.22, 1.12, 0.97);
const Vec3d kSkyColour(0.44, 0.50, 0.60);
const Vec3d kFloorColour(0.10, 0.08, 0.07);
const Vec3d kRimColour(0.62, 0.70, 0.85);
constexpr double kRimSharpness = 4;
constexpr double kKeyRadius = 0.07;  ///< of the key's disk at distance 1: soft shadow edges
constexpr double kSheen = 0.10, kSheenSharpness = 18;
/// What a blocked ray of the gather still brings, as a part of the sky: light bounced off the clay it meets.
constexpr double kBounce = 0.25;
constexpr double kBackgroundTop = 0.86, kBackgroundBottom = 0.64, kVignette = 0.10;

constexpr int kGatherRaysPerPixel = 32;  ///< fewer leave a visible grain
constexpr int kShadowRaysPerPixel = 16;  ///< likewise, in the soft edges of shadows
constexpr double kLeaveSurface = 1.0;    ///< voxels along the normal, so that a ray does not meet the surface it left
constexpr int kPixelsPerCheck = 16;      ///< between two looks at the monitor

/// The cells (the unit cubes between 8 nodes, named after their lowest one) whose corners differ in sign: all that a
/// ray can hit. Found from signs alone, as the field of a rough fractal changes too fast for a test of its values; that
/// is why tools::LevelSetRayIntersector, which passes over values beyond two voxels, leaves holes there.
class SurfaceCells {
 public:
  using Leaf = openvdb::FloatTree::LeafNodeType;

  SurfaceCells(const openvdb::FloatTree& tree, const std::vector<const Leaf*>& leaves, const Monitor& monitor)
      : mTree(tree), mLeaves(leaves), mMonitor(monitor) {}
  SurfaceCells(const SurfaceCells& other, tbb::split) : SurfaceCells(other.mTree, other.mLeaves, other.mMonitor) {}

  void operator()(const tbb::blocked_range<std::size_t>& range) {
    openvdb::FloatGrid::ConstAccessor field(mTree);
    openvdb::tree::ValueAccessor<openvdb::MaskTree> cells(mCells);
    for (std::size_t n = range.begin(); n != range.end(); ++n) {
      mMonitor.throwIfCancelled();
      for (openvdb::Index i = 0; i < Leaf::SIZE; ++i) markAround(*mLeaves[n], i, field, cells);
    }
  }
  void join(SurfaceCells& other) { mCells.merge(other.mCells); }
  openvdb::MaskTree& cells() { return mCells; }

 private:
  template <typename Field, typename Cells>
  static void markAround(const Leaf& leaf, openvdb::Index offset, Field& field, Cells& cells) {
    const bool inside = leaf.getValue(offset) < 0;
    const Coord local = Leaf::offsetToLocalCoord(offset);
    const Coord node = local + leaf.origin();
    for (int axis = 0; axis < 3; ++axis) {
      const auto stride = openvdb::Index(1) << (Leaf::LOG2DIM * (2 - axis));
      Coord next = node, previous = node;
      next[axis] += 1;
      previous[axis] -= 1;
      const bool atEnd = local[axis] == int(Leaf::DIM) - 1;
      const float ahead = atEnd ? field.getValue(next) : leaf.getValue(offset + stride);
      if ((ahead < 0) != inside) markEdge(node, axis, cells);
      // The leaf below may not exist, and then nobody else looks at this edge.
      if (local[axis] == 0 && (field.getValue(previous) < 0) != inside) markEdge(previous, axis, cells);
    }
  }

  /// The four cells around the edge that leaves @a node along @a axis.
  template <typename Cells>
  static void markEdge(const Coord& node, int axis, Cells& cells) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (int corner = 0; corner < 4; ++corner) {
      Coord cell = node;
      cell[u] -= corner & 1;
      cell[v] -= corner >> 1;
      cells.setValueOn(cell);
    }
  }

  const openvdb::FloatTree& mTree;
  const std::vector<const Leaf*>& mLeaves;
  const Monitor& mMonitor;
  openvdb::MaskTree mCells;
};

openvdb::MaskTree surfaceCells(const openvdb::FloatTree& tree, const Monitor& monitor) {
  std::vector<const SurfaceCells::Leaf*> leaves;
  tree.getNodes(leaves);
  SurfaceCells work(tree, leaves, monitor);
  tbb::parallel_reduce(tbb::blocked_range<std::size_t>(0, leaves.size()), work);
  return std::move(work.cells());
}

/// The ball around the surface, in index space.
struct Bounds {
  openvdb::BBoxd box;
  Vec3d centre;
  double radius = 0;
};

Bounds boundsOf(const openvdb::MaskTree& cells) {
  openvdb::CoordBBox extent;
  cells.evalActiveVoxelBoundingBox(extent);
  Bounds bounds;
  bounds.box = openvdb::BBoxd(extent.min().asVec3d(), extent.max().asVec3d() + Vec3d(1));
  bounds.centre = 0.5 * (bounds.box.min() + bounds.box.max());
  for (auto leaf = cells.cbeginLeaf(); leaf; ++leaf) {
    for (auto cell = leaf->cbeginValueOn(); cell; ++cell) {
      const Vec3d middle = cell.getCoord().asVec3d() + Vec3d(0.5);
      bounds.radius = std::max(bounds.radius, (middle - bounds.centre).lengthSqr());
    }
  }
  bounds.radius = std::sqrt(bounds.radius) + 0.5;  // half a cell: the surface is somewhere in it
  return bounds;
}

/// Follows rays through the surface cells and solves for the zero of the trilinear field in each. This is the tester
/// that OpenVDB's hierarchical DDA asks for. One for each thread.
class SurfaceTracer {
 public:
  using RayT = Ray;

  SurfaceTracer(const openvdb::FloatTree& field, const openvdb::MaskTree& cells, const openvdb::BBoxd& box)
      : mField(field), mCells(cells), mBox(box) {}

  /// Where the ray first goes inside, by its parameter.
  std::optional<double> firstHit(const Vec3d& origin, const Vec3d& direction) {
    mRefine = true;
    return trace(origin, direction) ? std::optional(mHit) : std::nullopt;
  }
  bool blocked(const Vec3d& origin, const Vec3d& direction) {
    mRefine = false;
    return trace(origin, direction);
  }

  /// The outward normal: differences over two voxels, which vary continuously where those of the trilinear field jump.
  Vec3d normal(const Vec3d& position) {
    Vec3d gradient;
    for (int axis = 0; axis < 3; ++axis) {
      Vec3d step(0);
      step[axis] = 1;
      gradient[axis] = openvdb::tools::BoxSampler::sample(mField, position + step) -
                       openvdb::tools::BoxSampler::sample(mField, position - step);
    }
    return gradient;
  }

  // For LevelSetHDDA.
  const Ray& ray() const { return mRay; }
  void setRange(double t0, double t1) { mRay.setTimes(t0, t1); }
  template <typename NodeT>
  bool hasNode(const Coord& ijk) {
    return mCells.probeConstNode<NodeT>(ijk) != nullptr;
  }
  void init(double t0) { mEntry = t0; }
  bool operator()(const Coord& cell, double exit) {
    const double entry = mEntry;
    mEntry = exit;
    return mCells.isValueOn(cell) && hitsCell(cell, entry, exit);
  }

 private:
  bool trace(const Vec3d& origin, const Vec3d& direction) {
    constexpr int kUpperNodes = openvdb::MaskTree::RootNodeType::ChildNodeType::LEVEL;
    mRay = Ray(origin, direction);
    return mRay.clip(mBox) && openvdb::math::LevelSetHDDA<openvdb::MaskTree, kUpperNodes>::test(*this);
  }

  bool hitsCell(const Coord& cell, double entry, double exit) {
    double corners[8];
    for (int i = 0; i < 8; ++i) corners[i] = mField.getValue(cell.offsetBy(i >> 2, (i >> 1) & 1, i & 1));
    const auto value = [&](double t) {
      const Vec3d p = mRay(t) - cell.asVec3d();
      const auto mix = [](double a, double b, double w) { return a + w * (b - a); };
      const double low = mix(mix(corners[0], corners[1], p[2]), mix(corners[2], corners[3], p[2]), p[1]);
      const double high = mix(mix(corners[4], corners[5], p[2]), mix(corners[6], corners[7], p[2]), p[1]);
      return mix(low, high, p[0]);
    };

    // Along a ray the field is a cubic; a dip between thirds is a graze that no picture shows.
    constexpr int kParts = 3;
    double before = entry, vBefore = value(entry);
    mHit = entry;
    if (vBefore < 0) return true;
    for (int part = 1; part <= kParts; ++part) {
      const double t = entry + (exit - entry) * part / kParts;
      const double v = value(t);
      if (v < 0) {
        if (mRefine) mHit = zeroBetween(before, vBefore, t, v, value);
        return true;
      }
      before = t, vBefore = v;
    }
    return false;
  }

  template <typename Value>
  static double zeroBetween(double t0, double v0, double t1, double v1, const Value& value) {
    constexpr int kSteps = 4;  // of the false position rule, from a third of a cell
    double t = t1;
    for (int i = 0; i < kSteps && v0 != v1; ++i) {
      t = t0 + (t1 - t0) * v0 / (v0 - v1);
      const double v = value(t);
      (v < 0 ? t1 : t0) = t;
      (v < 0 ? v1 : v0) = v;
    }
    return t;
  }

  openvdb::FloatGrid::ConstAccessor mField;
  openvdb::tree::ValueAccessor<const openvdb::MaskTree> mCells;
  openvdb::BBoxd mBox;
  Ray mRay;
  double mEntry = 0, mHit = 0;
  bool mRefine = true;
};

/// Camera and lights, in index space: its voxels are cubes, so angles are those of the world.
struct Stage {
  Vec3d eye, forward;
  Vec3d right, up;  ///< to the edges of the picture at distance 1
  Vec3d sky, key, rim;
};

Stage makeStage(const openvdb::math::Transform& transform, const Bounds& bounds, const PreviewOptions& options) {
  const auto radians = [](double degrees) { return degrees * (std::numbers::pi / 180); };
  const double azimuth = radians(options.azimuth), elevation = radians(options.elevation);
  const auto toIndex = [&](const Vec3d& world) { return transform.baseMap()->applyInverseJacobian(world).unit(); };

  // World directions. The lights turn with the camera, but stay upright.
  const Vec3d right(std::cos(azimuth), 0, -std::sin(azimuth));
  const Vec3d front(std::sin(azimuth), 0, std::cos(azimuth));
  const Vec3d sky(0, 1, 0);
  const Vec3d towardsEye = std::cos(elevation) * front + std::sin(elevation) * sky;

  const double aspect = double(options.width) / options.height;
  const double tangent = std::tan(0.5 * radians(options.fieldOfView));
  // The ball touches the nearer pair of edges.
  const double distance = bounds.radius / std::sin(std::atan(tangent * std::min(1.0, aspect)));

  Stage stage;
  stage.forward = toIndex(-towardsEye);
  stage.eye = bounds.centre - distance * stage.forward;
  stage.right = toIndex(right) * (tangent * aspect / options.zoom);
  stage.up = toIndex(towardsEye.cross(right)) * (tangent / options.zoom);
  stage.sky = toIndex(sky);
  stage.key = toIndex(-0.70 * right + 0.82 * sky + 0.62 * front);
  stage.rim = toIndex(0.95 * right + 0.30 * sky - 0.25 * front);
  return stage;
}

/// Two directions that complete @a n to an orthonormal frame (Duff et al., "Building an Orthonormal Basis, Revisited").
std::array<Vec3d, 2> tangents(const Vec3d& n) {
  const double sign = std::copysign(1.0, n[2]);
  const double a = -1 / (sign + n[2]), b = n[0] * n[1] * a;
  return {Vec3d(1 + sign * n[0] * n[0] * a, sign * b, -sign * n[0]), Vec3d(b, sign + n[1] * n[1] * a, -n[1])};
}

double fraction(double v) { return v - std::floor(v); }

/// Low-discrepancy points, a sequence for each pixel: they depend on the pixel only, hence not on the threads.
class PixelSequence {
 public:
  PixelSequence(int x, int y) {
    // A hash (splitmix64) gives neighbours unrelated shifts: a fine grain instead of a pattern.
    std::uint64_t h = (std::uint64_t(std::uint32_t(y)) << 32 | std::uint32_t(x)) + 0x9e3779b97f4a7c15ULL;
    h = (h ^ (h >> 30)) * 0xbf58476d1ce4e5b9ULL;
    h = (h ^ (h >> 27)) * 0x94d049bb133111ebULL;
    h ^= h >> 31;
    mShift = {double(h >> 32) * 0x1p-32, double(h & 0xffffffffU) * 0x1p-32};
  }
  /// Point @a i of the R2 sequence, shifted.
  std::array<double, 2> operator()(int i) const {
    return {fraction(mShift[0] + 0.7548776662 * i), fraction(mShift[1] + 0.5698402910 * i)};
  }

 private:
  std::array<double, 2> mShift;
};

class Renderer {
 public:
  /// @param balls  in index space
  Renderer(const openvdb::FloatTree& field, const openvdb::MaskTree& cells, const Bounds& bounds, const Stage& stage,
           const PreviewOptions& options, const std::vector<PreviewBall>& balls)
      : mTracer(field, cells, bounds.box),
        mStage(stage),
        mOptions(options),
        mBalls(balls),
        mGrid(static_cast<int>(std::lround(std::sqrt(options.samples)))),
        mGatherRays((kGatherRaysPerPixel + options.samples - 1) / options.samples),
        mShadowRays((kShadowRaysPerPixel + options.samples - 1) / options.samples) {}

  std::array<float, 3> pixel(int x, int y) {
    const PixelSequence sequence(x, y);
    Vec3d sum(0);
    for (int s = 0; s < mOptions.samples; ++s) {
      const double u = 2 * (x + (s % mGrid + 0.5) / mGrid) / mOptions.width - 1;
      const double v = 1 - 2 * (y + (s / mGrid + 0.5) / mGrid) / mOptions.height;
      const Vec3d direction = (mStage.forward + u * mStage.right + v * mStage.up).unit();
      const auto hit = mTracer.firstHit(mStage.eye, direction);
      const Vec3d seen = hit ? shade(mStage.eye + *hit * direction, direction, sequence, s) : background(u, v);
      sum += withBalls(seen, hit, direction);
    }
    sum /= mOptions.samples;
    return {float(sum[0]), float(sum[1]), float(sum[2])};
  }

 private:
  static Vec3d background(double u, double v) {
    const double height = 0.5 * (v + 1);
    return Vec3d(std::lerp(kBackgroundBottom, kBackgroundTop, height) - kVignette * 0.5 * (u * u + v * v));
  }

  /// What is seen, with the nearest ball before it, or shining through it from not far behind.
  Vec3d withBalls(const Vec3d& seen, const std::optional<double>& hit, const Vec3d& direction) const {
    constexpr double kSeenThrough = 0.55;  // of a ball's colour
    constexpr double kDepth = 8;           // radii behind the surface
    double nearest = std::numeric_limits<double>::infinity();
    const PreviewBall* ball = nullptr;
    for (const PreviewBall& candidate : mBalls) {
      const Vec3d to = candidate.centre - mStage.eye;
      const double along = to.dot(direction), off = to.lengthSqr() - along * along;
      const double square = candidate.radius * candidate.radius - off;
      if (square < 0) continue;
      const double entry = along - std::sqrt(square);
      if (entry <= 0 || entry >= nearest || (hit && entry > *hit + kDepth * candidate.radius)) continue;
      nearest = entry;
      ball = &candidate;
    }
    if (!ball) return seen;
    const Vec3d normal = (mStage.eye + nearest * direction - ball->centre) / ball->radius;
    const Vec3d colour(ball->colour[0], ball->colour[1], ball->colour[2]);
    const Vec3d lit = colour * (environment(normal) + std::max(0.0, normal.dot(mStage.key)) * kKeyColour);
    return !hit || nearest <= *hit ? lit : kSeenThrough * lit + (1 - kSeenThrough) * seen;
  }

  Vec3d environment(const Vec3d& direction) const {
    const double height = 0.5 * (1 + direction.dot(mStage.sky));
    const double rim = std::pow(std::max(0.0, direction.dot(mStage.rim)), kRimSharpness);
    return kFloorColour + height * (kSkyColour - kFloorColour) + rim * kRimColour;
  }

  Vec3d shade(const Vec3d& position, const Vec3d& view, const PixelSequence& sequence, int sample) {
    Vec3d normal = mTracer.normal(position);
    if (!normal.normalize()) normal = -view;
    const Vec3d origin = position + kLeaveSurface * normal;
    const auto frame = tangents(normal);

    Vec3d gathered(0);
    for (int i = 0; i < mGatherRays; ++i) {
      // Chosen with the density of the cosine, so that each ray counts the same.
      const auto [a, b] = sequence(sample * mGatherRays + i);
      const double radius = std::sqrt(a), angle = 2 * std::numbers::pi * b;
      const Vec3d direction = radius * std::cos(angle) * frame[0] + radius * std::sin(angle) * frame[1] +
                              std::sqrt(std::max(0.0, 1 - a)) * normal;
      const Vec3d light = environment(direction);
      gathered += mTracer.blocked(origin, direction) ? kBounce * light * kClay : light;
    }
    Vec3d radiance = kClay * gathered / mGatherRays;

    const auto disk = tangents(mStage.key);
    for (int i = 0; i < mShadowRays; ++i) {
      const auto [a, b] = sequence(sample * mShadowRays + i);
      const double spread = kKeyRadius * std::sqrt(a), angle = 2 * std::numbers::pi * b;
      const Vec3d key = (mStage.key + spread * (std::cos(angle) * disk[0] + std::sin(angle) * disk[1])).unit();
      const double facing = key.dot(normal);
      if (facing <= 0 || mTracer.blocked(origin, key)) continue;
      const double glint = std::max(0.0, (key - view).unit().dot(normal));
      radiance += facing * kKeyColour * (kClay + Vec3d(kSheen * std::pow(glint, kSheenSharpness))) / mShadowRays;
    }
    return radiance;
  }

  SurfaceTracer mTracer;
  const Stage& mStage;
  const PreviewOptions& mOptions;
  const std::vector<PreviewBall>& mBalls;
  int mGrid;                     ///< samples along a pixel's side
  int mGatherRays, mShadowRays;  ///< for each sample
};

void require(bool good, const char* name, double value, const char* domain) {
  if (!good) {
    throw std::invalid_argument(std::string("preview: ") + name + " must be " + domain + ", not " +
                                std::to_string(value));
  }
}

void check(const PreviewOptions& o) {
  constexpr int kLargestSide = 32768;
  require(o.width >= 1 && o.width <= kLargestSide, "width", o.width, "1 to 32768 pixels");
  require(o.height >= 1 && o.height <= kLargestSide, "height", o.height, "1 to 32768 pixels");
  require(std::isfinite(o.azimuth), "azimuth", o.azimuth, "finite");
  require(o.elevation >= -90 && o.elevation <= 90, "elevation", o.elevation, "-90 to 90 degrees");
  require(o.fieldOfView >= 1 && o.fieldOfView <= 150, "fieldOfView", o.fieldOfView, "1 to 150 degrees");
  require(o.samples == 1 || o.samples == 4 || o.samples == 9 || o.samples == 16, "samples", o.samples, "1, 4, 9 or 16");
  require(o.zoom > 0 && std::isfinite(o.zoom), "zoom", o.zoom, "positive");
  for (const PreviewBall& ball : o.balls) require(ball.radius > 0, "a ball's radius", ball.radius, "positive");
}

void check(const openvdb::FloatGrid& grid) {
  if (grid.getGridClass() != openvdb::GRID_LEVEL_SET) {
    throw DataError("the grid \"" + grid.getName() + "\" is no level set (its class is " +
                    openvdb::GridBase::gridClassToString(grid.getGridClass()) + "), so it has no surface to show");
  }
  if (!grid.hasUniformVoxels()) {
    throw DataError("the voxels of the level set \"" + grid.getName() + "\" are no cubes; resample it first");
  }
  for (auto value = grid.cbeginValueAll(); value; ++value)
    if (!std::isfinite(*value))
      throw DataError("the level set \"" + grid.getName() + "\" holds a value that is not finite");
}

}  // namespace

Image renderPreview(const openvdb::FloatGrid& levelSet, const PreviewOptions& options, Monitor& monitor) {
  check(options);
  check(levelSet);
  monitor.throwIfCancelled();

  const openvdb::MaskTree cells = surfaceCells(levelSet.tree(), monitor);
  if (cells.empty()) {
    throw DataError("the level set \"" + levelSet.getName() + "\" is empty: its sign never changes");
  }
  const Bounds bounds = boundsOf(cells);
  const Stage stage = makeStage(levelSet.transform(), bounds, options);

  std::vector<PreviewBall> balls = options.balls;
  for (PreviewBall& ball : balls) {
    ball.centre = levelSet.worldToIndex(ball.centre);
    ball.radius /= levelSet.voxelSize()[0];
  }
  Image image(options.width, options.height);
  monitor.begin("render", static_cast<std::uint64_t>(options.height));
  tbb::parallel_for(tbb::blocked_range<int>(0, options.height), [&](const tbb::blocked_range<int>& rows) {
    Renderer renderer(levelSet.tree(), cells, bounds, stage, options, balls);
    for (int y = rows.begin(); y != rows.end(); ++y) {
      for (int x = 0; x < options.width; ++x) {
        if (x % kPixelsPerCheck == 0) monitor.throwIfCancelled();
        image.at(x, y) = renderer.pixel(x, y);
      }
      monitor.advance(1);
    }
  });
  return image;
}

}  // namespace vdbtools
