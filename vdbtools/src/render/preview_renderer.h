// SPDX-License-Identifier: Apache-2.0
/// @file preview_renderer.h
/// The light of the shaded pictures, whatever the surface: a key light with soft shadows, and the light of the sky
/// gathered by ambient rays. preview.cpp renders level sets with it, mesh_preview.cpp meshes.
///
/// A surface has
///
///     std::optional<SurfacePoint> firstHit(const Vec3d& eye, const Vec3d& direction);
///     bool blocked(const Vec3d& origin, const Vec3d& direction);
///
/// in a space of its own, which differs from world space by a similarity. The lights turn with the camera.
#pragma once

#include "base/elementary.h"
#include "render/view.h"
#include "vdbtools/base/grids.h"
#include "vdbtools/base/monitor.h"
#include "vdbtools/picture/image.h"
#include "vdbtools/render/preview.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <optional>
#include <vector>

namespace vdbtools {

/// Where a ray first meets a surface.
struct SurfacePoint {
  double distance = 0;    ///< along the ray
  openvdb::Vec3d origin;  ///< of the rays that leave the surface there
  openvdb::Vec3d normal;  ///< of length 1, towards the side that is seen
  openvdb::Vec3d albedo;  ///< linear RGB
};

/// Camera and lights in the space of the surface.
struct PreviewStage {
  openvdb::Vec3d eye, forward;
  openvdb::Vec3d right, up;  ///< to the edges of the picture at distance 1
  openvdb::Vec3d sky, key, rim;
};

/// @param up     of the world: the lights stand upright
/// @param place  world space to the surface's, of a point
/// @param turn   the same of a direction, giving length 1
template <class Place, class Turn>
PreviewStage previewStage(const Camera& camera, UpAxis up, double aspect, const Place& place, const Turn& turn) {
  const CameraFrame frame = frameOf(camera);
  // The lights turn with the camera, but stay upright.
  const openvdb::Vec3d sky = directionOf(up), front = frame.right.cross(sky);

  PreviewStage stage;
  stage.eye = place(camera.eye);
  stage.forward = turn(frame.forward);
  stage.right = turn(frame.right) * (frame.tangent * aspect);
  stage.up = turn(frame.up) * frame.tangent;
  stage.sky = turn(sky);
  stage.key = turn(-0.70 * frame.right + 0.82 * sky + 0.62 * front);
  stage.rim = turn(0.95 * frame.right + 0.30 * sky - 0.25 * front);
  return stage;
}

namespace preview {

using openvdb::Vec3d;

// The lights, in linear RGB. A warm key from the upper left, a cool sky with a warm floor, and a rim from behind.
inline const Vec3d kKeyColour(1.22, 1.12, 0.97);
inline const Vec3d kSkyColour(0.44, 0.50, 0.60);
inline const Vec3d kFloorColour(0.10, 0.08, 0.07);
inline const Vec3d kRimColour(0.62, 0.70, 0.85);
inline constexpr double kKeyRadius = 0.07;  ///< of the key's disk at distance 1: soft shadow edges
inline constexpr double kSheen = 0.10, kSheenSharpness = 18;
/// The part of the sky's light that a blocked ray still brings: light bounced off the clay that it meets.
inline constexpr double kBounce = 0.25;

inline constexpr int kGatherRaysPerPixel = 32;  ///< fewer leave a visible grain
inline constexpr int kShadowRaysPerPixel = 16;  ///< likewise, in the soft edges of shadows
inline constexpr int kPixelsPerCheck = 16;      ///< between checks of the monitor

/// Two directions that complete @a n to an orthonormal frame (Duff et al., "Building an Orthonormal Basis, Revisited").
inline std::array<Vec3d, 2> tangents(const Vec3d& n) {
  const double sign = std::copysign(1.0, n[2]);
  const double a = -1 / (sign + n[2]), b = n[0] * n[1] * a;
  return {Vec3d(1 + sign * n[0] * n[0] * a, sign * b, -sign * n[0]), Vec3d(b, sign + n[1] * n[1] * a, -n[1])};
}

/// @param v  at least 0
inline double fraction(double v) { return v - static_cast<int>(v); }

/// The cosine and the sine of an angle.
struct Turn {
  double cosine, sine;
  static Turn by(double turns) {
    const double angle = 2 * std::numbers::pi * turns;
    return {elementary::cos(angle), elementary::sin(angle)};
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

/// The pixels of a picture, for one thread.
template <class Surface>
class Renderer {
 public:
  /// @param balls  in the surface's space
  Renderer(Surface surface, const PreviewStage& stage, const PreviewOptions& options, const PixelSamples& samples,
           const std::vector<PreviewBall>& balls)
      : mSurface(std::move(surface)),
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
      const std::optional<SurfacePoint> hit = mSurface.firstHit(mStage.eye, direction);
      const Vec3d seen = hit ? shade(*hit, direction, sequence, s) : background(u, v);
      sum += withBalls(seen, hit ? std::optional(hit->distance) : std::nullopt, direction);
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

  Vec3d shade(const SurfacePoint& point, const Vec3d& view, const PixelSequence& sequence, int sample) {
    const Vec3d &normal = point.normal, &origin = point.origin, &albedo = point.albedo;
    const auto frame = tangents(normal);

    Vec3d gathered(0);
    for (int i = 0; i < mGatherRays; ++i) {
      // Chosen with the density of the cosine, so that each ray counts the same.
      const auto [square, turn] = sequence(sample * mGatherRays + i);
      const double radius = std::sqrt(square);
      const Vec3d direction = radius * turn.cosine * frame[0] + radius * turn.sine * frame[1] +
                              std::sqrt(std::max(0.0, 1 - square)) * normal;
      const Vec3d light = environment(direction);
      gathered += mSurface.blocked(origin, direction) ? kBounce * light * albedo : light;
    }
    Vec3d radiance = albedo * gathered / mGatherRays;

    const auto disk = tangents(mStage.key);
    for (int i = 0; i < mShadowRays; ++i) {
      const auto [square, turn] = sequence(sample * mShadowRays + i);
      const double spread = kKeyRadius * std::sqrt(square);
      const Vec3d key = (mStage.key + spread * (turn.cosine * disk[0] + turn.sine * disk[1])).unit();
      const double facing = key.dot(normal);
      if (facing <= 0 || mSurface.blocked(origin, key)) continue;
      const double glint = std::max(0.0, (key - view).unit().dot(normal));
      radiance +=
          facing * kKeyColour * (albedo + Vec3d(kSheen * elementary::pow(glint, kSheenSharpness))) / mShadowRays;
    }
    return radiance;
  }

  Surface mSurface;
  const PreviewStage& mStage;
  const std::vector<PreviewBall>& mBalls;
  PixelSamples mSamples;
  int mCount;                    ///< of samples in a pixel
  int mGatherRays, mShadowRays;  ///< for each sample
};

}  // namespace preview

/// @param samples      of the options
/// @param balls        in the surface's space
/// @param makeSurface  gives a surface for one thread
/// @throw Interrupted
template <class MakeSurface>
Image renderStage(const PreviewStage& stage, const PreviewOptions& options, const PixelSamples& samples,
                  const std::vector<PreviewBall>& balls, const MakeSurface& makeSurface, Monitor& monitor) {
  Image image(options.width, options.height);
  monitor.begin("render", static_cast<std::uint64_t>(options.height));
  tbb::parallel_for(tbb::blocked_range<int>(0, options.height), [&](const tbb::blocked_range<int>& rows) {
    preview::Renderer renderer(makeSurface(), stage, options, samples, balls);
    for (int y = rows.begin(); y != rows.end(); ++y) {
      for (int x = 0; x < options.width; ++x) {
        if (x % preview::kPixelsPerCheck == 0) monitor.throwIfCancelled();
        image.at(x, y) = renderer.pixel(x, y);
      }
      monitor.advance(1);
    }
  });
  return image;
}

}  // namespace vdbtools
