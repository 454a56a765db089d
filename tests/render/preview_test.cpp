// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/render/preview.h"

#include "support/interrupting.h"
#include "support/test_images.h"

#include "vdbtools/base/errors.h"

#include <gtest/gtest.h>
#include <openvdb/tools/LevelSetSphere.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

using openvdb::FloatGrid;
using openvdb::Vec3d;
using openvdb::Vec3f;
using test_images::difference;
using test_monitors::Interrupting;
using vdbtools::Image;
using vdbtools::Monitor;
using vdbtools::PreviewOptions;
using vdbtools::renderPreview;

namespace {

constexpr double kHalfWidth = 3;  // voxels

FloatGrid::Ptr sphere(double radius, double voxelSize, const Vec3f& centre = Vec3f(0)) {
  return openvdb::tools::createLevelSetSphere<FloatGrid>(float(radius), centre, float(voxelSize), kHalfWidth);
}

/// A level set by a function in world units, clamped to the half width, in a box of [-extent, extent]^3.
FloatGrid::Ptr levelSet(double extent, double voxelSize, const std::function<double(const Vec3d&)>& phi) {
  const double background = kHalfWidth * voxelSize;
  auto grid = FloatGrid::create(float(background));
  grid->setTransform(openvdb::math::Transform::createLinearTransform(voxelSize));
  grid->setGridClass(openvdb::GRID_LEVEL_SET);
  auto accessor = grid->getAccessor();
  const int n = static_cast<int>(std::ceil(extent / voxelSize));
  for (int i = -n; i <= n; ++i) {
    for (int j = -n; j <= n; ++j) {
      for (int k = -n; k <= n; ++k) {
        const openvdb::Coord ijk(i, j, k);
        const double v = phi(grid->indexToWorld(ijk));
        if (v < background) accessor.setValue(ijk, float(std::max(v, -background)));
      }
    }
  }
  return grid;
}

PreviewOptions smallPreview(int width, int height, int samples = 1) {
  PreviewOptions options;
  options.width = width;
  options.height = height;
  options.samples = samples;
  options.view.azimuth = 0;
  options.view.elevation = 0;
  return options;
}

Image renderedBeauty(const FloatGrid& grid, const PreviewOptions& options) {
  Monitor monitor;
  return renderPreview(grid, options, monitor).beauty;
}

/// The background is neutral, the clay is not.
bool isClay(const std::array<float, 3>& c) { return c[0] - c[2] > 1e-3F; }

int area(const Image& image) {
  return static_cast<int>(std::count_if(image.pixels.begin(), image.pixels.end(), isClay));
}

TEST(Preview, SphereFillsTheFrameByItsSilhouette) {
  const double radius = 1, voxel = 1.0 / 40;
  const auto grid = sphere(radius, voxel);
  for (const double fieldOfView : {10.0, 30.0, 90.0}) {
    for (const auto& [width, height] : std::vector<std::pair<int, int>>{{120, 120}, {200, 120}, {120, 200}}) {
      PreviewOptions options = smallPreview(width, height);
      options.view.fieldOfView = fieldOfView;
      const Image image = renderedBeauty(*grid, options);
      // The camera's distance is that of a ball that holds the sphere and reaches at most two voxels beyond it.
      const double perPixel = std::tan(fieldOfView * std::numbers::pi / 360) / (0.5 * height);
      const double half = std::atan(perPixel * 0.5 * std::min(width, height));
      const auto discFor = [&](double ball) {
        const double pixels = std::tan(std::asin(radius / ball * std::sin(half))) / perPixel;
        return std::numbers::pi * pixels * pixels;
      };
      EXPECT_LT(area(image), 1.01 * discFor(radius)) << fieldOfView << ' ' << width << 'x' << height;
      EXPECT_GT(area(image), 0.99 * discFor(radius + 2 * voxel)) << fieldOfView << ' ' << width << 'x' << height;
      EXPECT_TRUE(isClay(image.at(width / 2, height / 2)));
      EXPECT_FALSE(isClay(image.at(0, 0)));
    }
  }
}

TEST(Preview, ZoomMagnifies) {
  const auto grid = sphere(1, 1.0 / 30);
  PreviewOptions options = smallPreview(160, 160);
  const double whole = area(renderedBeauty(*grid, options));
  options.view.zoom = 0.5;
  EXPECT_NEAR(area(renderedBeauty(*grid, options)) / whole, 0.25, 0.01);
  options.view.zoom = 3;
  EXPECT_EQ(area(renderedBeauty(*grid, options)), 160 * 160);
}

/// A large ball in the middle and a small one in the given direction.
FloatGrid::Ptr ballWithSatellite(const Vec3d& direction) {
  return levelSet(1.5, 1.0 / 24,
                  [&](const Vec3d& p) { return std::min(p.length() - 0.7, (p - 1.1 * direction).length() - 0.25); });
}

TEST(Preview, CameraStandsWhereTheAnglesSay) {
  struct Case {
    Vec3d satellite;
    double azimuth, elevation;
    int right, down;  ///< where the small ball is seen
  };
  for (const Case& c : {Case{{1, 0, 0}, 0, 0, 1, 0}, Case{{0, 1, 0}, 0, 0, 0, -1}, Case{{1, 0, 0}, 180, 0, -1, 0},
                        Case{{0, 0, 1}, 90, 0, -1, 0}, Case{{0, 0, 1}, -90, 0, 1, 0}, Case{{0, 0, 1}, 0, 90, 0, 1},
                        Case{{0, 0, 1}, 0, -90, 0, -1}, Case{{0, 1, 0}, 77, 0, 0, -1}}) {
    PreviewOptions options = smallPreview(80, 80);
    options.view.azimuth = c.azimuth;
    options.view.elevation = c.elevation;
    const Image image = renderedBeauty(*ballWithSatellite(c.satellite), options);
    // The frame's centre is that of both balls, so the large one weighs down the other side.
    double x = 0, y = 0;
    for (int j = 0; j < 80; ++j) {
      for (int i = 0; i < 80; ++i) {
        if (!isClay(image.at(i, j))) continue;
        x += i - 39.5;
        y += j - 39.5;
      }
    }
    x /= area(image);
    y /= area(image);
    EXPECT_NEAR(x, -8 * c.right, 4) << c.satellite << " at " << c.azimuth << ' ' << c.elevation;
    EXPECT_NEAR(y, -8 * c.down, 4) << c.satellite << " at " << c.azimuth << ' ' << c.elevation;
  }
}

TEST(Preview, MirroredAzimuthMirrorsTheSilhouette) {
  // Symmetric in x, not in z.
  const auto grid = levelSet(1.2, 1.0 / 24, [](const Vec3d& p) {
    const double ears = std::min((p - Vec3d(0.6, 0.5, 0.2)).length(), (p - Vec3d(-0.6, 0.5, 0.2)).length()) - 0.35;
    return std::min({p.length() - 0.5, ears, (p - Vec3d(0, -0.2, 0.7)).length() - 0.3});
  });
  PreviewOptions options = smallPreview(120, 120);
  options.view.elevation = 20;
  options.view.azimuth = 35;
  const Image left = renderedBeauty(*grid, options);
  options.view.azimuth = -35;
  const Image right = renderedBeauty(*grid, options);
  int different = 0, unlike = 0;
  for (int y = 0; y < 120; ++y) {
    for (int x = 0; x < 120; ++x) {
      different += isClay(left.at(x, y)) != isClay(right.at(119 - x, y));
      unlike += isClay(left.at(x, y)) != isClay(right.at(x, y));
    }
  }
  EXPECT_LE(different, 12);  // rounding, at the very edge
  EXPECT_GT(unlike, 500);    // the test would notice
}

TEST(Preview, LightComesFromTheUpperLeft) {
  const Image image = renderedBeauty(*sphere(1, 1.0 / 30), smallPreview(100, 100, 4));
  const auto red = [&](int x, int y) { return image.at(x, y)[0]; };
  EXPECT_GT(red(35, 30), 1.5F * red(70, 75));
  for (const auto& pixel : image.pixels) {
    for (const float channel : pixel) {
      EXPECT_TRUE(channel > 0 && channel < 1.3F) << channel;
    }
  }
}

TEST(Preview, WhatStandsBeforeTheLightCastsAShadow) {
  // A ball with two small ones at opposite sides, which keeps the frame: before the light (upper left, in front), or
  // not.
  const auto scene = [](double front) {
    const Vec3d lid(-0.56, 0.66, 0.5 * front);
    return levelSet(1, 1.0 / 24, [=](const Vec3d& p) {
      return std::min({p.length() - 0.5, (p - lid).length() - 0.2, (p + lid).length() - 0.2});
    });
  };
  const PreviewOptions options = smallPreview(200, 200, 4);
  const int x = 76, y = 72;  // the point of the ball towards the light
  const Image shaded = renderedBeauty(*scene(1), options), lit = renderedBeauty(*scene(-1), options);
  ASSERT_TRUE(isClay(shaded.at(x, y)));
  EXPECT_LT(shaded.at(x, y)[0], 0.6F * lit.at(x, y)[0]);
}

double noise(const openvdb::Coord& ijk) {
  std::uint32_t h =
      std::uint32_t(ijk[0]) * 73856093U ^ std::uint32_t(ijk[1]) * 19349663U ^ std::uint32_t(ijk[2]) * 83492791U;
  h = (h ^ (h >> 15)) * 0x2c1b3c6dU;
  h = (h ^ (h >> 12)) * 0x297a2d39U;
  return (h ^ (h >> 15)) / 4294967296.0 - 0.5;
}

TEST(Preview, SteepRoughFieldHasNoHoles) {
  // From 0 to the background within a voxel, plus a noise of a few voxels: |grad| is near 10, and most values near the
  // surface are clamped.
  const double voxel = 1.0 / 32;
  const auto grid = levelSet(1.4, voxel, [&](const Vec3d& p) {
    return 10 * (p.length() - 1 + 3 * voxel * noise(openvdb::Coord::round(p / voxel)));
  });
  PreviewOptions options = smallPreview(200, 200);
  const Image image = renderedBeauty(*grid, options);
  int holes = 0;
  for (int y = 0; y < 200; ++y) {
    for (int x = 0; x < 200; ++x) {
      if (std::hypot(x - 99.5, y - 99.5) < 88) holes += !isClay(image.at(x, y));
    }
  }
  EXPECT_EQ(holes, 0);
}

TEST(Preview, ASimilarityOfTheWorldChangesNothing) {
  // Turned about y by the azimuth's own step, scaled and moved far away: the same picture, up to the voxels.
  const PreviewOptions options = smallPreview(90, 90, 4);
  const auto grid = ballWithSatellite(Vec3d(1, 0, 0));
  const Image expected = renderedBeauty(*grid, options);

  auto moved = grid->deepCopy();
  auto transform = grid->transform().copy();
  transform->postScale(250.0);
  transform->postTranslate(Vec3d(1e4, -2e4, 3e4));
  moved->setTransform(transform);
  EXPECT_LT(difference(renderedBeauty(*moved, options), expected), 1e-4);

  auto turned = grid->deepCopy();
  transform = grid->transform().copy();
  transform->postRotate(std::numbers::pi / 2, openvdb::math::Y_AXIS);
  turned->setTransform(transform);
  const Vec3d direction = transform->indexToWorld(Vec3d(1, 0, 0)).unit();
  PreviewOptions fromThere = options;
  fromThere.view.azimuth = direction[2] < 0 ? 90 : -90;  // where that direction is to the right again
  // The noise of the shading is laid out in the grid's axes.
  EXPECT_LT(difference(renderedBeauty(*turned, fromThere), expected), 5e-3);
  EXPECT_GT(difference(renderedBeauty(*turned, options), expected), 5e-2);
}

TEST(Preview, SamePictureForAnyNumberOfThreads) {
  const auto grid = ballWithSatellite(Vec3d(0.6, 0.8, 0));
  PreviewOptions options;
  options.width = 90;
  options.height = 70;
  const auto with = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return renderedBeauty(*grid, options).pixels;
  };
  const auto one = with(1);
  EXPECT_EQ(one, with(2));
  EXPECT_EQ(one, with(4));
}

TEST(Preview, SamplesSmoothTheEdge) {
  const auto grid = sphere(1, 1.0 / 20);
  for (const int samples : {1, 4, 9, 16}) {
    const Image image = renderedBeauty(*grid, smallPreview(64, 64, samples));
    int between = 0;  // pixels of the silhouette's edge: neither neutral nor as coloured as the clay's own shades
    for (const auto& c : image.pixels) between += isClay(c) && c[2] > 0.8F * c[0];
    EXPECT_EQ(between > 0, samples > 1) << samples;
  }
  // One pixel is a picture too.
  EXPECT_EQ(area(renderedBeauty(*grid, smallPreview(1, 1))), 1);
}

TEST(Preview, BallsAreMarksThatShowThrough) {
  const auto grid = sphere(1, 1.0 / 30, Vec3f(5, 0, 0));
  PreviewOptions options = smallPreview(101, 101);
  const Image bare = renderedBeauty(*grid, options);
  const auto with = [&](const Vec3d& centre, double radius) {
    options.balls = {{centre, radius, {0, 0, 1}}};
    return renderedBeauty(*grid, options);
  };
  const auto isBlue = [](const auto& c) { return c[2] > c[0]; };
  // Before the surface: a disc of its size, and nothing else changes.
  const Image before = with(Vec3d(5, 0, 2), 0.2);
  // A ball of radius r at the distance d from the eye is seen as a disc of r / sqrt(d^2 - r^2) focal lengths: the unit
  // sphere's disc says where the eye is.
  const double focal = 101 / (2 * std::tan(std::numbers::pi / 12));
  const double sphereDisc = std::sqrt(area(bare) / std::numbers::pi);
  const double eye = std::hypot(focal / sphereDisc, 1);
  const double expected = focal * 0.2 / std::sqrt((eye - 2) * (eye - 2) - 0.2 * 0.2);
  int blue = 0;
  for (int y = 0; y < 101; ++y)
    for (int x = 0; x < 101; ++x) {
      const double off = std::hypot(x - 50, y - 50);
      if (off < expected - 2) {
        EXPECT_TRUE(isBlue(before.at(x, y))) << x << ' ' << y;
      }
      if (off > expected + 2) {
        EXPECT_EQ(before.at(x, y), bare.at(x, y)) << x << ' ' << y;
      }
      blue += isBlue(before.at(x, y));
    }
  EXPECT_NEAR(blue, std::numbers::pi * expected * expected, 0.15 * std::numbers::pi * expected * expected);
  // Not far behind the surface it shines through, mixed with the clay; far behind, or at the other side, it is hidden.
  const auto through = with(Vec3d(5, 0, 0.7), 0.1).at(50, 50);
  EXPECT_LT(through[0], 0.7F * bare.at(50, 50)[0]);
  EXPECT_GT(through[0], 0.3F * bare.at(50, 50)[0]);
  EXPECT_EQ(with(Vec3d(5, 0, -0.5), 0.1).pixels, bare.pixels);
  EXPECT_THROW(with(Vec3d(5, 0, 0), 0), std::invalid_argument);
}

TEST(Preview, ReportsProgress) {
  struct Counter : Monitor {
    std::string phase;
    std::uint64_t total = 0;
    std::atomic<std::uint64_t> done{0};
    void begin(const vdbtools::Phase& name, std::uint64_t steps) override { phase = name.text(), total = steps; }
    void advance(std::uint64_t steps) override { done += steps; }
  } monitor;
  renderPreview(*sphere(1, 0.1), smallPreview(31, 17), monitor);
  EXPECT_EQ(monitor.phase, "render");
  EXPECT_EQ(monitor.total, 17U);
  EXPECT_EQ(monitor.done, 17U);
}

TEST(Preview, StopsSoonWhenCancelled) {
  const auto grid = sphere(1, 1.0 / 40);
  Interrupting before(1);
  EXPECT_THROW(renderPreview(*grid, smallPreview(20, 20), before), vdbtools::Interrupted);

  // Wider rows ask more often, once in 100 pixels at least, and what is cancelled among them hardly asks again: it ends
  // after few pixels, however wide a picture is.
  const auto asked = [&](int width) {
    Interrupting never(std::numeric_limits<std::int64_t>::max());
    renderPreview(*grid, smallPreview(width, 40), never);
    return never.asked();
  };
  const std::int64_t all = asked(1000), inRows = all - asked(1);
  EXPECT_GT(inRows, 1000 * 40 / 100);
  Interrupting during(all - inRows / 2);
  EXPECT_THROW(renderPreview(*grid, smallPreview(1000, 40), during), vdbtools::Interrupted);
  EXPECT_LT(during.asked() - (all - inRows / 2), inRows / 4);
}

TEST(Preview, RefusesOptionsOutOfTheirDomain) {
  const auto grid = sphere(1, 0.1);
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  const std::vector<std::function<void(PreviewOptions&)>> faults = {[](auto& o) { o.width = 0; },
                                                                    [](auto& o) { o.height = -5; },
                                                                    [](auto& o) { o.width = 1 << 20; },
                                                                    [](auto& o) { o.view.azimuth = kNaN; },
                                                                    [](auto& o) { o.view.elevation = 91; },
                                                                    [](auto& o) { o.view.elevation = kNaN; },
                                                                    [](auto& o) { o.view.fieldOfView = 0; },
                                                                    [](auto& o) { o.view.fieldOfView = 180; },
                                                                    [](auto& o) { o.samples = 0; },
                                                                    [](auto& o) { o.samples = 5; },
                                                                    [](auto& o) { o.view.zoom = 0; },
                                                                    [](auto& o) { o.view.zoom = -1; },
                                                                    [](auto& o) { o.view.zoom = 1.0 / 0.0; }};
  for (std::size_t i = 0; i < faults.size(); ++i) {
    PreviewOptions options = smallPreview(8, 8);
    faults[i](options);
    EXPECT_THROW(renderedBeauty(*grid, options), std::invalid_argument) << "fault " << i;
  }
}

TEST(Preview, RefusesWhatIsNoLevelSet) {
  const auto fog = sphere(1, 0.1);
  fog->setGridClass(openvdb::GRID_FOG_VOLUME);
  EXPECT_THROW(renderedBeauty(*fog, smallPreview(8, 8)), vdbtools::DataError);

  const auto stretched = sphere(1, 0.1);
  stretched->transform().preScale(Vec3d(1, 2, 1));
  EXPECT_THROW(renderedBeauty(*stretched, smallPreview(8, 8)), vdbtools::DataError);

  const auto empty = FloatGrid::create(0.3F);
  empty->setGridClass(openvdb::GRID_LEVEL_SET);
  EXPECT_THROW(renderedBeauty(*empty, smallPreview(8, 8)), vdbtools::DataError);

  const auto positive = empty->deepCopy();
  positive->fill(openvdb::CoordBBox(openvdb::Coord(0), openvdb::Coord(20)), 0.1F);
  EXPECT_THROW(renderedBeauty(*positive, smallPreview(8, 8)), vdbtools::DataError);
}

}  // namespace
