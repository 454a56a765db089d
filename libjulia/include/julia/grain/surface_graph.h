// SPDX-License-Identifier: Apache-2.0
/// @file surface_graph.h
/// Directions and phases on a surface that is given by points, their normals and which of them are neighbours. No
/// triangles are needed, so the surface may have any number of parts, holes or sheets.
///
/// A tangent vector at point i is a complex number z_i in a basis of the tangent plane. Along an edge it is carried by
/// the smallest rotation that turns one normal into the other, which is a factor r_ij of length 1. A field is smooth if
///
///   sum over edges of  w_ij |z_j - r_ij z_i|^2
///
/// is small, which is the connection Laplacian of [KCPS13]. Stripes across a wave vector k are the phases
/// psi_i for which the same sum is small with r_ij = exp(i k.(x_j - x_i)) [KCPS15]. Both lead to one
/// sparse Hermitian system, which is factorised in a fixed order.
#pragma once

#include "julia/embedding.h"

#include <complex>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace julia {

struct SurfaceEdge {
  std::uint32_t from = 0, to = 0;
};

/// Units are those of the positions. All results are finite and have the same bits on every machine.
class SurfaceGraph {
 public:
  /// @param positions  with their @a normals, of length 1
  /// @param spacings   the distance between neighbours about each point, > 0
  /// @param edges      pairs of neighbours, each pair once
  /// @throw std::invalid_argument  sizes that differ, an edge without its points or from a point to itself
  SurfaceGraph(std::vector<Point> positions, std::vector<Point> normals, std::vector<double> spacings,
               std::vector<SurfaceEdge> edges);

  std::size_t size() const { return mPositions.size(); }
  const Point& position(std::size_t i) const { return mPositions[i]; }
  const Point& normal(std::size_t i) const { return mNormals[i]; }
  double spacing(std::size_t i) const { return mSpacings[i]; }
  std::span<const SurfaceEdge> edges() const { return mEdges; }

  /// The two tangents of point @a i, of length 1, at right angles.
  const Point& first(std::size_t i) const { return mFirst[i]; }
  const Point& second(std::size_t i) const { return mSecond[i]; }
  /// The tangential part of a vector as a complex number, and the vector of such a number.
  std::complex<double> tangent(std::size_t i, const Point& vector) const;
  Point vector(std::size_t i, const std::complex<double>& tangent) const;

  /// From 0 for neighbours that are as far away as any, to 1.
  double weight(std::size_t edge) const { return mWeights[edge]; }
  /// The factor that carries a tangent of the edge's first point to its second.
  const std::complex<double>& transport(std::size_t edge) const { return mTransports[edge]; }
  /// The way along an edge in the tangent plane of its first or its second point, as long as the edge.
  std::complex<double> wayAtFrom(std::size_t edge) const;
  std::complex<double> wayAtTo(std::size_t edge) const;

 private:
  std::vector<Point> mPositions, mNormals;
  std::vector<double> mSpacings;
  std::vector<SurfaceEdge> mEdges;
  std::vector<Point> mFirst, mSecond;
  std::vector<double> mWeights;
  std::vector<std::complex<double>> mTransports;
};

/// How a surface bends about a point.
struct Bending {
  std::complex<double> least;  ///< the tangent along which it bends least, of length 1; its sign means nothing
  double difference = 0;       ///< by how much it bends more across it, 1 / units of length
};
/// Curvatures from the normals of neighbours, averaged over their neighbours @a rounds times.
std::vector<Bending> bendings(const SurfaceGraph& graph, int rounds);

/// The tangential gradient of a function on the points, by least squares.
std::vector<std::complex<double>> gradients(const SurfaceGraph& graph, std::span<const double> values);

/// What is wanted of a direction at a point.
struct DirectionWish {
  std::complex<double> towards;  ///< a tangent of length 1, or 0 for no wish
  double weight = 0;             ///< >= 0; 1 outweighs all neighbours together
  bool signs = true;             ///< whether the opposite direction is not what is wanted
  /// Otherwise, how much that one is preferred: the signs of a connected part of the surface follow their sum.
  double lean = 0;
};
/// The smoothest field of directions that comes near the wishes: tangents of length 1.
/// @param cancelled  asked now and then; once it is true, the result means nothing
std::vector<std::complex<double>> smoothDirections(const SurfaceGraph& graph, std::span<const DirectionWish> wishes,
                                                   const std::function<bool()>& cancelled = {});

/// A wave at a point of the surface. Near the point its phase is phase + gradient.(x - position), in radians.
struct SurfacePhase {
  std::complex<double> value;  ///< exp(i phase), of length 1
  Point gradient;              ///< tangential, radians per unit of length
};
/// Phases whose gradients are near the wave vectors, which are tangents in radians per unit of length. Where waves
/// come closer together or farther apart, some begin or end.
/// @param cancelled  as above
std::vector<SurfacePhase> stripePhases(const SurfaceGraph& graph, std::span<const std::complex<double>> waves,
                                       const std::function<bool()>& cancelled = {});

}  // namespace julia
