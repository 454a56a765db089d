// SPDX-License-Identifier: Apache-2.0
// Rays through triangles against a plain loop over all of them, and pictures of meshes against those of level sets.
#include "vdbtools/render/preview.h"

#include "render/ray_tree.h"
#include "support/test_images.h"
#include "support/test_meshes.h"

#include "vdbtools/base/errors.h"

#include <gtest/gtest.h>
#include <openvdb/tools/LevelSetSphere.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <random>
#include <stdexcept>
#include <vector>

namespace {

using namespace vdbtools;
using openvdb::Vec3d;
using openvdb::Vec3I;
using openvdb::Vec3s;
using test_images::difference;
using test_meshes::makeBox;
using test_meshes::makeSphere;

Image picture(Mesh mesh, int samples = 1, bool colours = true) {
  Monitor monitor;
  MeshPreviewOptions options{.picture = {.width = 60, .height = 60, .samples = samples}, .colours = colours};
  return renderMeshPreview(std::move(mesh), options, monitor).beauty;
}

/// Where a ray meets a triangle, by Cramer's rule in long doubles.
std::optional<double> meets(const std::vector<Vec3s>& points, const Vec3I& t, const Vec3d& origin,
                            const Vec3d& direction) {
  using Vec = openvdb::math::Vec3<long double>;
  const Vec a(points[t[0]]), ab = Vec(points[t[1]]) - a, ac = Vec(points[t[2]]) - a, d(direction);
  const Vec s = Vec(origin) - a;
  const long double det = ab.dot(d.cross(ac));
  if (det == 0) return std::nullopt;
  const long double u = s.dot(d.cross(ac)) / det, v = d.dot(s.cross(ab)) / det, r = ac.dot(s.cross(ab)) / det;
  return u >= 0 && v >= 0 && u + v <= 1 && r > 0 ? std::optional(static_cast<double>(r)) : std::nullopt;
}

TEST(RayTree, FindsWhatAPlainLoopFinds) {
  Monitor monitor;
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> within(-0.5, 0.5);
  const auto anywhere = [&] { return Vec3d(within(random), within(random), within(random)); };
  for (const double size : {1.0, 0.1, 1e-3, 1e-5}) {
    for (const std::size_t count : {1U, 4U, 5U, 33U, 1000U}) {
      std::vector<Vec3s> points;
      std::vector<Vec3I> triangles;
      for (std::uint32_t i = 0; i < count; ++i) {
        const Vec3d at = anywhere();
        for (int k = 0; k < 3; ++k) points.emplace_back(at + size * anywhere());
        triangles.emplace_back(3 * i, 3 * i + 1, 3 * i + 2);
      }
      const RayTree tree(points, triangles, monitor);
      int hits = 0;
      for (int ray = 0; ray < 300; ++ray) {
        const Vec3I& t = triangles[static_cast<std::size_t>(random() % count)];
        Vec3d towards = Vec3d(points[t[0]] + points[t[1]] + points[t[2]]) / 3;
        // Some along the axes, of which a slope is 0.
        Vec3d direction = ray % 3 == 0 ? Vec3d(0) : anywhere().unit();
        if (ray % 3 == 0) direction[static_cast<int>(random() % 3)] = ray % 2 == 0 ? 1 : -1;
        const Vec3d origin = towards - 1.2 * direction;
        double nearest = std::numeric_limits<double>::infinity();
        for (const Vec3I& triangle : triangles)
          nearest = std::min(nearest, meets(points, triangle, origin, direction).value_or(nearest));
        const std::optional<RayTree::Hit> hit = tree.firstHit(origin, direction);
        EXPECT_EQ(tree.blocked(origin, direction), hit.has_value());
        // The tree keeps edges in floats.
        ASSERT_TRUE(hit || std::isinf(nearest)) << "size " << size << ", ray " << ray;
        if (!hit) continue;
        ++hits;
        ASSERT_LE(hit->distance, nearest + 1e-5) << "size " << size << ", ray " << ray;
        const Vec3I& found = triangles[hit->triangle];
        const Vec3d place = (1 - hit->u - hit->v) * Vec3d(points[found[0]]) + hit->u * Vec3d(points[found[1]]) +
                            hit->v * Vec3d(points[found[2]]);
        EXPECT_LT((place - (origin + hit->distance * direction)).length(), 1e-6);
      }
      EXPECT_GT(hits, 200) << "size " << size << ", " << count << " triangles";
    }
  }
}

TEST(RayTree, NoRaySlipsThroughAClosedMesh) {
  Monitor monitor;
  const Mesh sphere = makeSphere(0.9, 4);
  const std::vector<Vec3s> points(sphere.points.begin(), sphere.points.end());
  const RayTree tree(points, sphere.triangles, monitor);
  std::mt19937_64 random(3);
  for (const Vec3I& t : sphere.triangles) {
    // At its corners and at points of its edges, from far away.
    for (const double share : {0.0, 0.25, 0.5}) {
      const Vec3d target = (1 - share) * Vec3d(points[t[0]]) + share * Vec3d(points[t[1]]);
      const Vec3d direction = -target.unit();
      EXPECT_TRUE(tree.firstHit(target - 100.0 * direction, direction));
      EXPECT_TRUE(tree.blocked(Vec3d(0.01, 0.02, 0.03), target - Vec3d(0.01, 0.02, 0.03)));
    }
  }
}

TEST(MeshPreview, OfASphereIsThatOfItsLevelSet) {
  const auto grid = openvdb::tools::createLevelSetSphere<openvdb::FloatGrid>(1, openvdb::Vec3f(3, -2, 5), 0.02f, 3);
  Monitor monitor;
  const Image level = renderPreview(*grid, {.width = 60, .height = 60, .samples = 4}, monitor).beauty;
  const Image mesh = picture(makeSphere(1, 5, Vec3d(3, -2, 5)), 4);
  // Apart from the outline: a level set is framed with the cells that its surface is in.
  for (int y = 12; y < 48; ++y)
    for (int x = 12; x < 48; ++x)
      for (std::size_t c = 0; c < 3; ++c) ASSERT_NEAR(mesh.at(x, y)[c], level.at(x, y)[c], 0.04) << x << ", " << y;
}

TEST(MeshPreview, DoesNotDependOnTheSideThePlaceOrTheUnit) {
  const Mesh plain = makeSphere(1, 3);
  const Image expected = picture(plain);
  Mesh flipped = plain;
  for (std::size_t i = 0; i < flipped.triangles.size(); i += 3)
    std::swap(flipped.triangles[i][1], flipped.triangles[i][2]);
  EXPECT_LT(difference(picture(flipped), expected), 1e-4) << "a third of the triangles is turned inside out";
  Mesh soup;
  for (const Vec3I& t : plain.triangles) {
    const auto n = static_cast<std::uint32_t>(soup.points.size());
    for (int i = 0; i < 3; ++i) soup.points.push_back(plain.points[t[i]]);
    soup.triangles.emplace_back(n, n + 1, n + 2);
  }
  EXPECT_LT(difference(picture(soup), expected), 1e-4) << "triangles that share no points";
  for (const auto& [scale, shift] : {std::pair(1e-9, 0.0), {1e9, 0.0}, {1.0, 1e6}, {1e-3, 1e3}, {1e150, 0.0}}) {
    Mesh moved = plain;
    for (Vec3d& point : moved.points) point = scale * point + Vec3d(shift, -shift, shift);
    EXPECT_LT(difference(picture(moved), expected), 1e-3) << "scale " << scale << ", shift " << shift;
  }
}

TEST(MeshPreview, IsTheSameForAnyNumberOfThreads) {
  const Mesh mesh = makeSphere(1, 3);
  const Image expected = picture(mesh);
  for (const std::size_t threads : {1U, 3U}) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    EXPECT_EQ(picture(mesh).pixels, expected.pixels) << threads << " threads";
  }
}

TEST(MeshPreview, ShowsAnOpenSheetAndTheInsideOfABox) {
  Mesh sheet{.points = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, .triangles = {{0, 1, 2}, {0, 2, 3}}};
  const Image front = picture(sheet);
  for (Vec3I& t : sheet.triangles) std::swap(t[1], t[2]);
  EXPECT_EQ(picture(sheet).pixels, front.pixels);
  Mesh box = makeBox(Vec3d(-1), Vec3d(1));
  box.triangles.resize(10);
  EXPECT_NO_THROW(picture(box));
}

TEST(MeshPreview, PaintIsSeenUnlessClayIsAskedFor) {
  Mesh mesh = makeSphere(1, 3);
  const Image clay = picture(mesh);
  const std::size_t count = mesh.points.size();
  mesh.attributes = {{"red", std::vector<float>(count, 0.0f)}, {"green", std::vector<float>(count, 1.0f)}};
  EXPECT_EQ(picture(mesh).pixels, clay.pixels) << "two of three channels";
  mesh.attributes.push_back({"blue", std::vector<float>(count, 0.0f)});
  const Image green = picture(mesh);
  const std::array<float, 3>& middle = green.at(30, 30);
  EXPECT_GT(middle[1], 3 * middle[0]);
  EXPECT_GT(middle[1], 3 * middle[2]);
  EXPECT_EQ(picture(mesh, 1, false).pixels, clay.pixels);
  for (float& value : mesh.attributes[0].values) value = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(picture(mesh).pixels, clay.pixels) << "points without a colour";
}

TEST(MeshPreview, RefusesWhatHasNoExtent) {
  EXPECT_THROW(picture(Mesh{}), DataError);
  EXPECT_THROW(picture(Mesh{.points = {{1, 1, 1}}, .triangles = {{0, 0, 0}}}), DataError);
  EXPECT_THROW(picture(Mesh{.points = {{0, 0, 0}, {1, 0, 0}}, .triangles = {{0, 1, 2}}}), DataError);
  Mesh broken = makeSphere(1, 1);
  broken.points[3][1] = std::numeric_limits<double>::infinity();
  EXPECT_THROW(picture(broken), DataError);
}

}  // namespace
