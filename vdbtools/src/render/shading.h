// SPDX-License-Identifier: Apache-2.0
/// @file shading.h
/// The light of all shaded pictures, whatever the surface: a key light with soft shadows, and skylight gathered by
/// ambient rays. preview_renderer.h shades level sets and meshes with it, field_shading.h the set of a map.
///
/// An object that casts shadows has the function
///
///     bool blocked(const Vec3d& origin, const Vec3d& direction);
///
/// in a space of its own, which is related to world space by a similarity. The lights turn with the camera. A floor, if
/// there is one, is visible only by its shadows: what is behind it shows through, darkened where the surface blocks its
/// light.
#pragma once

#include "base/elementary.h"
#include "render/view.h"
#include "vdbtools/base/grids.h"
#include "vdbtools/render/look.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

namespace vdbtools {

/// Where a ray first meets a surface.
struct HitPoint {
  double distance = 0;                   ///< along the ray
  openvdb::Vec3d origin;                 ///< origin of the rays that leave the surface there
  openvdb::Vec3d normal;                 ///< of length 1, towards the visible side
  std::optional<openvdb::Vec3d> albedo;  ///< linear RGB; replaces the material's
};

/// Camera and lights in the space of the surface.
struct PreviewStage {
  openvdb::Vec3d eye, forward;
  openvdb::Vec3d right, up;  ///< vectors to the edges of the picture at distance 1
  openvdb::Vec3d sky, key, rim;
  openvdb::Mat3d toWorld;  ///< the rotation of directions into world space
  double scale = 1;        ///< world units per unit of the surface's space
  /// The floor consists of the points whose dot product with the sky is this.
  double floor = -std::numeric_limits<double>::infinity();
  openvdb::Vec3d middle;  ///< centre of the ball around the surface
  double radius = 1;
};

/// @param look   its key light is upright
/// @param sky    the direction of the skylight, world space, of length 1
/// @param ball   around the surface, world space
/// @param place  transforms a point from world space to the surface's
/// @param turn   transforms a direction likewise, to length 1
template <class Place, class Turn>
PreviewStage previewStage(const Camera& camera, const Look& look, const openvdb::Vec3d& sky, double aspect,
                          const FramedBall& ball, const Place& place, const Turn& turn) {
  const CameraFrame frame = frameOf(camera);
  // The lights turn with the camera, but stay upright.
  const openvdb::Vec3d front = frame.right.cross(sky).unit();
  constexpr double kDegree = std::numbers::pi / 180;
  const double azimuth = kDegree * look.keyAzimuth, elevation = kDegree * look.keyElevation;

  PreviewStage stage;
  stage.eye = place(camera.eye);
  stage.forward = turn(frame.forward);
  stage.right = turn(frame.right) * (frame.tangent * aspect);
  stage.up = turn(frame.up) * frame.tangent;
  stage.sky = turn(sky);
  stage.key =
      turn(elementary::cos(elevation) * (elementary::sin(azimuth) * frame.right + elementary::cos(azimuth) * front) +
           elementary::sin(elevation) * sky);
  stage.rim = turn(0.95 * frame.right + 0.30 * sky - 0.25 * front);
  // The images of the axes are the rows of the inverse of a rotation.
  for (int axis = 0; axis < 3; ++axis) {
    openvdb::Vec3d direction(0);
    direction[axis] = 1;
    stage.toWorld.setRow(axis, turn(direction));
  }
  stage.middle = place(ball.centre);
  const openvdb::Vec3d edge = place(ball.centre + ball.radius * frame.right);
  stage.radius = (edge - stage.middle).length();
  stage.scale = ball.radius / stage.radius;
  return stage;
}

namespace preview {

using openvdb::Vec3d;

// The lights, in linear RGB: a warm key light from the upper left, a cool sky with a warm ground, and a rim light from
// behind.
inline const Vec3d kKeyColour(1.22, 1.12, 0.97);
inline const Vec3d kSkyColour(0.44, 0.50, 0.60);
inline const Vec3d kFloorColour(0.10, 0.08, 0.07);
inline const Vec3d kRimColour(0.62, 0.70, 0.85);
inline constexpr double kKeyRadius = 0.07;  ///< radius of the key light's disk at distance 1, for soft shadow edges
/// The fraction of the sky's light that a blocked ray still brings: light reflected from the clay that it meets.
inline constexpr double kBounce = 0.25;

inline constexpr int kGatherRaysPerPixel = 32;  ///< fewer leave a visible grain
inline constexpr int kShadowRaysPerPixel = 16;  ///< likewise, for the soft edges of shadows
inline constexpr int kMirrorRaysPerPixel = 16;  ///< likewise, for reflections
inline constexpr int kFloorRays = 4;            ///< factor for the floor, which is smooth and shows more grain
inline constexpr double kFloorEnds = 6;         ///< in radii from the middle: the floor has no shadows farther out
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

/// Low-discrepancy points in a disk, with a sequence for each pixel that depends only on the pixel, not on the threads.
class PixelSequence {
 public:
  PixelSequence(int x, int y) {
    // A hash (splitmix64) gives adjacent pixels unrelated shifts, for a fine grain instead of a pattern.
    std::uint64_t h = (std::uint64_t(std::uint32_t(y)) << 32 | std::uint32_t(x)) + 0x9e3779b97f4a7c15ULL;
    h = (h ^ (h >> 30)) * 0xbf58476d1ce4e5b9ULL;
    h = (h ^ (h >> 27)) * 0x94d049bb133111ebULL;
    h ^= h >> 31;
    mShift = double(h >> 32) * 0x1p-32;
    mTurn = Turn::by(double(h & 0xffffffffU) * 0x1p-32);
  }
  struct Point {
    double square;  ///< squared distance from the centre
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

  static constexpr int kMost = 512;

 private:
  static constexpr double kStep = 0.5698402910;
  double mShift;
  Turn mTurn;
};

/// What a ray or a pixel shows.
struct Shown {
  Vec3d colour{0};  ///< linear RGB, multiplied by the alpha
  double alpha = 0;
  int hits = 0;  ///< rays that met the surface
  double distance = std::numeric_limits<double>::infinity();
  Vec3d normal{0};  ///< of the nearest point, in the space of the surface
  Vec3d albedo{0};  ///< summed over the hits, like open
  double open = 0;  ///< the fraction of the sky that is not hidden
  double trap = 0;  ///< of the nearest point
};

/// What the rays of a pixel have found about the key light.
class KeyLight {
 public:
  void add(bool isBlocked) { ++(isBlocked ? mBlocked : mClear); }
  /// Whether enough rays agree that no shadow edge is near.
  bool isSettled() const {
    constexpr int kEnough = 8;
    return mBlocked + mClear >= kEnough && (mBlocked == 0 || mClear == 0);
  }

 private:
  int mBlocked = 0, mClear = 0;
};

/// A pixel, the mean of what its rays show.
class Pixel {
 public:
  KeyLight key;

  void add(const Shown& seen, const Vec3d& direction) {
    ++mCount;
    mSum.colour += seen.colour;
    mSum.alpha += seen.alpha;
    mSum.hits += seen.hits;
    mSum.albedo += seen.albedo;
    mSum.open += seen.open;
    if (seen.hits > 0) {
      const double lightness = lightnessOf(seen.colour);
      mDarkest = std::min(mDarkest, lightness);
      mLightest = std::max(mLightest, lightness);
    }
    if (!(seen.distance < mSum.distance)) return;
    mSum.distance = seen.distance;
    mSum.normal = seen.normal;
    mSum.trap = seen.trap;
    mDirection = direction;
  }

  /// Whether more rays would make a visible difference: the surface ends in the pixel, or its lightness varies there.
  /// The background does not count, so that a picture has the same rays with any background.
  bool isRough() const {
    constexpr double kSeen = 0.3;  // in lightness
    if (mSum.hits == 0) return false;
    return mSum.hits < mCount || mLightest - mDarkest > kSeen;
  }

  Shown shown() const {
    Shown mean = mSum;
    mean.colour /= mCount;
    mean.alpha /= mCount;
    return mean;
  }
  /// The direction of the ray to the nearest point.
  const Vec3d& direction() const { return mDirection; }

 private:
  /// From 0 to 1, approximately as perceived.
  static double lightnessOf(const Vec3d& colour) {
    return std::sqrt(std::clamp(0.2126 * colour[0] + 0.7152 * colour[1] + 0.0722 * colour[2], 0.0, 1.0));
  }

  Shown mSum;
  Vec3d mDirection{0};
  int mCount = 0;
  double mDarkest = 1, mLightest = 0;
};

/// Shades points of a surface and what is behind it, for one thread.
template <class Surface>
class Shader {
 public:
  /// @param surface  casts the shadows
  /// @param samples  number of samples per pixel
  Shader(Surface surface, const PreviewStage& stage, const Look& look, int samples)
      : mSurface(std::move(surface)),
        mStage(stage),
        mLook(look),
        mGatherRays((kGatherRaysPerPixel + samples - 1) / samples),
        mShadowRays((kShadowRaysPerPixel + samples - 1) / samples),
        mMirrorRays((kMirrorRaysPerPixel + samples - 1) / samples),
        mGain(elementary::pow(2, look.exposure)) {}

  Surface& surface() { return mSurface; }
  double gain() const { return mGain; }

  /// The light from a direction, except the key light.
  Vec3d environment(const Vec3d& direction) const {
    const double height = 0.5 * (1 + direction.dot(mStage.sky));
    const double rim = std::max(0.0, direction.dot(mStage.rim)), square = rim * rim;
    return mLook.sky * (kFloorColour + height * (kSkyColour - kFloorColour) + square * square * kRimColour);
  }

  /// Shades a ray that meets no surface.
  Shown behind(const Vec3d& direction, double u, double v, const PixelSequence& sequence, int sample) {
    const Vec3d left = lightOfFloor(direction, sequence, sample);
    Shown seen;
    switch (mLook.backdrop) {
      case Backdrop::None:
        // A shadow is black, with a coverage equal to the light that it removes.
        seen.alpha = 1 - (left[0] + left[1] + left[2]) / 3;
        return seen;
      case Backdrop::Neutral: seen.colour = left * background(u, v); break;
      case Backdrop::Plain: seen.colour = left * mLook.plain; break;
    }
    seen.alpha = 1;
    return seen;
  }

  /// @param view  the direction of the ray, of length 1
  /// @param seen  what the other rays of the pixel have found
  Shown shade(const HitPoint& point, const Vec3d& view, const PixelSequence& sequence, int sample, KeyLight& seen) {
    const Material& material = mLook.material;
    const Vec3d &normal = point.normal, &origin = point.origin, albedo = point.albedo.value_or(material.albedo);
    const auto frame = tangents(normal);

    Vec3d gathered(0);
    int open = 0;
    for (int i = 0; i < mGatherRays; ++i) {
      const Vec3d direction = gatherDirection(frame, normal, sequence(sample * mGatherRays + i));
      const Vec3d light = environment(direction);
      const bool blocked = mSurface.blocked(origin, direction);
      gathered += blocked ? kBounce * light * albedo : light;
      open += !blocked;
    }
    Vec3d radiance = albedo * gathered / mGatherRays;

    // The narrower the lobe of a reflecting material, the brighter it is.
    const double lobe = material.mirrors ? (material.sharpness + 8) / 8 : 1;
    const auto disk = tangents(mStage.key);
    Vec3d lit(0);
    int shadowRays = 0;
    while (shadowRays < mShadowRays && (shadowRays == 0 || !seen.isSettled())) {
      const Vec3d key = keyDirection(disk, sequence(sample * mShadowRays + shadowRays++));
      const double facing = key.dot(normal);
      if (facing <= 0) continue;
      const bool blocked = mSurface.blocked(origin, key);
      seen.add(blocked);
      if (blocked) continue;
      const double glint = std::max(0.0, (key - view).unit().dot(normal));
      lit += facing * kKeyColour * (albedo + lobe * elementary::pow(glint, material.sharpness) * material.gloss);
    }
    radiance += lit / shadowRays;
    if (material.mirrors) radiance += mirrored(point, albedo, view, frame, sequence, sample);
    return {.colour = mGain * radiance,
            .alpha = 1,
            .hits = 1,
            .distance = point.distance,
            .normal = normal,
            .albedo = albedo,
            .open = static_cast<double>(open) / mGatherRays};
  }

 private:
  /// The fraction of the light that the surface leaves to the floor where a ray meets it; 1 if there is no floor.
  Vec3d lightOfFloor(const Vec3d& direction, const PixelSequence& sequence, int sample) {
    const double falling = direction.dot(mStage.sky), height = mStage.floor - mStage.eye.dot(mStage.sky);
    if (!std::isfinite(height) || !(falling < 0) || !(height < 0)) return Vec3d(1);
    const Vec3d at = mStage.eye + height / falling * direction;
    const double far = (at - mStage.middle).length() / mStage.radius;
    if (far > kFloorEnds) return Vec3d(1);
    Vec3d all(0), left(0);
    const auto frame = tangents(mStage.sky);
    const int gatherRays = kFloorRays * mGatherRays, shadowRays = kFloorRays * mShadowRays;
    for (int i = 0; i < gatherRays; ++i) {
      const Vec3d towards = gatherDirection(frame, mStage.sky, sequence(sample * gatherRays + i));
      const Vec3d light = environment(towards) / gatherRays;
      all += light;
      if (!mSurface.blocked(at, towards)) left += light;
    }
    const auto disk = tangents(mStage.key);
    for (int i = 0; i < shadowRays; ++i) {
      const Vec3d key = keyDirection(disk, sequence(sample * shadowRays + i));
      const Vec3d light = std::max(0.0, key.dot(mStage.sky)) * kKeyColour / shadowRays;
      all += light;
      if (!mSurface.blocked(at, key)) left += light;
    }
    // The floor fades out, so that it has no visible edge.
    const double fade = std::clamp(2 * far / kFloorEnds - 1, 0.0, 1.0);
    Vec3d share;
    for (int i = 0; i < 3; ++i) share[i] = all[i] > 0 ? std::lerp(left[i] / all[i], 1.0, fade) : 1;
    return share;
  }

  /// Samples with cosine density, so that all rays have the same weight.
  static Vec3d gatherDirection(const std::array<Vec3d, 2>& frame, const Vec3d& normal,
                               const PixelSequence::Point& point) {
    const double radius = std::sqrt(point.square);
    return radius * point.turn.cosine * frame[0] + radius * point.turn.sine * frame[1] +
           std::sqrt(std::max(0.0, 1 - point.square)) * normal;
  }

  Vec3d keyDirection(const std::array<Vec3d, 2>& disk, const PixelSequence::Point& point) const {
    const double spread = kKeyRadius * std::sqrt(point.square);
    return (mStage.key + spread * (point.turn.cosine * disk[0] + point.turn.sine * disk[1])).unit();
  }

  /// The surroundings reflected in a surface, with Blinn's distribution of normals and Schlick's approximation of the
  /// reflectance at an angle.
  Vec3d mirrored(const HitPoint& point, const Vec3d& albedo, const Vec3d& view, const std::array<Vec3d, 2>& frame,
                 const PixelSequence& sequence, int sample) {
    const Material& material = mLook.material;
    Vec3d sum(0);
    for (int i = 0; i < mMirrorRays; ++i) {
      const auto [square, turn] = sequence(sample * mMirrorRays + i);
      const double cosine = elementary::pow(1 - square, 1 / (material.sharpness + 1));
      const double sine = std::sqrt(std::max(0.0, 1 - cosine * cosine));
      const Vec3d half = sine * (turn.cosine * frame[0] + turn.sine * frame[1]) + cosine * point.normal;
      const double towards = -half.dot(view);
      if (towards <= 0) continue;
      const Vec3d direction = view + 2 * towards * half;
      if (direction.dot(point.normal) <= 0) continue;
      const double rest = 1 - towards, fifth = rest * rest * rest * rest * rest;
      const Vec3d share = material.gloss + fifth * (Vec3d(1) - material.gloss);
      const Vec3d light = environment(direction);
      sum += share * (mSurface.blocked(point.origin, direction) ? kBounce * light * albedo : light);
    }
    return sum / mMirrorRays;
  }

  Surface mSurface;
  const PreviewStage& mStage;
  const Look& mLook;
  int mGatherRays, mShadowRays, mMirrorRays;  ///< per sample
  double mGain;                               ///< gain of the exposure
};

}  // namespace preview
}  // namespace vdbtools
