// SPDX-License-Identifier: Apache-2.0
// Materials, lights, floors and layers: what each of them must do to a picture of a ball, whichever renderer makes it.
#include "vdbtools/render/look.h"

#include "render/shadow_proxy.h"
#include "vdbtools/render/field_render.h"
#include "vdbtools/render/preview.h"

#include "julia/quadratic_map.h"

#include <gtest/gtest.h>
#include <openvdb/tools/LevelSetSphere.h>
#include <openvdb/tools/VolumeToMesh.h>

#include <cmath>
#include <functional>
#include <memory>
#include <stdexcept>
#include <vector>

namespace {

using namespace vdbtools;
using openvdb::Vec3d;

Look parsedLook(const Recipe& given) {
  const OptionTable table(lookOptionSpecs());
  return parseLook(RecipeReader(given, table));
}

TEST(Look, ColoursMeanTheSameInEitherNotation) {
  EXPECT_EQ(parsedLook({{"background", "#ff0033"}}).plain, parsedLook({{"background", "1,0,0.2"}}).plain);
  EXPECT_EQ(parsedLook({{"material", "#FFFFFF:matt"}}).material.albedo, Vec3d(1));
  EXPECT_EQ(parsedLook({{"material", "0,0,0"}}).material.albedo, Vec3d(0));
  EXPECT_TRUE(parsedLook({{"material", "0.5,0.5,0.5:metal"}}).material.mirrors);
  EXPECT_EQ(parsedLook({{"background", "none"}}).backdrop, Backdrop::None);
}

TEST(Look, RefusesWhatIsNone) {
  for (const Recipe& bad : std::vector<Recipe>{{{"material", "wood"}},
                                               {{"material", "#12345"}},
                                               {{"material", "#12345g"}},
                                               {{"material", "1,1"}},
                                               {{"material", "1,1,2"}},
                                               {{"material", "1,1,1:wet"}},
                                               {{"material", "clay:metal"}},
                                               {{"light", "10"}},
                                               {{"light", "10,91"}},
                                               {{"light", "nan,0"}},
                                               {{"light", "0,0"}, {"ground", "true"}},
                                               {{"sky", "-0.1"}},
                                               {{"sky", "inf"}},
                                               {{"exposure", "11"}},
                                               {{"background", ""}},
                                               {{"background", "red"}}})
    EXPECT_THROW(parsedLook(bad), std::invalid_argument) << bad.begin()->second;
}

/// Three pictures of one ball, about a point away from the origin.
constexpr double kRadius = 0.8;
const Vec3d kCentre(3, -2, 5);
constexpr int kPictureSide = 72;
constexpr double kVoxel = 0.02;

struct Picture {
  const char* name;
  std::function<ShadedImage(const Look&, const std::set<Pass>&)> make;
};

openvdb::FloatGrid::Ptr ball() {
  openvdb::initialize();
  return openvdb::tools::createLevelSetSphere<openvdb::FloatGrid>(float(kRadius), openvdb::Vec3f(kCentre),
                                                                  float(kVoxel), 3.0F);
}

PreviewOptions previewOptions(const Look& look, const std::set<Pass>& passes) {
  return {.width = kPictureSide,
          .height = kPictureSide,
          .samples = 4,
          .view = {.azimuth = 20, .elevation = 10, .zoom = 0.5},
          .look = look,
          .passes = passes};
}

std::vector<Picture> pictures() {
  Monitor monitor;
  const auto level = [](const Look& look, const std::set<Pass>& passes) {
    Monitor monitor;
    return renderPreview(*ball(), previewOptions(look, passes), monitor);
  };
  const auto mesh = [](const Look& look, const std::set<Pass>& passes) {
    std::vector<openvdb::Vec3s> points;
    std::vector<openvdb::Vec4I> quads;
    openvdb::tools::volumeToMesh(*ball(), points, quads);
    Mesh mesh;
    for (const openvdb::Vec3s& point : points) mesh.points.emplace_back(point);
    for (const openvdb::Vec4I& quad : quads) {
      mesh.triangles.emplace_back(quad[0], quad[2], quad[1]);
      mesh.triangles.emplace_back(quad[0], quad[3], quad[2]);
    }
    Monitor monitor;
    return renderMeshPreview(std::move(mesh), {.picture = previewOptions(look, passes)}, monitor);
  };
  const auto field = [](const Look& look, const std::set<Pass>& passes) {
    // |q|^64 <= 20: a ball of about 1.05 in fractal space.
    constexpr int kSteps = 6;
    const auto evaluator = julia::makeFieldEvaluator<double>(
        std::make_shared<julia::QuadraticMap<double>>(julia::Quaternion<double>{}), {}, {.maxIterations = kSteps});
    const FractalSpace space{kCentre, kRadius / std::pow(20.0, 1.0 / 64)};
    FieldRenderOptions options;
    options.width = options.height = kPictureSide;
    options.camera = cameraAround({kCentre, kRadius + kVoxel}, previewOptions(look, passes).view, 1);
    options.orbit.maxIterations = kSteps;
    options.colour = FieldColour::Clay;
    options.look = look;
    options.passes = passes;
    const openvdb::BBoxd region(kCentre - Vec3d(1.5 * kRadius), kCentre + Vec3d(1.5 * kRadius));
    Monitor monitor;
    return ShadedImage(renderField({*evaluator, space}, region, options, monitor));
  };
  return {{"level set", level}, {"mesh", mesh}, {"field", field}};
}

const std::set<Pass> kAll{Pass::Beauty, Pass::Normal, Pass::Depth, Pass::Albedo, Pass::Ao, Pass::Id};

double brightness(const Colour& colour) { return double(colour[0]) + double(colour[1]) + double(colour[2]); }

// Promise: "All three have the same ..."
TEST(Look, ABallHasTheLayersOfABall) {
  for (const Picture& picture : pictures()) {
    SCOPED_TRACE(picture.name);
    const ShadedImage image = picture.make({}, kAll);
    int seen = 0;
    double first = 0;
    // Each renderer frames a ball of about a voxel more.
    const Camera camera = cameraAround({kCentre, kRadius + kVoxel}, previewOptions({}, {}).view, 1);
    const Vec3d axis = (camera.lookAt - camera.eye).unit();
    for (std::size_t i = 0; i < image.id.size(); ++i) {
      if (image.id[i] == 0) {
        EXPECT_EQ(image.depth[i], kNoDepth);
        EXPECT_EQ(brightness(image.normal.pixels[i]), 0);
        continue;
      }
      ++seen;
      const Colour& n = image.normal.pixels[i];
      const Vec3d normal(n[0], n[1], n[2]);
      EXPECT_NEAR(normal.length(), 1, 1e-5);
      // A point of the ball with this normal lies so much before its middle, and faces the eye.
      const double middle = image.depth[i] - kRadius * normal.dot(axis);
      EXPECT_NEAR(middle, (kCentre - camera.eye).dot(axis), 0.05 * kRadius + 4 * kVoxel) << i;
      if (seen == 1) first = middle;
      EXPECT_NEAR(middle, first, kVoxel) << i;
      EXPECT_LT(normal.dot(axis), 0);
      // Nothing hides the sky from a convex body.
      EXPECT_GT(image.ao[i], 0.97F) << i;
      for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(image.albedo.pixels[i][c], Material{}.albedo[int(c)], 1e-6);
    }
    EXPECT_GT(seen, kPictureSide * kPictureSide / 8);
  }
}

// Promise of pictures.md: "All three have the same camera, the same light and the same materials"
TEST(Look, TheThreeRenderersShowOneLight) {
  Look look;
  look.ground = true;
  const std::vector<Picture> all = pictures();
  const ShadedImage first = all[0].make(look, kAll);
  const auto difference = [&](const ShadedImage& image) {
    double sum = 0;
    for (std::size_t i = 0; i < image.id.size(); ++i)
      sum += std::abs(brightness(image.beauty.pixels[i]) - brightness(first.beauty.pixels[i])) / 3;
    return sum / static_cast<double>(image.id.size());
  };
  look.keyAzimuth = -look.keyAzimuth;
  const double ofAnother = difference(all[0].make(look, kAll));
  look.keyAzimuth = -look.keyAzimuth;
  // What is left are the outlines, as the cameras stand a voxel apart.
  for (const Picture& picture : all) EXPECT_LT(difference(picture.make(look, kAll)), 0.3 * ofAnother) << picture.name;
}

TEST(Look, ExposureMultipliesTheLight) {
  for (const Picture& picture : pictures()) {
    Look look{.backdrop = Backdrop::None}, brighter = look;
    brighter.exposure = 1;
    const ShadedImage one = picture.make(look, {Pass::Beauty}), two = picture.make(brighter, {Pass::Beauty});
    for (std::size_t i = 0; i < one.coverage.size(); ++i)
      for (std::size_t c = 0; c < 3; ++c)
        EXPECT_NEAR(two.beauty.pixels[i][c], 2 * one.beauty.pixels[i][c], 1e-5) << picture.name;
  }
}

// Promise of pictures.md#light-and-materials: `--background none`: a picture with alpha
TEST(Look, AlphaPutsAPictureBeforeAnyBackground) {
  for (const Picture& picture : pictures()) {
    const Vec3d colour(0.1, 0.4, 0.9);
    const ShadedImage cut = picture.make({.backdrop = Backdrop::None}, kAll);
    const ShadedImage plain = picture.make({.backdrop = Backdrop::Plain, .plain = colour}, kAll);
    for (std::size_t i = 0; i < cut.coverage.size(); ++i)
      for (std::size_t c = 0; c < 3; ++c) {
        const double before = double(cut.beauty.pixels[i][c]) + (1 - double(cut.coverage[i])) * colour[int(c)];
        EXPECT_NEAR(plain.beauty.pixels[i][c], before, 1e-5) << picture.name;
        EXPECT_EQ(plain.coverage[i], 1);
      }
  }
}

// Promise of pictures.md: `--ground` "is seen by its shadows alone"
TEST(Look, AFloorIsSeenByItsShadowsAlone) {
  for (const Picture& picture : pictures()) {
    SCOPED_TRACE(picture.name);
    const ShadedImage without = picture.make({}, kAll), with = picture.make({.ground = true}, kAll);
    const ShadedImage cut = picture.make({.ground = true, .backdrop = Backdrop::None}, kAll);
    int darker = 0;
    for (std::size_t i = 0; i < with.id.size(); ++i) {
      const double before = brightness(without.beauty.pixels[i]), now = brightness(with.beauty.pixels[i]);
      EXPECT_LE(now, before + 1e-5);
      darker += now < 0.8 * before;
      if (with.coverage[i] == 1 && cut.coverage[i] == 1) {
        EXPECT_NEAR(now, before, 1e-5);
      }
      EXPECT_EQ(with.id[i], without.id[i]);
    }
    EXPECT_GT(darker, kPictureSide * kPictureSide / 100);
  }
}

TEST(Look, TheBrighterSideIsThatOfTheKeyLight) {
  for (const Picture& picture : pictures()) {
    for (const auto& [azimuth, elevation] : {std::pair{-80.0, 0.0}, {80.0, 0.0}, {0.0, 80.0}, {0.0, -80.0}}) {
      Look look;
      look.keyAzimuth = azimuth;
      look.keyElevation = elevation;
      look.sky = 0;
      look.backdrop = Backdrop::None;
      const ShadedImage image = picture.make(look, kAll);
      Vec3d towards(0);
      for (int y = 0; y < kPictureSide; ++y)
        for (int x = 0; x < kPictureSide; ++x)
          towards +=
              brightness(image.beauty.at(x, y)) * Vec3d(x + 0.5 - kPictureSide / 2.0, kPictureSide / 2.0 - y - 0.5, 0);
      if (azimuth != 0) {
        EXPECT_GT(towards[0] * azimuth, 2 * std::abs(towards[1] * azimuth)) << picture.name << ' ' << azimuth;
      } else {
        EXPECT_GT(towards[1] * elevation, 2 * std::abs(towards[0] * elevation)) << picture.name << ' ' << elevation;
      }
    }
  }
}

TEST(ShadowProxy, RaysAreBlockedByABallWhereverTheyComeFrom) {
  const auto evaluator = julia::makeFieldEvaluator<double>(
      std::make_shared<julia::QuadraticMap<double>>(julia::Quaternion<double>{}), {}, {.maxIterations = 6});
  const double radius = std::pow(20.0, 1.0 / 64);
  const openvdb::BBoxd region(Vec3d(-2), Vec3d(2));
  Monitor monitor;
  for (const double reach : {2.0, 0.2, 0.01}) {
    const ShadowProxy proxy(*evaluator, {region, Vec3d(radius, 0, 0), reach, 64}, monitor);
    EXPECT_NEAR(proxy.radius(), radius, 0.15);
    EXPECT_NEAR(proxy.lowestAlong(Vec3d(0, 1, 0)), -radius, 0.08);
    ShadowProxy::Surface surface(proxy);
    int compared = 0;
    for (int i = 0; i < 4000; ++i) {
      // Points about the ball, and directions, spread by irrational turns.
      const auto unit = [](double a, double b) {
        const double z = 2 * (a - std::floor(a)) - 1, turn = 6.283185307 * b, r = std::sqrt(1 - z * z);
        return Vec3d(r * std::cos(turn), r * std::sin(turn), z);
      };
      const Vec3d origin = (radius * (1.08 + 0.5 * (i % 7) / 7.0)) * unit(0.618034 * i, 0.754878 * i);
      const Vec3d direction = unit(0.5698 * i, 0.819173 * i);
      const double along = -origin.dot(direction);
      const double nearest = along > 0 ? (origin + along * direction).length() : origin.length();
      if (std::abs(nearest - radius) < 0.08) continue;  // a voxel
      EXPECT_EQ(surface.blocked(origin, direction), nearest < radius) << reach << ' ' << i;
      ++compared;
    }
    EXPECT_GT(compared, 2500);
    // What leaves a point of the surface outward meets nothing.
    for (int i = 0; i < 200; ++i) {
      const double turn = 0.0314159 * i;
      const Vec3d normal(std::cos(turn), std::sin(turn), 0);
      EXPECT_FALSE(surface.blocked(surface.leave(0.9999 * radius * normal, -normal, normal), normal)) << reach;
    }
  }
}

}  // namespace
