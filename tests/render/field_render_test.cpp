// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/render/field_render.h"

#include "support/temporary_folder.h"
#include "support/test_meshes.h"

#include "vdbtools/formats/versor_file.h"
#include "vdbtools/job/fractal_job.h"
#include "vdbtools/mesh_files/mesh_writer.h"
#include "vdbtools/render/preview.h"

#include "julia/quadratic_map.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>
#include <openvdb/tools/LevelSetSphere.h>
#include <tbb/global_control.h>

#include <atomic>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <numbers>
#include <sstream>

namespace {

using namespace vdbtools;
using openvdb::BBoxd;
using openvdb::Vec3d;

/// |q|^(2^n) <= escape: a ball.
constexpr int kIterations = 6;
const double kBall = std::pow(20.0, 1.0 / 64);

/// A quadratic set somewhere in the world, at another scale.
struct Quadratic {
  explicit Quadratic(const julia::Quaternion<double>& c = {}, int iterations = kIterations)
      : evaluator(julia::makeFieldEvaluator<double>(std::make_shared<julia::QuadraticMap<double>>(c), {},
                                                    {.maxIterations = iterations})) {}

  FieldSource source() const { return {*evaluator, space}; }
  BBoxd region() const { return {space.toWorld({-1.7, -1.7, -1.7}), space.toWorld({1.7, 1.7, 1.7})}; }

  std::unique_ptr<julia::FieldEvaluator> evaluator;
  FractalSpace space{Vec3d(3, -2, 5), 2.5};
};

const julia::Quaternion<double> kRough{-0.2, 0.6, 0.2, 0.2};

FieldRenderOptions smallFieldRender(const Quadratic& set, int width, int height, int samples = 1) {
  FieldRenderOptions options;
  options.width = width;
  options.height = height;
  options.samples = samples;
  options.orbit.maxIterations = kIterations;
  options.camera = {.eye = set.space.toWorld({0, 0, 6}), .lookAt = set.space.centre};
  return options;
}

FieldImage renderedField(const Quadratic& set, const FieldRenderOptions& options) {
  Monitor monitor;
  return renderField(set.source(), set.region(), options, monitor);
}

void expectSame(const FieldImage& a, const FieldImage& b) {
  EXPECT_EQ(a.beauty.pixels, b.beauty.pixels);
  EXPECT_EQ(a.coverage, b.coverage);
  EXPECT_EQ(a.normal.pixels, b.normal.pixels);
  EXPECT_EQ(a.depth, b.depth);
  EXPECT_EQ(a.id, b.id);
}

TEST(FieldRender, ABallIsACircleWithItsNormalsAndDepth) {
  const Quadratic set;
  constexpr int kSide = 160;
  FieldRenderOptions options = smallFieldRender(set, kSide, kSide);
  options.look.backdrop = Backdrop::None;
  const FieldImage image = renderedField(set, options);
  const double tangent = std::tan(options.camera.fieldOfView * std::numbers::pi / 360);
  const double radius = std::tan(std::asin(kBall / 6)) / tangent * kSide / 2;  // pixels
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const double a = x + 0.5 - kSide / 2, b = kSide / 2 - y - 0.5, off = std::hypot(a, b);
      const std::size_t at = static_cast<std::size_t>(y * kSide + x);
      if (off < radius - 0.75) {
        ASSERT_EQ(image.id[at], 1) << x << ' ' << y;
      }
      if (off > radius + 0.75) {
        ASSERT_EQ(image.id[at], 0) << x << ' ' << y;
        ASSERT_EQ(image.depth[at], kNoDepth);
        ASSERT_EQ(image.coverage[at], 0);
        ASSERT_EQ(image.normal.pixels[at], (std::array<float, 3>{}));
      }
      if (off > radius - 2) continue;
      // Where the ray meets the ball, in fractal space.
      const Vec3d d = Vec3d(2 * tangent * a / kSide, 2 * tangent * b / kSide, -1).unit(), eye(0, 0, 6);
      const double t = -eye.dot(d) - std::sqrt(std::pow(eye.dot(d), 2) - eye.lengthSqr() + kBall * kBall);
      const Vec3d hit = eye + t * d;
      ASSERT_NEAR(image.depth[at], 2.5 * (6 - hit[2]), 2.5 * 2e-4) << x << ' ' << y;
      const auto& n = image.normal.pixels[at];
      ASSERT_NEAR(Vec3d(n[0], n[1], n[2]).dot(hit.unit()), 1, 1e-3) << x << ' ' << y;  // 2.5 degrees
    }
  }
}

TEST(FieldRender, AnEdgeGetsMoreRaysAndIsSmoother) {
  const Quadratic set;
  constexpr int kSide = 120;
  FieldRenderOptions options = smallFieldRender(set, kSide, kSide, 4);
  options.look.backdrop = Backdrop::None;
  const FieldImage image = renderedField(set, options);
  const double tangent = std::tan(options.camera.fieldOfView * std::numbers::pi / 360);
  const double radius = std::tan(std::asin(kBall / 6)) / tangent * kSide / 2;  // pixels
  /// The part of a pixel in the circle, by n x n places.
  const auto covered = [&](int x, int y, int n) {
    int in = 0;
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j)
        in += std::hypot(x + (i + 0.5) / n - kSide / 2, y + (j + 0.5) / n - kSide / 2) < radius;
    return static_cast<double>(in) / (n * n);
  };
  double error = 0, ofLattice = 0;
  std::uint64_t edges = 0;
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const double truth = covered(x, y, 32), lattice = covered(x, y, 2);
      edges += lattice > 0 && lattice < 1;
      error += std::pow(image.coverage[static_cast<std::size_t>(y * kSide + x)] - truth, 2);
      ofLattice += std::pow(lattice - truth, 2);
    }
  }
  EXPECT_LT(error, 0.6 * ofLattice);
  EXPECT_NEAR(static_cast<double>(image.rays), static_cast<double>(4 * kSide * kSide + 4 * edges),
              0.05 * static_cast<double>(4 * edges))
      << "a ball in even light is rough at its edge alone";
  options.samples = 1;
  EXPECT_EQ(renderedField(set, options).rays, static_cast<std::uint64_t>(kSide * kSide));
}

// Promise of pictures.md: `render --field`: skipped space "does not change the picture"
TEST(FieldRender, SkippingSavesMostAndChangesNothing) {
  for (const auto& c : {julia::Quaternion<double>{}, kRough}) {
    const Quadratic set(c);
    for (const int delta : {0, 1, 2}) {
      FieldRenderOptions options = smallFieldRender(set, 60, 40, 4);
      options.clarity.delta = delta;
      const FieldImage skipped = renderedField(set, options);
      options.skip = false;
      const FieldImage all = renderedField(set, options);
      expectSame(skipped, all);
      EXPECT_LT(2 * skipped.evaluations, all.evaluations);
    }
  }
}

TEST(FieldRender, SkippingSeesTheInsideAndCutsAsItIs) {
  const Quadratic set(kRough);
  FieldRenderOptions options = smallFieldRender(set, 40, 40);
  const BBoxd half(set.region().min(), Vec3d(set.region().max()[0], set.region().max()[1], set.space.centre[2]));
  for (const Vec3d& eye : {set.space.toWorld({0.3, 0.2, 6}), set.space.toWorld({1.2, 0.1, -0.3}), set.space.centre}) {
    options.camera = {.eye = eye, .lookAt = set.space.toWorld({0.01, 0.02, -0.4})};
    Monitor monitor;
    options.skip = true;
    const FieldImage skipped = renderField(set.source(), half, options, monitor);
    options.skip = false;
    expectSame(skipped, renderField(set.source(), half, options, monitor));
  }
  // The cut faces the eye.
  const Quadratic ball;
  options = smallFieldRender(ball, 40, 40);
  Monitor monitor;
  const FieldImage cut = renderField(ball.source(), half, options, monitor);
  EXPECT_EQ(cut.normal.at(20, 20), (std::array<float, 3>{0, 0, 1}));
  EXPECT_NEAR(cut.depth[20 * 40 + 20], 6 * 2.5, 1e-4);
}

TEST(FieldRender, AMapThatProvesNothingIsShownAsWell) {
  struct Silent : julia::FieldEvaluator {
    const julia::FieldEvaluator& other;
    explicit Silent(const julia::FieldEvaluator& o) : other(o) {}
    void evaluate(std::span<const julia::Point> p, std::span<double> f, std::span<int> n) const override {
      other.evaluate(p, f, n);
    }
    void versors(std::span<const julia::Point> p, std::span<julia::Quaternion<double>> u) const override {
      other.versors(p, u);
    }
    void orbitTraps(std::span<const julia::Point> p, std::span<double> l) const override { other.orbitTraps(p, l); }
  };
  const Quadratic set(kRough);
  const Silent silent(*set.evaluator);
  const FieldRenderOptions options = smallFieldRender(set, 40, 30);
  Monitor monitor;
  expectSame(renderedField(set, options), renderField({silent, set.space}, set.region(), options, monitor));
}

TEST(FieldRender, SamePictureForAnyNumberOfThreads) {
  const Quadratic set(kRough);
  const FieldRenderOptions options = smallFieldRender(set, 90, 70, 4);
  const auto with = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return renderedField(set, options);
  };
  const FieldImage one = with(1);
  expectSame(one, with(2));
  expectSame(one, with(4));
}

TEST(FieldRender, APartOfAPictureIsThatPartOfIt) {
  // A ray's samples are its own: in a picture of another shape, other rays march beside it.
  const Quadratic set(kRough);
  const FieldImage wide = renderedField(set, smallFieldRender(set, 100, 50)),
                   narrow = renderedField(set, smallFieldRender(set, 50, 50));
  for (int y = 0; y < 50; ++y)
    for (int x = 0; x < 50; ++x)
      ASSERT_NEAR(wide.depth[static_cast<std::size_t>(y * 100 + x + 25)],
                  narrow.depth[static_cast<std::size_t>(y * 50 + x)], 1e-3)
          << x << ' ' << y;
}

TEST(FieldRender, ColoursAreThoseOfTheMap) {
  const Quadratic set;  // q^2 of a unit imaginary is -1, of 1 is 1
  FieldRenderOptions options = smallFieldRender(set, 41, 41);
  options.colour = FieldColour::Direction;
  options.camera = {.eye = set.space.toWorld({0, 6, 0}), .lookAt = set.space.centre};
  const auto pole = renderedField(set, options).beauty.at(20, 20);
  EXPECT_LT(pole[0], pole[1]);  // (-1, 0, 0)
  EXPECT_NEAR(pole[1], pole[2], 0.02);
  options.camera = {.eye = set.space.toWorld({6, 0, 0}), .lookAt = set.space.centre};
  const auto front = renderedField(set, options).beauty.at(20, 20);
  EXPECT_GT(front[0], front[1]);  // (1, 0, 0)
  std::vector<Image> images;
  for (const FieldColour colour :
       {FieldColour::Direction, FieldColour::Iterations, FieldColour::Trap, FieldColour::Clay}) {
    options.colour = colour;
    images.push_back(renderedField(set, options).beauty);
    for (std::size_t i = 0; i + 1 < images.size(); ++i) EXPECT_NE(images[i].pixels, images.back().pixels);
  }
}

TEST(FieldRender, TheFrameHoldsTheSet) {
  const Quadratic set;
  const FramedBall ball = frameSet(set.source(), set.region());
  EXPECT_LT((ball.centre - set.space.centre).length(), 0.1);
  EXPECT_NEAR(ball.radius, 2.5 * kBall, 0.2);
  for (const double aspect : {0.5, 1.0, 2.0}) {
    FieldRenderOptions options = smallFieldRender(set, static_cast<int>(80 * aspect), 80);
    options.camera = cameraAround(ball, {.azimuth = 25, .elevation = -40, .fieldOfView = 35}, aspect);
    const FieldImage image = renderedField(set, options);
    int covered = 0;
    for (int y = 0; y < options.height; ++y)
      for (int x = 0; x < options.width; ++x) {
        const bool seen = image.id[static_cast<std::size_t>(y * options.width + x)] != 0;
        covered += seen;
        if (x == 0 || y == 0 || x == options.width - 1 || y == options.height - 1) {
          EXPECT_FALSE(seen);
        }
      }
    EXPECT_GT(covered, 0.5 * 80 * 80 * std::min(1.0, aspect) * std::min(1.0, aspect));
  }
}

/// A picture of the same thing from the same place, whichever of the two renderers makes it.
TEST(FieldRender, PreviewsHaveTheSameCameraAndBackground) {
  const Quadratic set;
  const float radius = 2.5F * static_cast<float>(kBall), voxel = 0.05F;
  const auto sphere =
      openvdb::tools::createLevelSetSphere<openvdb::FloatGrid>(radius, openvdb::Vec3f(set.space.centre), voxel, 3.0F);
  const ViewAngles view{.azimuth = 40, .elevation = -90, .fieldOfView = 50, .zoom = 0.6};
  constexpr int kWidth = 90, kHeight = 60;
  Monitor monitor;
  const Image preview =
      renderPreview(*sphere, {.width = kWidth, .height = kHeight, .samples = 1, .view = view}, monitor).beauty;
  FieldRenderOptions options = smallFieldRender(set, kWidth, kHeight);
  // Previews frame the cells of the surface, up to two voxels more than the sphere.
  options.camera = cameraAround({set.space.centre, radius + voxel}, view, 1.0 * kWidth / kHeight);
  const FieldImage field = renderedField(set, options);
  int differently = 0, outside = 0;
  for (std::size_t i = 0; i < field.id.size(); ++i) {
    const bool seen = preview.pixels[i][0] != preview.pixels[i][2];  // the background is neutral
    differently += seen != (field.id[i] != 0);
    if (seen || field.id[i] != 0) continue;
    EXPECT_EQ(preview.pixels[i], field.beauty.pixels[i]);
    ++outside;
  }
  EXPECT_LT(differently, 60);  // at the edge
  EXPECT_GT(outside, kWidth * kHeight / 2);
}

TEST(FieldRender, AnExrHasItsChannels) {
  const Quadratic set;
  FieldRenderOptions options = smallFieldRender(set, 24, 16, 4);
  options.look.backdrop = Backdrop::None;
  const FieldImage image = renderedField(set, options);
  const std::string bytes = encodeFieldImage(image, ".exr");
  EXPECT_EQ(bytes, encodeFieldImage(image, "EXR"));
  OIIO::Filesystem::IOMemReader source(bytes.data(), bytes.size());
  const auto input = OIIO::ImageInput::open("x.exr", nullptr, &source);
  ASSERT_TRUE(input) << OIIO::geterror();
  const OIIO::ImageSpec spec = input->spec();
  std::vector<float> values(24 * 16 * static_cast<std::size_t>(spec.nchannels));
  ASSERT_TRUE(input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, values.data()));
  for (const char* name : {"R", "G", "B", "A", "N.x", "N.y", "N.z", "Z", "id"})
    EXPECT_GE(spec.channelindex(name), 0) << name;
  const auto value = [&](const char* name, std::size_t pixel) {
    return values[pixel * static_cast<std::size_t>(spec.nchannels) + static_cast<std::size_t>(spec.channelindex(name))];
  };
  for (std::size_t i = 0; i < image.depth.size(); ++i) {
    EXPECT_EQ(value("Z", i), image.depth[i]);
    EXPECT_EQ(value("N.z", i), image.normal.pixels[i][2]);
    EXPECT_EQ(value("id", i), image.id[i]);
    EXPECT_EQ(value("A", i), image.coverage[i]);
    if (image.coverage[i] == 0) {
      EXPECT_EQ(value("R", i), 0);
    }
  }
}

TEST(FieldRender, RefusesOptionsOutOfTheirDomain) {
  const Quadratic set;
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  const std::vector<std::function<void(FieldRenderOptions&)>> faults = {[](auto& o) { o.width = 0; },
                                                                        [](auto& o) { o.height = 0; },
                                                                        [](auto& o) { o.height = 1 << 20; },
                                                                        [](auto& o) { o.samples = 2; },
                                                                        [](auto& o) { o.camera.fieldOfView = 0; },
                                                                        [](auto& o) { o.camera.fieldOfView = 180; },
                                                                        [](auto& o) { o.camera.eye = o.camera.lookAt; },
                                                                        [](auto& o) { o.camera.eye[1] = kNaN; },
                                                                        [](auto& o) { o.camera.up = Vec3d(0); },
                                                                        [](auto& o) { o.clarity.epsilon = 0; },
                                                                        [](auto& o) { o.clarity.epsilon = kNaN; },
                                                                        [](auto& o) { o.clarity.alpha = -1; },
                                                                        [](auto& o) { o.clarity.delta = 3; },
                                                                        [](auto& o) { o.clarity.delta = -1; },
                                                                        [](auto& o) { o.orbit.maxIterations = 0; },
                                                                        [](auto& o) { o.orbit.escapeRadius = 1; }};
  for (std::size_t i = 0; i < faults.size(); ++i) {
    FieldRenderOptions options = smallFieldRender(set, 8, 8);
    faults[i](options);
    EXPECT_THROW(renderedField(set, options), std::invalid_argument) << "fault " << i;
  }
  Monitor monitor;
  EXPECT_THROW(renderField(set.source(), BBoxd(), smallFieldRender(set, 8, 8), monitor), std::invalid_argument);
}

TEST(FieldRender, StopsWhenCancelled) {
  struct Stopper : Monitor {
    std::atomic<int> advanced{0};
    void advance(std::uint64_t) override { ++advanced; }
    bool cancelled() const override { return advanced > 1; }
  } stopper;
  const Quadratic set(kRough);
  EXPECT_THROW(renderField(set.source(), set.region(), smallFieldRender(set, 400, 400), stopper), Interrupted);
  EXPECT_LT(stopper.advanced, 20);
}

/// What the camera sees in a pixel's middle, at a depth along the view axis.
struct ViewFrame {
  explicit ViewFrame(const Camera& c)
      : eye(c.eye),
        forward((c.lookAt - c.eye).unit()),
        right(forward.cross(c.up).unit()),
        up(right.cross(forward)),
        tangent(std::tan(c.fieldOfView * std::numbers::pi / 360)) {}

  Vec3d at(int x, int y, int side, double depth) const {
    const double u = 2 * (x + 0.5) / side - 1, v = 1 - 2 * (y + 0.5) / side;
    return eye + depth * (forward + tangent * (u * right + v * up));
  }

  Vec3d eye, forward, right, up;
  double tangent;
};

/// Scenes as the program makes them.
class FieldRenderScene : public testing::Test {
 protected:
  FieldRenderScene() { openvdb::initialize(); }

  std::string write(const std::string& name, const std::string& bytes) const {
    const std::string path = mFolder / name;
    std::ofstream(path, std::ios::binary) << bytes;
    return path;
  }
  Scene scene(Recipe recipe) {
    return makeScene(parseFractalOptions(completeRecipe(std::move(recipe), fractalOptionTable())), mMonitor);
  }
  static BBoxd regionOf(const Scene& scene) { return scene.exponent() ? meshBox(planScene(scene)) : scene.region(); }
  std::string target() const {
    std::ostringstream stream;
    writeMesh(stream,
              test_meshes::merged(test_meshes::makeSphere(1, 3),
                                  test_meshes::makeBox(Vec3d(1.2, -0.3, -0.2), Vec3d(1.8, 0.4, 0.5))),
              {.format = &meshFormat(".obj")});
    return write("target.obj", stream.str());
  }
  std::vector<Recipe> recipes() const {
    julia::Rational map{.logScale = 0.3};
    map.top.roots = {{{0.2, 0.1, -0.1, 0}, 3}, {{-0.3, 0.2, 0.1, 0}, 2}};
    const std::string rational = rationalToJson(map);
    return {
        {{"map", "quadratic"}, {"c", "-0.2,0.6,0.2,0.2"}, {"iterations", "6"}, {"resolution", "96"}},
        {{"input", target()}, {"alpha", "30"}, {"frequency", "coarse"}, {"resolution", "96"}, {"sdf-resolution", "48"}},
        {{"map", "rational"},
         {"rational", write("map.json", rational)},
         {"box", "-1.5,-1.5,-1.5,1.5,1.5,1.5"},
         {"resolution", "96"}},
        // Smooth enough for a lattice: what is finer than its voxels is in one of the pictures only.
        {{"map", "cross"}, {"iterations", "4"}, {"resolution", "128"}},
        {{"map", "cross"}, {"pair", "A'"}, {"iterations", "3"}, {"resolution", "128"}},
        {{"map", "cross"}, {"scheme", "3"}, {"pair", "B"}, {"radius", "6"}, {"resolution", "96"}},
        {{"map", "cross"}, {"pair", "C"}, {"radius", "5"}, {"iterations", "3"}, {"resolution", "128"}},
        {{"map", "cross"}, {"pair", "D"}, {"radius", "8"}, {"iterations", "4"}, {"resolution", "96"}},
        {{"map", "cross"}, {"scheme", "5"}, {"c", "0.39,0.2,0"}, {"iterations", "4"}, {"resolution", "128"}},
        {{"map", "mandelbulb"}, {"theta", "pole"}, {"iterations", "3"}, {"resolution", "128"}},
        {{"map", "quadratic"}, {"mandelbrot", "true"}, {"iterations", "5"}, {"resolution", "128"}}};
  }

  const TemporaryFolder mTemporary;
  const std::filesystem::path mFolder = mTemporary.path();
  Monitor mMonitor;
};

std::string recipeText(const Recipe& recipe) {
  std::string text;
  for (const auto& [name, value] : recipe) text += name + " = " + value + "; ";
  return text;
}

FieldRenderOptions optionsFor(const Scene& scene, const BBoxd& region, int side) {
  FieldRenderOptions options;
  options.width = options.height = side;
  options.samples = 1;
  options.orbit = scene.field.orbit;
  options.camera = cameraAround(frameSet(scene.source(), region), {.azimuth = 30, .elevation = 20}, 1);
  return options;
}

// Promise: `render --field`: skipped space ...
TEST_F(FieldRenderScene, SkippingChangesNothingForAnyMap) {
  for (const Recipe& recipe : recipes()) {
    const Scene made = scene(recipe);
    const BBoxd region = regionOf(made);
    FieldRenderOptions options = optionsFor(made, region, 64);
    const FieldImage skipped = renderField(made.source(), region, options, mMonitor);
    options.skip = false;
    const FieldImage all = renderField(made.source(), region, options, mMonitor);
    expectSame(skipped, all);
    // Scheme (3) fills the ball: there is little to skip, and a ray's last samples are taken some at a time.
    const auto scheme = recipe.find("scheme");
    if (scheme == recipe.end() || scheme->second != "3") {
      EXPECT_LT(skipped.evaluations, 0.7 * static_cast<double>(all.evaluations)) << recipeText(recipe);
    }
  }
}

TEST_F(FieldRenderScene, SkippingChangesNothingWhereNothingIsProved) {
  for (const Recipe& recipe :
       std::vector<Recipe>{{{"map", "cross"}, {"f", "x*x, y*y, z*z"}, {"g", "cos(x), cos(y), cos(z)"}, {"radius", "5"}},
                           {{"map", "cross"}, {"scheme", "3"}, {"radius", "10"}},
                           {{"map", "mandelbulb"}, {"power", "4.5"}}}) {
    const Scene made = scene(recipe);
    FieldRenderOptions options = optionsFor(made, made.region(), 40);
    const FieldImage skipped = renderField(made.source(), made.region(), options, mMonitor);
    options.skip = false;
    expectSame(skipped, renderField(made.source(), made.region(), options, mMonitor));
  }
}

/// [ZB25] colours by the direction of f x g, brought from [-1, 1] to [0, 1].
TEST_F(FieldRenderScene, CrossProductsAreTheColours) {
  for (const std::string pair : {"A", "C", "D"}) {
    const Scene made = scene({{"map", "cross"}, {"pair", pair}, {"iterations", "3"}, {"scheme", "4"}});
    FieldRenderOptions options = optionsFor(made, made.region(), 48);
    options.passes.insert(Pass::Albedo);
    const FieldImage direction = renderField(made.source(), made.region(), options, mMonitor);
    const ViewFrame frame(options.camera);
    int compared = 0;
    for (std::size_t i = 0; i < direction.id.size(); ++i) {
      if (direction.id[i] == 0) continue;
      const Vec3d hit = frame.at(static_cast<int>(i % 48), static_cast<int>(i / 48), 48, direction.depth[i]);
      const julia::Point point = made.source().space.toFractal(hit);
      julia::Quaternion<double> u;
      made.source().evaluator.versors(std::span(&point, 1), std::span(&u, 1));
      const double length = std::sqrt(normSquared(u));
      EXPECT_NEAR(length, 1, 1e-6);
      const auto& rgb = direction.albedo.pixels[i];
      const double entries[] = {u.a, u.b, u.c};
      for (std::size_t one = 0; one < 3; ++one)
        for (std::size_t other = 0; other < 3; ++other)
          if (entries[one] > entries[other] + 0.05) {
            EXPECT_GT(rgb[one], rgb[other]) << pair << ' ' << i;
            ++compared;
          }
    }
    EXPECT_GT(compared, 300) << pair;
  }
}

/// The pixels that the mesh covers.
std::vector<char> silhouette(const Mesh& mesh, const Camera& camera, int side) {
  const Vec3d forward = (camera.lookAt - camera.eye).unit(), right = forward.cross(camera.up).unit();
  const Vec3d up = right.cross(forward);
  const double tangent = std::tan(camera.fieldOfView * std::numbers::pi / 360);
  const auto project = [&](const auto& p) {
    const Vec3d to = Vec3d(p[0], p[1], p[2]) - camera.eye;
    const double w = to.dot(forward) * tangent;
    return Vec3d(0.5 * side * (1 + to.dot(right) / w), 0.5 * side * (1 - to.dot(up) / w), 0);
  };
  std::vector<char> mask(static_cast<std::size_t>(side * side));
  for (const auto& triangle : mesh.triangles) {
    const Vec3d a = project(mesh.points[triangle[0]]), b = project(mesh.points[triangle[1]]),
                c = project(mesh.points[triangle[2]]);
    const auto edge = [](const Vec3d& p, const Vec3d& q, double x, double y) {
      return (q[0] - p[0]) * (y - p[1]) - (q[1] - p[1]) * (x - p[0]);
    };
    const auto low = [&](int k) { return std::max(0, static_cast<int>(std::min({a[k], b[k], c[k]}))); };
    const auto high = [&](int k) { return std::min(side - 1, static_cast<int>(std::max({a[k], b[k], c[k]}))); };
    for (int y = low(1); y <= high(1); ++y)
      for (int x = low(0); x <= high(0); ++x) {
        const double e[] = {edge(a, b, x + 0.5, y + 0.5), edge(b, c, x + 0.5, y + 0.5), edge(c, a, x + 0.5, y + 0.5)};
        if ((e[0] >= 0 && e[1] >= 0 && e[2] >= 0) || (e[0] <= 0 && e[1] <= 0 && e[2] <= 0))
          mask[static_cast<std::size_t>(y * side + x)] = 1;
      }
  }
  return mask;
}

TEST_F(FieldRenderScene, SilhouettesAreThoseOfTheMesh) {
  constexpr int kSide = 96, kNear = 2;  // pixels
  for (const Recipe& recipe : recipes()) {
    const Scene made = scene(recipe);
    const BBoxd region = regionOf(made);
    const FieldRenderOptions options = optionsFor(made, region, kSide);
    const FieldImage image = renderField(made.source(), region, options, mMonitor);
    const std::vector<char> mesh = silhouette(fractalMesh(made, mMonitor), options.camera, kSide);
    const std::vector<char> field(image.id.begin(), image.id.end());
    const auto nearOne = [&](const std::vector<char>& mask, int x, int y) {
      for (int j = std::max(0, y - kNear); j <= std::min(kSide - 1, y + kNear); ++j)
        for (int i = std::max(0, x - kNear); i <= std::min(kSide - 1, x + kNear); ++i)
          if (mask[static_cast<std::size_t>(j * kSide + i)]) return true;
      return false;
    };
    int covered = 0, apart = 0;
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x) {
        const std::size_t at = static_cast<std::size_t>(y * kSide + x);
        covered += field[at];
        apart += (mesh[at] && !nearOne(field, x, y)) || (field[at] && !nearOne(mesh, x, y));
      }
    // Specks smaller than a voxel, or than a step, are in one of them only.
    EXPECT_LE(apart, covered / 500) << recipeText(recipe);
    EXPECT_GT(covered, kSide * kSide / 8);
  }
}

}  // namespace
