// SPDX-License-Identifier: Apache-2.0
/// @file elementary.h
/// Elementary functions that use only additions, multiplications, divisions, square roots and integer operations. IEEE
/// 754 fixes the result of each, so every instruction set and vector width gives the same bits. The code has no
/// branches, so compilers vectorise it inside a loop. Errors are a few ulp.
///
/// The polynomials are Chebyshev fits, with 40 digits, to the functions named beside them. The functions themselves are
/// shared text (shared/elementary.h), which devices compile as well.
///
/// Included by sources that are compiled for different instruction sets: everything has internal linkage.
#pragma once

#include "language.h"
#include "loop_pragmas.h"

#include <bit>
#include <cstddef>
#include <cstdint>

namespace julia::kernels {

#define JULIA_INLINE [[gnu::always_inline]] static inline

/// Constants that differ between the two widths.
template <class Real>
struct Ieee;

template <>
struct Ieee<float> {
  using Int = std::int32_t;
  using Unsigned = std::uint32_t;
  static constexpr int kMantissaBits = 23;
  static constexpr float kEpsilon = 0x1p-23f;
  static constexpr Unsigned kMagnitude = 0x7fffffff;     ///< all but the sign
  static constexpr float kRounder = 0x1.8p23f;           ///< x + this - this = x to the nearest integer, |x| < 2^22
  static constexpr Unsigned kExponentBits = 0x7f800000;  ///< the bits of the exponent
  static constexpr Unsigned kBiasTwice = 0x7f000000;     ///< the bits of 2^k and of its inverse add up to this
  static constexpr Unsigned kSqrtHalf = 0x3f3504f3;      ///< bits of sqrt(1/2)
  static constexpr float kLog2E = float(1.4426950408889634074);
  /// ln 2 in two parts; the product of the first with any exponent is exact.
  static constexpr float kLn2High = 0x1.62ep-1f, kLn2Low = 0x1.0bfbe8p-15f;
  static constexpr float kLeastExponent = -87;  ///< e^x is a normal number from this x on
  static constexpr float kMostExponent = 88;    ///< e^x is finite up to this x
  /// Bits of an initial guess of 1 / sqrt(x), before half the bits of x are subtracted; its error is 3.5 per cent.
  static constexpr Unsigned kRootGuess = 0x5f3759df;
  /// |q - t|^2 below this goes through the careful path: squares underflow.
  static constexpr float kTiny = 1e-30f;
  /// |q|^2 is reliable up to this.
  static constexpr float kHuge = 1e38f;
  /// Powers beyond this do not fit sineCosine() or drift in norm.
  static constexpr float kLargestPower = 0x1p20f;

  static constexpr float kAtan[] = {1.7610707731959368e-3f,  -1.0014824235222271e-2f, 2.68256443374629e-2f,
                                    -4.7471812219091153e-2f, 6.759864697812169e-2f,   -9.0385987997914194e-2f,
                                    1.2727221020373234e-1f,  -2.1220470242186062e-1f, 6.366197607738795e-1f};
  static constexpr float kSin[] = {1.5167170366408959e-4f, -4.6741438381517776e-3f, 7.9689918329028496e-2f,
                                   -6.459637595835393e-1f, 1.5707963200386016f};
  static constexpr float kCos[] = {-2.4049913667215291e-5f, 9.1825925125935912e-4f, -2.0863124385951487e-2f,
                                   2.5366946341771486e-1f, -1.2337005492467463f};
  static constexpr float kLog[] = {2.9580985929974423e-1f, 3.9988757716604847e-1f, 6.6666685095429069e-1f};
  static constexpr float kExp[] = {1.3926213466332443e-3f, 8.3632029715758549e-3f, 4.1666554437685939e-2f,
                                   1.6666576845993976e-1f, 0.5f};
};

template <>
struct Ieee<double> {
  using Int = std::int64_t;
  using Unsigned = std::uint64_t;
  static constexpr int kMantissaBits = 52;
  static constexpr double kEpsilon = 0x1p-52;
  static constexpr Unsigned kMagnitude = 0x7fffffffffffffff;
  static constexpr double kRounder = 0x1.8p52;
  static constexpr Unsigned kExponentBits = 0x7ff0000000000000;
  static constexpr Unsigned kBiasTwice = 0x7fe0000000000000;
  static constexpr Unsigned kSqrtHalf = 0x3fe6a09e667f3bcd;
  static constexpr double kLog2E = 1.4426950408889634074;
  static constexpr double kLn2High = 0x1.62e42fee00000p-1, kLn2Low = 0x1.a39ef35793c76p-33;
  static constexpr double kLeastExponent = -708;
  static constexpr double kMostExponent = 709;
  static constexpr Unsigned kRootGuess = 0x5fe6eb50c7b537a9;
  static constexpr double kTiny = 1e-280;
  static constexpr double kHuge = 1e307;
  static constexpr double kLargestPower = 0x1p40;

  static constexpr double kAtan[] = {
      -1.231372092164173e-5,  1.3638821515656189e-4, -7.1635921922447444e-4, 2.3880489277811624e-3,
      -5.7238996484056917e-3, 1.0644025440027983e-2, -1.6277491364232295e-2, 2.15631183045346e-2,
      -2.5981247095510743e-2, 2.9722155732148845e-2, -3.3342473384855847e-2, 3.7413049764882895e-2,
      -4.2435577400991022e-2, 4.8970059747680367e-2, -5.7874465569745159e-2, 7.0735526869187109e-2,
      -9.0945681647192066e-2, 1.2732395447127511e-1, -2.1220659078917703e-1, 6.3661977236758132e-1};
  static constexpr double kSin[] = {5.8729757447999501e-12, -6.6844168318560843e-10, 5.6921364280986252e-8,
                                    -3.5988430204672575e-6, 1.6044118471309159e-4,   -4.6817541353042553e-3,
                                    7.969262624616564e-2,   -6.459640975062462e-1,   1.5707963267948966};
  static constexpr double kCos[] = {6.3574210551863837e-11, -6.3832314259805815e-9, 4.7108463195309231e-7,
                                    -2.5202041040893936e-5, 9.19260274500616e-4,    -2.0863480763310631e-2,
                                    2.53669507901046e-1,    -1.2337005501361698};
  static constexpr double kLog[] = {1.4617807153417325e-1, 1.5331611722055008e-1, 1.8182892432536871e-1,
                                    2.2222211089379496e-1, 2.8571428626253838e-1, 3.9999999999898891e-1,
                                    6.6666666666666697e-1};
  static constexpr double kExp[] = {
      2.5100424157005067e-8, 2.7620138719733996e-7, 2.7557268378684193e-6, 2.4801521190217728e-5, 1.9841269863105969e-4,
      1.3888888917281793e-3, 8.3333333333300513e-3, 4.1666666666623992e-2, 1.6666666666666667e-1, 0.5};
};

template <class Real>
using Unsigned = typename Ieee<Real>::Unsigned;

template <class Real>
JULIA_INLINE Unsigned<Real> bitsOf(Real x) {
  return std::bit_cast<Unsigned<Real>>(x);
}
template <class Real>
JULIA_INLINE Real fromBits(Unsigned<Real> bits) {
  return std::bit_cast<Real>(bits);
}

JULIA_INLINE float squareRoot(float x) { return __builtin_sqrtf(x); }
JULIA_INLINE double squareRoot(double x) { return __builtin_sqrt(x); }

/// Horner's rule, the highest coefficient first.
template <class Real, std::size_t N>
JULIA_INLINE Real polynomial(const Real (&coefficients)[N], Real x) {
  Real sum = coefficients[0];
  JULIA_UNROLLED_32
  for (std::size_t i = 1; i < N; ++i) sum = sum * x + coefficients[i];
  return sum;
}

/// The angle of x radians, |x| < 2^30, in quadrants between -2 and 2, with an absolute error of a few epsilon of the
/// number's type, however large x is. Whole turns are subtracted in double, where the products of their number with the
/// first two parts of 2 pi are exact.
JULIA_INLINE double quadrantsOfRadians(double x){
#include "shared/quadrants_of_doubles.h"
} JULIA_INLINE float quadrantsOfRadians(float x) {
#include "shared/quadrants_of_floats.h"
}

#include "shared/elementary.h"

}  // namespace julia::kernels
