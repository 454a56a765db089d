// SPDX-License-Identifier: Apache-2.0
/// @file kernels.h
/// The inner loops, compiled once for each instruction set: structure of arrays in and out, plain loops that the
/// compiler vectorises. A quaternion batch is four pointers, a b c d; outputs do not overlap inputs unless it says so.
///
/// Plain loops were measured against vector types and intrinsics (docs/performance.md): split so that no loop carries a
/// long chain of dependent operations, they are the fastest and the simplest.
#pragma once

#include <cstddef>
#include <cstdint>

namespace julia::kernels {

/// How a root's factor (q - t)^p is made.
enum class PowerMethod : std::uint8_t {
  Products,       ///< integer p up to 64 in magnitude: multiplications, the scale guessed
  ExactProducts,  ///< larger integers: multiplications from a unit quaternion
  Angle,          ///< real p: by the angle
};

template <class Real>
struct RootFactor {
  Real root[4];
  Real power;  ///< negative for a bottom root
  PowerMethod method;
  std::uint32_t integer;      ///< |p|, unless the method is Angle
  bool renormaliseAfterward;  ///< scales that were only guessed may have added up
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

/// What a map adds: one value for each point, or one for all.
template <class Real>
struct Addend {
  ConstBatch<Real> value;
  bool forAll;
};

/// The pairs of [ZB25], in the order of julia::CrossPair.
inline constexpr int kCrossPairs = 6;

/// The power of a triplex number, a point of R^3 by its radius and two angles.
template <class Real>
struct TriplexPower {
  Real power;
  std::uint32_t integer;  ///< the same if it is whole and its powers are made by products, else 0
  bool fromPole;          ///< the second angle is that from the z axis, not that above the xy plane
};

/// A scalar field of bricks (brick_field.h), as its kernel needs it.
template <class Real>
struct BrickLattice {
  Real matrix[3][3];  ///< point to brick-lattice position
  Real offset[3];
  Real low[3], high[3];  ///< positions are clamped to this, so that a cell is always there
  std::uint32_t bricks[3];
  const std::uint32_t* brickAt;  ///< which brick, by (x * bricks[1] + y) * bricks[2] + z
  const float* values;           ///< of all bricks
};

/// A wave (julia/wave_versor.h).
template <class Real>
struct WaveTerm {
  Real frequency[4];
  Real cosine[4], sine[4];
};
/// A factor of waves first to last - 1.
template <class Real>
struct WaveSpan {
  std::size_t first, last;
  std::uint32_t power;  ///< its magnitude
  Real conjugated;      ///< -1 for a negative one, else 1
};

/// Rows and columns of the tiles that dense matrices are multiplied by.
constexpr std::size_t kTile = 64;

template <class Real>
struct Kernels {
  /// u = the unit quaternion of the ordered product of (q - t)^p over all roots; least[i] = the smallest |q - t|^2, or
  /// squared distance from the real axis through t for a real power, that was met. Where that is below Ieee::kTiny or
  /// |q|^2 above its inverse, u is not to be used. @return whether there is such a point
  bool (*versor)(const RootFactor<Real>* roots, std::size_t rootCount, ConstBatch<Real> q, Batch<Real> u, Real* least,
                 std::size_t size);
  /// l = constant + sum of p ln|q - t|; least as above, of |q - t|^2, and so is what is returned.
  bool (*logModulus)(const RootFactor<Real>* roots, std::size_t rootCount, Real constant, ConstBatch<Real> q, Real* l,
                     Real* least, std::size_t size);
  /// A lower bound l of ln|v| over the balls of one radius about q: v is what is left of the versors there without the
  /// component number @a dropped; -inf where nothing is known. @param u  the versors at q  @param rounding  radians by
  /// which rounding may turn a versor
  void (*logLeastPart)(const RootFactor<Real>* roots, std::size_t rootCount, Real radius, Real rounding,
                       unsigned dropped, ConstBatch<Real> q, ConstBatch<Real> u, Real* l, std::size_t size);
  /// Closes the ranks of the entries with l < escape and, if @a traps, l > trap: of l, of index and of the rows, in
  /// place and in their order. @return how many there are
  std::size_t (*compact)(Real escape, bool traps, Real trap, Real* l, std::uint32_t* index, Real* const* rows,
                         std::size_t rowCount, std::size_t size);
  /// q = e^l q, in place.
  void (*scaleByExponential)(const Real* l, Batch<Real> q, std::size_t size);
  /// l = ln|q|, where |q|^2 is a normal number. @return whether there may be one that is not
  bool (*logNorm)(ConstBatch<Real> q, Real* l, std::size_t size);
  /// q / |q|, in place, where |q|^2 is a normal number.
  void (*normalise)(Batch<Real> q, std::size_t size);
  /// f = q^2 + c.
  void (*quadratic)(const Addend<Real>& c, ConstBatch<Real> q, Batch<Real> f, std::size_t size);
  /// For each of the pairs: next = f(p) x g(p) + c, in R^3. The fourth components are 0 here and below.
  void (*cross[kCrossPairs])(const Addend<Real>& c, ConstBatch<Real> p, Batch<Real> next, std::size_t size);
  /// g(p).
  void (*crossSecond[kCrossPairs])(ConstBatch<Real> p, Batch<Real> g, std::size_t size);
  /// next = f x g + c.
  void (*crossProduct)(const Addend<Real>& c, ConstBatch<Real> f, ConstBatch<Real> g, Batch<Real> next,
                       std::size_t size);
  /// next = p^power + c.
  void (*triplex)(const TriplexPower<Real>& power, const Addend<Real>& c, ConstBatch<Real> p, Batch<Real> next,
                  std::size_t size);
  /// The versors of waves about @a origin, by octaves, each from -40 to 40.
  void (*waveVersor)(const WaveTerm<Real>* waves, const WaveSpan<Real>* factors, std::size_t factorCount,
                     const Real* origin, ConstBatch<Real> q, const Real* octave, Batch<Real> u, std::size_t size);
  /// Trilinear: bricks of 8^3 cells, 9^3 values. Between nodes of a cell the result is linear along each axis.
  void (*sampleTrilinear)(const BrickLattice<Real>& lattice, const Real* x, const Real* y, const Real* z, Real* out,
                          std::size_t size);
  /// Quadratic B-spline: bricks of 8^3 nodes with one more all round, 10^3 values.
  void (*sampleQuadratic)(const BrickLattice<Real>& lattice, const Real* x, const Real* y, const Real* z, Real* out,
                          std::size_t size);
  /// out = ln|x - root|, of roots that lie @a rest (squared) off the slice of the points. The square of the distance is
  /// taken as at least Ieee::kTiny.
  void (*logDistances)(const Real* root, Real rest, const Real* x, const Real* y, const Real* z, Real* out,
                       std::size_t size);
  /// sums += the columns times their weights, one after the other; columns lie @a size apart, a multiple of 16.
  void (*addColumns)(const Real* columns, const double* weights, std::size_t columnCount, double* sums,
                     std::size_t size);
  /// products[j] = the sum over i of column j times factors; columns as above.
  void (*dotColumns)(const Real* columns, const double* factors, std::size_t columnCount, double* products,
                     std::size_t size);
  /// out[i][j] = the sum over k of a[k][i] b[k][j], k < depth, one after the other; rows of kTile, @a out of kTile^2.
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
