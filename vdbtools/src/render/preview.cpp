// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/render/preview.h"

#include "render/surface_tracer.h"
#include "render/view.h"

#include "vdbtools/base/errors.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

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

using openvdb::Vec3d;

// The lights, in linear RGB. A warm key from the upper left, a cool sky with a warm floor, and a rim from behind.
const Vec3d kKeyColour(1.22, 1.12, 0.97);
const Vec3d kSkyColour(0.44, 0.50, 0.60);
const Vec3d kFloorColour(0.10, 0.08, 0.07);
const Vec3d kRimColour(0.62, 0.70, 0.85);
constexpr double kKeyRadius = 0.07;  ///< of the key's disk at distance 1: soft shadow edges
constexpr double kSheen = 0.10, kSheenSharpness = 18;
/// The part of the sky's light that a blocked ray still brings: light bounced off the clay that it meets.
constexpr double kBounce = 0.25;

constexpr int kGatherRaysPerPixel = 32;  ///< fewer leave a visible grain
constexpr int kShadowRaysPerPixel = 16;  ///< likewise, in the soft edges of shadows
constexpr double kLeaveSurface = 1.0;    ///< voxels along the normal, so that a ray does not meet the surface it left
constexpr int kPixelsPerCheck = 16;      ///< between checks of the monitor

/// Camera and lights in index space. The voxels are cubes there, so angles are those of the world.
struct Stage {
  Vec3d eye, forward;
  Vec3d right, up;  ///< to the edges of the picture at distance 1
  Vec3d sky, key, rim;
};

Stage makeStage(const openvdb::FloatGrid& grid, const Camera& camera, UpAxis up, double aspect) {
  const auto toIndex = [&](const Vec3d& direction) {
    return grid.transform().baseMap()->applyInverseJacobian(direction).unit();
  };
  const CameraFrame frame = frameOf(camera);
  // The lights turn with the camera, but stay upright.
  const Vec3d sky = directionOf(up), front = frame.right.cross(sky);

  Stage stage;
  stage.eye = grid.worldToIndex(camera.eye);
  stage.forward = toIndex(frame.forward);
  stage.right = toIndex(frame.right) * (frame.tangent * aspect);
  stage.up = toIndex(frame.up) * frame.tangent;
  stage.sky = toIndex(sky);
  stage.key = toIndex(-0.70 * frame.right + 0.82 * sky + 0.62 * front);
  stage.rim = toIndex(0.95 * frame.right + 0.30 * sky - 0.25 * front);
  return stage;
}

/// Two directions that complete @a n to an orthonormal frame (Duff et al., "Building an Orthonormal Basis, Revisited").
std::array<Vec3d, 2> tangents(const Vec3d& n) {
  const double sign = std::copysign(1.0, n[2]);
  const double a = -1 / (sign + n[2]), b = n[0] * n[1] * a;
  return {Vec3d(1 + sign * n[0] * n[0] * a, sign * b, -sign * n[0]), Vec3d(b, sign + n[1] * n[1] * a, -n[1])};
}

/// @param v  at least 0
double fraction(double v) { return v - static_cast<int>(v); }

/// The cosine and the sine of an angle.
struct Turn {
  double cosine, sine;
  static Turn by(double turns) {
    const double angle = 2 * std::numbers::pi * turns;
    return {std::cos(angle), std::sin(angle)};
  }
  Turn after(const Turn& other) const {
    return {cosine * other.cosine - sine * other.sine, sine * other.cosine + cosine * other.sine};
  }
};

/// Low-discrepancy points in a disk, a sequence for each pixel: they depend on the pixel only, hence not on the
/// threads.
class PixelSequence {
 public:
  PixelSequence(int x, int y) {
    // A hash (splitmix64) gives neighbours unrelated shifts: a fine grain instead of a pattern.
    std::uint64_t h = (std::uint64_t(std::uint32_t(y)) << 32 | std::uint32_t(x)) + 0x9e3779b97f4a7c15ULL;
    h = (h ^ (h >> 30)) * 0xbf58476d1ce4e5b9ULL;
    h = (h ^ (h >> 27)) * 0x94d049bb133111ebULL;
    h ^= h >> 31;
    mShift = double(h >> 32) * 0x1p-32;
    mTurn = Turn::by(double(h & 0xffffffffU) * 0x1p-32);
  }
  struct Point {
    double square;  ///< of the distance from the centre
    Turn turn;
  };
  /// Point @a i of the R2 sequence, shifted. @param i  below kMost
  Point operator()(int i) const {
    static const std::array<Turn, kMost> turns = [] {
      std::array<Turn, kMost> result;
      for (std::size_t k = 0; k < result.size(); ++k) result[k] = Turn::by(kStep * static_cast<double>(k));
      return result;
    }();
    return {fraction(mShift + 0.7548776662 * i), mTurn.after(turns[static_cast<std::size_t>(i)])};
  }

  static constexpr int kMost = 64;

 private:
  static constexpr double kStep = 0.5698402910;
  double mShift;
  Turn mTurn;
};

class Renderer {
 public:
  /// @param balls  in index space
  Renderer(const SurfaceLattice& lattice, const Stage& stage, const PreviewOptions& options,
           const PixelSamples& samples, const std::vector<PreviewBall>& balls)
      : mTracer(lattice),
        mStage(stage),
        mBalls(balls),
        mSamples(samples),
        mCount(options.samples),
        mGatherRays((kGatherRaysPerPixel + options.samples - 1) / options.samples),
        mShadowRays((kShadowRaysPerPixel + options.samples - 1) / options.samples) {}

  Colour pixel(int x, int y) {
    const PixelSequence sequence(x, y);
    Vec3d sum(0);
    for (int s = 0; s < mCount; ++s) {
      const auto [u, v] = mSamples.at(x, y, s);
      const Vec3d direction = (mStage.forward + u * mStage.right + v * mStage.up).unit();
      const auto hit = mTracer.firstHit(mStage.eye, direction);
      const Vec3d seen = hit ? shade(mStage.eye + *hit * direction, direction, sequence, s) : background(u, v);
      sum += withBalls(seen, hit, direction);
    }
    sum /= mCount;
    return toColour(sum);
  }

 private:
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
    const double rim = std::max(0.0, direction.dot(mStage.rim)), square = rim * rim;
    return kFloorColour + height * (kSkyColour - kFloorColour) + square * square * kRimColour;
  }

  Vec3d shade(const Vec3d& position, const Vec3d& view, const PixelSequence& sequence, int sample) {
    Vec3d normal = mTracer.normal(position);
    if (!normal.normalize()) normal = -view;
    const Vec3d origin = position + kLeaveSurface * normal;
    const auto frame = tangents(normal);

    Vec3d gathered(0);
    for (int i = 0; i < mGatherRays; ++i) {
      // Chosen with the density of the cosine, so that each ray counts the same.
      const auto [square, turn] = sequence(sample * mGatherRays + i);
      const double radius = std::sqrt(square);
      const Vec3d direction = radius * turn.cosine * frame[0] + radius * turn.sine * frame[1] +
                              std::sqrt(std::max(0.0, 1 - square)) * normal;
      const Vec3d light = environment(direction);
      gathered += mTracer.blocked(origin, direction) ? kBounce * light * kClay : light;
    }
    Vec3d radiance = kClay * gathered / mGatherRays;

    const auto disk = tangents(mStage.key);
    for (int i = 0; i < mShadowRays; ++i) {
      const auto [square, turn] = sequence(sample * mShadowRays + i);
      const double spread = kKeyRadius * std::sqrt(square);
      const Vec3d key = (mStage.key + spread * (turn.cosine * disk[0] + turn.sine * disk[1])).unit();
      const double facing = key.dot(normal);
      if (facing <= 0 || mTracer.blocked(origin, key)) continue;
      const double glint = std::max(0.0, (key - view).unit().dot(normal));
      radiance += facing * kKeyColour * (kClay + Vec3d(kSheen * std::pow(glint, kSheenSharpness))) / mShadowRays;
    }
    return radiance;
  }

  SurfaceTracer mTracer;
  const Stage& mStage;
  const std::vector<PreviewBall>& mBalls;
  PixelSamples mSamples;
  int mCount;                    ///< of samples in a pixel
  int mGatherRays, mShadowRays;  ///< for each sample
};

void requireLevelSet(const openvdb::FloatGrid& grid) {
  if (grid.getGridClass() != openvdb::GRID_LEVEL_SET) {
    throw DataError("the grid \"" + grid.getName() + "\" is not a level set (its class is " +
                    openvdb::GridBase::gridClassToString(grid.getGridClass()) + "), so it has no surface to show");
  }
  if (!grid.hasUniformVoxels()) {
    throw DataError("the voxels of the level set \"" + grid.getName() + "\" are not cubes; resample it first");
  }
  for (auto value = grid.cbeginValueAll(); value; ++value)
    if (!std::isfinite(*value))
      throw DataError("the level set \"" + grid.getName() + "\" holds a value that is not finite");
}

/// @return the balls, in index space
std::vector<PreviewBall> ballsInIndexSpace(const openvdb::FloatGrid& grid, std::vector<PreviewBall> balls) {
  for (PreviewBall& ball : balls) {
    requireOption(ball.radius > 0, "the radius of a ball", ball.radius, "above 0");
    ball.centre = grid.worldToIndex(ball.centre);
    ball.radius /= grid.voxelSize()[0];
  }
  return balls;
}

}  // namespace

Image renderPreview(const openvdb::FloatGrid& levelSet, const PreviewOptions& options, Monitor& monitor) {
  const PixelSamples samples(options.width, options.height, options.samples);
  requireAngles(options.view);
  requireLevelSet(levelSet);
  const std::vector<PreviewBall> balls = ballsInIndexSpace(levelSet, options.balls);
  monitor.throwIfCancelled();

  const openvdb::MaskTree cells = surfaceCells(levelSet.tree(), monitor);
  if (cells.empty()) throw DataError("the level set \"" + levelSet.getName() + "\" is empty: its sign never changes");
  const SurfaceBounds bounds = boundsOf(cells);
  const FramedBall ball{levelSet.indexToWorld(bounds.centre), bounds.radius * levelSet.voxelSize()[0]};
  const Camera camera = cameraAround(ball, options.view, samples.aspect(), options.up);
  const Stage stage = makeStage(levelSet, camera, options.up, samples.aspect());

  const SurfaceLattice lattice(levelSet.tree(), cells);
  monitor.throwIfCancelled();

  Image image(options.width, options.height);
  monitor.begin("render", static_cast<std::uint64_t>(options.height));
  tbb::parallel_for(tbb::blocked_range<int>(0, options.height), [&](const tbb::blocked_range<int>& rows) {
    Renderer renderer(lattice, stage, options, samples, balls);
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
