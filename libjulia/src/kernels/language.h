// SPDX-License-Identifier: Apache-2.0
/// @file language.h
/// The words of the shared text (kernels/shared), as C++ has them. That text is compiled as C++ for the processor's
/// kernels and as OpenCL C for devices (device/program_text.cpp defines the same words there), so a point is computed
/// by the same operations in the same order on both.
///
/// In C++ a shared function is a template over Real, in OpenCL C a function for the one Real of the program. Results
/// beyond one number are written through pointers.
#pragma once

/// Begins the definition of a shared function.
#define JULIA_SHARED    \
  template <class Real> \
  JULIA_INLINE
/// Begins the definition of a shared function whose numbers are doubles whatever Real is.
#define JULIA_SHARED_IN_DOUBLES JULIA_INLINE
/// A constant of Ieee<Real>.
#define JULIA_IEEE(name) Ieee<Real>::name
/// The polynomial whose coefficients are a constant of Ieee<Real>.
#define JULIA_POLYNOMIAL(name, x) polynomial(Ieee<Real>::name, x)
/// A number in the type Real.
#define JULIA_REAL(x) Real(x)
#define JULIA_INFINITY Real(__builtin_inff())
/// The unsigned integers of Real's size, and the bits of a number as one of them and back.
#define JULIA_BITS Unsigned<Real>
#define JULIA_TO_BITS(x) bitsOf(x)
#define JULIA_FROM_BITS(bits) fromBits<Real>(bits)
