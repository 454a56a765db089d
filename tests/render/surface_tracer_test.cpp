// SPDX-License-Identifier: Apache-2.0
#include "render/surface_tracer.h"

#include <gtest/gtest.h>
#include <openvdb/tools/Interpolation.h>

#include <cmath>
#include <optional>
#include <random>
#include <vector>

using openvdb::Coord;
using openvdb::FloatGrid;
using openvdb::Vec3d;
using vdbtools::SurfaceLattice;
using vdbtools::SurfaceTracer;

namespace {

constexpr int kLumpSide = 44;  ///< voxels: several bricks, and no whole number of leaves

/// A lumpy ball with a hollow, and thin threads around it, some on the faces of leaves.
FloatGrid::Ptr lumps(const Coord& at) {
  auto grid = FloatGrid::create(3.0F);
  auto accessor = grid->getAccessor();
  for (int x = 0; x < kLumpSide; ++x)
    for (int y = 0; y < kLumpSide; ++y)
      for (int z = 0; z < kLumpSide; ++z) {
        const Vec3d p = Vec3d(x, y, z) - Vec3d(0.5 * kLumpSide);
        const double ball = p.length() - 13 - 2 * std::sin(0.9 * p[0]) * std::sin(0.7 * p[1] + 1) * std::sin(p[2]);
        const double thread = std::hypot(x - 8.0, y - 31.5) - 0.8;
        const double value = std::min(std::max(ball, 6 - p.length()), thread);
        if (value < 3) accessor.setValue(at + Coord(x, y, z), static_cast<float>(std::max(value, -3.0)));
      }
  return grid;
}

struct TracedScene {
  explicit TracedScene(FloatGrid::Ptr made)
      : grid(std::move(made)),
        cells(vdbtools::surfaceCells(grid->tree(), vdbtools::Monitor())),
        lattice(grid->tree(), cells) {}
  FloatGrid::Ptr grid;
  openvdb::MaskTree cells;
  SurfaceLattice lattice;
};

struct Ray {
  Vec3d origin, direction;
};

/// From all around and from within, some of them along axes and through nodes.
std::vector<Ray> rays(int count) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(-10, kLumpSide + 10), part(-1, 1);
  std::vector<Ray> result;
  for (int i = 0; i < count; ++i) {
    Vec3d origin(place(random), place(random), place(random)), direction(part(random), part(random), part(random));
    if (i % 2 == 0) direction = Vec3d(0.5 * kLumpSide) + 12.0 * direction - origin;  // so that most are hits
    if (i % 3 == 0) direction[i / 3 % 3] = 0;
    if (i % 9 == 0) direction[(i / 9 + 1) % 3] = 0;
    if (i % 5 == 0) origin = Vec3d(std::round(origin[0]), std::round(origin[1]), std::round(origin[2]));
    if (direction.length() < 1e-3) direction = Vec3d(0, 0, -1);
    result.push_back({origin, direction.unit()});
  }
  return result;
}

/// Small steps through the trilinear field.
std::optional<double> slowFirstHit(const FloatGrid& grid, const Ray& ray) {
  constexpr double kStep = 0.02, kLength = 130;
  FloatGrid::ConstAccessor accessor = grid.getConstAccessor();
  for (double t = 0; t < kLength; t += kStep)
    if (openvdb::tools::BoxSampler::sample(accessor, ray.origin + t * ray.direction) < 0) return t;
  return std::nullopt;
}

TEST(SurfaceTracer, HitsWhatSmallStepsHit) {
  const TracedScene scene(lumps(Coord(0)));
  SurfaceTracer tracer(scene.lattice);
  constexpr int kRays = 800;
  int hits = 0, compared = 0, grazes = 0;
  for (const Ray& ray : rays(kRays)) {
    // A ray that begins inside meets the surface from behind, which no picture does.
    if (openvdb::tools::BoxSampler::sample(scene.grid->tree(), ray.origin) <= 0) continue;
    ++compared;
    const auto slow = slowFirstHit(*scene.grid, ray), fast = tracer.firstHit(ray.origin, ray.direction);
    EXPECT_EQ(tracer.blocked(ray.origin, ray.direction), fast.has_value());
    if (slow.has_value() != fast.has_value() || (slow && std::abs(*slow - *fast) > 0.05)) {
      ++grazes;
      continue;
    }
    hits += fast.has_value();
  }
  EXPECT_GT(hits, compared / 5);
  EXPECT_LE(grazes, compared / 100);
}

TEST(SurfaceTracer, SomethingFarAwayChangesNoHit) {
  const Coord at(-1203, 57, 2004);
  const TracedScene alone(lumps(at));
  // The lattice's cubes become larger than bricks.
  const FloatGrid::Ptr both = lumps(at);
  both->tree().merge(lumps(at + Coord(1500, -1800, 1700))->tree());
  const TracedScene together(both);
  ASSERT_EQ(alone.lattice.shift(), SurfaceLattice::kBrickShift);
  ASSERT_GT(together.lattice.shift(), SurfaceLattice::kBrickShift + 1);
  SurfaceTracer one(alone.lattice), other(together.lattice);
  int hits = 0;
  for (const Ray& ray : rays(4000)) {
    const Vec3d origin = ray.origin + at.asVec3d();
    const auto expected = one.firstHit(origin, ray.direction), found = other.firstHit(origin, ray.direction);
    if (expected) {
      ASSERT_TRUE(found.has_value()) << origin << ray.direction;
      EXPECT_NEAR(*found, *expected, 1e-9);
      ++hits;
    } else if (found) {
      EXPECT_GT(*found, 1000);
    }
  }
  EXPECT_GT(hits, 500);
  // Rays that are aimed at the far one find it.
  for (const Ray& ray : rays(200)) {
    const Vec3d origin = ray.origin + at.asVec3d();
    const Vec3d centre = at.asVec3d() + Vec3d(1500, -1800, 1700) + Vec3d(0.5 * kLumpSide) + Vec3d(9.5, 0, 0);
    EXPECT_TRUE(other.blocked(origin, (centre - origin).unit()));
  }
}

}  // namespace
