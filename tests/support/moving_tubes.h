// SPDX-License-Identifier: Apache-2.0
/// @file moving_tubes.h
/// A tube that bends, as a target that moves.
#pragma once

#include "support/test_meshes.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace moving_tubes {

using openvdb::Vec3d;
using test_meshes::kPi;
using test_meshes::Mesh;

inline constexpr double kLength = 4, kRadius = 0.45;  ///< of the straight part along X, from 0 on; its ends are round

inline Mesh straightTube(int rings = 48, int around = 32) {
  constexpr int kEnd = 8;
  Mesh mesh;
  const auto ring = [&](double x, double radius) {
    for (int k = 0; k < around; ++k) {
      const double angle = 2 * kPi * k / around;
      mesh.points.emplace_back(x, radius * std::cos(angle), radius * std::sin(angle));
    }
  };
  const auto end = [&](int step) { return kPi / 2 * step / kEnd; };
  mesh.points.emplace_back(-kRadius, 0, 0);
  for (int k = 1; k <= kEnd; ++k) ring(-kRadius * std::cos(end(k)), kRadius * std::sin(end(k)));
  for (int k = 1; k < rings; ++k) ring(kLength * k / rings, kRadius);
  for (int k = kEnd; k >= 1; --k) ring(kLength + kRadius * std::cos(end(k)), kRadius * std::sin(end(k)));
  mesh.points.emplace_back(kLength + kRadius, 0, 0);
  const auto count = static_cast<std::uint32_t>(around), last = static_cast<std::uint32_t>(mesh.points.size() - 1);
  for (std::uint32_t k = 0; k < count; ++k) {
    const std::uint32_t next = (k + 1) % count;
    mesh.triangles.emplace_back(0, 1 + next, 1 + k);
    mesh.triangles.emplace_back(last, last - count + k, last - count + next);
    for (std::uint32_t first = 1; first + 2 * count <= last; first += count) {
      mesh.triangles.emplace_back(first + k, first + next, first + count + next);
      mesh.triangles.emplace_back(first + k, first + count + next, first + count + k);
    }
  }
  return mesh;
}

/// Turns the half beyond the bend, which reaches from x = @a from to @a to, by an angle in the plane of X and Y.
inline Mesh bent(Mesh mesh, double degrees, double from = 1.2, double to = 2.8) {
  const double angle = degrees * kPi / 180;
  if (angle == 0) return mesh;
  const double radius = (to - from) / angle;
  for (Vec3d& p : mesh.points) {
    const double turn = std::clamp((p[0] - from) / (to - from), 0., 1.) * angle;
    const double beyond = p[0] - std::clamp(p[0], from, to);
    const Vec3d along(std::cos(turn), std::sin(turn), 0), aside(-std::sin(turn), std::cos(turn), 0);
    p = Vec3d(from + radius * std::sin(turn), radius * (1 - std::cos(turn)), p[2]) + along * beyond + aside * p[1];
  }
  return mesh;
}

}  // namespace moving_tubes
