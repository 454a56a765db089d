// SPDX-License-Identifier: Apache-2.0
// Directions and phases over shapes whose directions are known.
#include "vdbtools/grain/grain.h"

#include "support/test_fields.h"

#include "vdbtools/base/errors.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <functional>
#include <limits>
#include <string>
#include <vector>

namespace {

using namespace vdbtools;
using openvdb::FloatGrid;
using openvdb::Vec3d;
using Complex = std::complex<double>;

constexpr double kGrainVoxel = 0.0125;
constexpr double kRingRadius = 0.42, kTubeRadius = 0.15;

double torusDistance(const Vec3d& x) { return std::hypot(std::hypot(x[0], x[1]) - kRingRadius, x[2]) - kTubeRadius; }
Vec3d alongRing(const Vec3d& x) { return Vec3d(-x[1], x[0], 0).unit(); }

/// A rod from -0.4 to 0.4 along X that becomes thinner, with round ends.
double taperedDistance(const Vec3d& x) {
  const double at = std::clamp(x[0], -0.4, 0.4), radius = 0.12 - 0.15 * at;
  return (x - Vec3d(at, 0, 0)).length() - radius;
}

struct Grained {
  FloatGrid::Ptr phi;
  LocalThickness thickness;
  GrainSurface surface;
};
Grained grained(const test_fields::Distance& distance, double voxel = kGrainVoxel) {
  openvdb::initialize();
  const FloatGrid::Ptr phi = test_fields::bandGrid(distance, voxel, 4 * voxel);
  Monitor monitor;
  const LocalThickness thickness = localThickness(*phi, monitor);
  return {phi, thickness, grainSurface(*phi, thickness, monitor)};
}

std::vector<Complex> directionsOf(const Grained& shape, const GrainOptions& options) {
  Monitor monitor;
  return grainDirections(shape.surface, options, monitor);
}

Vec3d placeOf(const Grained& shape, std::size_t i) { return Vec3d(shape.surface.graph.position(i).data()); }
Vec3d directionAt(const Grained& shape, const std::vector<Complex>& field, std::size_t i) {
  return Vec3d(shape.surface.graph.vector(i, field[i]).data());
}

/// The share of the points at which the direction lies within 15 degrees of a wanted line.
double shareAlong(const Grained& shape, const std::vector<Complex>& field,
                  const std::function<Vec3d(const Vec3d&)>& wanted) {
  int near = 0;
  for (std::size_t i = 0; i < field.size(); ++i)
    near += std::abs(directionAt(shape, field, i).dot(wanted(placeOf(shape, i)))) > std::cos(0.2618);
  return near / static_cast<double>(field.size());
}

TEST(Grain, PointsLieOnTheSurfaceAThirdOfTheThicknessApart) {
  const Grained shape = grained(torusDistance);
  const julia::SurfaceGraph& graph = shape.surface.graph;
  EXPECT_GT(graph.size(), 500u);
  EXPECT_LT(graph.size(), 3000u);
  std::vector<int> neighbours(graph.size());
  for (const auto& [from, to] : graph.edges()) {
    ++neighbours[from];
    ++neighbours[to];
    EXPECT_GE((placeOf(shape, from) - placeOf(shape, to)).length(),
              0.999 * std::min(graph.spacing(from), graph.spacing(to)));
  }
  for (std::size_t i = 0; i < graph.size(); ++i) {
    EXPECT_NEAR(torusDistance(placeOf(shape, i)), 0, 0.2 * kGrainVoxel);
    EXPECT_GE(neighbours[i], 4) << i;
  }
}

// Promise: A grain: its table, `--grain-turn`, and that vectors ...
TEST(Grain, AlongATorusIsAlongItsRingAndAroundIsAcross) {
  const Grained shape = grained(torusDistance);
  const std::vector<Complex> along = directionsOf(shape, {.kind = GrainKind::Along});
  EXPECT_GT(shareAlong(shape, along, alongRing), 0.97);
  const std::vector<Complex> around = directionsOf(shape, {.kind = GrainKind::Around});
  EXPECT_LT(shareAlong(shape, around, alongRing), 0.01);
  EXPECT_GT(shareAlong(shape, directionsOf(shape, {.kind = GrainKind::Curvature}), alongRing), 0.9);
  // It turns without a break.
  int forward = 0;
  for (std::size_t i = 0; i < along.size(); ++i)
    forward += directionAt(shape, along, i).dot(alongRing(placeOf(shape, i))) > 0;
  EXPECT_TRUE(forward == 0 || forward == static_cast<int>(along.size())) << forward;
}

// Promise: A grain: its table, `--grain-turn`, and that vectors ...
TEST(Grain, AlongATaperedRodPointsToItsThinEnd) {
  const Grained shape = grained(taperedDistance);
  const std::vector<Complex> along = directionsOf(shape, {.kind = GrainKind::Along});
  int towards = 0, all = 0;
  for (std::size_t i = 0; i < along.size(); ++i) {
    if (std::abs(placeOf(shape, i)[0]) > 0.32) continue;
    ++all;
    towards += directionAt(shape, along, i)[0] > std::cos(0.2618);
  }
  EXPECT_GT(towards, 0.95 * all);
}

// Promise: A grain: its table, `--grain-turn`, and that vectors ...
TEST(Grain, AVectorIsFollowedAndTurned) {
  const Grained shape = grained(torusDistance);
  const auto projected = [&](const Vec3d& towards, std::size_t i) {
    const Vec3d normal(shape.surface.graph.normal(i).data());
    return towards - normal * normal.dot(towards);
  };
  for (const double degrees : {0., 90., -30.}) {
    const Vec3d towards(0.2, 1, -0.4);
    GrainOptions options{.kind = GrainKind::Towards, .towards = towards};
    options.turn = Control(degrees);
    const std::vector<Complex> field = directionsOf(shape, options);
    int near = 0, all = 0;
    for (std::size_t i = 0; i < field.size(); ++i) {
      Vec3d wanted = projected(towards, i);
      if (wanted.length() < 0.5) continue;
      wanted.normalize();
      const Vec3d normal(shape.surface.graph.normal(i).data());
      const double turn = degrees * 3.14159265358979 / 180;
      wanted = wanted * std::cos(turn) + normal.cross(wanted) * std::sin(turn);
      ++all;
      near += directionAt(shape, field, i).dot(wanted) > std::cos(0.2618);
    }
    EXPECT_GT(near, 0.95 * all) << degrees;
  }
}

// Promise: A grain: its table, `--grain-turn`, and that vectors ...
TEST(Grain, GivenVectorsMayBeMissingInPlacesButNotEverywhere) {
  const Grained shape = grained(torusDistance);
  GrainOptions options{.kind = GrainKind::Given};
  options.given = [](std::span<const Vec3d> points, std::span<Vec3d> vectors) {
    for (std::size_t i = 0; i < points.size(); ++i)
      vectors[i] = points[i][0] > 0 ? 7. * alongRing(points[i]) : Vec3d(0);
  };
  EXPECT_GT(shareAlong(shape, directionsOf(shape, options), alongRing), 0.9);
  options.given = [](std::span<const Vec3d>, std::span<Vec3d> vectors) {
    std::fill(vectors.begin(), vectors.end(), Vec3d(0));
  };
  EXPECT_THROW(directionsOf(shape, options), DataError);
  options.given = [](std::span<const Vec3d> points, std::span<Vec3d> vectors) {
    for (std::size_t i = 0; i < points.size(); ++i)
      vectors[i] = i % 2 ? Vec3d(std::numeric_limits<double>::quiet_NaN()) : alongRing(points[i]);
  };
  EXPECT_GT(shareAlong(shape, directionsOf(shape, options), alongRing), 0.9);
}

GrainGrids gridsOf(const Grained& shape, const std::vector<Complex>& field) {
  Monitor monitor;
  std::vector<double> wavelength;
  for (const double tau : shape.surface.thickness) wavelength.push_back(2 * tau);
  const GrainPhases phases = grainPhases(shape.surface, field, wavelength, monitor);
  return grainGrids(shape.surface, phases, wavelength, 0.4, shape.thickness, monitor);
}

/// The share of the points at which the waves are as long as is wanted, within a factor of 1.5.
double shareOfLengths(const std::vector<julia::SurfacePhase>& phases, const std::vector<double>& wavelength) {
  int near = 0;
  for (std::size_t i = 0; i < phases.size(); ++i) {
    const double length = 6.283185307179586 / Vec3d(phases[i].gradient.data()).length() / wavelength[i];
    near += length > 1 / 1.5 && length < 1.5;
  }
  return near / static_cast<double>(phases.size());
}

// Promise of textures.md: Waves along a grain "are as long as is wanted, within a factor of 1.5", and have no seam
TEST(Grain, WavesAreAsLongAsTheThicknessAsks) {
  for (const test_fields::Distance& distance :
       {test_fields::Distance(torusDistance), test_fields::Distance(taperedDistance)}) {
    const Grained shape = grained(distance);
    std::vector<double> wavelength;
    for (const double tau : shape.surface.thickness) wavelength.push_back(2 * tau);
    Monitor monitor;
    const GrainPhases phases =
        grainPhases(shape.surface, directionsOf(shape, {.kind = GrainKind::Along}), wavelength, monitor);
    EXPECT_GT(shareOfLengths(phases.along, wavelength), 0.9);
    EXPECT_GT(shareOfLengths(phases.across, wavelength), 0.9);
  }
}

/// Within one cell of the lattice no phase jumps, except where it counts for little; and nearly everywhere about the
/// surface it counts in full.
// Promise: Waves along a grain "are as long ..."
TEST(Grain, PhasesHaveNoSeam) {
  for (const test_fields::Distance& distance :
       {test_fields::Distance(torusDistance), test_fields::Distance(taperedDistance)}) {
    const Grained shape = grained(distance);
    const GrainGrids grids = gridsOf(shape, directionsOf(shape, {.kind = GrainKind::Along}));
    for (const auto& [cosine, sine] :
         {std::pair(grids.alongCosine, grids.alongSine), std::pair(grids.acrossCosine, grids.acrossSine)}) {
      const FloatGrid::ConstAccessor c = cosine->getConstAccessor(), s = sine->getConstAccessor();
      const FloatGrid::ConstAccessor tau = shape.thickness.tau->getConstAccessor();
      int jumps = 0, cells = 0, certain = 0;
      for (auto node = cosine->cbeginValueOn(); node; ++node) {
        const openvdb::Coord at = node.getCoord();
        // A shell of the usual depth.
        if (std::abs(distance(cosine->indexToWorld(at))) > 0.25 * static_cast<double>(tau.getValue(at))) continue;
        const Complex here(static_cast<double>(*node), static_cast<double>(s.getValue(at)));
        EXPECT_LE(std::abs(here), 1 + 1e-6);
        ++cells;
        certain += std::abs(here) > 0.70711;
        for (int axis = 0; axis < 3; ++axis) {
          openvdb::Coord beside = at;
          beside[axis] += 1;
          const Complex there(static_cast<double>(c.getValue(beside)), static_cast<double>(s.getValue(beside)));
          // A turn of more than a quarter between nodes that both count in full.
          if (std::abs(here) > 0.70711 && std::abs(there) > 0.70711) jumps += (here * std::conj(there)).real() < 0;
        }
      }
      EXPECT_GT(cells, 5000);
      EXPECT_EQ(jumps, 0);
      EXPECT_GT(certain, 0.9 * cells);
    }
  }
}

// Promise: Waves along a grain "are as long ..."
TEST(Grain, TheThirdCoordinateIsTheDistanceInWaves) {
  const Grained shape = grained(torusDistance);
  const GrainGrids grids = gridsOf(shape, directionsOf(shape, {.kind = GrainKind::Along}));
  for (auto node = grids.depth->cbeginValueOn(); node; ++node) {
    const double distance = torusDistance(grids.depth->indexToWorld(node.getCoord()));
    if (std::abs(distance) > 0.3 * kTubeRadius) continue;
    EXPECT_NEAR(static_cast<double>(*node), distance / (2 * kTubeRadius), 0.06);
  }
}

TEST(Grain, EveryShapeHasOne) {
  const auto ball = [](const Vec3d& x) { return x.length() - 0.4; };
  const auto plate = [](const Vec3d& x) {
    const Vec3d out(std::abs(x[0]) - 0.5, std::abs(x[1]) - 0.5, std::abs(x[2]) - 0.02);
    const Vec3d beyond(std::max(out[0], 0.), std::max(out[1], 0.), std::max(out[2], 0.));
    return beyond.length() + std::min(0., std::max({out[0], out[1], out[2]}));
  };
  const auto two = [](const Vec3d& x) {
    return std::min((x - Vec3d(0.25, 0, 0)).length() - 0.2, (x + Vec3d(0.4, 0, 0)).length() - 0.08);
  };
  for (const test_fields::Distance& distance :
       {test_fields::Distance(ball), test_fields::Distance(plate), test_fields::Distance(two)})
    for (const GrainKind kind : {GrainKind::Along, GrainKind::Around, GrainKind::Curvature, GrainKind::Towards}) {
      const Grained shape = grained(distance);
      const std::vector<Complex> field = directionsOf(shape, {.kind = kind});
      for (const Complex& z : field) ASSERT_NEAR(std::abs(z), 1, 1e-9);
      const GrainGrids grids = gridsOf(shape, field);
      for (const FloatGrid::Ptr& grid : {grids.alongCosine, grids.alongSine, grids.acrossCosine, grids.depth})
        for (auto node = grid->cbeginValueOn(); node; ++node) ASSERT_TRUE(std::isfinite(*node));
      EXPECT_GT(grids.alongCosine->activeVoxelCount(), 1000u);
    }
}

TEST(Grain, AShapeWithoutASurfaceIsRefused) {
  openvdb::initialize();
  const FloatGrid::Ptr phi = test_fields::bandGrid([](const Vec3d& x) { return x.length() - 0.5; }, 0.05, 0.2);
  Monitor monitor;
  const LocalThickness thickness = localThickness(*phi, monitor);
  FloatGrid::Ptr outside = FloatGrid::create(1.0f);
  outside->setTransform(phi->transform().copy());
  EXPECT_THROW(grainSurface(*outside, thickness, monitor), DataError);
}

TEST(GrainScale, IsKeptByTheGrid) {
  const FloatGrid::Ptr grid = FloatGrid::create();
  EXPECT_THROW(grainScale(*grid), std::invalid_argument);
  setGrainScale(*grid, {3, 0.25});
  EXPECT_EQ(grainScale(*grid).octave, 3);
  EXPECT_EQ(grainScale(*grid).wavelength, 0.25);
}

}  // namespace
