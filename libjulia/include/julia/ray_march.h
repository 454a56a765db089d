// SPDX-License-Identifier: Apache-2.0
/// @file ray_march.h
/// Rays from an eye that are sampled until they meet the set, for devices that follow many rays at a time.
#pragma once

#include "julia/embedding.h"

#include <array>
#include <cstdint>
#include <span>

namespace julia {

/// The point at a distance from another one.
inline Point pointAlong(const Point& from, double distance, const Point& direction) {
  return {from[0] + distance * direction[0], from[1] + distance * direction[1], from[2] + distance * direction[2]};
}

/// How rays are sampled: each where it begins, and then at the members of one sequence of distances from the eye,
/// t_{k+1} = t_k + max(alpha t_k^delta, epsilon). The first sample with F < 0 and the distance of the sample before it
/// are halved so many times, towards the change of sign.
struct RayMarch {
  Point eye{};
  double alpha = 0, epsilon = 0;
  int delta = 1;                      ///< 0, 1 or 2
  std::span<const double> members{};  ///< some of the sequence in their order; the first is below each ray's beginning
  int bisections = 0;

  /// Cubes along the axes, in which samples are evaluated if a bit is set: bit n % 32 of word n / 32 for cube n =
  /// (x count[1] + y) count[2] + z. F >= 0 is proved in the others. If there is none, all samples are evaluated.
  std::span<const std::uint32_t> occupied{};
  std::array<int, 3> count{};
  Point corner{};   ///< the lowest one of cube (0, 0, 0)
  double side = 1;  ///< of a cube
};

/// A ray, or what is left of it.
struct MarchedRay {
  Point direction;        ///< of length 1
  double before = 0;      ///< the distance of the sample before the next one; that of the next one where a ray begins
  double t = 0, end = 0;  ///< of the next sample, and beyond which there is none
};

enum class RayEnd : std::int32_t {
  Missed,  ///< no sample has F < 0
  Met,     ///< F < 0 at the distance `inside`, and not at `outside`; if these are equal, the ray begins in the set
  Left,  ///< the caller has to follow the rest of the ray: the next sample is at `inside`, that before it at `outside`
};

struct RayMeeting {
  RayEnd end = RayEnd::Left;
  double outside = 0, inside = 0;
  int samples = 0;  ///< how many were evaluated, without those of the bisection
};

}  // namespace julia
