// SPDX-License-Identifier: Apache-2.0
#include "decimation/simplify.h"

#include "support/mesh_laws.h"
#include "support/test_meshes.h"

#include <gtest/gtest.h>

#include <vector>

namespace {

using vdbtools::Mesh;

Mesh levelOf(const Mesh& mesh, double share) {
  std::vector<float> positions;
  for (const auto& point : mesh.points)
    for (int axis = 0; axis < 3; ++axis) positions.push_back(static_cast<float>(point[axis]));
  Mesh level;
  level.points = mesh.points;
  level.triangles = vdbtools::simplified(positions, mesh.triangles, share).triangles;
  return level;
}

TEST(Simplify, ASolidStaysASolid) {
  Mesh tetrahedron;
  tetrahedron.points = {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
  tetrahedron.triangles = {{0, 1, 2}, {0, 3, 1}, {0, 2, 3}, {1, 3, 2}};
  for (const Mesh& mesh : {tetrahedron, test_meshes::makeCube(2), test_meshes::makeSphere(1, 2)}) {
    ASSERT_GT(mesh_laws::volume(mesh), 1);
    for (const double share : {0.9, 0.5, 0.25, 0.1, 0.01, 0.0}) {
      const Mesh level = levelOf(mesh, share);
      EXPECT_GT(mesh_laws::volume(level), 0.01 * mesh_laws::volume(mesh))
          << mesh.triangles.size() << " triangles, share " << share;
      EXPECT_LE(level.triangles.size(), mesh.triangles.size());
    }
  }
}

TEST(Simplify, WhatIsFlatAndOpenMayBecomeTwoTriangles) {
  constexpr unsigned kSide = 9;
  Mesh square;
  for (unsigned y = 0; y < kSide; ++y)
    for (unsigned x = 0; x < kSide; ++x) square.points.push_back({float(x), float(y), 0});
  for (unsigned y = 0; y + 1 < kSide; ++y)
    for (unsigned x = 0; x + 1 < kSide; ++x) {
      const unsigned at = y * kSide + x;
      square.triangles.push_back({at, at + 1, at + kSide});
      square.triangles.push_back({at + 1, at + kSide + 1, at + kSide});
    }
  EXPECT_LE(levelOf(square, 0.01).triangles.size(), 4u);
}

}  // namespace
