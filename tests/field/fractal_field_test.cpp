// SPDX-License-Identifier: Apache-2.0
// The shell: what is not evaluated has the sign that evaluating it would give; and the field agrees with the reference.
#include "support/mesh_laws.h"
#include "support/test_fields.h"

#include "vdbtools/exponent/exponent_grid.h"
#include "vdbtools/field/fractal_field.h"
#include "vdbtools/surface/extract_mesh.h"
#include "vdbtools/surface/level_set.h"

#include "julia/quadratic_map.h"
#include "julia/rational_map.h"
#include "julia/shape_modulus.h"

#include <gtest/gtest.h>

#include <tbb/parallel_for.h>
#include <atomic>

namespace {

using namespace vdbtools;
using openvdb::BBoxd;
using openvdb::Coord;
using openvdb::CoordBBox;
using openvdb::Vec3d;

constexpr double kPhiVoxel = 1.0 / 40;

struct Case {
  std::string name;
  std::function<double(const Vec3d&)> alpha, beta;
  Control alphaControl, betaControl;
  Vec3d origin{0};
  int iterations = 3;
  double slice = 0;
  julia::DropAxis dropped = julia::DropAxis::K;
  bool integerPowers = true;
};

std::vector<Case> cases() {
  const BBoxd unit(Vec3d(-0.5), Vec3d(0.5));
  const auto constant = [](double value) { return [value](const Vec3d&) { return value; }; };
  const auto ramp = [](int axis, double from, double to, bool smooth) {
    return [=](const Vec3d& x) {
      double t = std::clamp(x[axis] + 0.5, 0.0, 1.0);
      if (smooth) t = 3 * t * t - 2 * t * t * t;
      return (1 - t) * from + t * to;
    };
  };
  std::vector<Case> all;
  for (const double alpha : {6.0, 40.0, 100.0})
    all.push_back({"alpha " + std::to_string(alpha), constant(alpha), constant(0), Control(alpha), Control(0.0)});
  all.push_back({"alpha 40 beta 0.05", constant(40), constant(0.05), Control(40.0), Control(0.05)});
  all.push_back({"alpha 40 beta -0.05", constant(40), constant(-0.05), Control(40.0), Control(-0.05)});
  all.push_back({"alpha ramp", ramp(0, 10, 300, true), constant(0),
                 Control(Ramp{.axis = 0, .from = 10, .to = 300, .smooth = true}, unit), Control(0.0)});
  all.push_back({"both ramps", ramp(1, 100, 12, false), ramp(2, -0.03, 0.06, false),
                 Control(Ramp{.axis = 1, .from = 100, .to = 12}, unit),
                 Control(Ramp{.axis = 2, .from = -0.03, .to = 0.06}, unit)});
  Case moved = all[1];
  moved.name = "origin moved, slice, axis i, real powers";
  moved.origin = Vec3d(0.1, -0.05, 0.02);
  moved.slice = 0.07;
  moved.dropped = julia::DropAxis::I;
  moved.integerPowers = false;
  all.push_back(moved);
  for (const int n : {1, 2, 6}) {
    Case steps = all[1];
    steps.name = "n = " + std::to_string(n);
    steps.iterations = n;
    steps.dropped = julia::DropAxis::J;
    all.push_back(steps);
  }
  return all;
}

struct Made {
  ExponentGrid exponent;
  std::unique_ptr<julia::FieldEvaluator> evaluator;
};

Made make(const Case& c, const julia::Rational& versor, bool trap = true) {
  Monitor monitor;
  ExponentGridOptions options{c.alphaControl, c.betaControl, {c.iterations, 20}};
  // A band as a level set has it; the rest is for extendBand(), but with the true distance, which the test knows.
  const auto phi = test_fields::bandGrid(test_fields::lumpy, kPhiVoxel, exteriorReach(options) + 6 * kPhiVoxel);
  const Target target = makeTarget(phi, std::nullopt);
  Made made;
  made.exponent = exponentGrid(target, FractalSpace{c.origin, 1}, options, monitor);
  julia::OrbitOptions orbit = made.exponent.orbit;
  orbit.confirmTrap = !trap;
  made.evaluator = julia::makeFieldEvaluator<double>(
      std::make_shared<julia::ShapeModulus<double>>(makeExponentField<double>(made.exponent), versor, c.dropped),
      {c.slice, c.dropped}, orbit);
  return made;
}

/// The dynamics as [SK23] writes them down, in doubles, without any shell.
double referenceField(const Case& c, const julia::Rational& versor, const Vec3d& world) {
  const auto nodeExponent = [&](const Vec3d& x) {
    const double phi = static_cast<float>(test_fields::lumpy(x));
    return c.alpha(x) * (phi - c.beta(x));
  };
  const auto exponent = [&](const julia::Quaternion<double>& q) {
    const Vec3d kept = c.dropped == julia::DropAxis::I   ? Vec3d(q.a, q.c, q.d)
                       : c.dropped == julia::DropAxis::J ? Vec3d(q.a, q.b, q.d)
                                                         : Vec3d(q.a, q.b, q.c);
    return test_fields::trilinear(nodeExponent, kPhiVoxel, kept + c.origin);
  };
  const Vec3d x = world - c.origin;
  const julia::Quaternion<double> q = julia::Embedding{c.slice, c.dropped}.quaternion<double>({x[0], x[1], x[2]});
  return julia::reference::orbit<double>(julia::reference::shapeModulus<double>(exponent, versor), q, c.iterations, 20)
      .logModulus;
}

// Promise: "Tests compare everything fast ..."
TEST(FractalField, SignsAreTheReferencesEverywhere) {
  openvdb::initialize();
  const double h = 1.0 / 44;
  const CoordBBox lattice(Coord(-36), Coord(36));
  for (const Case& c : cases()) {
    SCOPED_TRACE(c.name);
    const julia::Rational versor = test_fields::randomVersor(17, 8, 9, c.integerPowers);
    const Made made = make(c, versor);
    Monitor monitor;
    const FractalField field =
        fractalField({*made.evaluator, made.exponent.space}, made.exponent, {.voxelSize = h}, monitor);
    std::atomic<int> wrong{0}, inside{0};
    tbb::parallel_for(lattice.min()[0], lattice.max()[0] + 1, [&](int x) {
      const auto accessor = field.field->getConstAccessor();
      for (int y = lattice.min()[1]; y <= lattice.max()[1]; ++y)
        for (int z = lattice.min()[2]; z <= lattice.max()[2]; ++z) {
          const Coord node(x, y, z);
          const bool expected = referenceField(c, versor, node.asVec3d() * h) < 0;
          inside += expected;
          wrong += expected != (accessor.getValue(node) < 0);
        }
    });
    EXPECT_EQ(wrong, 0) << "of " << lattice.volume() << " nodes, " << inside << " of them inside";
    EXPECT_GT(inside, 100);
    EXPECT_LT(inside, static_cast<int>(lattice.volume() / 2));
  }
}

FractalField exhaustiveField(const FieldSource& source, const ExponentGrid& exponent,
                             const FractalFieldOptions& options, Monitor& monitor) {
  return evaluateField(planExhaustive(exponent, options), source, {.everyNode = true}, monitor);
}

TEST(FractalField, TheShellIsASmallPartAtHighAlpha) {
  const Case c = cases()[2];
  const Made made = make(c, test_fields::randomVersor(17, 8, 9, true));
  Monitor monitor;
  const FieldSource source{*made.evaluator, made.exponent.space};
  const FractalField shell = fractalField(source, made.exponent, {.voxelSize = 1.0 / 100}, monitor);
  const FractalField all = exhaustiveField(source, made.exponent, {.voxelSize = 1.0 / 100}, monitor);
  EXPECT_LT(shell.evaluatedNodes, all.evaluatedNodes / 2);
}

// Promise: "`--exhaustive`, which evaluates every ..."
TEST(FractalField, ExhaustiveGivesTheSameMesh) {
  for (const Case& c : cases()) {
    SCOPED_TRACE(c.name);
    const julia::Rational versor = test_fields::randomVersor(3, 6, 7, c.integerPowers);
    const Made fast = make(c, versor), slow = make(c, versor, /*trap=*/false);
    Monitor monitor;
    const FieldSource fastSource{*fast.evaluator, fast.exponent.space},
        slowSource{*slow.evaluator, slow.exponent.space};
    const FractalFieldOptions options{.voxelSize = 1.0 / 40};
    const Mesh a = extractMesh(fractalField(fastSource, fast.exponent, options, monitor), fastSource, {}, monitor);
    const Mesh b = extractMesh(exhaustiveField(slowSource, slow.exponent, options, monitor), slowSource, {}, monitor);
    EXPECT_EQ(mesh_laws::notClosedManifold(a), "");
    std::set<std::tuple<double, double, double>> inA, inB;
    for (const Vec3d& p : a.points) inA.insert({p[0], p[1], p[2]});
    for (const Vec3d& p : b.points) inB.insert({p[0], p[1], p[2]});
    EXPECT_EQ(inA, inB);
    EXPECT_EQ(a.triangles.size(), b.triangles.size());
  }
}

// Promise: "With `--box` it ends at the box" ...
TEST(FractalField, ABoxIsTheWholeCutOut) {
  const Case c = cases()[1];
  const Made made = make(c, test_fields::randomVersor(5, 6, 7, true));
  Monitor monitor;
  const FieldSource source{*made.evaluator, made.exponent.space};
  const double h = 1.0 / 60;
  const FractalField whole = fractalField(source, made.exponent, {.voxelSize = h}, monitor);
  const BBoxd box(Vec3d(-0.2, -0.5, 0.0), Vec3d(0.25, 0.11, 0.43));
  const FractalField part = fractalField(source, made.exponent, {.voxelSize = h, .box = box}, monitor);
  EXPECT_TRUE(part.bounded);
  for (auto node = part.domain.begin(); node; ++node)
    ASSERT_EQ(part.field->tree().getValue(*node) < 0, whole.field->tree().getValue(*node) < 0) << *node;
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_GE(part.domain.min()[axis] * h, box.min()[axis] - 1e-12);
    EXPECT_LE(part.domain.max()[axis] * h, box.max()[axis] + 1e-12);
  }
  // Capped, it is closed; and a level set, though its inside reaches the border.
  const Mesh capped = extractMesh(part, source, {.border = Border::Cap}, monitor);
  EXPECT_EQ(mesh_laws::notClosedManifold(capped), "");
  BBoxd reached;
  for (const Vec3d& point : capped.points) reached.expand(point);
  // It ends at the faces that cut it.
  int cut = 0;
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_GE(reached.min()[axis], box.min()[axis] - 0.0101 * h);
    EXPECT_LE(reached.max()[axis], box.max()[axis] + 0.0101 * h);
    cut += reached.min()[axis] < box.min()[axis] + 1e-9;
    cut += reached.max()[axis] > box.max()[axis] - 1e-9;
  }
  EXPECT_GE(cut, 4);
  const LevelSetCheck check = checkSurface(*levelSet(part, capped, monitor));
  EXPECT_EQ(check.failure, "");
}

TEST(FractalField, RefusesWhatCannotBe) {
  const Made made = make(cases()[1], test_fields::randomVersor(5, 6, 7, true));
  Monitor monitor;
  const FieldSource source{*made.evaluator, made.exponent.space};
  for (const double h : {0.0, -1.0, std::nan(""), double(INFINITY), 1e-12})
    EXPECT_THROW(fractalField(source, made.exponent, {.voxelSize = h}, monitor), std::invalid_argument) << h;
  EXPECT_THROW(fractalField(source, made.exponent, {.voxelSize = 0.1, .box = BBoxd(Vec3d(5), Vec3d(6))}, monitor),
               DataError);
  EXPECT_THROW(fractalField(source, made.exponent, {.voxelSize = 0.1, .box = BBoxd(Vec3d(0.01), Vec3d(0.02))}, monitor),
               std::invalid_argument);
  EXPECT_THROW(fractalFieldEverywhere(source, {.voxelSize = 0.1}, monitor), std::invalid_argument);
}

TEST(FractalField, StopsWhenAsked) {
  struct Cancelled final : Monitor {
    bool cancelled() const override { return true; }
  } monitor;
  const Made made = make(cases()[1], test_fields::randomVersor(5, 6, 7, true));
  EXPECT_THROW(fractalField({*made.evaluator, made.exponent.space}, made.exponent, {.voxelSize = 0.02}, monitor),
               Interrupted);
}

// Promise: "Every vertex is within the tolerance ..."
TEST(UnitBall, OfTheSquare) {
  // After n steps |q|^(2^n) < 20 is left: a ball of radius 20^(1/2^n), which is 1 + 3e-6 for n = 20.
  const auto map = std::make_shared<julia::QuadraticMap<double>>(julia::Quaternion<double>{});
  const auto evaluator = julia::makeFieldEvaluator<double>(map, {}, {.maxIterations = 20});
  // The same ball for any n as a rational, whose surface is at |q| = 1.
  const auto rational = std::make_shared<julia::RationalMap<double>>(julia::Rational{0, {{{{}, 2}}, 1}, {}});
  const auto rationalEvaluator = julia::makeFieldEvaluator<double>(rational, {}, {.maxIterations = 3});
  const double h = 0.05;
  for (const julia::FieldEvaluator* each : {evaluator.get(), rationalEvaluator.get()}) {
    Monitor monitor;
    const FieldSource source{*each, {}};
    const FractalField field =
        fractalFieldEverywhere(source, {.voxelSize = h, .box = BBoxd(Vec3d(-1.2), Vec3d(1.2))}, monitor);
    const Mesh mesh = extractMesh(field, source, {}, monitor);
    EXPECT_EQ(mesh_laws::notClosedManifold(mesh), "");
    for (const Vec3d& p : mesh.points) ASSERT_NEAR(p.length(), 1, 1e-3 * h + 4e-6);
    // Chords cut (h/2)^2/2 off the radius at most.
    EXPECT_NEAR(mesh_laws::volume(mesh), 4 * M_PI / 3, 4 * M_PI * h * h / 4);
    EXPECT_NEAR(mesh_laws::area(mesh), 4 * M_PI, 4 * M_PI * h * h);
    const auto surface = levelSet(field, mesh, monitor);
    EXPECT_EQ(checkSurface(*surface).failure, "");
    EXPECT_GT(checkSurface(*surface).gradientFraction, 0.99);
    for (auto value = surface->cbeginValueOn(); value; ++value) {
      const double distance = surface->indexToWorld(value.getCoord()).length() - 1;
      ASSERT_NEAR(*value, distance, h * h) << value.getCoord();
    }
  }
}

// Promise: The level set "passes tests ..."
// Promise of design.md: "with the sign that F has at each node"
TEST(LevelSet, OfARoughFractalPassesOpenVdbsChecksAndHasItsSigns) {
  for (const std::size_t k : {0u, 1u, 5u}) {
    const Case c = cases()[k];
    SCOPED_TRACE(c.name);
    const Made made = make(c, test_fields::randomVersor(9, 10, 11, true));
    Monitor monitor;
    const FieldSource source{*made.evaluator, made.exponent.space};
    const FractalField field = fractalField(source, made.exponent, {.voxelSize = 1.0 / 80}, monitor);
    const Mesh mesh = extractMesh(field, source, {}, monitor);
    const auto surface = levelSet(field, mesh, monitor);
    EXPECT_EQ(checkSurface(*surface).failure, "");
    EXPECT_EQ(surface->getName(), "surface");
    EXPECT_EQ(surface->tree().activeTileCount(), 0u);
    CoordBBox box = surface->evalActiveVoxelBoundingBox();
    box.expand(4);
    const auto a = surface->getConstAccessor(), b = field.field->getConstAccessor();
    for (auto node = box.begin(); node; ++node) ASSERT_EQ(a.getValue(*node) < 0, b.getValue(*node) < 0) << *node;
    const auto fog = densityGrid(*surface);
    for (auto value = fog->cbeginValueOn(); value; ++value) {
      ASSERT_GE(*value, 0);
      ASSERT_LE(*value, 1);
    }
    const auto logModulus = logModulusGrid(field);
    for (auto value = logModulus->cbeginValueAll(); value; ++value) ASSERT_TRUE(std::isfinite(*value));
    const auto versors = versorGrid(*surface, source, monitor);
    EXPECT_EQ(versors->activeVoxelCount(), surface->activeVoxelCount());
    for (auto value = versors->cbeginValueOn(); value; ++value) ASSERT_LE(value->length(), 1 + 1e-6);
  }
}

}  // namespace
