// SPDX-License-Identifier: Apache-2.0
/// @file fit_bodies.h
/// The kernels of fits, a part of kernel_bodies.h with the same restrictions.
#pragma once

#include "blocks.h"
#include "elementary.h"
#include "kernels.h"
#include "loop_pragmas.h"

namespace julia::kernels {
namespace {

template <class Real>
void logDistances(const Real* root, Real rest, const Real* x, const Real* y, const Real* z, Real* out,
                  std::size_t size) {
  const Real rx = root[0], ry = root[1], rz = root[2];
  JULIA_INDEPENDENT
  for (std::size_t i = 0; i < size; ++i) {
    const Real dx = x[i] - rx, dy = y[i] - ry, dz = z[i] - rz;
    const Real square = dx * dx + dy * dy + dz * dz + rest;
    out[i] = Real(0.5) * logarithm(square > Ieee<Real>::kTiny ? square : Ieee<Real>::kTiny);
  }
}

template <class Real>
void logSlopes(const Real* root, const Real* x, const Real* y, const Real* z, Real* columns, std::size_t size) {
  const Real rx = root[0], ry = root[1], rz = root[2], rest = root[3];
  Real *byX = columns, *byY = byX + size, *byZ = byY + size, *byRest = byZ + size;
  JULIA_INDEPENDENT
  for (std::size_t i = 0; i < size; ++i) {
    const Real dx = rx - x[i], dy = ry - y[i], dz = rz - z[i];
    const Real square = dx * dx + dy * dy + dz * dz + rest * rest;
    const Real over = Real(1) / (square > Ieee<Real>::kTiny ? square : Ieee<Real>::kTiny);
    byX[i] = dx * over;
    byY[i] = dy * over;
    byZ[i] = dz * over;
    byRest[i] = rest * over;
  }
}

// Columns processed at once, so that the sums are loaded and stored less often.
constexpr std::size_t kColumns = 4;

template <class Real>
void addColumns(const Real* columns, const double* weights, std::size_t columnCount, double* sums, std::size_t size) {
  size = size / kWidest * kWidest;
  std::size_t j = 0;
  for (; j + kColumns <= columnCount; j += kColumns) {
    const Real *a = columns + j * size, *b = a + size, *c = b + size, *d = c + size;
    const double wa = weights[j], wb = weights[j + 1], wc = weights[j + 2], wd = weights[j + 3];
    JULIA_INDEPENDENT
    for (std::size_t i = 0; i < size; ++i) sums[i] = sums[i] + wa * a[i] + wb * b[i] + wc * c[i] + wd * d[i];
  }
  for (; j < columnCount; ++j) {
    const Real* a = columns + j * size;
    const double w = weights[j];
    JULIA_INDEPENDENT
    for (std::size_t i = 0; i < size; ++i) sums[i] += w * a[i];
  }
}

// Bytes per register of the instruction set, and number of registers.
#if defined(__AVX512F__)
constexpr std::size_t kRegister = 64, kRegisters = 32;
#elif defined(__AVX2__)
constexpr std::size_t kRegister = 32, kRegisters = 16;
#else
constexpr std::size_t kRegister = 16, kRegisters = 16;
#endif

/// Computes the products of kCount columns. Each has eight sums, whatever the vector width, which stay in registers.
template <std::size_t kCount, class Real>
JULIA_INLINE void dotSome(const Real* columns, const double* factors, double* products, std::size_t size) {
  constexpr std::size_t kLanes = 8, kWidth = kRegister / sizeof(double), kParts = kLanes / kWidth;
  typedef double Vector __attribute__((vector_size(kRegister)));
  typedef double LoadedFactors __attribute__((vector_size(kRegister), aligned(alignof(double)), may_alias));
  typedef Real LoadedReals __attribute__((vector_size(kWidth * sizeof(Real)), aligned(alignof(Real)), may_alias));
  Vector sums[kCount][kParts] = {};
  for (std::size_t i = 0; i < size; i += kLanes) {
    JULIA_UNROLLED_4
    for (std::size_t part = 0; part < kParts; ++part) {
      const std::size_t at = i + part * kWidth;
      const Vector factor = *reinterpret_cast<const LoadedFactors*>(factors + at);
      JULIA_UNROLLED_4
      for (std::size_t j = 0; j < kCount; ++j)
        sums[j][part] +=
            __builtin_convertvector(*reinterpret_cast<const LoadedReals*>(columns + j * size + at), Vector) * factor;
    }
  }
  for (std::size_t j = 0; j < kCount; ++j) {
    double sum = 0;
    for (std::size_t lane = 0; lane < kLanes; ++lane) sum += sums[j][lane / kWidth][lane % kWidth];
    products[j] = sum;
  }
}

template <class Real>
void dotColumns(const Real* columns, const double* factors, std::size_t columnCount, double* products,
                std::size_t size) {
  size = size / kWidest * kWidest;
  std::size_t j = 0;
  for (; j + kColumns <= columnCount; j += kColumns) dotSome<kColumns>(columns + j * size, factors, products + j, size);
  for (; j < columnCount; ++j) dotSome<1>(columns + j * size, factors, products + j, size);
}

/// Computes the part of a tile's product whose sums fill half of the registers and stay there.
template <class Real>
JULIA_INLINE void patchProduct(const Real* a, const Real* b, std::size_t depth, Real* out) {
  typedef Real Vector __attribute__((vector_size(kRegister)));
  typedef Real Loaded __attribute__((vector_size(kRegister), aligned(alignof(Real)), may_alias));
  constexpr std::size_t kLanes = kRegister / sizeof(Real);
  Vector sums[4][kRegisters / 8] = {};
  for (std::size_t k = 0; k < depth; ++k, a += kTile, b += kTile) {
    JULIA_UNROLLED_4
    for (std::size_t i = 0; i < 4; ++i) {
      JULIA_UNROLLED_4
      for (std::size_t j = 0; j < kRegisters / 8; ++j)
        sums[i][j] += a[i] * *reinterpret_cast<const Loaded*>(b + j * kLanes);
    }
  }
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = 0; j < kRegisters / 8; ++j)
      *reinterpret_cast<Loaded*>(out + i * kTile + j * kLanes) = sums[i][j];
}

template <class Real>
void tileProduct(const Real* a, const Real* b, std::size_t depth, Real* out) {
  constexpr std::size_t kWidth = kRegister / sizeof(Real) * (kRegisters / 8);
  for (std::size_t j = 0; j < kTile; j += kWidth)
    for (std::size_t i = 0; i < kTile; i += 4) patchProduct(a + i, b + j, depth, out + i * kTile + j);
}

}  // namespace
}  // namespace julia::kernels
