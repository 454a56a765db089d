// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/decimation/adaptive_mesh.h"

#include "search/surface_distance.h"
#include "support/mesh_laws.h"
#include "support/test_meshes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace {

using openvdb::Vec3d;
using test_meshes::makeSphere;
using test_meshes::transformed;
using vdbtools::Mesh;

/// A ball with two long horns: flat, round and sharp places.
Mesh horned(int subdivisions) {
  Mesh mesh = makeSphere(1, subdivisions);
  for (Vec3d& p : mesh.points)
    for (const double side : {-1.0, 1.0}) {
      const double angle = std::acos(std::clamp(p.unit()[0] * side, -1.0, 1.0));
      p *= 1 + 1.5 * std::exp(-50 * angle * angle);
    }
  return mesh;
}

/// A cube whose edges are cut off here and there.
Mesh cubed(int subdivisions) {
  Mesh mesh = makeSphere(1, subdivisions);
  for (Vec3d& p : mesh.points) p /= std::max({std::abs(p[0]), std::abs(p[1]), std::abs(p[2])});
  return mesh;
}

/// The greatest distance of random places on a surface from another one.
double sampledDistance(const Mesh& from, const Mesh& to) {
  const vdbtools::SurfaceSearch search(to.points, to.triangles);
  std::mt19937 random(3);
  const auto unit = [&] { return random() / 4294967296.0; };
  double most = 0;
  for (const openvdb::Vec3I& t : from.triangles)
    for (int n = 0; n < 4; ++n) {
      const double u = std::sqrt(unit()), v = unit();
      const Vec3d p = from.points[t[0]] * (1 - u) + from.points[t[1]] * u * (1 - v) + from.points[t[2]] * u * v;
      most = std::max(most, search.nearest(p)->distance);
    }
  return most;
}

// Promise: "`--adaptivity 0.2` leaves out ..."
// Promise: `--tolerance`: "neither mesh is farther ..."
TEST(AdaptiveMesh, StaysClosedAndWithinTheBoundOfBothSurfaces) {
  const Mesh mesh = horned(5);
  std::size_t before = mesh.triangles.size() + 1;
  for (const double bound : {0.001, 0.01, 0.1}) {
    vdbtools::Monitor monitor;
    const vdbtools::AdaptedMesh adapted = vdbtools::adaptedMesh(mesh, bound, monitor);
    const Mesh coarse = meshOf(adapted, mesh);
    EXPECT_EQ(mesh_laws::notClosedManifold(coarse), "") << bound;
    EXPECT_TRUE(std::is_sorted(adapted.points.begin(), adapted.points.end()));
    EXPECT_LE(sampledDistance(coarse, mesh), bound);
    EXPECT_LE(sampledDistance(mesh, coarse), bound);
    EXPECT_EQ(boundingBox(coarse), boundingBox(mesh));
    EXPECT_LT(coarse.triangles.size(), before) << bound;
    before = coarse.triangles.size();
  }
  EXPECT_LT(before, mesh.triangles.size() / 20);
}

// A surface that is rough at the size of the bound: the first attempt is not near enough everywhere.
TEST(AdaptiveMesh, StaysWithinTheBoundOfARoughSurface) {
  Mesh mesh = makeSphere(1, 5);
  std::mt19937 random(1);
  for (Vec3d& p : mesh.points) p *= 1 + 0.03 * (random() / 4294967296.0 - 0.5);
  for (const double bound : {0.003, 0.01}) {
    vdbtools::Monitor monitor;
    const Mesh coarse = meshOf(vdbtools::adaptedMesh(mesh, bound, monitor), mesh);
    EXPECT_EQ(mesh_laws::notClosedManifold(coarse), "") << bound;
    EXPECT_LE(sampledDistance(coarse, mesh), bound);
    EXPECT_LE(sampledDistance(mesh, coarse), bound);
    EXPECT_LT(coarse.triangles.size(), mesh.triangles.size());
  }
}

TEST(AdaptiveMesh, APlaneTakesAFewTriangles) {
  const Mesh mesh = cubed(5);
  vdbtools::Monitor monitor;
  const Mesh coarse = meshOf(vdbtools::adaptedMesh(mesh, 0.02, monitor), mesh);
  EXPECT_EQ(mesh_laws::notClosedManifold(coarse), "");
  EXPECT_EQ(boundingBox(coarse), boundingBox(mesh));
  EXPECT_LT(coarse.triangles.size(), mesh.triangles.size() / 10);  // the rest are teeth along the edges
  EXPECT_LE(sampledDistance(mesh, coarse), 0.02);
}

// The planes are a thousand times as wide as the bound, so that the rounding of their many points adds up.
TEST(AdaptiveMesh, CoordinatesOf32BitsMakeAPlaneNoRougher) {
  Mesh exact = cubed(5);
  const Vec3d x = Vec3d(1, 2, 3).unit(), y = Vec3d(3, 0, -1).unit(), z = x.cross(y);
  for (Vec3d& p : exact.points) p = x * p[0] + y * p[1] + z * p[2];
  Mesh rounded = exact;
  for (Vec3d& p : rounded.points) p = Vec3d(openvdb::Vec3s(p));
  vdbtools::Monitor monitor;
  const Mesh coarse = meshOf(vdbtools::adaptedMesh(rounded, 0.002, monitor), rounded);
  EXPECT_EQ(mesh_laws::notClosedManifold(coarse), "");
  EXPECT_LE(sampledDistance(rounded, coarse), 0.002);
  EXPECT_LT(coarse.triangles.size(), 1.05 * vdbtools::adaptedMesh(exact, 0.002, monitor).triangles.size());
}

// Nothing but its border says that a sheet has a notch.
TEST(AdaptiveMesh, ANotchInASheetStaysOpen) {
  constexpr std::uint32_t kCells = 40;
  Mesh mesh;
  for (std::uint32_t j = 0; j <= kCells; ++j)
    for (std::uint32_t i = 0; i <= kCells; ++i) mesh.points.emplace_back(i, j, 0);
  for (std::uint32_t j = 0; j < kCells; ++j)
    for (std::uint32_t i = 0; i < kCells; ++i) {
      const std::uint32_t a = j * (kCells + 1) + i, b = a + 1, c = a + kCells + 1, d = c + 1;
      const int across = std::abs(static_cast<int>(i) - 20), up = static_cast<int>(j) - 15;
      if (3 * across < up) continue;
      mesh.triangles.emplace_back(a, b, d);
      mesh.triangles.emplace_back(a, d, c);
    }
  vdbtools::Monitor monitor;
  const Mesh coarse = meshOf(vdbtools::adaptedMesh(mesh, 0.5, monitor), mesh);
  EXPECT_LE(sampledDistance(coarse, mesh), 0.5);
  EXPECT_LE(sampledDistance(mesh, coarse), 0.5);
  EXPECT_LT(coarse.triangles.size(), mesh.triangles.size() / 20);
}

TEST(AdaptiveMesh, DependsOnTheShapeAloneAndNotOnItsSizeOrPlace) {
  const Mesh mesh = horned(4);
  vdbtools::Monitor monitor;
  const auto here = vdbtools::adaptedMesh(mesh, 1.0 / 64, monitor);
  for (const double scale : {0x1p-30, 0x1p30})
    EXPECT_EQ(vdbtools::adaptedMesh(transformed(mesh, scale, Vec3d(0)), scale / 64, monitor).triangles, here.triangles)
        << scale;
  const Mesh far = transformed(mesh, 1, Vec3d(4096, -8192, 1024));
  EXPECT_LE(sampledDistance(meshOf(vdbtools::adaptedMesh(far, 0.01, monitor), far), far), 0.01);
}

TEST(AdaptiveMesh, TheSinkKeepsTheRowsOfThePointsThatRemain) {
  Mesh mesh = makeSphere(1, 4);
  std::vector<float> rows;
  for (const Vec3d& p : mesh.points) {
    mesh.normals.emplace_back(p);
    rows.insert(rows.end(), {static_cast<float>(p[0]), static_cast<float>(2 * p[1])});
  }
  struct Check final : vdbtools::MeshSink {
    void addPoints(const vdbtools::PointBatch& batch) override {
      for (std::size_t i = 0; i < batch.positions.size(); ++i) {
        const Vec3d& p = batch.positions[i];
        EXPECT_EQ(batch.normals[i], openvdb::Vec3s(p));
        EXPECT_EQ(batch.values[2 * i], static_cast<float>(p[0]));
        EXPECT_EQ(batch.values[2 * i + 1], static_cast<float>(2 * p[1]));
      }
      points += batch.positions.size();
    }
    void addTriangles(std::span<const openvdb::Vec3I> some, std::uint64_t) override { triangles += some.size(); }
    std::size_t points = 0, triangles = 0;
  } check;
  vdbtools::AdaptiveMeshSink sink(check, 0.02);
  const std::size_t half = mesh.points.size() / 2;
  const std::span points(mesh.points);
  const std::span normals(mesh.normals);
  const std::span values(rows);
  sink.addPoints({points.first(half), normals.first(half), values.first(2 * half)});
  sink.addPoints({points.subspan(half), normals.subspan(half), values.subspan(2 * half)});
  sink.addTriangles(mesh.triangles, 0);
  vdbtools::Monitor monitor;
  sink.finish(monitor);
  EXPECT_EQ(check.points, sink.pointsAfter());
  EXPECT_EQ(check.triangles, sink.trianglesAfter());
  EXPECT_EQ(check.triangles, 2 * check.points - 4);  // Euler's formula for a ball
  EXPECT_LT(check.points, mesh.points.size() / 2);
  EXPECT_THROW(vdbtools::adaptedMesh(mesh, 0, monitor), std::invalid_argument);
}

// A surface may be far from another one between its points only: two slopes of a roof, over its base.
TEST(SurfaceDistance, SeesWhatLiesBetweenPoints) {
  const Mesh base{.points = {{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}}, .triangles = {{0, 1, 2}, {0, 2, 3}}};
  Mesh roof{.points = {{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}, {1, 1, 0.5}},
            .triangles = {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}}};
  const vdbtools::SurfaceSearch toBase(base.points, base.triangles), toRoof(roof.points, roof.triangles);
  const vdbtools::Monitor monitor;
  // All four corners of the base lie on the roof; its middle is sqrt(0.2) below.
  const double between = std::sqrt(0.2);
  EXPECT_TRUE(vdbtools::placesFartherThan(between * 1.001, base, roof, toRoof, monitor).empty());
  EXPECT_FALSE(vdbtools::placesFartherThan(between * 0.999, base, roof, toRoof, monitor).empty());
  EXPECT_TRUE(vdbtools::placesFartherThan(0.501, roof, base, toBase, monitor).empty());
  EXPECT_EQ(vdbtools::placesFartherThan(0.499, roof, base, toBase, monitor).size(), 4u);
}

}  // namespace
