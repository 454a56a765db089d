// SPDX-License-Identifier: Apache-2.0
// Versors that are made of others, moved, symmetric or mixed, as text of C++ and OpenCL C (kernels/language.h).
// versor_arithmetic.h includes it.

/// A component of (q - t) / s.
JULIA_SHARED Real movedBack(Real x, Real translate, Real scale) { return (x - translate) / scale; }

/// A coordinate, reflected to the upper side of a plane.
JULIA_SHARED Real mirroredUp(Real x, Real middle) { return middle + magnitude(x - middle); }

/// Turns a vector of a plane.
JULIA_SHARED void turnBy(Real cosine, Real sine, Real* x, Real* y) {
  const Real X = *x, Y = *y;
  *x = X * cosine + Y * sine;
  *y = Y * cosine - X * sine;
}

/// How far a vector of a plane reaches along a direction.
JULIA_SHARED Real reachAlong(Real cosine, Real sine, Real x, Real y) { return x * cosine + y * sine; }

/// A component of a mixture.
JULIA_SHARED Real mixedPart(Real under, Real over, Real mix) { return under * (1 - mix) + over * mix; }

/// q / |q|, even if the square of |q| is outside the range of Real; 1 if q is 0 or not finite.
JULIA_SHARED void makeDirection(Real a, Real b, Real c, Real d, Real* ua, Real* ub, Real* uc, Real* ud) {
  const Real A = magnitude(a), B = magnitude(b), C = magnitude(c), D = magnitude(d);
  const bool isFinite = A < JULIA_INFINITY && B < JULIA_INFINITY && C < JULIA_INFINITY && D < JULIA_INFINITY;
  const Real ab = A > B ? A : B, cd = C > D ? C : D, most = ab > cd ? ab : cd;
  *ua = 1;
  *ub = *uc = *ud = 0;
  if (!isFinite || !(most > 0)) return;
  const Real sa = a / most, sb = b / most, sc = c / most, sd = d / most;
  const Real length = squareRoot(sa * sa + sb * sb + sc * sc + sd * sd);
  *ua = sa / length;
  *ub = sb / length;
  *uc = sc / length;
  *ud = sd / length;
}
