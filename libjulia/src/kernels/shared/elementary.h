// SPDX-License-Identifier: Apache-2.0
// Elementary functions as text of C++ and OpenCL C (kernels/language.h). kernels/elementary.h includes it.

JULIA_SHARED Real magnitude(Real x) { return JULIA_FROM_BITS(JULIA_TO_BITS(x) & JULIA_IEEE(kMagnitude)); }

/// 1 / sqrt(x) within 3.5 per cent, for normal x > 0.
JULIA_SHARED Real guessedInverseRoot(Real x) {
  return JULIA_FROM_BITS(JULIA_IEEE(kRootGuess) - (JULIA_TO_BITS(x) >> 1));
}

/// ln x for normal x > 0.
JULIA_SHARED Real logarithm(Real x) {
  // x = 2^e m with m from sqrt(1/2) to sqrt(2); the bias keeps the shifted number positive.
  const JULIA_BITS kBias = (JULIA_BITS)1 << (sizeof(Real) * 8 - 2);
  const JULIA_BITS shifted = (JULIA_TO_BITS(x) - JULIA_IEEE(kSqrtHalf) + kBias) >> JULIA_IEEE(kMantissaBits);
  const JULIA_BITS e = shifted - (kBias >> JULIA_IEEE(kMantissaBits));
  const Real m = JULIA_FROM_BITS(JULIA_TO_BITS(x) - (e << JULIA_IEEE(kMantissaBits)));
  // The integer is converted to floating point through the low bits of a large number; AVX2 has no other way for 64
  // bits.
  const Real exponent = JULIA_FROM_BITS(JULIA_TO_BITS(JULIA_IEEE(kRounder)) + e) - JULIA_IEEE(kRounder);
  const Real f = m - 1;
  const Real s = f / (f + 2);
  const Real z = s * s;
  // ln m = 2 artanh s, written so that its leading part f is exact.
  const Real rest = exponent * JULIA_IEEE(kLn2Low) + s * (z * JULIA_POLYNOMIAL(kLog, z) - f);
  return exponent * JULIA_IEEE(kLn2High) + (f + rest);
}

/// e^x for x up to 88; 0 where it would be denormal.
JULIA_SHARED Real exponential(Real x) {
  const Real clamped = x > JULIA_IEEE(kLeastExponent) ? x : JULIA_IEEE(kLeastExponent);
  const Real rounded = clamped * JULIA_IEEE(kLog2E) + JULIA_IEEE(kRounder);
  const Real n = rounded - JULIA_IEEE(kRounder);
  const Real r = (clamped - n * JULIA_IEEE(kLn2High)) - n * JULIA_IEEE(kLn2Low);
  const Real value = 1 + (r + r * r * JULIA_POLYNOMIAL(kExp, r));
  const Real scaled = JULIA_FROM_BITS(JULIA_TO_BITS(value) + (JULIA_TO_BITS(rounded) << JULIA_IEEE(kMantissaBits)));
  return x > JULIA_IEEE(kLeastExponent) ? scaled : JULIA_REAL(0);
}

/// The angle of a + i y, y > 0, in quadrants: 0 on the positive real axis, 2 on the negative.
/// @param inverseY  1 / y, a by-product
JULIA_SHARED Real angleInQuadrants(Real a, Real y, Real* inverseY) {
  const Real x = magnitude(a);
  const Real larger = x > y ? x : y, smaller = x > y ? y : x;
  const Real inverse = 1 / (y * larger);
  *inverseY = larger * inverse;
  const Real t = smaller * (y * inverse);
  const Real steep = t * JULIA_POLYNOMIAL(kAtan, t * t);
  const Real acute = x > y ? steep : 1 - steep;
  return a < 0 ? 2 - acute : acute;
}

/// Sine and cosine of an angle in quadrants, for |angle| < 2^22 in floats and 2^51 in doubles.
JULIA_SHARED void sineCosine(Real quadrants, Real* sine, Real* cosine) {
  // Each half turn changes both signs.
  const Real rounded = quadrants * JULIA_REAL(0.5) + JULIA_IEEE(kRounder);
  const JULIA_BITS sign = JULIA_TO_BITS(rounded) << (sizeof(Real) * 8 - 1);
  const Real rest = quadrants - 2 * (rounded - JULIA_IEEE(kRounder));
  const Real z = rest * rest;
  *sine = JULIA_FROM_BITS(JULIA_TO_BITS(rest * JULIA_POLYNOMIAL(kSin, z)) ^ sign);
  *cosine = JULIA_FROM_BITS(JULIA_TO_BITS(1 + z * JULIA_POLYNOMIAL(kCos, z)) ^ sign);
}

/// Sine and cosine of x radians, |x| < 2^30.
JULIA_SHARED void sineCosineOfRadians(Real x, Real* sine, Real* cosine) {
  sineCosine(quadrantsOfRadians(x), sine, cosine);
}

JULIA_SHARED Real cosineOfRadians(Real x) {
  Real sine, cosine;
  sineCosineOfRadians(x, &sine, &cosine);
  return cosine;
}

/// The power of two that scales x >= 0 to between 1 and 2; for 0 and denormal numbers, the second largest power.
JULIA_SHARED Real scaleToOne(Real x) {
  return JULIA_FROM_BITS(JULIA_IEEE(kBiasTwice) - (JULIA_TO_BITS(x) & JULIA_IEEE(kExponentBits)));
}

/// Twice the angles of [ZB25] Eq. (1), phi about the z axis and theta above the xy plane, from the components alone;
/// x = y = 0 means phi = 0, and p = 0 means theta = 0 also.
/// @param angles  receives cos 2phi, sin 2phi, cos 2theta, sin 2theta
JULIA_SHARED void doubleAngles(Real x, Real y, Real z, Real* angles) {
  const Real flat = magnitude(x) > magnitude(y) ? magnitude(x) : magnitude(y);
  const Real largest = flat > magnitude(z) ? flat : magnitude(z);
  // Scaled, so that no square underflows.
  const Real s = scaleToOne(flat), X = x * s, Y = y * s, across = X * X + Y * Y;
  const Real t = scaleToOne(largest), U = x * t, V = y * t, W = z * t, level = U * U + V * V, r = level + W * W;
  angles[0] = across > 0 ? (X * X - Y * Y) / across : JULIA_REAL(1);
  angles[1] = across > 0 ? 2 * (X * Y) / across : JULIA_REAL(0);
  angles[2] = r > 0 ? (level - W * W) / r : JULIA_REAL(1);
  angles[3] = r > 0 ? 2 * (squareRoot(level) * W) / r : JULIA_REAL(0);
}
