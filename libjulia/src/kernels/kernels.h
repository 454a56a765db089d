// SPDX-License-Identifier: Apache-2.0
/// @file kernels.h
/// The inner loops, compiled once for each instruction set: they take and return structures of arrays, in plain loops
/// that the compiler vectorises. A quaternion batch is four pointers, a b c d; outputs do not overlap inputs unless
/// stated otherwise.
///
/// Plain loops were compared with vector types and intrinsics (docs/trials.md). Split so that no loop carries a
/// long chain of dependent operations, they are the fastest and the simplest.
#pragma once

#include <cstddef>
#include <cstdint>

namespace julia::kernels {

/// How a root's factor (q - t)^p is computed.
enum class PowerMethod : std::uint8_t {
  Products,       ///< integer p up to 64 in magnitude: multiplications, with an estimated scale
  ExactProducts,  ///< larger integers: multiplications starting from a unit quaternion
  Angle,          ///< real p: from the angle
};

template <class Real>
struct RootFactor {
  Real root[4];
  Real power;  ///< negative for a bottom root
  PowerMethod method;
  std::uint32_t integer;      ///< |p|, unless the method is Angle
  bool renormaliseAfterward;  ///< errors of estimated scales may have accumulated
};

template <class Real>
struct ConstBatch {
  const Real* component[4];
};
template <class Real>
struct Batch {
  Real* component[4];
  operator ConstBatch<Real>() const { return {{component[0], component[1], component[2], component[3]}}; }
};

/// The number that a map adds: one value for each point, or one for all.
template <class Real>
struct Addend {
  ConstBatch<Real> value;
  bool forAll;
};

/// The pairs of [ZB25], in the order of julia::CrossPair.
inline constexpr int kCrossPairs = 6;

/// The power of a triplex number, a point of R^3 given by its radius and two angles.
template <class Real>
struct TriplexPower {
  Real power;
  std::uint32_t integer;  ///< the power if it is an integer computed by products, else 0
  bool fromPole;          ///< whether the second angle is measured from the z axis instead of from the xy plane
};

/// A scalar field of bricks (brick_field.h), in the form for its kernel.
template <class Real>
struct BrickLattice {
  Real matrix[3][3];  ///< transforms a point to a brick-lattice position
  Real offset[3];
  Real low[3], high[3];  ///< positions are clamped to this box, so that a cell always exists
  Real knee, more;       ///< julia/bricks.h
  std::uint32_t bricks[3];
  const std::uint32_t* brickAt;  ///< the brick at each place, indexed by (x * bricks[1] + y) * bricks[2] + z
  const float* values;           ///< values of all bricks
};

/// A wave (julia/wave_versor.h).
template <class Real>
struct WaveTerm {
  Real frequency[4];
  Real cosine[4], sine[4];
};
/// A factor that consists of the waves first to last - 1.
template <class Real>
struct WaveSpan {
  std::size_t first, last;
  std::uint32_t power;  ///< magnitude of the power
  Real conjugated;      ///< -1 for a negative power, else 1
};

/// How fast a factor of waves may change at octave 0, and how its Real rounds it.
struct WaveFactorBound {
  double curvature = 0;  ///< of the sum of waves: units of amplitude per unit of space squared
  double rounding = 0;   ///< of the sum, however small its phases are
  double perSize = 0;    ///< of the sum, for each unit of a place's size
};
/// A ball over which the versor of waves is bounded. Its octaves lie between one whole number and the next.
struct WaveBall {
  double place[4];  ///< its centre, from the texture's origin, units of the map's space
  double radius = 0;
  double size = 0;             ///< upper bound of the distances of its points from 0 and from the origin, added up
  double scale = 1;            ///< 2 to the power of the whole number
  double least = 0, most = 0;  ///< the weights of the finer octave
};
/// A versor, and an upper bound of the distance of a ball's versors from it; infinity if nothing is known.
struct VersorDisc {
  double centre[4];
  double radius;
};

/// Fields that are read together, and how many values a read of them takes.
constexpr std::size_t kJoinedFields = 5, kJoinedWidth = 8;

/// Rows and columns of the tiles in which dense matrices are multiplied.
constexpr std::size_t kTile = 64;

template <class Real>
struct Kernels {
  /// u = the versor of the ordered product of (q - t)^p over all roots; least[i] = the smallest |q - t|^2 that occurred
  /// or, for a real power, the smallest squared distance from the real axis through t. If that is below Ieee::kTiny or
  /// |q|^2 above its inverse, u is not valid. @return whether there is such a point
  bool (*versor)(const RootFactor<Real>* roots, std::size_t rootCount, ConstBatch<Real> q, Batch<Real> u, Real* least,
                 std::size_t size);
  /// l = constant + sum of p ln|q - t|; least is the smallest |q - t|^2, and the return value has the same meaning as
  /// above.
  bool (*logModulus)(const RootFactor<Real>* roots, std::size_t rootCount, Real constant, ConstBatch<Real> q, Real* l,
                     Real* least, std::size_t size);
  /// l = a lower bound of ln|v| over the balls of one radius about q, where v is the versor without the component
  /// number @a dropped; -inf if nothing is known. @param u  the versors at q  @param rounding  radians by which
  /// rounding may turn a versor
  void (*logLeastPart)(const RootFactor<Real>* roots, std::size_t rootCount, Real radius, Real rounding,
                       unsigned dropped, ConstBatch<Real> q, ConstBatch<Real> u, Real* l, std::size_t size);
  /// Compacts l, index and the rows to the entries with l < escape and, if @a traps, l > trap, in place and in order.
  /// @return the number of entries left
  std::size_t (*compact)(Real escape, bool traps, Real trap, Real* l, std::uint32_t* index, Real* const* rows,
                         std::size_t rowCount, std::size_t size);
  /// q = e^l q, in place.
  void (*scaleByExponential)(const Real* l, Batch<Real> q, std::size_t size);
  /// l = ln|q|, if |q|^2 is a normal number. @return whether |q|^2 may be another one somewhere
  bool (*logNorm)(ConstBatch<Real> q, Real* l, std::size_t size);
  /// q / |q|, in place, if |q|^2 is a normal number.
  void (*normalise)(Batch<Real> q, std::size_t size);
  /// f = q^2 + c.
  void (*quadratic)(const Addend<Real>& c, ConstBatch<Real> q, Batch<Real> f, std::size_t size);
  /// For each of the pairs: next = f(p) x g(p) + c, in R^3. Here and below the fourth components are 0.
  void (*cross[kCrossPairs])(const Addend<Real>& c, ConstBatch<Real> p, Batch<Real> next, std::size_t size);
  /// g(p).
  void (*crossSecond[kCrossPairs])(ConstBatch<Real> p, Batch<Real> g, std::size_t size);
  /// next = f x g + c.
  void (*crossProduct)(const Addend<Real>& c, ConstBatch<Real> f, ConstBatch<Real> g, Batch<Real> next,
                       std::size_t size);
  /// next = p^power + c.
  void (*triplex)(const TriplexPower<Real>& power, const Addend<Real>& c, ConstBatch<Real> p, Batch<Real> next,
                  std::size_t size);
  /// The versors of waves about @a origin, for octaves from -40 to 40.
  void (*waveVersor)(const WaveTerm<Real>* waves, const WaveSpan<Real>* factors, std::size_t factorCount,
                     const Real* origin, ConstBatch<Real> q, const Real* octave, Batch<Real> u, std::size_t size);
  /// The versors of waves that follow a grain (julia/grain_versor.h). @param fields  its five fields at the points
  void (*grainVersor)(const WaveTerm<Real>* waves, const WaveSpan<Real>* factors, std::size_t factorCount,
                      const Real* const* fields, Batch<Real> u, std::size_t size);
  /// Discs that contain the versors of waves over balls, as waveVersor() computes them in another type, whose rounding
  /// of a versor is at most @a slack. They are formed from the derivatives at the centre and from bounds of the terms
  /// of higher order.
  void (*waveDiscs)(const WaveTerm<double>* waves, const WaveSpan<double>* factors, const WaveFactorBound* bounds,
                    std::size_t factorCount, double slack, const WaveBall* balls, VersorDisc* discs, std::size_t size);
  /// Trilinear: bricks of 8^3 cells, 9^3 values. Between nodes of a cell the result is linear along each axis.
  void (*sampleTrilinear)(const BrickLattice<Real>& lattice, const Real* x, const Real* y, const Real* z, Real* out,
                          std::size_t size);
  /// The same for kJoinedFields fields on one lattice. The values of a node lie side by side, and after the last there
  /// are kJoinedWidth - kJoinedFields floats more. @param out  a row for each field
  void (*sampleJoined)(const BrickLattice<Real>& lattice, const Real* x, const Real* y, const Real* z, Real* const* out,
                       std::size_t size);
  /// Quadratic B-spline: bricks of 8^3 nodes with one additional node on every side, 10^3 values.
  void (*sampleQuadratic)(const BrickLattice<Real>& lattice, const Real* x, const Real* y, const Real* z, Real* out,
                          std::size_t size);
  /// out = ln|x - root|, for a root whose squared distance from the slice of the points is @a rest. Squared distances
  /// are raised to at least Ieee::kTiny.
  void (*logDistances)(const Real* root, Real rest, const Real* x, const Real* y, const Real* z, Real* out,
                       std::size_t size);
  /// The four columns of the derivatives of ln|x - root| by the coordinates of the root, @a size apart; with the same
  /// least squared distance, which keeps them finite.
  void (*logSlopes)(const Real* root, const Real* x, const Real* y, const Real* z, Real* columns, std::size_t size);
  /// sums += the columns times their weights, in order; columns are @a size apart, a multiple of 16.
  void (*addColumns)(const Real* columns, const double* weights, std::size_t columnCount, double* sums,
                     std::size_t size);
  /// products[j] = the sum over i of column j times factors; columns as above.
  void (*dotColumns)(const Real* columns, const double* factors, std::size_t columnCount, double* products,
                     std::size_t size);
  /// out[i][j] = the sum over k of a[k][i] b[k][j], k < depth, in order; rows have kTile entries, @a out has kTile^2.
  void (*tileProduct)(const Real* a, const Real* b, std::size_t depth, Real* out);
};

/// The kernels of the instruction set in use.
template <class Real>
const Kernels<Real>& kernels();

template <>
const Kernels<float>& kernels();
template <>
const Kernels<double>& kernels();

}  // namespace julia::kernels
