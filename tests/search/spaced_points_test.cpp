// SPDX-License-Identifier: Apache-2.0
#include "search/spaced_points.h"

#include "search/surface_search.h"
#include "support/temporary_folder.h"
#include "support/test_meshes.h"
#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/surface/extract_mesh.h"

#include <gtest/gtest.h>
#include <openvdb/points/PointDataGrid.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace {

using openvdb::Vec3d;
using test_meshes::makeCube;
using test_meshes::makeSphere;
using test_meshes::transformed;
using vdbtools::Mesh;
using vdbtools::SpacedPoints;

Mesh withNormals(Mesh mesh) {
  vdbtools::computeNormals(mesh);
  return mesh;
}

double leastDistance(const SpacedPoints& spaced) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < spaced.points.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      least = std::min(least, (spaced.points[i].position - spaced.points[j].position).length());
  return least;
}

/// How far some places of the mesh, on a fine lattice in each triangle, are from the nearest point at most.
double greatestGap(const Mesh& mesh, const SpacedPoints& spaced, int steps) {
  double most = 0;
  for (const openvdb::Vec3I& t : mesh.triangles)
    for (int i = 0; i <= steps; ++i)
      for (int j = 0; i + j <= steps; ++j) {
        const Vec3d p = mesh.points[t[0]] * (double(i) / steps) + mesh.points[t[1]] * (double(j) / steps) +
                        mesh.points[t[2]] * (double(steps - i - j) / steps);
        double least = std::numeric_limits<double>::infinity();
        for (const auto& point : spaced.points) least = std::min(least, (point.position - p).lengthSqr());
        most = std::max(most, std::sqrt(least));
      }
  return most;
}

bool same(const SpacedPoints& a, const SpacedPoints& b) {
  return std::equal(a.points.begin(), a.points.end(), b.points.begin(), b.points.end(), [](auto& p, auto& q) {
    return p.position == q.position && p.normal == q.normal && p.triangle == q.triangle;
  });
}

// Promise of points.md: "No two points are nearer than S. On a mesh, no place is farther than 1.1 S from a point";
//   "Exactly N points"
TEST(SpacedPoints, KeepTheirDistanceAndLeaveNoGap) {
  vdbtools::Monitor monitor;
  // Triangles much larger than the spacing, and much smaller; and a size and a place of their own.
  const Mesh small = transformed(makeCube(), 1e-4, Vec3d(7, -5, 3));
  for (const auto& [mesh, spacing, steps] :
       {std::tuple(makeCube(2), 0.15, 60), {makeSphere(1, 4), 0.3, 2}, {small, 2e-5, 30}}) {
    const Mesh complete = withNormals(mesh);
    const SpacedPoints spaced = vdbtools::pointsBySpacing(complete, spacing, {}, monitor);
    EXPECT_GT(spaced.points.size(), 50u);
    EXPECT_GE(leastDistance(spaced), spacing);
    EXPECT_DOUBLE_EQ(leastDistance(spaced), spaced.spacing);
    EXPECT_LE(greatestGap(complete, spaced, steps), 1.1 * spacing);
    EXPECT_LE(spaced.reach, 1.1 * spacing);
    EXPECT_GT(spaced.reach, 0.7 * spacing);
  }
}

// Promise: "No two points are nearer ..."
TEST(SpacedPoints, ComeInTheNumberThatIsWanted) {
  vdbtools::Monitor monitor;
  const Mesh mesh = withNormals(makeSphere(1, 4));
  for (const std::uint64_t count : {1, 2, 10, 700}) {
    const SpacedPoints spaced = vdbtools::pointsByCount(mesh, count, {}, monitor);
    ASSERT_EQ(spaced.points.size(), count);
    if (count < 2) continue;
    // The densest packing of as many discs on as much of a plane.
    const double packed = std::sqrt(4 * M_PI / static_cast<double>(count) * 2 / std::sqrt(3.0));
    EXPECT_DOUBLE_EQ(spaced.spacing, leastDistance(spaced));
    EXPECT_GT(spaced.spacing, 0.6 * packed) << count;
    if (count > 100) {
      EXPECT_LT(greatestGap(mesh, spaced, 2), 1.6 * spaced.spacing);
    }
  }
  EXPECT_THROW(vdbtools::pointsByCount(mesh, 0, {}, monitor), std::invalid_argument);
  EXPECT_THROW(vdbtools::pointsBySpacing(mesh, -1, {}, monitor), std::invalid_argument);
  EXPECT_THROW(vdbtools::pointsBySpacing(mesh, 1e-6, {}, monitor), std::invalid_argument);
}

// Promise: "the same one gives the same ..."
TEST(SpacedPoints, AreTheSameForAnyNumberOfThreadsAndOthersForAnotherSeed) {
  vdbtools::Monitor monitor;
  const Mesh mesh = withNormals(makeSphere(1, 5));
  const auto bySpacing = [&](std::uint64_t seed) {
    return vdbtools::pointsBySpacing(mesh, 0.05, {.seed = seed}, monitor);
  };
  const auto byCount = [&](std::uint64_t seed) { return vdbtools::pointsByCount(mesh, 2000, {.seed = seed}, monitor); };
  const SpacedPoints spacing = bySpacing(1), count = byCount(1);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_TRUE(same(bySpacing(1), spacing));
  EXPECT_TRUE(same(byCount(1), count));
  EXPECT_FALSE(same(bySpacing(2), spacing));
  EXPECT_FALSE(same(byCount(2), count));
}

// A coarse ball that stands for a true one, of which a cap is missing.
// Promise: "No two points are nearer ..."
TEST(SpacedPoints, KeepTheirDistanceWhereTheyWereMovedTo) {
  vdbtools::Monitor monitor;
  const Mesh mesh = withNormals(makeSphere(1, 2));
  const vdbtools::SpacedPointsOptions options{.move = [](std::span<vdbtools::PlacedPoint> points) {
    for (auto& point : points) {
      point.lost = point.position[1] > 0.8;
      point.position.normalize();
    }
  }};
  for (const SpacedPoints& spaced : {vdbtools::pointsBySpacing(mesh, 0.15, options, monitor),
                                     vdbtools::pointsByCount(mesh, 500, options, monitor)}) {
    EXPECT_GT(spaced.lost, 0u);
    EXPECT_GE(leastDistance(spaced), spaced.spacing);
    EXPECT_GT(spaced.points.size(), 300u);
    for (const auto& point : spaced.points) {
      EXPECT_NEAR(point.position.length(), 1, 1e-12);
      EXPECT_LT(point.position[1], 0.9);
    }
  }
}

TEST(SpacedPoints, HaveNormalsThatBendWithTheSurfaceAndBreakAtEdges) {
  vdbtools::Monitor monitor;
  for (const auto& point :
       vdbtools::pointsByCount(withNormals(makeSphere(1, 4)), 200, {.keepsCreases = true}, monitor).points)
    EXPECT_GT(Vec3d(point.normal).dot(point.position.unit()), 0.999);
  for (const auto& point :
       vdbtools::pointsByCount(withNormals(makeCube(2)), 200, {.keepsCreases = true}, monitor).points)
    for (int axis = 0; axis < 3; ++axis) {
      const double across = std::abs(point.normal[axis]) > 0.9 ? std::abs(point.position[axis]) : 1;
      EXPECT_NEAR(across, 1, 1e-12);
    }
}

TEST(VdbPoints, AreReadBackByOpenVdb) {
  using namespace openvdb::points;
  vdbtools::Monitor monitor;
  const Mesh mesh = withNormals(transformed(makeSphere(1, 4), 3, Vec3d(1000, -20, 5)));
  const SpacedPoints spaced = vdbtools::pointsByCount(mesh, 900, {}, monitor);
  std::vector<Vec3d> positions;
  std::vector<openvdb::Vec3s> normals;
  std::vector<float> values;
  for (const auto& point : spaced.points) {
    positions.push_back(point.position);
    normals.push_back(point.normal);
    const auto i = static_cast<float>(values.size() / 4);
    values.insert(values.end(), {i, i + 0.25F, i + 0.5F, -i});
  }
  const std::vector<vdbtools::VertexColumn> columns = {{"Cd", vdbtools::ColumnKind::LinearRgb},
                                                       {"depth", vdbtools::ColumnKind::Number}};
  const TemporaryFolder folder;
  const std::string bytes =
      vdbtools::encodeVdb({vdbtools::pointGrid({positions, normals, values}, columns, spaced.spacing)}, {});
  EXPECT_EQ(bytes,
            vdbtools::encodeVdb({vdbtools::pointGrid({positions, normals, values}, columns, spaced.spacing)}, {}));
  openvdb::io::File file(folder.write("p.vdb", bytes));
  file.open();
  const auto grid = openvdb::gridPtrCast<PointDataGrid>(file.readGrid("points"));
  ASSERT_TRUE(grid);
  std::vector<bool> seen(positions.size(), false);
  for (auto leaf = grid->tree().cbeginLeaf(); leaf; ++leaf) {
    const AttributeHandle<openvdb::Vec3s> p(leaf->constAttributeArray("P")), n(leaf->constAttributeArray("N")),
        colour(leaf->constAttributeArray("Cd"));
    const AttributeHandle<float> depth(leaf->constAttributeArray("depth"));
    for (auto index = leaf->beginIndexOn(); index; ++index) {
      const auto i = static_cast<std::size_t>(-depth.get(*index));
      ASSERT_LT(i, positions.size());
      EXPECT_FALSE(seen[i]);
      seen[i] = true;
      const Vec3d at = grid->indexToWorld(Vec3d(p.get(*index)) + index.getCoord().asVec3d());
      EXPECT_LT((at - positions[i]).length(), 1e-6 * spaced.spacing);
      EXPECT_EQ(n.get(*index), normals[i]);
      EXPECT_EQ(colour.get(*index), openvdb::Vec3s(values[4 * i], values[4 * i + 1], values[4 * i + 2]));
    }
  }
  EXPECT_EQ(std::count(seen.begin(), seen.end(), true), static_cast<std::ptrdiff_t>(seen.size()));
  EXPECT_THROW(vdbtools::pointGrid({}, {}, 1), std::invalid_argument);
  EXPECT_THROW(vdbtools::pointGrid({positions}, {}, 0), std::invalid_argument);
}

}  // namespace
