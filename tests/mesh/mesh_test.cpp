// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/mesh/mesh.h"

#include "support/test_meshes.h"
#include "vdbtools/base/errors.h"

#include <gtest/gtest.h>

#include <cmath>

namespace {

using namespace test_meshes;
using vdbtools::MeshReport;
using vdbtools::reportMesh;
using vdbtools::weldMesh;

TEST(MeshReport, CubeHasTheAreaAndVolumeOfACube) {
  const MeshReport report = reportMesh(makeCube(2, Vec3d(5, -3, 1)));
  EXPECT_EQ(report.points, 8U);
  EXPECT_EQ(report.triangles, 12U);
  EXPECT_EQ(report.components, 1U);
  EXPECT_TRUE(report.closed());
  EXPECT_EQ(report.degenerateFaces, 0U);
  EXPECT_DOUBLE_EQ(report.area, 24);
  EXPECT_DOUBLE_EQ(report.volume, 8);
  EXPECT_EQ(report.box.min(), Vec3d(4, -4, 0));
  EXPECT_EQ(report.box.max(), Vec3d(6, -2, 2));
}

TEST(Mesh, ItsBoundingBoxHoldsAlsoThePointsThatNoTriangleUses) {
  vdbtools::Mesh mesh = makeCube(2, Vec3d(5, -3, 1));
  EXPECT_EQ(boundingBox(mesh), reportMesh(mesh).box);
  mesh.points.emplace_back(0, -3, 9);
  EXPECT_EQ(boundingBox(mesh), openvdb::BBoxd(Vec3d(0, -4, 0), Vec3d(6, -2, 9)));
  EXPECT_TRUE(boundingBox(vdbtools::Mesh{}).empty());
}

TEST(MeshReport, SphereConvergesToTheBallAtSecondOrder) {
  double lastArea = 0;
  double lastVolume = 0;
  for (int n = 2; n <= 5; ++n) {
    const MeshReport report = reportMesh(makeSphere(2, n));
    EXPECT_TRUE(report.closed()) << n;
    // Euler: V - E + F = 2, with E = 3 F / 2.
    EXPECT_EQ(report.points + report.triangles - 3 * report.triangles / 2, 2U) << n;
    const double area = 16 * kPi - report.area;
    const double volume = 32 * kPi / 3 - report.volume;
    EXPECT_GT(area, 0) << n;
    EXPECT_GT(volume, 0) << n;
    if (n > 2) {
      EXPECT_NEAR(lastArea / area, 4, 0.3) << n;
      EXPECT_NEAR(lastVolume / volume, 4, 0.3) << n;
    }
    lastArea = area;
    lastVolume = volume;
  }
}

TEST(MeshReport, VolumeChangesSignWithTheOrientationAndDoesNotFeelTheOrigin) {
  const Mesh sphere = makeSphere(1, 3);
  const double volume = reportMesh(sphere).volume;
  EXPECT_DOUBLE_EQ(reportMesh(flipped(sphere)).volume, -volume);
  EXPECT_NEAR(reportMesh(transformed(sphere, 1, Vec3d(1e6, -2e6, 3e6))).volume, volume, 1e-8);
}

TEST(MeshReport, CountsEachKindOfBadEdge) {
  Mesh open = makeCube();
  open.triangles.pop_back();
  EXPECT_EQ(reportMesh(open).openEdges, 3U);
  EXPECT_FALSE(reportMesh(open).closed());

  Mesh turned = makeCube();
  std::swap(turned.triangles[0][1], turned.triangles[0][2]);
  EXPECT_EQ(reportMesh(turned).misorientedEdges, 3U);
  EXPECT_EQ(reportMesh(turned).openEdges, 0U);

  Mesh fin = makeCube();
  fin.points.emplace_back(3, 3, 3);
  fin.triangles.emplace_back(0, 1, 8);
  EXPECT_EQ(reportMesh(fin).nonManifoldEdges, 1U);
  EXPECT_EQ(reportMesh(fin).openEdges, 2U);
}

TEST(MeshReport, CountsComponentsThroughSharedPointsOnly) {
  const Mesh two = merged(makeCube(1), makeCube(1, Vec3d(3, 0, 0)));
  EXPECT_EQ(reportMesh(two).components, 2U);
  Mesh unused = makeCube();
  unused.points.emplace_back(100, 0, 0);
  EXPECT_EQ(reportMesh(unused).components, 1U);
  EXPECT_EQ(reportMesh(unused).box.max(), Vec3d(0.5)) << "an unused point is no part of the box";
}

TEST(MeshReport, FindsFacesWithoutAnArea) {
  Mesh mesh = makeCube();
  mesh.triangles.emplace_back(0, 0, 1);
  mesh.points.emplace_back((mesh.points[0] + mesh.points[1]) / 2.0);
  mesh.triangles.emplace_back(0, 1, 8);
  EXPECT_EQ(reportMesh(mesh).degenerateFaces, 2U);
  EXPECT_DOUBLE_EQ(reportMesh(mesh).area, 6);
}

TEST(MeshReport, RefusesAnIndexOutOfRange) {
  Mesh mesh = makeCube();
  mesh.triangles.emplace_back(0, 1, 8);
  EXPECT_THROW(reportMesh(mesh), vdbtools::DataError);
  EXPECT_THROW(weldMesh(mesh), vdbtools::DataError);
}

TEST(MeshReport, EmptyMeshHasNothing) {
  const MeshReport report = reportMesh(Mesh());
  EXPECT_EQ(report.triangles, 0U);
  EXPECT_EQ(report.components, 0U);
  EXPECT_EQ(report.area, 0);
}

TEST(WeldMesh, MakesASoupOneAgain) {
  const Mesh sphere = makeSphere(1, 3);
  const Mesh soup = makeSoup(sphere, 0);
  EXPECT_EQ(reportMesh(soup).openEdges, 3 * soup.triangles.size());
  const Mesh welded = weldMesh(soup);
  const MeshReport report = reportMesh(welded);
  EXPECT_TRUE(report.closed());
  EXPECT_EQ(report.points, sphere.points.size());
  EXPECT_EQ(report.volume, reportMesh(soup).volume);
  ASSERT_EQ(welded.triangles.size(), soup.triangles.size());
  for (std::size_t n = 0; n < soup.triangles.size(); ++n) {
    for (int c = 0; c < 3; ++c) {
      ASSERT_EQ(welded.points[welded.triangles[n][c]], soup.points[soup.triangles[n][c]]) << n;
    }
  }
}

TEST(WeldMesh, MergesBitForBitAndDropsWhatCollapses) {
  Mesh mesh;
  const double next = std::nextafter(1.0, 2.0);
  mesh.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-0.0, 0, 0}, {next, 0, 0}};
  mesh.normals = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, -1, 0}, {0, 0, -1}};
  mesh.triangles = {{0, 1, 2}, {3, 4, 2}, {0, 3, 1}};
  const Mesh welded = weldMesh(mesh);
  ASSERT_EQ(welded.points.size(), 4U) << "-0 is 0; 1 and the next number are two";
  EXPECT_EQ(welded.points[3][0], next);
  EXPECT_EQ(welded.normals.size(), 4U);
  EXPECT_EQ(welded.normals[3], openvdb::Vec3s(0, 0, -1));
  ASSERT_EQ(welded.triangles.size(), 2U);
  EXPECT_EQ(welded.triangles[1], Vec3I(0, 3, 2));
}

}  // namespace
