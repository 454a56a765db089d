// SPDX-License-Identifier: Apache-2.0
/// @file preview_renderer.h
/// Renders surfaces for which rays can be intersected, with the light of shading.h. preview.cpp renders level sets with
/// it, and mesh_preview.cpp meshes. In addition to the shadow interface, such a surface has
///
///     std::optional<HitPoint> firstHit(const Vec3d& eye, const Vec3d& direction);
#pragma once

#include "render/image_layers.h"
#include "render/shading.h"
#include "vdbtools/base/monitor.h"
#include "vdbtools/render/preview.h"
#include "vdbtools/render/shaded_image.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

namespace vdbtools {

/// The camera of a picture, and the direction of its skylight. @param ball  around the surface
inline std::pair<Camera, openvdb::Vec3d> cameraAndSky(const PreviewOptions& options, const FramedBall& ball,
                                                      double aspect) {
  if (options.camera) return {*options.camera, options.camera->up.unit()};
  return {cameraAround(ball, options.view, aspect, options.up), directionOf(options.up)};
}

namespace preview {

/// Renders the pixels of a picture, for one thread.
template <class Surface>
class Renderer {
 public:
  /// @param balls  in the surface's space
  Renderer(Surface surface, const PreviewStage& stage, const PreviewOptions& options, const PixelSamples& samples,
           const std::vector<PreviewBall>& balls)
      : mShader(std::move(surface), stage, options.look, options.samples),
        mStage(stage),
        mBalls(balls),
        mSamples(samples) {}

  Pixel pixel(int x, int y) {
    const PixelSequence sequence(x, y);
    Pixel pixel;
    const auto look = [&](int begin, int end) {
      for (int s = begin; s < end; ++s) {
        const auto [u, v] = mSamples.at(x, y, s);
        const Vec3d direction = (mStage.forward + u * mStage.right + v * mStage.up).unit();
        const std::optional<HitPoint> hit = mShader.surface().firstHit(mStage.eye, direction);
        Shown seen =
            hit ? mShader.shade(*hit, direction, sequence, s, pixel.key) : mShader.behind(direction, u, v, sequence, s);
        addBalls(seen, direction);
        pixel.add(seen, direction);
      }
    };
    look(0, mSamples.usual());
    if (pixel.isRough()) look(mSamples.usual(), 2 * mSamples.usual());
    return pixel;
  }

 private:
  /// Draws the nearest ball in front of what is visible, or blends it in if it is not far behind.
  void addBalls(Shown& seen, const Vec3d& direction) const {
    constexpr double kSeenThrough = 0.55;  // fraction of a ball's colour
    constexpr double kDepth = 8;           // radii behind the surface
    double nearest = std::numeric_limits<double>::infinity();
    const PreviewBall* ball = nullptr;
    for (const PreviewBall& candidate : mBalls) {
      const Vec3d to = candidate.centre - mStage.eye;
      const double along = to.dot(direction), off = to.lengthSqr() - along * along;
      const double square = candidate.radius * candidate.radius - off;
      if (square < 0) continue;
      const double entry = along - std::sqrt(square);
      if (entry <= 0 || entry >= nearest || entry > seen.distance + kDepth * candidate.radius) continue;
      nearest = entry;
      ball = &candidate;
    }
    if (!ball) return;
    const Vec3d normal = (mStage.eye + nearest * direction - ball->centre) / ball->radius;
    const Vec3d colour(ball->colour[0], ball->colour[1], ball->colour[2]);
    const Vec3d lit =
        mShader.gain() * colour * (mShader.environment(normal) + std::max(0.0, normal.dot(mStage.key)) * kKeyColour);
    const double opacity = nearest <= seen.distance ? 1 : kSeenThrough;
    seen.colour = opacity * lit + (1 - opacity) * seen.colour;
    seen.alpha = opacity + (1 - opacity) * seen.alpha;
  }

  Shader<Surface> mShader;
  const PreviewStage& mStage;
  const std::vector<PreviewBall>& mBalls;
  PixelSamples mSamples;
};

}  // namespace preview

/// @param samples      the samples of the options
/// @param balls        in the surface's space
/// @param makeSurface  makes a surface for one thread
/// @throw Interrupted
template <class MakeSurface>
ShadedImage renderStage(const PreviewStage& stage, const PreviewOptions& options, const PixelSamples& samples,
                        const std::vector<PreviewBall>& balls, const MakeSurface& makeSurface, Monitor& monitor) {
  preview::Layers layers(options.width, options.height, options.passes);
  monitor.begin(PhaseKind::Render, static_cast<std::uint64_t>(options.height));
  tbb::parallel_for(tbb::blocked_range<int>(0, options.height), [&](const tbb::blocked_range<int>& rows) {
    preview::Renderer renderer(makeSurface(), stage, options, samples, balls);
    for (int y = rows.begin(); y != rows.end(); ++y) {
      for (int x = 0; x < options.width; ++x) {
        if (x % preview::kPixelsPerCheck == 0) monitor.throwIfCancelled();
        const preview::Pixel pixel = renderer.pixel(x, y);
        const auto at =
            static_cast<std::size_t>(y) * static_cast<std::size_t>(options.width) + static_cast<std::size_t>(x);
        layers.set(at, pixel.shown(), stage.forward.dot(pixel.direction()) * stage.scale, stage.toWorld);
      }
      monitor.advance(1);
    }
  });
  return layers.take();
}

}  // namespace vdbtools
