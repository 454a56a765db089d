// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/render/preview.h"

#include "base/lattice_transform.h"
#include "render/preview_renderer.h"
#include "render/surface_tracer.h"

#include "vdbtools/base/errors.h"

#include <cmath>
#include <optional>
#include <vector>

namespace vdbtools {
namespace {

using openvdb::Vec3d;

/// The surface of a level set, in index space. The voxels are cubes, so angles are those of the world.
class LevelSetSurface {
 public:
  explicit LevelSetSurface(const SurfaceLattice& lattice) : mTracer(lattice) {}

  std::optional<HitPoint> firstHit(const Vec3d& eye, const Vec3d& direction) {
    constexpr double kLeaveSurface = 1.0;  // voxels along the normal, so that a ray does not hit its own surface
    const std::optional<double> hit = mTracer.firstHit(eye, direction);
    if (!hit) return std::nullopt;
    const Vec3d position = eye + *hit * direction;
    Vec3d normal = mTracer.normal(position);
    if (!normal.normalize(0)) normal = -direction;
    return HitPoint{*hit, position + kLeaveSurface * normal, normal, std::nullopt};
  }
  bool blocked(const Vec3d& origin, const Vec3d& direction) { return mTracer.blocked(origin, direction); }

 private:
  SurfaceTracer mTracer;
};

void requireLevelSet(const openvdb::FloatGrid& grid) {
  if (grid.getGridClass() != openvdb::GRID_LEVEL_SET) {
    throw DataError("the grid \"" + grid.getName() + "\" is not a level set (its class is " +
                    openvdb::GridBase::gridClassToString(grid.getGridClass()) + "), so it has no surface to show");
  }
  if (!hasCubicVoxels(grid)) {
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

ShadedImage renderPreview(const openvdb::FloatGrid& levelSet, const PreviewOptions& options, Monitor& monitor) {
  const PixelSamples samples(options.width, options.height, options.samples);
  requireAngles(options.view);
  requireLevelSet(levelSet);
  const std::vector<PreviewBall> balls = ballsInIndexSpace(levelSet, options.balls);
  monitor.throwIfCancelled();

  const openvdb::MaskTree cells = surfaceCells(levelSet.tree(), monitor);
  if (cells.empty()) throw DataError("the level set \"" + levelSet.getName() + "\" is empty: its sign never changes");
  const SurfaceBounds bounds = boundsOf(cells);
  const FramedBall ball{levelSet.indexToWorld(bounds.centre), bounds.radius * levelSet.voxelSize()[0]};
  const auto turn = [&](const Vec3d& direction) {
    return levelSet.transform().baseMap()->applyInverseJacobian(direction).unit();
  };
  const auto [camera, sky] = cameraAndSky(options, ball, samples.aspect());
  PreviewStage stage = previewStage(
      camera, options.look, sky, samples.aspect(), ball,
      [&](const Vec3d& point) { return levelSet.worldToIndex(point); }, turn);
  if (options.look.ground) stage.floor = lowestCorner(stage.sky, cells);

  const SurfaceLattice lattice(levelSet.tree(), cells);
  monitor.throwIfCancelled();
  return renderStage(
      stage, options, samples, balls, [&] { return LevelSetSurface(lattice); }, monitor);
}

}  // namespace vdbtools
