// SPDX-License-Identifier: Apache-2.0
/// @file kernel_bodies.h
/// The code of the kernels. Each source that is compiled for one instruction set includes it once, so nothing here may
/// have external linkage or call a function that the compiler might emit out of line: the linker would use any one of
/// the copies for all processors.
#pragma once

#include "blocks.h"
#include "cartesian_bodies.h"
#include "compress.h"
#include "elementary.h"
#include "fit_bodies.h"
#include "kernels.h"
#include "wave_bodies.h"
#include "wave_discs.h"

namespace julia::kernels {
namespace {

/// Whether the squares of some point of a block are unreliable.
template <class Real>
JULIA_INLINE bool anyUnusual(const Row<Real> (&q)[4], const Row<Real>& least, std::size_t padded) {
  constexpr Real kTiny = Ieee<Real>::kTiny;
  typename Ieee<Real>::Int unusual = 0;
  JULIA_FOR_POINTS {
    const Real norm = sumOfSquares(q[0][i], q[1][i], q[2][i], q[3][i]);
    unusual |= least[i] >= kTiny && norm <= 1 / kTiny ? 0 : 1;  // a NaN is unusual too
  }
  return unusual != 0;
}

/// The factor (q - t)^p of every point as real + imaginary v, where v is the imaginary part of q - t.
template <class Real>
struct Factor {
  alignas(64) Row<Real> real, imaginary;
};

/// Computes an integer power by squaring. @a scale makes |q - t| about 1.
template <class Real>
JULIA_INLINE void powerByProducts(std::uint32_t integer, const Row<Real>& a, const Row<Real>& s, const Row<Real>& scale,
                                  Factor<Real>& factor, std::size_t padded) {
  JULIA_FOR_POINTS {
    factor.real[i] = a[i];
    factor.imaginary[i] = 1;
  }
  for (int bit = 30 - __builtin_clz(integer); bit >= 0; --bit) {
    if (integer >> bit & 1)
      JULIA_FOR_POINTS squareAndMultiplyFactor(a[i], s[i], &factor.real[i], &factor.imaginary[i]);
    else
      JULIA_FOR_POINTS squareFactor(s[i], &factor.real[i], &factor.imaginary[i]);
  }
  JULIA_FOR_POINTS factor.imaginary[i] *= scale[i];
}

/// Computes the factor of a real power from the angle of q - t. @param angle, inverse  working memory
template <class Real>
JULIA_INLINE void factorByAngle(const RootFactor<Real>& root, const Row<Real> (&q)[4], Row<Real>& angle,
                                Row<Real>& inverse, Row<Real>& smallest, Factor<Real>& factor, std::size_t padded) {
  const Real ta = root.root[0], tb = root.root[1], tc = root.root[2], td = root.root[3], power = root.power;
  JULIA_FOR_POINTS {
    const Real da = q[0][i] - ta, db = q[1][i] - tb, dc = q[2][i] - tc, dd = q[3][i] - td;
    const Real square = imaginarySquare(db, dc, dd);
    smallest[i] = square < smallest[i] ? square : smallest[i];
    angle[i] = power * angleInQuadrants(da, squareRoot(square), &inverse[i]);
  }
  JULIA_FOR_POINTS {
    Real sine, cosine;
    sineCosine(angle[i], &sine, &cosine);
    factor.real[i] = cosine;
    factor.imaginary[i] = sine * inverse[i];
  }
}

/// 1 / sqrt(x) of a squared norm, or an estimate of it.
template <bool kGuess, class Real>
JULIA_INLINE Real inverseRoot(Real x) {
  if constexpr (kGuess)
    return guessedInverseRoot(x);
  else
    return 1 / squareRoot(x);
}

/// Scales q - t to a length of 1, or about 1: its real part, the square of its imaginary part, and the scale.
template <bool kGuess, class Real>
JULIA_INLINE void scaledDifference(const RootFactor<Real>& root, const Row<Real> (&q)[4], Row<Real>& a, Row<Real>& s,
                                   Row<Real>& scale, Row<Real>& smallest, std::size_t padded) {
  const Real ta = root.root[0], tb = root.root[1], tc = root.root[2], td = root.root[3];
  JULIA_FOR_POINTS {
    const Real da = q[0][i] - ta, db = q[1][i] - tb, dc = q[2][i] - tc, dd = q[3][i] - td;
    const Real square = imaginarySquare(db, dc, dd), norm = da * da + square;
    smallest[i] = norm < smallest[i] ? norm : smallest[i];
    const Real by = inverseRoot<kGuess>(norm);
    scale[i] = by;
    a[i] = da * by;
    s[i] = square * (by * by);
  }
}

/// u times the factor of a root.
template <class Real>
JULIA_INLINE void multiplyBy(const Factor<Real>& factor, const RootFactor<Real>& root, const Row<Real> (&q)[4],
                             Row<Real> (&u)[4], std::size_t padded) {
  const Real tb = root.root[1], tc = root.root[2], td = root.root[3];
  JULIA_FOR_POINTS {
    const Real fa = factor.real[i], by = factor.imaginary[i];
    const Real fb = (q[1][i] - tb) * by, fc = (q[2][i] - tc) * by, fd = (q[3][i] - td) * by;
    multiplyQuaternion(fa, fb, fc, fd, &u[0][i], &u[1][i], &u[2][i], &u[3][i]);
  }
}

/// u scaled to a length of 1, or about 1.
template <bool kGuess, class Real>
JULIA_INLINE void normaliseRows(Row<Real> (&u)[4], std::size_t padded) {
  JULIA_FOR_POINTS {
    const Real ua = u[0][i], ub = u[1][i], uc = u[2][i], ud = u[3][i];
    const Real by = inverseRoot<kGuess>(sumOfSquares(ua, ub, uc, ud));
    u[0][i] = ua * by;
    u[1][i] = ub * by;
    u[2][i] = uc * by;
    u[3][i] = ud * by;
  }
}

template <class Real>
bool versor(const RootFactor<Real>* roots, std::size_t rootCount, ConstBatch<Real> points, Batch<Real> out, Real* least,
            std::size_t size) {
  alignas(64) Row<Real> q[4], u[4], a, s, scale, smallest;
  Factor<Real> factor;
  bool unusual = false;
  for (std::size_t begin = 0; begin < size; begin += kBlock) {
    const Range range = blockAt(begin, size);
    const std::size_t padded = range.padded;
    for (int k = 0; k < 4; ++k) load(points.component[k], q[k], range);
    JULIA_FOR_POINTS {
      u[0][i] = 1;
      u[1][i] = u[2][i] = u[3][i] = 0;
      smallest[i] = 1;
    }
    for (std::size_t r = 0; r < rootCount; ++r) {
      const RootFactor<Real>& root = roots[r];
      if (root.method == PowerMethod::Angle) {
        factorByAngle(root, q, a, scale, smallest, factor, padded);
      } else {
        if (root.method == PowerMethod::Products)
          scaledDifference<true>(root, q, a, s, scale, smallest, padded);
        else
          scaledDifference<false>(root, q, a, s, scale, smallest, padded);
        powerByProducts(root.integer, a, s, scale, factor, padded);
        if (root.power < 0) JULIA_FOR_POINTS factor.imaginary[i] = -factor.imaginary[i];
      }
      multiplyBy(factor, root, q, u, padded);
      if (root.renormaliseAfterward) normaliseRows<true>(u, padded);
    }
    normaliseRows<false>(u, padded);
    for (int k = 0; k < 4; ++k) store(u[k], out.component[k], range);
    store(smallest, least, range);
    unusual |= anyUnusual(q, smallest, padded);
  }
  return unusual;
}

template <class Real>
bool logModulus(const RootFactor<Real>* roots, std::size_t rootCount, Real constant, ConstBatch<Real> points, Real* l,
                Real* least, std::size_t size) {
  alignas(64) Row<Real> q[4], sum, smallest;
  bool unusual = false;
  for (std::size_t begin = 0; begin < size; begin += kBlock) {
    const Range range = blockAt(begin, size);
    const std::size_t padded = range.padded;
    for (int k = 0; k < 4; ++k) load(points.component[k], q[k], range);
    JULIA_FOR_POINTS {
      sum[i] = constant;
      smallest[i] = 1;
    }
    for (std::size_t r = 0; r < rootCount; ++r) {
      const RootFactor<Real>& root = roots[r];
      const Real ta = root.root[0], tb = root.root[1], tc = root.root[2], td = root.root[3];
      const Real halfPower = root.power * Real(0.5);
      JULIA_FOR_POINTS {
        const Real da = q[0][i] - ta, db = q[1][i] - tb, dc = q[2][i] - tc, dd = q[3][i] - td;
        const Real norm = da * da + imaginarySquare(db, dc, dd);
        smallest[i] = norm < smallest[i] ? norm : smallest[i];
        sum[i] += halfPower * logarithm(norm);
      }
    }
    store(sum, l, range);
    store(smallest, least, range);
    unusual |= anyUnusual(q, smallest, padded);
  }
  return unusual;
}

/// An upper bound of how far a factor turns over a ball of radius r about q: rational_bounds.cpp has the formulas. Here
/// they are evaluated in Real, with slack for its rounding errors.
/// @param a, imaginarySquared, distance  the real part, the squared imaginary part and the length of q - t
/// @param sine  r / distance
template <class Real>
JULIA_INLINE Real turningOf(const RootFactor<Real>& root, Real a, Real imaginarySquared, Real distance, Real sine) {
  constexpr Real kRounding = 32 * Ieee<Real>::kEpsilon, kMost = Ieee<Real>::kHuge, kHalfPi = Real(1.5707963267948966);
  const Real p = magnitude(root.power);
  if (root.method != PowerMethod::Angle) return p;
  const Real cosine = 1 - sine * sine, along = magnitude(a) * sine, other = along + distance * (1 / p + kRounding);
  const Real left = squareRoot(imaginarySquared) * cosine - along - distance * kRounding;
  const Real byDistance = left > 0 ? distance / left : kMost;
  const Real byPower = byDistance < p * kHalfPi ? byDistance : p * kHalfPi;
  const Real either = a > distance * sine * (1 + kRounding) ? byPower : byDistance;
  const Real larger = either > p ? either : p;
  return imaginarySquared * (cosine * cosine) >= other * other ? p : larger;
}

template <class Real>
void logLeastPart(const RootFactor<Real>* roots, std::size_t rootCount, Real radius, Real rounding, unsigned dropped,
                  ConstBatch<Real> points, ConstBatch<Real> versors, Real* l, std::size_t size) {
  constexpr Real kRounding = 64 * Ieee<Real>::kEpsilon, kUnknown = -__builtin_inff();
  constexpr Real kLeast = Real(1e-3);  // a smaller bound is useless
  // Covers the rounding errors of the sum and of its terms.
  const Real slack = 1 + (kRounding + static_cast<Real>(rootCount) * Ieee<Real>::kEpsilon);
  alignas(64) Row<Real> q[4], u[4], sum, result;
  for (std::size_t begin = 0; begin < size; begin += kBlock) {
    const Range range = blockAt(begin, size);
    const std::size_t padded = range.padded;
    for (int k = 0; k < 4; ++k) load(points.component[k], q[k], range);
    for (int k = 0; k < 4; ++k) load(versors.component[k], u[k], range);
    JULIA_FOR_POINTS sum[i] = rounding;
    for (std::size_t r = 0; r < rootCount; ++r) {
      const RootFactor<Real> root = roots[r];
      const auto add = [&](const auto& turning) __attribute__((always_inline)) {
        constexpr Real kMostSine = Real(0.99);
        JULIA_FOR_POINTS {
          const Real da = q[0][i] - root.root[0], db = q[1][i] - root.root[1], dc = q[2][i] - root.root[2],
                     dd = q[3][i] - root.root[3];
          const Real imaginary = db * db + dc * dc + dd * dd, square = da * da + imaginary;
          const Real distance = squareRoot(square), sine = radius / distance;
          // The bound of the arc; for a sine above 1 the ball contains the root.
          const Real arc = sine * (1 + (sine <= Real(0.5) ? Real(0.1888) : Real(0.5708)) * (sine * sine));
          sum[i] += sine < kMostSine ? turning(da, imaginary, distance, sine) * arc : 4;
        }
      };
      if (root.method == PowerMethod::Angle)
        add([&](Real a, Real imaginary, Real distance, Real sine)
                __attribute__((always_inline)) { return turningOf(root, a, imaginary, distance, sine); });
      else
        add([p = magnitude(root.power)](Real, Real, Real, Real) __attribute__((always_inline)) { return p; });
    }
    // Uses the angle between the versors and the axis of the component.
    JULIA_FOR_POINTS {
      const Real quadrants = sum[i] * (slack * Real(0.63661977236758134));
      const bool known = quadrants < 1;
      Real sine, cosine;
      sineCosine(known ? quadrants : Real(0), &sine, &cosine);
      const Real ua = u[0][i] * u[0][i], ub = u[1][i] * u[1][i], uc = u[2][i] * u[2][i], ud = u[3][i] * u[3][i];
      const Real squares =
          (dropped == 0 ? 0 : ua) + (dropped == 1 ? 0 : ub) + (dropped == 2 ? 0 : uc) + (dropped == 3 ? 0 : ud);
      const Real gone = squareRoot(dropped == 0 ? ua : dropped == 1 ? ub : dropped == 2 ? uc : ud);
      const Real part = squareRoot(squares) * cosine - gone * sine - kRounding;
      const Real logPart = logarithm(part > kLeast ? part : kLeast) - kRounding;
      result[i] = known && part > kLeast ? logPart : kUnknown;
    }
    store(result, l, range);
  }
}

template <class Real>
std::size_t compact(Real escape, bool traps, Real trap, Real* l, std::uint32_t* index, Real* const* rows,
                    std::size_t rowCount, std::size_t size) {
  // The number of entries processed at once. One loop finds whether an entry is kept, and another one counts, because
  // the additions of the count depend on each other. Nothing branches on the result, which is unpredictable.
  constexpr std::size_t kTogether = 256;
  const bool all = !traps;
  std::size_t kept = 0;
  for (std::size_t begin = 0; begin < size; begin += kTogether) {
    const std::size_t count = size - begin < kTogether ? size - begin : kTogether;
    Real* const values = l + begin;
    alignas(64) std::uint8_t isKept[kTogether];
    for (std::size_t i = 0; i < count; ++i) isKept[i] = (values[i] < escape) & (all | (values[i] > trap)) ? 1 : 0;
    std::size_t done = 0;
#if defined(__AVX2__)
    // A vector is read completely before it is stored, at its own place or before it.
    for (; done + kCompressed <= count; done += kCompressed) {
      const KeptMask mask = keptMask(isKept + done);
      for (std::size_t row = 0; row < rowCount; ++row) compress(rows[row] + kept, mask, rows[row] + begin + done);
      compress(index + kept, mask, index + begin + done);
      compress(l + kept, mask, values + done);
      kept += static_cast<std::size_t>(__builtin_popcount(mask));
    }
#endif
    std::uint32_t stays[kTogether];
    std::size_t found = 0;
    for (std::size_t i = done; i < count; ++i) {
      stays[found] = static_cast<std::uint32_t>(i);
      found += isKept[i];
    }
    const auto close = [&](auto* from) __attribute__((always_inline)) {
      for (std::size_t k = 0; k < found; ++k) from[kept + k] = from[begin + stays[k]];
    };
    for (std::size_t row = 0; row < rowCount; ++row) close(rows[row]);
    close(index);
    close(l);
    kept += found;
  }
  return kept;
}

template <class Real>
void scaleByExponential(const Real* l, Batch<Real> batch, std::size_t size) {
  alignas(64) Row<Real> factor, q;
  for (std::size_t begin = 0; begin < size; begin += kBlock) {
    const Range range = blockAt(begin, size);
    const std::size_t padded = range.padded;
    load(l, factor, range);
    JULIA_FOR_POINTS factor[i] = exponential(factor[i]);
    for (int k = 0; k < 4; ++k) {
      load<Real>(batch.component[k], q, range);
      JULIA_FOR_POINTS q[i] *= factor[i];
      store(q, batch.component[k], range);
    }
  }
}

template <class Real>
bool logNorm(ConstBatch<Real> points, Real* l, std::size_t size) {
  constexpr Real kLeast = 2 * Ieee<Real>::kTiny, kMost = Ieee<Real>::kHuge;
  alignas(64) Row<Real> q[4], result, norm;
  typename Ieee<Real>::Int unusual = 0;
  for (std::size_t begin = 0; begin < size; begin += kBlock) {
    const Range range = blockAt(begin, size);
    const std::size_t padded = range.padded;
    for (int k = 0; k < 4; ++k) load(points.component[k], q[k], range);
    JULIA_FOR_POINTS norm[i] = q[0][i] * q[0][i] + imaginarySquare(q[1][i], q[2][i], q[3][i]);
    JULIA_FOR_POINTS result[i] = Real(0.5) * logarithm(norm[i]);
    JULIA_FOR_POINTS unusual |= norm[i] >= kLeast && norm[i] <= kMost ? 0 : 1;  // a NaN is unusual too
    store(result, l, range);
  }
  return unusual != 0;
}

template <class Real>
void normalise(Batch<Real> batch, std::size_t size) {
  alignas(64) Row<Real> q[4];
  for (std::size_t begin = 0; begin < size; begin += kBlock) {
    const Range range = blockAt(begin, size);
    const std::size_t padded = range.padded;
    for (int k = 0; k < 4; ++k) load<Real>(batch.component[k], q[k], range);
    JULIA_FOR_POINTS {
      const Real by = 1 / squareRoot(q[0][i] * q[0][i] + imaginarySquare(q[1][i], q[2][i], q[3][i]));
      q[0][i] *= by;
      q[1][i] *= by;
      q[2][i] *= by;
      q[3][i] *= by;
    }
    for (int k = 0; k < 4; ++k) store(q[k], batch.component[k], range);
  }
}

/// Positions of a block of points on the brick lattice, clamped to it.
template <class Real>
JULIA_INLINE void latticePositions(const BrickLattice<Real>& lattice, const Row<Real> (&point)[3],
                                   Row<Real> (&position)[3], std::size_t padded) {
  for (int row = 0; row < 3; ++row) {
    const Real mx = lattice.matrix[row][0], my = lattice.matrix[row][1], mz = lattice.matrix[row][2];
    const Real offset = lattice.offset[row], low = lattice.low[row], high = lattice.high[row];
    JULIA_FOR_POINTS
    position[row][i] = latticePosition(mx, my, mz, offset, low, high, point[0][i], point[1][i], point[2][i]);
  }
}

/// Finds the brick of the table in which a cell lies, and its position in the brick.
template <class Real, std::uint32_t kSide>
JULIA_INLINE void findCells(const BrickLattice<Real>& lattice, const Row<std::int32_t> (&cell)[3],
                            Row<std::int32_t>& brick, Row<std::int32_t>& offset, std::size_t padded) {
  const std::int32_t ny = static_cast<std::int32_t>(lattice.bricks[1]);
  const std::int32_t nz = static_cast<std::int32_t>(lattice.bricks[2]);
  constexpr std::int32_t side = kSide;
  JULIA_FOR_POINTS {
    const std::int32_t x = cell[0][i], y = cell[1][i], z = cell[2][i];
    brick[i] = ((x >> 3) * ny + (y >> 3)) * nz + (z >> 3);
    offset[i] = ((x & 7) * side + (y & 7)) * side + (z & 7);
  }
}

/// Whether kWidest points from @a first on read the same cell.
JULIA_INLINE bool isOneCell(const Row<std::int32_t>& brick, const Row<std::int32_t>& offset, std::size_t first) {
  std::int32_t differing = 0;
  for (std::size_t i = first; i < first + kWidest; ++i)
    differing |= (brick[i] ^ brick[first]) | (offset[i] ^ offset[first]);
  return differing == 0;
}

/// Nodes along the edge of a brick that is read trilinearly.
constexpr std::uint32_t kTrilinearSide = 9;

/// How a block reads bricks trilinearly: the first corner of the cell of each point, the place in the cell, and whether
/// the kWidest points of a group share it.
template <class Real>
struct TrilinearReads {
  alignas(64) Row<Real> position[3];
  const float* at[kBlock];
  bool isShared[kBlock / kWidest];
};

/// @tparam kFields  the values of a node, which lie side by side
template <std::size_t kFields, class Real>
JULIA_INLINE void findReads(const BrickLattice<Real>& lattice, const Real* const (&from)[3], const Range& range,
                            TrilinearReads<Real>& reads) {
  constexpr std::uint32_t kSide = kTrilinearSide;
  constexpr std::size_t kRow = kSide * kFields, kFace = kSide * kRow, kBrick = kSide * kFace;
  alignas(64) Row<Real> point[3];
  alignas(64) Row<std::int32_t> cell[3], brick, offset;
  const std::size_t padded = range.padded;
  for (int axis = 0; axis < 3; ++axis) load(from[axis], point[axis], range);
  latticePositions(lattice, point, reads.position, padded);
  for (int axis = 0; axis < 3; ++axis) JULIA_FOR_POINTS {
      const std::int32_t floor = static_cast<std::int32_t>(reads.position[axis][i]);
      cell[axis][i] = floor;
      reads.position[axis][i] -= static_cast<Real>(floor);
    }
  findCells<Real, kSide>(lattice, cell, brick, offset, padded);
  // Addresses are computed in advance: points of a block may lie far apart, and a read waits for memory. Where the
  // voxels are much finer than the lattice, most groups read one cell.
  for (std::size_t first = 0; first < padded; first += kWidest) {
    const bool isOne = reads.isShared[first / kWidest] = isOneCell(brick, offset, first);
    for (std::size_t i = first; i < first + (isOne ? 1 : kWidest); ++i) {
      const float* const at = reads.at[i] = lattice.values + std::size_t{lattice.brickAt[brick[i]]} * kBrick +
                                            static_cast<std::size_t>(offset[i]) * kFields;
      __builtin_prefetch(at);
      __builtin_prefetch(at + kFace + kRow);
      if (kFields > 1) {
        __builtin_prefetch(at + kRow);
        __builtin_prefetch(at + kFace);
      }
    }
  }
}

template <class Real>
void sampleTrilinear(const BrickLattice<Real>& lattice, const Real* x, const Real* y, const Real* z, Real* out,
                     std::size_t size) {
  constexpr std::size_t kSide = kTrilinearSide;
  alignas(64) Row<Real> result;
  TrilinearReads<Real> reads;
  const auto& [position, at, isShared] = reads;
  const Real* const from[3] = {x, y, z};
  // The two values along z that one read takes, and where the four reads begin.
  constexpr std::size_t kReads = 4, kBegins[kReads] = {0, kSide, kSide * kSide, kSide * kSide + kSide};
  for (std::size_t begin = 0; begin < size; begin += kBlock) {
    const Range range = blockAt(begin, size);
    const std::size_t padded = range.padded;
    findReads<1>(lattice, from, range, reads);
    for (std::size_t first = 0; first < padded; first += kWidest) {
      if (isShared[first / kWidest]) {
        Real v[2 * kReads];
        for (std::size_t k = 0; k < 2 * kReads; ++k) v[k] = at[first][kBegins[k / 2] + k % 2];
        JULIA_INDEPENDENT for (std::size_t i = first; i < first + kWidest; ++i) result[i] =
            trilinear(v[0], v[1], v[2], v[3], v[4], v[5], v[6], v[7], position[0][i], position[1][i], position[2][i]);
        continue;
      }
      alignas(64) float edge[kReads][2 * kWidest];
      for (std::size_t i = 0; i < kWidest; ++i)
        for (std::size_t k = 0; k < kReads; ++k)
          __builtin_memcpy(&edge[k][2 * i], at[first + i] + kBegins[k], 2 * sizeof(float));
      JULIA_INDEPENDENT for (std::size_t i = 0; i < kWidest; ++i) {
        const Real v0 = edge[0][2 * i], v1 = edge[0][2 * i + 1], v2 = edge[1][2 * i], v3 = edge[1][2 * i + 1];
        const Real v4 = edge[2][2 * i], v5 = edge[2][2 * i + 1], v6 = edge[3][2 * i], v7 = edge[3][2 * i + 1];
        result[first + i] = trilinear(v0, v1, v2, v3, v4, v5, v6, v7, position[0][first + i], position[1][first + i],
                                      position[2][first + i]);
      }
    }
    const Real knee = lattice.knee, more = lattice.more;
    JULIA_FOR_POINTS result[i] = bent(result[i], knee, more);
    store(result, out, range);
  }
}

/// Several fields, whose values of a node lie side by side, share positions, addresses and the lines of the cache.
template <class Real>
void sampleJoined(const BrickLattice<Real>& lattice, const Real* x, const Real* y, const Real* z, Real* const* out,
                  std::size_t size) {
  constexpr std::size_t kFields = kJoinedFields, kRow = kTrilinearSide * kFields, kFace = kTrilinearSide * kRow;
  constexpr std::size_t kCorners = 8, kAt[kCorners] = {0,     kFields,         kRow,         kRow + kFields,
                                                       kFace, kFace + kFields, kFace + kRow, kFace + kRow + kFields};
  alignas(64) Row<Real> result[kFields];
  TrilinearReads<Real> reads;
  const auto& [position, at, isShared] = reads;
  const Real* const from[3] = {x, y, z};
  for (std::size_t begin = 0; begin < size; begin += kBlock) {
    const Range range = blockAt(begin, size);
    findReads<kFields>(lattice, from, range, reads);
    for (std::size_t first = 0; first < range.padded; first += kWidest) {
      if (isShared[first / kWidest]) {
        for (std::size_t k = 0; k < kFields; ++k) {
          Real v[kCorners];
          for (std::size_t corner = 0; corner < kCorners; ++corner) v[corner] = at[first][kAt[corner] + k];
          JULIA_INDEPENDENT for (std::size_t i = first; i < first + kWidest; ++i) result[k][i] =
              trilinear(v[0], v[1], v[2], v[3], v[4], v[5], v[6], v[7], position[0][i], position[1][i], position[2][i]);
        }
        continue;
      }
      // A vector is as wide as a power of two, so it reads the next node's values, too.
      alignas(64) Real values[kWidest][kJoinedWidth];
      for (std::size_t i = 0; i < kWidest; ++i) {
        const float* const v = at[first + i];
        const Real tx = position[0][first + i], ty = position[1][first + i], tz = position[2][first + i];
        JULIA_INDEPENDENT for (std::size_t k = 0; k < kJoinedWidth; ++k) values[i][k] =
            trilinear<Real>(v[kAt[0] + k], v[kAt[1] + k], v[kAt[2] + k], v[kAt[3] + k], v[kAt[4] + k], v[kAt[5] + k],
                            v[kAt[6] + k], v[kAt[7] + k], tx, ty, tz);
      }
      for (std::size_t k = 0; k < kFields; ++k)
        JULIA_INDEPENDENT for (std::size_t i = 0; i < kWidest; ++i) result[k][first + i] = values[i][k];
    }
    const Real knee = lattice.knee, more = lattice.more;
    const std::size_t padded = range.padded;
    for (std::size_t k = 0; k < kFields; ++k) {
      JULIA_FOR_POINTS result[k][i] = bent(result[k][i], knee, more);
      store(result[k], out[k], range);
    }
  }
}

template <class Real>
void sampleQuadratic(const BrickLattice<Real>& lattice, const Real* x, const Real* y, const Real* z, Real* out,
                     std::size_t size) {
  constexpr std::uint32_t kSide = 10;
  alignas(64) Row<Real> point[3], position[3], weight[3][3], result;
  alignas(64) Row<std::int32_t> cell[3], brick, offset;
  const Real* const from[3] = {x, y, z};
  for (std::size_t begin = 0; begin < size; begin += kBlock) {
    const Range range = blockAt(begin, size);
    const std::size_t padded = range.padded;
    for (int axis = 0; axis < 3; ++axis) load(from[axis], point[axis], range);
    latticePositions(lattice, point, position, padded);
    // The nearest node and its two neighbours, weighted by the quadratic B-spline.
    for (int axis = 0; axis < 3; ++axis) JULIA_FOR_POINTS {
        const Real half = Real(0.5);
        const std::int32_t nearest = static_cast<std::int32_t>(position[axis][i] + half);
        const Real t = position[axis][i] - static_cast<Real>(nearest);
        cell[axis][i] = nearest;
        splineWeights(t, &weight[axis][0][i], &weight[axis][1][i], &weight[axis][2][i]);
      }
    findCells<Real, kSide>(lattice, cell, brick, offset, padded);
    for (std::size_t i = 0; i < range.size; ++i) {
      const float* value =
          lattice.values + std::size_t{lattice.brickAt[brick[i]]} * (kSide * kSide * kSide) + offset[i];
      Real sum = 0;
      for (std::size_t dx = 0; dx < 3; ++dx) {
        Real face = 0;
        for (std::size_t dy = 0; dy < 3; ++dy, value += kSide) {
          const Real edge =
              weightedSum<Real>(value[0], value[1], value[2], weight[2][0][i], weight[2][1][i], weight[2][2][i]);
          face += edge * weight[1][dy][i];
        }
        sum += face * weight[0][dx][i];
        value += kSide * kSide - 3 * kSide;
      }
      result[i] = bent(sum, lattice.knee, lattice.more);
    }
    store(result, out, range);
  }
}

template <class Real>
constexpr Kernels<Real> kTable = {
    .versor = versor<Real>,
    .logModulus = logModulus<Real>,
    .logLeastPart = logLeastPart<Real>,
    .compact = compact<Real>,
    .scaleByExponential = scaleByExponential<Real>,
    .logNorm = logNorm<Real>,
    .normalise = normalise<Real>,
    .quadratic = quadratic<Real>,
    .cross = {cross<Real, PairA<1>>, cross<Real, PairA<-1>>, cross<Real, PairB>, cross<Real, PairC>, cross<Real, PairD>,
              cross<Real, PairE>},
    .crossSecond = {crossSecond<Real, PairA<1>>, crossSecond<Real, PairA<-1>>, crossSecond<Real, PairB>,
                    crossSecond<Real, PairC>, crossSecond<Real, PairD>, crossSecond<Real, PairE>},
    .crossProduct = crossProduct<Real>,
    .triplex = triplex<Real>,
    .waveVersor = waveVersor<Real>,
    .grainVersor = grainVersor<Real>,
    .waveDiscs = waveDiscs,
    .sampleTrilinear = sampleTrilinear<Real>,
    .sampleJoined = sampleJoined<Real>,
    .sampleQuadratic = sampleQuadratic<Real>,
    .logDistances = logDistances<Real>,
    .logSlopes = logSlopes<Real>,
    .addColumns = addColumns<Real>,
    .dotColumns = dotColumns<Real>,
    .tileProduct = tileProduct<Real>,
};

}  // namespace
}  // namespace julia::kernels
