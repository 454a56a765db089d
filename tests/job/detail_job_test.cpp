// SPDX-License-Identifier: Apache-2.0
// What --detail, --outward, --mask and --origin promise, from a mesh to the sign of the field.
#include "support/temporary_folder.h"
#include "support/test_fields.h"
#include "support/test_meshes.h"

#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/job/fractal_job.h"
#include "vdbtools/mesh_files/mesh_writer.h"
#include "vdbtools/recipe/option_value.h"
#include "vdbtools/search/solid_meter.h"
#include "vdbtools/surface/level_set.h"
#include "vdbtools/target/target_survey.h"

#include <gtest/gtest.h>

#include <openvdb/tools/Interpolation.h>

#include <cmath>
#include <fstream>
#include <sstream>

namespace {

using namespace vdbtools;
using namespace test_meshes;
using openvdb::Coord;
using openvdb::Vec3d;

class DetailJob : public testing::Test {
 protected:
  DetailJob() { openvdb::initialize(); }

  std::string write(const std::string& name, const Mesh& mesh) const {
    std::ostringstream stream;
    writeMesh(stream, mesh, {.format = &meshFormat(".obj")});
    const std::string path = mFolder.path() / name;
    std::ofstream(path, std::ios::binary) << stream.str();
    return path;
  }
  std::string writeField(const std::string& name, const test_fields::Distance& distance) const {
    const std::string path = mFolder.path() / name;
    std::ofstream(path, std::ios::binary)
        << encodeVdb({test_fields::bandGrid(distance, 0.02, 0.06, 0.06)}, {.half = false, .metadata = {}});
    return path;
  }
  Scene scene(Recipe recipe) {
    recipe.emplace("sdf-resolution", "64");
    recipe.emplace("resolution", "64");
    return makeScene(parseFractalOptions(recipe), mMonitor);
  }
  static double fieldAt(const Scene& scene, const Vec3d& world) {
    const julia::Point point = scene.field.space.toFractal(world);
    double field = 0;
    scene.field.evaluator->evaluate({&point, 1}, {&field, 1}, {});
    return field;
  }

  /// Points of a dense grid that break the promise, and those that it speaks of on either side.
  struct Count {
    int broken = 0, inside = 0, outside = 0;
  };
  static Count countBroken(const Scene& scene, double step) {
    Count count;
    const DetailOptions& detail = *scene.shellOptions().detail;
    const openvdb::FloatGrid& phi = *scene.target->distances.phi;
    const Vec3d low = scene.target->distances.box.min(), extent = scene.target->distances.box.extents();
    const double longest = scene.placed.space.scale;
    step *= longest;
    const Vec3d margin(0.1 * longest);
    for (double x = low[0] - margin[0]; x < low[0] + extent[0] + margin[0]; x += step)
      for (double y = low[1] - margin[1]; y < low[1] + extent[1] + margin[1]; y += step)
        for (double z = low[2] - margin[2]; z < low[2] + extent[2] + margin[2]; z += step) {
          const Vec3d point(x, y, z);
          const double distance = openvdb::tools::BoxSampler::sample(phi.tree(), phi.worldToIndex(point));
          const double tau = detail.thickness.at(point);
          if (distance <= -detail.detail.at(point) * tau) {
            ++count.inside;
            count.broken += !(fieldAt(scene, point) < 0);
          } else if (distance > detail.outward.at(point) * tau) {
            ++count.outside;
            count.broken += !(fieldAt(scene, point) > 0);
          }
        }
    return count;
  }

  /// How deep a point that is not in the set lies at most, as a share of D tau.
  static double reach(const Scene& scene, double step) {
    const DetailOptions& detail = *scene.shellOptions().detail;
    const openvdb::FloatGrid& phi = *scene.target->distances.phi;
    const Vec3d low = scene.target->distances.box.min(), high = scene.target->distances.box.max();
    step *= scene.placed.space.scale;
    double deepest = 0;
    for (double x = low[0]; x < high[0]; x += step)
      for (double y = low[1]; y < high[1]; y += step)
        for (double z = low[2]; z < high[2]; z += step) {
          const Vec3d point(x, y, z);
          const double distance = openvdb::tools::BoxSampler::sample(phi.tree(), phi.worldToIndex(point));
          const double share = -distance / (detail.detail.at(point) * detail.thickness.at(point));
          if (share > deepest && share < 1.2 && !(fieldAt(scene, point) < 0)) deepest = share;
        }
    return deepest;
  }

  TemporaryFolder mFolder;
  Monitor mMonitor;
};

/// A forked rod that becomes thin.
double forked(const Vec3d& x) {
  const auto rod = [&](const Vec3d& from, const Vec3d& to, double first, double last) {
    const double t = std::clamp((x - from).dot(to - from) / (to - from).lengthSqr(), 0.0, 1.0);
    return (x - from - (to - from) * t).length() - (first + (last - first) * t);
  };
  return std::min({rod(Vec3d(-0.4, 0, 0), Vec3d(0, 0, 0), 0.16, 0.12),
                   rod(Vec3d(0, 0, 0), Vec3d(0.3, 0.25, 0), 0.1, 0.04),
                   rod(Vec3d(0, 0, 0), Vec3d(0.35, -0.2, 0.1), 0.08, 0.03),
                   rod(Vec3d(-0.4, 0, 0), Vec3d(-0.5, 0.1, 0.3), 0.09, 0.035)});
}

// Promise of design.md: "every point with phi <= -m D tau is in the set, and every point with phi >= m O tau is
//   outside", so that no thin part vanishes
TEST_F(DetailJob, KeepsItsPromiseOverADenseGrid) {
  const std::string lumpy = writeField("lumpy.vdb", test_fields::lumpy);
  std::vector<Recipe> recipes;
  for (const char* detail : {"0.1", "0.5", "0.9"}) {
    recipes.push_back({{"input", lumpy}, {"detail", detail}});
    recipes.push_back({{"input", lumpy}, {"detail", detail}, {"outward", "0"}, {"texture-integer", "true"}});
    recipes.push_back({{"input", writeField("forked.vdb", forked)}, {"detail", detail}});
    if (hasBunny()) recipes.push_back({{"input", bunnyPath().string()}, {"detail", detail}, {"repair", "true"}});
  }
  recipes.push_back({{"input", lumpy}, {"detail", "x:0.1:0.9:smooth"}, {"outward", "y:0:0.3"}});
  recipes.push_back({{"input", lumpy}, {"detail", "0.5"}, {"mask", "x:0:1"}});
  recipes.push_back({{"input", lumpy}, {"detail", "0.5"}, {"iterations", "6"}, {"sampling", "quadratic"}});
  for (const Recipe& recipe : recipes) {
    const Count count = countBroken(scene(recipe), 0.023);
    EXPECT_EQ(count.broken, 0) << recipe.at("input") << ' ' << recipe.at("detail");
    // At 0.9 little more than the medial axis is promised.
    EXPECT_GT(count.inside, recipe.at("detail") == "0.9" ? 5 : 500) << recipe.at("input") << ' ' << recipe.at("detail");
    EXPECT_GT(count.outside, 500) << recipe.at("input") << ' ' << recipe.at("detail");
  }
}

// Promise of design.md: K "is taken no larger than it has to be", so that detail reaches nearly as deep as D says, and
//   no deeper
TEST_F(DetailJob, DetailReachesWhatItsNameSays) {
  const auto ball = [](const Vec3d& x) { return x.length() - 0.4; };
  for (const auto& [name, distance] : {std::pair<const char*, test_fields::Distance>{"ball.vdb", ball},
                                       {"lumpy.vdb", test_fields::lumpy},
                                       {"forked.vdb", forked}}) {
    const std::string path = writeField(name, distance);
    for (const char* detail : {"0.5", "0.8"}) {
      double most = 0;
      for (const char* versor : {"coral", "random"})
        most = std::max(most, reach(scene({{"input", path}, {"detail", detail}, {"texture", versor}}), 0.02));
      EXPECT_GT(most, 0.7) << name << ' ' << detail;
      EXPECT_LE(most, 1) << name << ' ' << detail;
    }
  }
}

// Promise: "every point with phi <= ..."
TEST_F(DetailJob, TheShellOfABallIsAsDeepAsAskedFor) {
  constexpr double kRadius = 3;
  const std::string ball = write("ball.obj", makeSphere(kRadius, 5, Vec3d(20, -5, 1)));
  for (const double detail : {0.2, 0.5}) {
    const Scene made =
        scene({{"input", ball}, {"detail", std::to_string(detail)}, {"outward", "0.1"}, {"texture-seed", "3"}});
    const Mesh mesh = fractalMesh(made, mMonitor);
    double deepest = 0, highest = -kRadius;
    for (const Vec3d& point : mesh.points) {
      const double depth = kRadius - (point - Vec3d(20, -5, 1)).length();
      deepest = std::max(deepest, depth);
      highest = std::max(highest, -depth);
    }
    const double voxel = made.voxelSize;
    EXPECT_LE(deepest, detail * kRadius + voxel) << detail;
    EXPECT_LE(highest, 0.1 * kRadius + voxel) << detail;
    // The shell is filled: detail reaches most of the way down and up.
    EXPECT_GT(deepest, 0.7 * detail * kRadius) << detail;
    EXPECT_GT(highest, 0.3 * 0.1 * kRadius) << detail;
  }
}

// Promise: "D tau grows with D everywhere", and for D ...
TEST_F(DetailJob, AThinHandleStaysOnePiece) {
  // A dumbbell whose handle has a quarter of its ends' radius: its core is two voxels thick.
  const auto dumbbell = [](const Vec3d& x) {
    const double along = std::clamp(x[0], -0.4, 0.4);
    const double handle = (x - Vec3d(along, 0, 0)).length() - 0.05;
    return std::min({handle, (x - Vec3d(-0.35, 0, 0)).length() - 0.2, (x - Vec3d(0.35, 0, 0)).length() - 0.2});
  };
  const std::string path =
      write("dumbbell.obj", meshOfLevelSet(*test_fields::bandGrid(dumbbell, 0.005, 0.02, 0.02), mMonitor));
  for (const char* seed : {"1", "2"}) {
    const Scene made = scene({{"input", path},
                              {"detail", "0.8"},
                              {"resolution", "250"},
                              {"sdf-resolution", "200"},
                              {"texture", "random"},
                              {"texture-seed", seed}});
    const SolidMeasure solid = measureSolid(fractalMesh(made, mMonitor));
    ASSERT_FALSE(solid.islands.empty());
    EXPECT_GT(solid.shareOfLargest(1), 0.97) << seed;
  }
}

// Promise: "Parts that run into each ..."
TEST_F(DetailJob, ATreeOfTubesStaysOnePiece) {
  // Closed tubes of 12 sides that begin inside of others.
  const auto tube = [](const Vec3d& from, const Vec3d& to, double first, double last) {
    constexpr std::uint32_t kSides = 12;
    const Vec3d along = (to - from).unit(), side = along.cross(Vec3d(0.3, 0.5, 0.81)).unit(), up = along.cross(side);
    Mesh mesh;
    for (const auto& [middle, radius] : {std::pair{from, first}, {to, last}})
      for (std::uint32_t k = 0; k < kSides; ++k) {
        const double angle = 2 * kPi * k / kSides;
        mesh.points.push_back(middle + (side * std::cos(angle) + up * std::sin(angle)) * radius);
      }
    for (std::uint32_t k = 0; k < kSides; ++k) {
      const std::uint32_t next = (k + 1) % kSides;
      mesh.triangles.insert(mesh.triangles.end(), {Vec3I(k, next, k + kSides), Vec3I(next, next + kSides, k + kSides)});
      if (k == 0 || next == 0) continue;
      mesh.triangles.emplace_back(0, next, k);
      mesh.triangles.emplace_back(kSides, kSides + k, kSides + next);
    }
    return mesh;
  };
  Mesh tree = tube(Vec3d(0), Vec3d(0, 0, 1), 0.13, 0.09);
  std::size_t tubes = 1;
  for (int i = 0; i < 3; ++i) {
    const double turn = 2.1 * i;
    const Vec3d fork(0, 0, 0.6 + 0.15 * i), out(std::cos(turn), std::sin(turn), 0.7), end = fork + out * 0.5;
    tree = merged(tree, tube(fork, end, 0.075, 0.055));
    ++tubes;
    for (const double way : {-1.0, 1.0}) {
      const Vec3d twig = fork + out * 0.35, across(-out[1] * way, out[0] * way, 0.4);
      tree = merged(tree, tube(twig, twig + across * 0.4, 0.05, 0.04));
      ++tubes;
    }
  }
  const std::string path = write("tree.obj", tree);
  for (const char* detail : {"0.3", "0.6"}) {
    const Scene made = scene({{"input", path}, {"detail", detail}, {"resolution", "150"}, {"sdf-resolution", "200"}});
    EXPECT_EQ(made.metadata.at("julia_united_parts"), std::to_string(tubes));
    EXPECT_GT(measureSolid(fractalMesh(made, mMonitor)).shareOfLargest(1), 0.97) << detail;
  }
}

// Promise of design.md: "D tau grows with D everywhere", and for D up to 0.8 the core "stays connected"
TEST_F(DetailJob, MoreDetailIsNowhereLessDeep) {
  const std::string lumpy = writeField("lumpy.vdb", test_fields::lumpy);
  const Scene shallow = scene({{"input", lumpy}, {"detail", "0.2"}}),
              deep = scene({{"input", lumpy}, {"detail", "0.5"}}),
              deepest = scene({{"input", lumpy}, {"detail", "0.9"}});
  const auto depthAt = [](const Scene& scene, const Vec3d& point) {
    return scene.shellOptions().detail->detail.at(point) * scene.shellOptions().detail->thickness.at(point);
  };
  for (auto value = shallow.target->distances.phi->cbeginValueOn(); value; ++value) {
    const Vec3d point = shallow.target->distances.phi->indexToWorld(value.getCoord());
    ASSERT_LT(depthAt(shallow, point), depthAt(deep, point) + 1e-6) << point;
    ASSERT_LT(depthAt(deep, point), depthAt(deepest, point) + 1e-6) << point;
  }
}

// Promise: "the same for a target of any ..."
TEST_F(DetailJob, SizeAndPlaceDoNotMatter) {
  const Mesh shape = merged(makeSphere(1, 4), makeSphere(0.4, 4, Vec3d(1.1, 0.3, 0)));
  const Scene here = scene({{"input", write("here.obj", shape)}, {"repair", "true"}});
  const Scene there =
      scene({{"input", write("there.obj", transformed(shape, 16, Vec3d(-300, 40, 8)))}, {"repair", "true"}});
  EXPECT_NEAR((there.placed.space.centre - (here.placed.space.centre * 16 + Vec3d(-300, 40, 8))).length() / 16, 0,
              2e-3);
  EXPECT_NEAR(there.exponent()->alphaRange.first / here.exponent()->alphaRange.first, 1, 0.01);
  EXPECT_NEAR(there.exponent()->alphaRange.second / here.exponent()->alphaRange.second, 1, 0.02);
  const double volume = measureSolid(fractalMesh(here, mMonitor)).volume,
               scaled = measureSolid(fractalMesh(there, mMonitor)).volume;
  EXPECT_NEAR(scaled / (volume * 16 * 16 * 16), 1, 0.01);
}

// Promise of controls.md#where-the-dynamics-has-its-origin: The recorded origin makes the same fractal again
TEST_F(DetailJob, TheRecordedOriginMakesTheSameAgain) {
  const std::string lumpy = writeField("lumpy.vdb", test_fields::lumpy);
  const Scene chosen = scene({{"input", lumpy}});
  const std::string at = chosen.metadata.at("julia_origin_at");
  const Scene given = scene({{"input", lumpy}, {"origin", at}});
  EXPECT_NEAR((given.placed.space.centre - chosen.placed.space.centre).length(), 0, 1e-12);
  EXPECT_EQ(given.metadata.at("julia_shell"), chosen.metadata.at("julia_shell"));
  // The middle of the box is the origin of the numbers.
  const Scene middle = scene({{"input", lumpy}, {"origin", "centre"}});
  EXPECT_EQ(middle.metadata.at("julia_origin_at"), "0,0,0");
}

// Promise of options.md: "A shift from there erodes the set"
TEST_F(DetailJob, ShiftingTheOriginErodes) {
  const std::string ball = write("ball.obj", makeSphere(1, 5));
  double last = std::numeric_limits<double>::infinity();
  for (const char* shift : {"0,0,0", "0.2,0,0", "0.35,0,0"}) {
    const Scene made = scene({{"input", ball}, {"alpha", "20"}, {"origin-shift", shift}});
    const double volume = measureSolid(fractalMesh(made, mMonitor)).volume;
    EXPECT_LT(volume, last) << shift;
    last = volume;
  }
}

// Promise of controls.md: Where the mask is 0, "the plain target comes out, to within a voxel"
TEST_F(DetailJob, AMaskOfZeroGivesThePlainTargetThere) {
  const std::string lumpy = writeField("lumpy.vdb", test_fields::lumpy);
  for (const Recipe& of : std::vector<Recipe>{{{"detail", "0.6"}}, {{"alpha", "15"}}}) {
    Recipe recipe = of;
    recipe["input"] = lumpy;
    recipe["mask"] = "0";
    const Scene plain = scene(recipe);
    const Mesh mesh = fractalMesh(plain, mMonitor);
    for (const Vec3d& point : mesh.points) ASSERT_LT(std::abs(test_fields::lumpy(point)), 0.02) << point;
    // Half of it, with a sharp border: the other half is as rough as without a mask.
    recipe["mask"] = "x:0@0.499:1@0.501";
    double smooth = 0, rough = 0;
    for (const Vec3d& point : fractalMesh(scene(recipe), mMonitor).points) {
      double& most = point[0] < -0.05 ? smooth : rough;
      most = std::max(most, std::abs(test_fields::lumpy(point)));
    }
    EXPECT_LT(smooth, 0.02);
    EXPECT_GT(rough, 0.04);
  }
}

TEST_F(DetailJob, RefusesWhatItCannotDo) {
  const std::string ball = write("ball.obj", makeSphere(1, 3));
  for (const Recipe& recipe : std::vector<Recipe>{{{"detail", "1.5"}},
                                                  {{"detail", "-0.1"}},
                                                  {{"outward", "2"}},
                                                  {{"mask", "-1"}},
                                                  {{"detail", "x:0.1:3"}},
                                                  {{"detail", "0.2"}, {"alpha", "40"}},
                                                  {{"outward", "0.2"}, {"beta", "0"}},
                                                  {{"detail", "0.2"}, {"beta", "0"}},
                                                  {{"origin", "0.9,0,0"}},
                                                  {{"origin", "middle"}},
                                                  {{"origin", "centre"}, {"origin-near", "0,0,0"}}}) {
    Recipe given = recipe;
    given["input"] = ball;
    EXPECT_THROW(scene(given), std::invalid_argument) << recipe.begin()->first << ' ' << recipe.begin()->second;
  }
}

}  // namespace
