// SPDX-License-Identifier: Apache-2.0
/// @file test_meshes.h
/// Meshes that tests share, all oriented outward.
#pragma once

#include "vdbtools/mesh/mesh.h"
#include "vdbtools/mesh_files/mesh_reader.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <map>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace test_meshes {

using openvdb::Vec3d;
using openvdb::Vec3I;
using vdbtools::Mesh;

inline constexpr double kPi = 3.14159265358979323846;

/// An axis-parallel box of 8 points and 12 triangles.
inline Mesh makeBox(const Vec3d& low, const Vec3d& high) {
  Mesh mesh;
  for (int n = 0; n < 8; ++n) {
    mesh.points.emplace_back(n & 1 ? high[0] : low[0], n & 2 ? high[1] : low[1], n & 4 ? high[2] : low[2]);
  }
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

inline Mesh makeCube(double side = 1, const Vec3d& center = Vec3d(0)) {
  return makeBox(center - Vec3d(side / 2), center + Vec3d(side / 2));
}

/// A geodesic sphere: an icosahedron whose triangles are split in four @a subdivisions times, 20 * 4^n triangles. All
/// points lie on the sphere, so its faces lie within it.
inline Mesh makeSphere(double radius = 1, int subdivisions = 4, const Vec3d& center = Vec3d(0)) {
  const double t = (1 + std::sqrt(5.0)) / 2;
  Mesh mesh;
  mesh.points = {{-1, t, 0},  {1, t, 0},  {-1, -t, 0}, {1, -t, 0}, {0, -1, t},  {0, 1, t},
                 {0, -1, -t}, {0, 1, -t}, {t, 0, -1},  {t, 0, 1},  {-t, 0, -1}, {-t, 0, 1}};
  mesh.triangles = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                    {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                    {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  for (Vec3d& p : mesh.points) p.normalize();
  for (int s = 0; s < subdivisions; ++s) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto [it, isNew] = middles.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(mesh.points.size()));
      if (isNew) mesh.points.push_back((mesh.points[a] + mesh.points[b]).unit());
      return it->second;
    };
    std::vector<Vec3I> finer;
    for (const Vec3I& f : mesh.triangles) {
      const std::uint32_t ab = middle(f[0], f[1]);
      const std::uint32_t bc = middle(f[1], f[2]);
      const std::uint32_t ca = middle(f[2], f[0]);
      finer.insert(finer.end(), {Vec3I(f[0], ab, ca), Vec3I(f[1], bc, ab), Vec3I(f[2], ca, bc), Vec3I(ab, bc, ca)});
    }
    mesh.triangles = std::move(finer);
  }
  for (Vec3d& p : mesh.points) p = center + p * radius;
  return mesh;
}

/// Without the triangles for whose centre @a drop is true. Points stay.
template <typename Predicate>
Mesh withoutTriangles(const Mesh& mesh, Predicate drop) {
  Mesh result = mesh;
  result.triangles.clear();
  for (const Vec3I& t : mesh.triangles) {
    if (!drop((mesh.points[t[0]] + mesh.points[t[1]] + mesh.points[t[2]]) / 3.0)) result.triangles.push_back(t);
  }
  return result;
}

inline Mesh merged(const Mesh& a, const Mesh& b) {
  Mesh result = a;
  const auto first = static_cast<std::uint32_t>(a.points.size());
  result.points.insert(result.points.end(), b.points.begin(), b.points.end());
  for (const Vec3I& t : b.triangles) result.triangles.emplace_back(t[0] + first, t[1] + first, t[2] + first);
  return result;
}

inline Mesh flipped(Mesh mesh) {
  for (Vec3I& t : mesh.triangles) std::swap(t[1], t[2]);
  return mesh;
}

inline Mesh transformed(Mesh mesh, double scale, const Vec3d& shift) {
  for (Vec3d& p : mesh.points) p = p * scale + shift;
  return mesh;
}

/// Each triangle with points of its own, each moved by up to @a jitter along each axis.
inline Mesh makeSoup(const Mesh& mesh, double jitter, unsigned seed = 1) {
  std::mt19937 random(seed);  // its sequence is the same everywhere, unlike a distribution's
  const auto offset = [&] { return jitter * (2.0 * random() / 4294967295.0 - 1.0); };
  Mesh soup;
  for (const Vec3I& t : mesh.triangles) {
    const auto first = static_cast<std::uint32_t>(soup.points.size());
    for (int c = 0; c < 3; ++c) {
      const double x = offset();
      const double y = offset();
      const double z = offset();
      soup.points.push_back(mesh.points[t[c]] + Vec3d(x, y, z));
    }
    soup.triangles.emplace_back(first, first + 1, first + 2);
  }
  return soup;
}

/// 34835 points, 69666 triangles, closed but for the holes under its base, longest side about 2. From the package
/// glmark2-data; a test that needs it asks first.
inline const std::filesystem::path& bunnyPath() {
  static const std::filesystem::path path = "/usr/share/glmark2/models/bunny.obj";
  return path;
}
inline bool hasBunny() { return std::filesystem::exists(bunnyPath()); }
inline const Mesh& bunny() {
  static const Mesh mesh = vdbtools::readMesh(bunnyPath());
  return mesh;
}

}  // namespace test_meshes
