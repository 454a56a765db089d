// SPDX-License-Identifier: Apache-2.0
// The study of a target: its counts against the sets themselves, its circles against distances that are known.
#include "support/temporary_folder.h"
#include "support/test_fields.h"
#include "support/test_meshes.h"

#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/formats/versor_file.h"
#include "vdbtools/mesh_files/mesh_writer.h"
#include "vdbtools/study/study.h"

#include <gtest/gtest.h>

#include <openvdb/tools/LevelSetSphere.h>

#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <sstream>

namespace {

using namespace vdbtools;
using openvdb::Vec3d;

const Vec3d kCentre(10, -20, 30);
constexpr double kRadius = 2;

class StudyTest : public testing::Test {
 protected:
  StudyTest() { openvdb::initialize(); }

  std::string file(const std::string& name, const Mesh& mesh) const {
    std::ostringstream obj;
    writeMesh(obj, mesh, {.format = &meshFormat(".obj")});
    return mFolder.write(name, obj.str()).string();
  }
  std::string file(const std::string& name, const openvdb::FloatGrid::Ptr& grid) const {
    return mFolder.write(name, encodeVdb({grid}, {})).string();
  }
  std::string sphere() const { return file("sphere.obj", test_meshes::makeSphere(kRadius, 4, kCentre)); }
  std::string lumpy() const { return file("lumpy.vdb", test_fields::bandGrid(test_fields::lumpy, 1.0 / 24, 4.0 / 24)); }

  /// @param recipe  besides a low resolution
  Scene scene(Recipe recipe) {
    recipe.emplace("sdf-resolution", "40");
    recipe.emplace("texture", "random");
    return makeScene(parseFractalOptions(completeRecipe(recipe, fractalOptionTable())), mMonitor);
  }

  static SlicePlane planeOf(const Scene& scene, int size, double above = 0) {
    openvdb::BBoxd box = scene.target->distances.box;
    box.expand(0.1 * scene.field.space.scale);
    return {Axis::Z, scene.field.space.centre[2] + above, box, size};
  }

  /// The same by way of the job alone: 1 where the set holds a pixel.
  static std::vector<int> membership(const Scene& scene, const SlicePlane& plane) {
    std::vector<julia::Point> points;
    for (int y = 0; y < plane.height(); ++y)
      for (int x = 0; x < plane.width(); ++x) points.push_back(scene.field.space.toFractal(plane.position(x, y)));
    std::vector<double> field(points.size());
    scene.field.evaluator->evaluate(points, field, {});
    std::vector<int> inside;
    for (const double f : field) inside.push_back(f < 0 ? 1 : 0);
    return inside;
  }

  Study study(const Scene& scene, const SlicePlane& plane, int versors, bool circles = false) {
    return runStudy(scene, plane, {.versors = versors, .circles = circles}, mMonitor);
  }

  TemporaryFolder mFolder;
  Monitor mMonitor;
};

// Promise: A texture of a study is the slice ...
TEST_F(StudyTest, CountsTheSetsThatTheJobMakes) {
  const std::string input = lumpy();
  const std::vector<Recipe> recipes{
      {{"alpha", "6"}},
      {{"alpha", "x:10:60"}, {"texture-integer", "true"}, {"slice", "0.1"}, {"drop-axis", "i"}},
      {{"alpha", "12"}, {"texture-placement", "inside"}, {"texture-scale", "0.5"}, {"origin", "0.05,0,0"}},
      {{"alpha", "15"}, {"texture-translate", "0.1,0,0"}, {"precision", "double"}, {"iterations", "5"}},
      {{"alpha", "10"}, {"texture-seed", "77"}, {"space", "world"}, {"exhaustive", "true"}},
  };
  for (std::size_t n = 0; n < recipes.size(); ++n) {
    Recipe recipe = recipes[n];
    recipe["input"] = input;
    const Scene first = scene(recipe);
    const SlicePlane plane = planeOf(first, 40, 0.02);
    const std::vector<int> alone = study(first, plane, 1).inside;
    EXPECT_EQ(alone, membership(first, plane)) << "recipe " << n;
    std::vector<int> sum = alone;
    for (std::uint64_t k = 1; k < 3; ++k) {
      recipe["texture-seed"] = std::to_string(VersorSeeds(first).first() + k);
      const std::vector<int> other = membership(scene(recipe), plane);
      EXPECT_NE(other, alone) << "recipe " << n;
      for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += other[i];
    }
    EXPECT_EQ(study(first, plane, 3).inside, sum) << "recipe " << n;
  }
}

TEST_F(StudyTest, EachVersorHasItsOwnArithmetic) {
  // Summed powers lie about the 250 from which doubles are taken.
  Recipe recipe{{"input", lumpy()}, {"alpha", "10"}, {"texture-roots", "38"}};
  const Scene first = scene(recipe);
  const SlicePlane plane = planeOf(first, 32);
  std::vector<int> sum(static_cast<std::size_t>(plane.width()) * static_cast<std::size_t>(plane.height()));
  int inFloats = 0;
  for (int k = 0; k < 8; ++k) {
    recipe["texture-seed"] = std::to_string(1 + k);
    const Scene one = scene(recipe);
    inFloats += one.field.arithmetic == Arithmetic::Float ? 1 : 0;
    const std::vector<int> inside = membership(one, plane);
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += inside[i];
  }
  EXPECT_GT(inFloats, 0);
  EXPECT_LT(inFloats, 8);
  EXPECT_EQ(study(first, plane, 8).inside, sum);
}

// Promise: The lines of the study's ...
TEST_F(StudyTest, OneIterationIsTheTarget) {
  const Scene made = scene({{"input", lumpy()}, {"iterations", "1"}});
  const SlicePlane plane = planeOf(made, 50);
  const Study result = study(made, plane, 70);
  std::vector<int> expected = membership(made, plane);
  for (int& count : expected) count *= 70;
  EXPECT_EQ(result.inside, expected);
}

TEST_F(StudyTest, CirclesAboutASphere) {
  for (const std::string alpha : {"40", "12"}) {
    const Scene made = scene({{"input", sphere()}, {"alpha", alpha}});
    const SlicePlane plane = planeOf(made, 40);
    const Study result = study(made, plane, 10, true);
    ASSERT_GT(result.circles.size(), 100u);
    EXPECT_EQ(result.circles.front().radius, 0);
    EXPECT_NEAR(result.circles.back().radius, (plane.position(0, 0) - kCentre).length(), 1e-9);
    EXPECT_TRUE(result.originInside);
    const auto [low, high] = result.undecided.value();
    EXPECT_NEAR(high, 2 * kRadius * std::log(20.0) / std::stod(alpha), 1e-9);
    EXPECT_LT(low, 0);
    for (const StudyCircle& circle : result.circles) {
      const double phi = circle.radius - kRadius;
      // Facets, voxels of 0.1, and about the middle, where the distance has a kink, sweeping in voxels of 0.2.
      const double tolerance = circle.radius < 0.8 ? 0.2 : 0.03;
      EXPECT_NEAR(circle.mean, phi, tolerance) << circle.radius;
      EXPECT_NEAR(circle.sphereMean, phi, tolerance) << circle.radius;
      EXPECT_LE(circle.least, circle.mean + 1e-12);
      EXPECT_GE(circle.greatest, circle.mean - 1e-12);
      EXPECT_LT(circle.greatest - circle.least, 0.1) << circle.radius;
      if (circle.greatest < low) {
        EXPECT_EQ(circle.membership, 1) << circle.radius;
      }
      if (circle.least > high) {
        EXPECT_EQ(circle.membership, 0) << circle.radius;
      }
      if (circle.membership > 0 && circle.membership < 1) {
        EXPECT_GT(circle.greatest, low);
        EXPECT_LT(circle.least, high);
      }
    }
    const auto undecided = [](const StudyCircle& c) { return c.membership > 0.05 && c.membership < 0.95; };
    EXPECT_TRUE(std::any_of(result.circles.begin(), result.circles.end(), undecided));
    // A pixel on the circle agrees with it, up to the roughness of ten sets.
    EXPECT_EQ(result.inside[static_cast<std::size_t>(plane.width()) * (plane.height() / 2) + plane.width() / 2], 10);
    EXPECT_EQ(result.inside.front(), 0);
  }
}

TEST_F(StudyTest, OffTheOriginTheCirclesAreAboutItsFoot) {
  const Scene made = scene({{"input", sphere()}});
  const double above = 1.2;
  const Study result = study(made, planeOf(made, 20, above), 1, true);
  for (const StudyCircle& circle : result.circles)
    EXPECT_NEAR(circle.mean, std::hypot(circle.radius, above) - kRadius, 0.03) << circle.radius;
}

TEST_F(StudyTest, EveryKindOfTarget) {
  const auto ball = [](const Vec3d& x) { return x.length() - 0.5; };
  const std::vector<openvdb::FloatGrid::Ptr> grids{
      openvdb::tools::createLevelSetSphere<openvdb::FloatGrid>(0.5f, openvdb::Vec3f(0), 0.025f, 3.0f),
      test_fields::bandGrid(ball, 1.0 / 40, 0.3),
      test_fields::denseGrid(ball, 1.0 / 40, {openvdb::Coord(-60), openvdb::Coord(60)})};
  for (std::size_t n = 0; n < grids.size(); ++n) {
    const Scene made = scene({{"input", file("ball.vdb", grids[n])}});
    for (const StudyCircle& circle : study(made, planeOf(made, 20), 1, true).circles)
      EXPECT_NEAR(circle.mean, circle.radius - 0.5, circle.radius > 0.25 ? 0.01 : 0.05)
          << "grid " << n << ", radius " << circle.radius;
  }
}

TEST_F(StudyTest, FarFromTheTarget) {
  const Scene made = scene({{"input", sphere()}});
  const openvdb::BBoxd box(kCentre - Vec3d(300), kCentre + Vec3d(300));
  const Study result = study(made, SlicePlane(Axis::Y, kCentre[1], box, 16), 2, true);
  for (const StudyCircle& circle : result.circles)
    EXPECT_NEAR(circle.mean, circle.radius - kRadius, 0.02 * circle.radius + 0.2) << circle.radius;
}

TEST_F(StudyTest, AnOriginOutside) {
  const Scene made = scene({{"input", sphere()}, {"origin", "0.8,0,0"}, {"alpha", "x:20:40"}});
  const Study result = study(made, planeOf(made, 16), 2, true);
  EXPECT_FALSE(result.originInside);
  EXPECT_FALSE(result.undecided.has_value());
  EXPECT_NEAR(result.circles.front().mean, 0.8 * 2 * kRadius - kRadius, 0.05);
  EXPECT_FALSE(studyPlot(result).band.has_value());
}

TEST_F(StudyTest, ThePlotShowsTheCirclesAndWhatIsUndecided) {
  const Scene made = scene({{"input", sphere()}, {"alpha", "20"}});
  const Study result = study(made, planeOf(made, 16), 2, true);
  const Plot plot = studyPlot(result);
  ASSERT_EQ(plot.series.size(), 3u);
  for (std::size_t i = 0; i < result.circles.size(); ++i) {
    const StudyCircle& circle = result.circles[i];
    const double values[] = {circle.least, circle.greatest, circle.mean};
    for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ(plot.series[k].points[i], std::pair(circle.radius, values[k]));
  }
  ASSERT_TRUE(plot.band && result.undecided);
  EXPECT_EQ(std::pair(plot.band->low, plot.band->high), *result.undecided);
  EXPECT_NO_THROW(plotImage(plot));
}

TEST_F(StudyTest, ThreadsDoNotMatter) {
  const Scene made = scene({{"input", lumpy()}, {"alpha", "10"}});
  const SlicePlane plane = planeOf(made, 100);
  std::vector<std::string> results;
  for (const std::size_t threads : {1, 2, 5}) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    const Study result = study(made, plane, 70, true);
    results.push_back(studyCsv(result) + encodeImage(studyImage(plane, result), "png"));
  }
  EXPECT_EQ(results[0], results[1]);
  EXPECT_EQ(results[0], results[2]);
}

TEST_F(StudyTest, WhatLeavesIt) {
  const Scene made = scene({{"input", sphere()}, {"alpha", "15"}});
  const SlicePlane plane = planeOf(made, 32);
  const Study result = study(made, plane, 6, true);
  const Image image = studyImage(plane, result);
  for (std::size_t i = 0; i < image.pixels.size(); ++i) {
    const float grey = image.pixels[i][0];
    EXPECT_EQ(grey == 0, result.inside[i] == 6);
    EXPECT_EQ(grey == 1, result.inside[i] == 0);
    for (std::size_t j = 0; j < i; ++j)
      ASSERT_EQ(grey<image.pixels[j][0], result.inside[i]> result.inside[j]) << i << ' ' << j;
  }
  std::istringstream csv(studyCsv(result));
  std::string line;
  std::getline(csv, line);
  EXPECT_EQ(line, "radius,mean,least,greatest,sphere_mean,membership");
  std::size_t rows = 0;
  for (; std::getline(csv, line); ++rows) EXPECT_EQ(std::stod(line), std::stod(line.substr(0, line.find(','))));
  EXPECT_EQ(rows, result.circles.size());
  EXPECT_TRUE(study(made, plane, 1).circles.empty());
}

TEST_F(StudyTest, Refusals) {
  const std::string input = sphere();
  const Scene made = scene({{"input", input}});
  const SlicePlane plane = planeOf(made, 8);
  for (const int versors : {0, -1, kMostVersors + 1})
    EXPECT_THROW(study(made, plane, versors), std::invalid_argument) << versors;
  const Scene last = scene({{"input", input}, {"texture-seed", "18446744073709551615"}});
  EXPECT_THROW(study(last, plane, 2), std::invalid_argument);
  EXPECT_NO_THROW(study(last, plane, 1));
  const std::string versor =
      mFolder.write("v.json", rationalToJson(test_fields::randomVersor(1, 5, 6, false), {}, {})).string();
  EXPECT_THROW(study(scene({{"input", input}, {"texture", versor}}), plane, 2), std::invalid_argument);
  EXPECT_THROW(study(scene({{"input", input}, {"map", "rational"}, {"texture", versor}}), plane, 2),
               std::invalid_argument);
  EXPECT_THROW(study(scene({{"map", "quadratic"}}), plane, 2), std::invalid_argument);
}

TEST_F(StudyTest, StopsWhenToldTo) {
  struct Stopper : Monitor {
    void begin(const Phase& phase, std::uint64_t) override { mStop = phase.kind == PhaseKind::Versors; }
    bool cancelled() const override { return mStop; }
    bool mStop = false;
  } stopper;
  const Scene made = scene({{"input", lumpy()}, {"alpha", "6"}});
  EXPECT_THROW(runStudy(made, planeOf(made, 300), {.versors = kMostVersors}, stopper), Interrupted);
}

TEST(StudyOptions, AreThoseOfTheFractal) {
  const auto has = [](const std::string& name) { return studyOptionTable().knows(name); };
  for (const char* name :
       {"input", "alpha", "beta", "texture-seed", "iterations", "escape", "box", "precision", "grid"})
    EXPECT_TRUE(has(name)) << name;
  for (const char* name : {"map", "texture", "scheme", "power", "radius", "mandelbrot", "grids", "follow", "tolerance"})
    EXPECT_FALSE(has(name)) << name;
}

}  // namespace
