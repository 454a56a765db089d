// SPDX-License-Identifier: Apache-2.0
#include "decimation/decimate.h"

#include "support/mesh_laws.h"
#include "support/test_meshes.h"
#include "vdbtools/base/errors.h"

#include <gtest/gtest.h>
#include <OpenMesh/Core/System/omstream.hh>

namespace {

using namespace test_meshes;

TEST(Decimate, KeepsAClosedManifold) {
  const Mesh sphere = makeSphere(1, 4);
  const Mesh mesh = vdbtools::decimated(sphere, 500, 0.01);
  EXPECT_LE(mesh.triangles.size(), 500U);
  EXPECT_GT(mesh.triangles.size(), 400U);
  EXPECT_EQ(mesh_laws::notClosedManifold(mesh), "");
  for (const Vec3d& p : mesh.points) EXPECT_NEAR(p.length(), 1, 1e-9) << "points that remain stay where they are";
}

TEST(Decimate, LeavesTheErrorStreamAsItWas) {
  Mesh fin;
  fin.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, -1, 0}};
  fin.triangles = {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}};
  for (const bool enabled : {true, false}) {
    enabled ? omerr().enable() : omerr().disable();
    testing::internal::CaptureStderr();
    EXPECT_THROW(vdbtools::decimated(fin, 1, 0.01), vdbtools::DataError);
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
    EXPECT_EQ(omerr().is_enabled(), enabled);
  }
  omerr().enable();
}

}  // namespace
