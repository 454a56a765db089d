// SPDX-License-Identifier: Apache-2.0
/// @file test_fields.h
/// Targets with a known signed distance, as grids and as functions, and the plain evaluation of what they define:
/// nothing here shares code with what it tests.
#pragma once

#include "julia/embedding.h"
#include "julia/evaluator.h"
#include "julia/rational.h"
#include "support/reference.h"
#include "vdbtools/base/grids.h"

#include <openvdb/tools/SignedFloodFill.h>

#include <cmath>
#include <functional>
#include <random>

namespace test_fields {

using openvdb::Coord;
using openvdb::Vec3d;
using Distance = std::function<double(const Vec3d&)>;

/// A ball with a ring through it: curved both ways, and not symmetric. Its longest side is about 1.
inline double lumpy(const Vec3d& x) {
  const double ball = (x - Vec3d(0.05, -0.02, 0.01)).length() - 0.3;
  const double ring = Vec3d(std::hypot(x[0], x[2]) - 0.38, x[1] - 0.1, 0).length() - 0.11;
  return std::min(ball, ring);
}

/// @a distance at the nodes of a box of index space, all active.
inline openvdb::FloatGrid::Ptr denseGrid(const Distance& distance, double voxelSize, const openvdb::CoordBBox& box,
                                         const Vec3d& shift = Vec3d(0)) {
  auto grid = openvdb::FloatGrid::create(0.0f);
  auto transform = openvdb::math::Transform::createLinearTransform(voxelSize);
  transform->postTranslate(shift);
  grid->setTransform(transform);
  grid->setName("sdf");
  auto accessor = grid->getAccessor();
  for (auto node = box.begin(); node; ++node)
    accessor.setValue(*node, static_cast<float>(distance(grid->indexToWorld(*node))));
  return grid;
}

/// The whole inside, and outside as far as @a width.
inline openvdb::FloatGrid::Ptr bandGrid(const Distance& distance, double voxelSize, double width, double inside = 1e9) {
  auto grid = openvdb::FloatGrid::create(static_cast<float>(width));
  grid->setTransform(openvdb::math::Transform::createLinearTransform(voxelSize));
  grid->setGridClass(openvdb::GRID_LEVEL_SET);
  grid->setName("phi");
  auto accessor = grid->getAccessor();
  const int reach = static_cast<int>(std::ceil((0.6 + width) / voxelSize)) + 2;
  for (auto node = openvdb::CoordBBox(Coord(-reach), Coord(reach)).begin(); node; ++node) {
    const double phi = distance(grid->indexToWorld(*node));
    if (phi < width && phi > -inside) accessor.setValue(*node, static_cast<float>(phi));
  }
  openvdb::tools::signedFloodFill(grid->tree());
  return grid;
}

/// Trilinear between the nodes of the lattice of @a distance, in doubles; the values rounded to floats as a grid does.
inline double trilinear(const Distance& distance, double voxelSize, const Vec3d& world, const Vec3d& shift = Vec3d(0)) {
  const Vec3d index = (world - shift) / voxelSize;
  const Coord corner = Coord::floor(index);
  double sum = 0;
  for (int k = 0; k < 8; ++k) {
    const Coord node = corner.offsetBy(k & 1, k >> 1 & 1, k >> 2 & 1);
    double weight = 1;
    for (int axis = 0; axis < 3; ++axis) {
      const double t = index[axis] - corner[axis];
      weight *= (k >> axis & 1) ? t : 1 - t;
    }
    sum += weight * static_cast<double>(static_cast<float>(distance(node.asVec3d() * voxelSize + shift)));
  }
  return sum;
}

inline julia::Rational randomVersor(unsigned seed, int roots, double maxPower, bool integer, double extent = 0.5) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> place(-extent, extent), power(2, maxPower);
  julia::Rational rational;
  for (int i = 0; i < roots; ++i) {
    const double p = power(random);
    rational.top.roots.push_back({{place(random), place(random), place(random), 0}, integer ? std::floor(p) : p});
  }
  return rational;
}

/// A number in [-1, 1) that depends on the node alone.
inline double noise(const Coord& node, unsigned seed) {
  std::uint64_t h = seed * 0x9E3779B97F4A7C15ull;
  for (int axis = 0; axis < 3; ++axis) {
    h ^= static_cast<std::uint64_t>(node[axis] + 1000);
    h *= 0xBF58476D1CE4E5B9ull;
    h ^= h >> 29;
  }
  return static_cast<double>(h >> 11) * 0x1p-52 - 1;
}

/// A field given by its values at integer nodes, trilinear between them: what random fields are made of.
class NodeEvaluator final : public julia::FieldEvaluator {
 public:
  explicit NodeEvaluator(std::function<double(const Coord&)> value) : mValue(std::move(value)) {}

  void evaluate(std::span<const julia::Point> points, std::span<double> field,
                std::span<int> iterations) const override {
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Vec3d index(points[i].data());
      const Coord corner = Coord::floor(index);
      field[i] = 0;
      for (int k = 0; k < 8; ++k) {
        double weight = 1;
        for (int axis = 0; axis < 3; ++axis) {
          const double t = index[axis] - corner[axis];
          weight *= (k >> axis & 1) ? t : 1 - t;
        }
        if (weight != 0) field[i] += weight * mValue(corner.offsetBy(k & 1, k >> 1 & 1, k >> 2 & 1));
      }
      if (!iterations.empty()) iterations[i] = 1;
    }
  }
  void versors(std::span<const julia::Point>, std::span<julia::Quaternion<double>> versors) const override {
    std::fill(versors.begin(), versors.end(), julia::Quaternion<double>::one());
  }
  void orbitTraps(std::span<const julia::Point>, std::span<double> nearest) const override {
    std::fill(nearest.begin(), nearest.end(), julia::kFieldLimit);
  }

 private:
  std::function<double(const Coord&)> mValue;
};

}  // namespace test_fields
