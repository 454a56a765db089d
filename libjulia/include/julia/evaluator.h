// SPDX-License-Identifier: Apache-2.0
/// @file evaluator.h
/// The interface between the dynamics and the code that fills grids and searches edges: it takes points and returns
/// field values.
#pragma once

#include "julia/ball.h"
#include "julia/cartesian_map.h"
#include "julia/edge_search.h"
#include "julia/embedding.h"
#include "julia/map.h"
#include "julia/orbit.h"
#include "julia/ray_march.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>

namespace julia {

/// F as plain values, from which another back end can be built.
struct FieldDescription {
  MapDescription map;     ///< empty if the map has no description
  Embedding embedding;    ///< how the points lie in the quaternions
  OrbitOptions orbit;     ///< a trap decides orbits early, but changes no sign of F if it is sound
  double level = 0;       ///< F = l_last - level
  bool inFloats = false;  ///< whether F is computed in 32 bits, from the map's numbers rounded to 32 bits
};

/// 8^3 nodes of a lattice along the axes of space: node (x, y, z), whose number is (8 x + y) 8 + z, lies at (at[0][x],
/// at[1][y], at[2][z]).
struct NodeBlock {
  static constexpr std::size_t kSide = 8, kSize = kSide * kSide * kSide;

  std::array<std::array<double, kSide>, 3> at{};
  std::uint8_t wanted = 0xff;     ///< bit x/4 4 + y/4 2 + z/4: whether that eighth of the block is evaluated
  std::span<float, kSize> field;  ///< receives the results; values of the other eighths are left unchanged
};

/// The signs of F at 8^3 nodes of a lattice, by their numbers.
struct SignBlock {
  std::array<std::int32_t, 3> origin{};   ///< the first node
  std::uint8_t wanted = 0xff;             ///< as in NodeBlock
  std::array<std::uint64_t, 8> inside{};  ///< receives in bit 8 y + z of word x whether F < 0; 0 where it is not wanted
};

/// F as it is stored in 32 bits: rounded, without losing the sign.
inline float storedField(double field) {
  const float value = static_cast<float>(field);
  return value == 0 && field < 0 ? -std::numeric_limits<float>::min() : value;
}

/// Evaluates F. Evaluation is const, so one evaluator serves many threads; a point's value does not depend on its
/// batch.
///
///     const auto evaluator = julia::makeFieldEvaluator<float>(map, {}, {.maxIterations = 5});
///     const std::vector<julia::Point> points = {{0.1, 0.2, 0.3}, {0.4, 0.5, 0.6}};
///     std::vector<double> field(points.size());
///     evaluator->evaluate(points, field, {});
///     const bool isInside = field[0] < 0;
class FieldEvaluator {
 public:
  virtual ~FieldEvaluator() = default;

  /// Sets field[i] to F(points[i]), which is finite. Unless @a iterations is empty, sets iterations[i] to the number of
  /// steps taken.
  virtual void evaluate(std::span<const Point> points, std::span<double> field, std::span<int> iterations) const = 0;

  /// How many points evaluate() should get at a time. Smaller batches waste vector lanes; larger ones do not help.
  virtual std::size_t preferredBatch() const { return 2048; }

  /// Describes what is evaluated; the map is empty if the evaluator cannot describe it.
  virtual FieldDescription describe() const { return {}; }

  /// 4, or 3 for a map of R^3.
  virtual int dimension() const { return 4; }

  /// Sets versors[i] to f/|f| at points[i], where f is the map's first step or, for a Cartesian map, its direction().
  virtual void versors(std::span<const Point> points, std::span<Quaternion<double>> versors) const = 0;

  /// Evaluates an orbit trap about 0: sets nearest[i] to the logarithm of the smallest modulus among the iterates of
  /// points[i], not counting the point itself, or to kFieldLimit if there is no iterate.
  virtual void orbitTraps(std::span<const Point> points, std::span<double> nearest) const = 0;

  /// Sets out[i] to what is known about the sign of F, as evaluate() computes it, at all points within @a radius of
  /// centres[i]. Inside and Outside are proofs; Undecided means that nothing is known.
  virtual void decide(std::span<const Point> centres, double radius, std::span<Decision> out) const {
    (void)centres, (void)radius;
    std::fill(out.begin(), out.end(), Decision::Undecided);
  }

  /// Evaluates the sign of F at the nodes of blocks: field receives F or, if its sign is known without following the
  /// orbit to its end, kFieldLimit with that sign. The result at a node depends on its block alone.
  virtual void evaluateBlocks(std::span<const NodeBlock> blocks) const;

  /// How many nodes evaluateSigns() should get at a time; 0 if evaluateBlocks() is at least as fast.
  virtual std::size_t preferredNodes() const { return 0; }

  /// Evaluates the signs of F at the nodes of blocks of a lattice, whose coordinates are made where F is evaluated.
  virtual void evaluateSigns(const SearchLattice& lattice, std::span<SignBlock> blocks) const;

  /// As findCrossings(), for edges between nodes of the lattice.
  virtual void findNodeCrossings(std::span<const NodeEdge> edges, const SearchLattice& lattice,
                                 std::span<double> found) const;

  /// Sets found[i] to a place on edge i, in voxels from its beginning. The sign of F changes within the lattice's
  /// tolerance of it. The result depends on the edge alone. @pre found.size() == edges.size()
  virtual void findCrossings(std::span<const CrossedEdge> edges, const SearchLattice& lattice,
                             std::span<double> found) const;

  /// How many rays followRays() should get at a time; 0 if it leaves all of them to the caller.
  virtual std::size_t preferredRays() const { return 0; }

  /// Follows rays. The result for a ray depends on the ray alone, but for which of them are left to the caller.
  virtual void followRays(const RayMarch& march, std::span<const MarchedRay> rays, std::span<RayMeeting> met) const;

  /// Evaluates as evaluate() the points centres[i] + distances[i] directions[k], whose number is i directions.size() +
  /// k.
  virtual void evaluateAround(std::span<const Point> centres, std::span<const double> distances,
                              std::span<const Point> directions, std::span<double> field,
                              std::span<int> iterations) const;
};

/// Makes the back end of the processor, which runs batches through the vector kernels in the type Real (float or
/// double). onCurrentDevice() (device/device.h) puts it on a device.
/// @throw std::invalid_argument if the options are out of their domain
template <class Real>
std::unique_ptr<FieldEvaluator> makeFieldEvaluator(std::shared_ptr<const Map<Real>> map, const Embedding& embedding,
                                                   const OrbitOptions& options);

extern template std::unique_ptr<FieldEvaluator> makeFieldEvaluator(std::shared_ptr<const Map<float>>, const Embedding&,
                                                                   const OrbitOptions&);
extern template std::unique_ptr<FieldEvaluator> makeFieldEvaluator(std::shared_ptr<const Map<double>>, const Embedding&,
                                                                   const OrbitOptions&);

/// As above for a Cartesian map; what the evaluator can prove depends on the map's imageOf().
/// @throw std::invalid_argument if the options are out of their domain, or if the map is one of R^3 and the embedding
///                              has a slice or a dropped axis other than k
template <class Real>
std::unique_ptr<FieldEvaluator> makeFieldEvaluator(std::shared_ptr<const CartesianMap<Real>> map,
                                                   const Embedding& embedding, const OrbitOptions& options);

extern template std::unique_ptr<FieldEvaluator> makeFieldEvaluator(std::shared_ptr<const CartesianMap<float>>,
                                                                   const Embedding&, const OrbitOptions&);
extern template std::unique_ptr<FieldEvaluator> makeFieldEvaluator(std::shared_ptr<const CartesianMap<double>>,
                                                                   const Embedding&, const OrbitOptions&);

}  // namespace julia
