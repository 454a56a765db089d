// SPDX-License-Identifier: Apache-2.0
// Maps without a target through the whole job: where they are looked for, what is skipped, and what their recipes say.
#include "support/mesh_laws.h"

#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/job/fractal_job.h"
#include "vdbtools/records/recorded_recipe.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <string>
#include <vector>

namespace {

using namespace vdbtools;
using openvdb::Coord;
using openvdb::Vec3d;

class MapJob : public testing::Test {
 protected:
  MapJob() { openvdb::initialize(); }

  static Recipe completed(Recipe recipe) {
    recipe.emplace("resolution", "24");
    return completeRecipe(std::move(recipe), fractalOptionTable());
  }
  Scene scene(const Recipe& recipe) { return makeScene(parseFractalOptions(completed(recipe)), mMonitor); }
  Mesh mesh(const Recipe& recipe) { return fractalMesh(scene(recipe), mMonitor); }

  Monitor mMonitor;
};

const std::vector<Recipe> kRecipes = {
    {{"map", "cross"}, {"scheme", "3"}, {"pair", "B"}, {"radius", "6"}},
    {{"map", "cross"}, {"scheme", "3"}, {"pair", "C"}, {"radius", "6"}},
    {{"map", "cross"}, {"scheme", "4"}, {"pair", "A"}},
    {{"map", "cross"}, {"scheme", "4"}, {"pair", "A'"}},
    {{"map", "cross"}, {"scheme", "4"}, {"pair", "D"}, {"radius", "8"}},
    {{"map", "cross"}, {"scheme", "5"}, {"pair", "A"}, {"c", "0.39,0.2,0"}},
    {{"map", "cross"}, {"scheme", "5"}, {"pair", "C"}, {"radius", "5"}},
    {{"map", "cross"}, {"scheme", "5"}, {"pair", "E"}, {"radius", "5"}},
    {{"map", "cross"}, {"f", "x*x, y*y, z*z"}, {"g", "cos(x), cos(y), cos(z)"}, {"radius", "5"}},
    {{"map", "mandelbulb"}},
    {{"map", "mandelbulb"}, {"power", "2.5"}, {"c", "0.1,0.2,-0.3"}, {"theta", "pole"}},
    {{"map", "mandelbulb"}, {"power", "-2"}, {"c", "0.1,0.2,-0.3"}},
    {{"map", "quadratic"}, {"mandelbrot", "true"}},
    {{"map", "quadratic"}, {"mandelbrot", "true"}, {"slice", "0.3"}},
    {{"map", "quadratic"}, {"c", "-0.2,0.6,0.2,0.2"}, {"iterations", "8"}},
};

std::string text(const Recipe& recipe) {
  std::string result;
  for (const auto& [name, value] : recipe) result += " --" + name + "=" + value;
  return result;
}

// The region is to hold the whole set: what lies beyond is outside, as far as the escape radius.
// Promise of sets.md: "a smaller ball is searched, which is proved to hold the set"
TEST_F(MapJob, TheRegionHoldsTheSet) {
  for (const Recipe& recipe : kRecipes) {
    SCOPED_TRACE(text(recipe));
    const Scene scene = this->scene(recipe);
    const double radius = scene.field.orbit.escapeRadius, step = radius / 21.3;
    std::vector<julia::Point> beyond;
    for (double x = -radius; x <= radius; x += step)
      for (double y = -radius; y <= radius; y += step)
        for (double z = -radius; z <= radius; z += step)
          if (!scene.region().isInside(scene.field.space.toWorld({x, y, z}))) beyond.push_back({x, y, z});
    std::vector<double> field(beyond.size());
    scene.field.evaluator->evaluate(beyond, field, {});
    for (std::size_t i = 0; i < beyond.size(); ++i)
      ASSERT_GE(field[i], 0) << beyond[i][0] << ' ' << beyond[i][1] << ' ' << beyond[i][2];
    const FieldPlan plan = planScene(scene);
    const FractalField made = evaluateField(plan, scene.source(), {}, mMonitor);
    // And no cell of it is cut by the region's faces.
    const auto values = made.field->getConstAccessor();
    for (auto node = plan.domain.begin(); node; ++node)
      for (int axis = 0; axis < 3; ++axis)
        if ((*node)[axis] == plan.domain.min()[axis] || (*node)[axis] == plan.domain.max()[axis]) {
          ASSERT_GE(values.getValue(*node), 0) << *node;
        }
  }
}

// What is skipped would have come out the same.
// Promise: "with the sign that F has at each node"
TEST_F(MapJob, SignsAreThoseOfTheEvaluator) {
  for (const Recipe& recipe : kRecipes) {
    SCOPED_TRACE(text(recipe));
    const Scene scene = this->scene(recipe);
    const FieldPlan plan = planScene(scene);
    const FractalField made = evaluateField(plan, scene.source(), {}, mMonitor);
    const auto values = made.field->getConstAccessor();
    std::vector<Coord> nodes;
    std::vector<julia::Point> points;
    for (auto node = plan.domain.begin(); node; ++node) {
      nodes.push_back(*node);
      points.push_back(scene.field.space.toFractal((*node).asVec3d() * plan.voxelSize));
    }
    std::vector<double> field(points.size());
    scene.field.evaluator->evaluate(points, field, {});
    std::size_t inside = 0;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      inside += field[i] < 0;
      ASSERT_EQ(values.getValue(nodes[i]) < 0, field[i] < 0) << nodes[i];
    }
    EXPECT_GT(inside, 0u);
  }
}

// Promise: A mesh is "closed, 2-manifold, oriented ..."
TEST_F(MapJob, MeshesAreClosed) {
  for (const Recipe& recipe : kRecipes) {
    SCOPED_TRACE(text(recipe));
    const Mesh mesh = this->mesh(recipe);
    ASSERT_GT(mesh.triangles.size(), 100u);
    EXPECT_EQ(mesh_laws::notClosedManifold(mesh), "");
    EXPECT_GT(mesh_laws::volume(mesh), 0);
  }
}

TEST_F(MapJob, TheRecipeSaysWhatWasTaken) {
  const auto taken = [](const Recipe& recipe, const char* option) {
    const Recipe complete = completed(recipe);
    const auto found = complete.find(option);
    return found == complete.end() ? std::string("none") : found->second;
  };
  const Recipe cross{{"map", "cross"}}, bulb{{"map", "mandelbulb"}}, quadratic{{"map", "quadratic"}}, shape;
  EXPECT_EQ(taken(cross, "iterations"), "10");
  EXPECT_EQ(taken(bulb, "iterations"), "10");
  EXPECT_EQ(taken(quadratic, "iterations"), "3");
  EXPECT_EQ(taken(shape, "iterations"), "5");
  EXPECT_EQ(taken({{"beta", "0.1"}}, "iterations"), "3");
  EXPECT_EQ(taken({{"map", "quadratic"}, {"mandelbrot", "true"}}, "iterations"), "10");
  EXPECT_EQ(taken({{"map", "cross"}, {"iterations", "3"}}, "iterations"), "3");
  EXPECT_EQ(taken(cross, "radius"), "2");
  EXPECT_EQ(taken(cross, "escape"), "none");
  EXPECT_EQ(taken(shape, "escape"), "2");
  EXPECT_EQ(taken({{"alpha", "40"}}, "escape"), "20");
  EXPECT_EQ(taken({{"beta", "0.1"}}, "alpha"), "40");
  EXPECT_EQ(taken({{"beta", "0.1"}}, "detail"), "none");
  EXPECT_EQ(taken(shape, "radius"), "none");
  EXPECT_EQ(taken(shape, "pair"), "none");
  EXPECT_EQ(taken(cross, "scheme"), "4");
  EXPECT_EQ(taken(cross, "pair"), "A");
  EXPECT_EQ(taken({{"map", "cross"}, {"f", "1,1,1"}}, "pair"), "user");
  EXPECT_EQ(taken(cross, "c"), "none");
  EXPECT_EQ(taken({{"map", "cross"}, {"scheme", "5"}}, "c"), "-1,0,0");
  EXPECT_EQ(taken(quadratic, "c"), "0,0,0,0");
  EXPECT_EQ(taken({{"map", "quadratic"}, {"mandelbrot", "true"}}, "c"), "none");
  EXPECT_EQ(taken(bulb, "mandelbrot"), "true");
  EXPECT_EQ(taken({{"map", "mandelbulb"}, {"c", "0,0,0"}}, "mandelbrot"), "none");
  for (const Recipe& recipe : kRecipes) EXPECT_EQ(completed(completed(recipe)), completed(recipe)) << text(recipe);
}

// Promise: A run from the recipe in a VDB, PLY, OBJ ...
TEST_F(MapJob, TheRecipeMakesTheSameBytes) {
  const auto bytes = [&](const Recipe& recipe) {
    const Scene scene = makeScene(parseFractalOptions(recipe), mMonitor);
    const VdbWriteOptions options{.metadata = sceneMetadata(scene, recipe)};
    return std::pair(
        encodeVdb(runFractal(scene, planFractal(scene, {.grids = true}), nullptr, mMonitor).grids, options),
        options.metadata);
  };
  for (Recipe recipe : kRecipes) {
    SCOPED_TRACE(text(recipe));
    recipe["grids"] = "surface,logmodulus,iterations,versor";
    const auto [first, metadata] = bytes(completed(recipe));
    const auto [command, again] = recordedRecipe(metadata);
    EXPECT_EQ(again, completed(recipe));
    EXPECT_TRUE(bytes(again).first == first) << "the recipe made another file";
  }
}

TEST_F(MapJob, WhatBelongsToAnotherMapIsRefused) {
  const auto refused = [](Recipe recipe, const char* map, const char* mention) {
    recipe["map"] = map;
    try {
      parseFractalOptions(completed(recipe));
      ADD_FAILURE() << text(recipe) << " was not refused";
    } catch (const std::invalid_argument& error) {
      EXPECT_NE(std::string(error.what()).find(mention), std::string::npos) << text(recipe) << ": " << error.what();
    }
  };
  for (const char* map : {"shape-modulus", "rational", "quadratic", "mandelbulb"})
    for (const char* option : {"scheme", "pair", "f", "g"}) refused({{option, "4"}}, map, option);
  for (const char* map : {"shape-modulus", "rational", "quadratic"}) {
    for (const char* option : {"power", "theta", "radius"}) refused({{option, "2"}}, map, option);
  }
  for (const char* map : {"shape-modulus", "rational", "cross"}) refused({{"mandelbrot", "true"}}, map, "mandelbrot");
  for (const char* map : {"cross", "mandelbulb"}) {
    refused({{"escape", "20"}}, map, "--radius");
    refused({{"input", "bunny.obj"}}, map, "bunny.obj");
    refused({{"slice", "0.1"}}, map, "--slice");
    refused({{"drop-axis", "i"}}, map, "--drop-axis");
    for (const char* radius : {"0", "-2", "1", "nan", "1e10", "two"}) refused({{"radius", radius}}, map, "--radius");
    refused({{"iterations", "0"}}, map, "--iterations");
  }
  for (const char* scheme : {"3", "4"}) refused({{"c", "-1,0,0"}, {"scheme", scheme}}, "cross", "--c");
  for (const char* c : {"1,2", "1,2,3,4", "0,0,0,0"}) refused({{"c", c}, {"scheme", "5"}}, "cross", "--c");
  for (const char* c : {"1,2", "1,2,3,4"}) refused({{"c", c}}, "mandelbulb", "--c");
  refused({{"c", "1,2,3"}}, "quadratic", "--c");
  for (const char* map : {"mandelbulb", "quadratic"})
    refused({{"c", "0,0,0,0"}, {"mandelbrot", "true"}}, map, "--mandelbrot");
  refused({{"f", "x,y,z"}}, "cross", "--g");
  refused({{"f", "x,y,z"}, {"g", "z,x,y"}, {"pair", "B"}}, "cross", "--f");
  refused({{"pair", "user"}}, "cross", "--f");
}

TEST_F(MapJob, AnotherMapDisplacesWhatBelongedToTheFirst) {
  const Recipe base = completed({{"map", "cross"}, {"scheme", "5"}, {"f", "x,y,z"}, {"g", "z,x,y"}});
  const auto displaced = [&](const char* option, const char* value) {
    return displacedOptions(base, option, value, fractalOptionTable());
  };
  const auto holds = [](const std::vector<std::string>& options, const char* option) {
    return std::find(options.begin(), options.end(), option) != options.end();
  };
  EXPECT_TRUE(displaced("scheme", "5").empty());
  EXPECT_TRUE(holds(displaced("scheme", "4"), "c"));
  EXPECT_TRUE(holds(displaced("pair", "B"), "f"));
  EXPECT_TRUE(holds(displaced("map", "quadratic"), "scheme"));
  EXPECT_TRUE(holds(displaced("map", "quadratic"), "iterations"));
  EXPECT_FALSE(holds(displaced("map", "mandelbulb"), "radius"));
  EXPECT_TRUE(holds(displaced("map", "mandelbulb"), "pair"));
}

// In the xy plane pair D is the square of complex numbers.
TEST_F(MapJob, PairDHasTheComplexSetsInItsPlane) {
  const std::complex<double> constant(-0.4, 0.6);
  const Scene julia = scene({{"map", "cross"}, {"scheme", "5"}, {"pair", "D"}, {"c", "-0.4,0.6,0"}});
  const Scene mandelbrot = scene({{"map", "cross"}, {"scheme", "4"}, {"pair", "D"}});
  int inside = 0;
  for (int i = -40; i <= 40; ++i)
    for (int j = -40; j <= 40; ++j)
      for (const bool fixed : {true, false}) {
        const julia::Point p{i / 21.0, j / 21.0, 0};
        const std::complex<double> start(p[0], p[1]);
        std::complex<double> z = start;
        for (int n = 0; n < 10 && std::abs(z) < 2; ++n) z = z * z + (fixed ? constant : start);
        if (std::abs(std::abs(z) - 2) < 1e-9) continue;
        double field = 0;
        (fixed ? julia : mandelbrot).field.evaluator->evaluate({&p, 1}, {&field, 1}, {});
        EXPECT_EQ(field < 0, std::abs(z) < 2) << p[0] << ' ' << p[1] << (fixed ? " Julia" : " Mandelbrot");
        inside += field < 0;
      }
  EXPECT_GT(inside, 500);
}

// A is outside where |x| = |y|, by definition, and that set has no volume: on a lattice with nodes there the shape
// would come apart along two planes.
// Promise: "the lattice of a `cross` ..."
TEST_F(MapJob, APairWithUndefinedPointsIsInOnePiece) {
  const Recipe recipe{{"map", "cross"}, {"pair", "A"}, {"iterations", "5"}};
  const Scene scene = this->scene(recipe);
  const julia::Point diagonal{0.1, 0.1, 0.05}, beside{0.1, 0.1 + 1e-9, 0.05};
  double field[2];
  scene.field.evaluator->evaluate(std::array{diagonal, beside}, field, {});
  EXPECT_GE(field[0], 0) << "the definition";
  EXPECT_LT(field[1], 0);
  const FieldPlan plan = planScene(scene);
  const FractalField made = evaluateField(plan, scene.source(), {}, mMonitor);
  const auto values = made.field->getConstAccessor();
  for (int k = -2; k <= 2; ++k)
    for (const int sign : {1, -1}) EXPECT_LT(values.getValue(Coord(k, sign * k, 1)), 0) << k << ' ' << sign;
  // The same with the planes' limits, as the triplex square has them. A cut would cost 6 %; needles come and go with
  // the nodes that they meet.
  const double whole = mesh_laws::volume(mesh({{"map", "mandelbulb"}, {"power", "2"}, {"iterations", "5"}}));
  EXPECT_NEAR(mesh_laws::volume(mesh(recipe)), whole, 0.02 * whole);
}

// The lattice of such a map is shifted. What is written is where the nodes were: between the two nodes of a vertex's
// edge, which the grid's transform places, the definition has a change of sign.
// Promise: "the lattice of a `cross` ..."
// Promise: "their meshes and grids say ..."
TEST_F(MapJob, FilesSayWhereACrossMapWasEvaluated) {
  for (const char* pair : {"A", "C", "D"}) {
    SCOPED_TRACE(pair);
    const Scene scene =
        this->scene({{"map", "cross"}, {"pair", pair}, {"radius", "4"}, {"grids", "surface,logmodulus"}});
    EXPECT_EQ(scene.metadata.at("julia_space_centre"), "0,0,0");
    Mesh mesh;
    MeshCollector collector(mesh);
    const FractalResult made =
        runFractal(scene, planFractal(scene, {.grids = true, .mesh = true}), &collector, mMonitor);
    ASSERT_EQ(made.grids.size(), 2u);
    const openvdb::math::Transform& lattice = made.grids[0]->transform();
    EXPECT_EQ(lattice, made.grids[1]->transform());
    const Vec3d zero = lattice.indexToWorld(Vec3d(0));
    for (int axis = 0; axis < 3; ++axis) EXPECT_NE(zero[axis], 0);
    EXPECT_LT(zero.length(), scene.options.surface.tolerance * scene.voxelSize);
    std::vector<julia::Point> ends;
    for (const Vec3d& point : mesh.points) {
      const Vec3d at = lattice.worldToIndex(point);
      Vec3d node, off;
      for (int axis = 0; axis < 3; ++axis) off[axis] = std::abs(at[axis] - (node[axis] = std::round(at[axis])));
      const int along = off[0] >= off[1] && off[0] >= off[2] ? 0 : off[1] >= off[2] ? 1 : 2;
      for (int axis = 0; axis < 3; ++axis)
        if (axis != along) {
          ASSERT_LT(off[axis], 1e-9) << point;
        }
      node[along] = std::floor(at[along]);
      ends.emplace_back(scene.placed.space.toFractal(lattice.indexToWorld(node)));
      node[along] += 1;
      ends.emplace_back(scene.placed.space.toFractal(lattice.indexToWorld(node)));
    }
    std::vector<double> field(ends.size());
    scene.field.evaluator->evaluate(ends, field, {});
    std::size_t same = 0;
    for (std::size_t i = 0; i < field.size(); i += 2) same += (field[i] < 0) == (field[i + 1] < 0);
    EXPECT_EQ(same, 0u) << "of " << mesh.points.size();
  }
}

// Promise of maps.md#--map-cross: A user's pair that says what a built-in one does is that one
TEST_F(MapJob, AUsersPairIsTheBuiltInOneByteForByte) {
  const Recipe builtIn{{"map", "cross"}, {"pair", "C"}, {"radius", "4"}};
  const Recipe own{{"map", "cross"}, {"f", "x*x, y*y, z*z"}, {"g", "cos(x), cos(y), cos(z)"}, {"radius", "4"}};
  const Mesh one = mesh(builtIn), two = mesh(own);
  EXPECT_EQ(one.points, two.points);
  EXPECT_EQ(one.triangles, two.triangles);
}

TEST_F(MapJob, TheBallOfTheEscapeRadiusClosesWhatFillsIt) {
  // f x g = 0: no orbit of scheme 3 leaves the ball.
  const double radius = 3;
  const Mesh ball = mesh({{"map", "cross"}, {"scheme", "3"}, {"f", "x,y,z"}, {"g", "x,y,z"}, {"radius", "3"}});
  EXPECT_EQ(mesh_laws::notClosedManifold(ball), "");
  for (const Vec3d& p : ball.points) EXPECT_NEAR(p.length(), radius, 1e-3);
}

TEST_F(MapJob, VersorsAreDirectionsInSpace) {
  const Scene scene = this->scene({{"map", "cross"}, {"scheme", "5"}, {"pair", "D"}});
  const julia::Point p{0.5, 0.5, 0.2};  // cos 2phi = 0, sin 2phi = 1
  const std::vector<openvdb::Vec3s> versors = scene.source().versorVectors({&p, 1});
  EXPECT_NEAR(versors[0][0], 0, 1e-6);
  EXPECT_NEAR(versors[0][1], 1, 1e-6);
  EXPECT_NEAR(versors[0][2], 0, 1e-6);
}

// Promise: "An empty result is an error, not ..."
TEST_F(MapJob, AnEmptySetIsBadData) {
  EXPECT_THROW(mesh({{"map", "cross"}, {"scheme", "5"}, {"pair", "A"}, {"c", "0,0,1.9"}, {"iterations", "50"}}),
               DataError);
}

}  // namespace
