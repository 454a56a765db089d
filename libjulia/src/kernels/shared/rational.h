// SPDX-License-Identifier: Apache-2.0
// The factors (q - t)^p of a rational as text of C++ and OpenCL C (kernels/language.h). kernels/blocks.h includes it. A
// factor is real + imaginary v, where v is the imaginary part of q - t.

/// The squared length of the imaginary part.
JULIA_SHARED Real imaginarySquare(Real b, Real c, Real d) { return b * b + c * c + d * d; }

/// The squared length, summed in the order of the components.
JULIA_SHARED Real sumOfSquares(Real a, Real b, Real c, Real d) { return a * a + b * b + c * c + d * d; }

/// The square of a factor in the plane of 1 and v: (R + S v)^2 = R^2 - S^2 s + 2 R S v with s = |v|^2.
JULIA_SHARED void squareFactor(Real s, Real* real, Real* imaginary) {
  const Real R = *real, S = *imaginary;
  *real = R * R - S * S * s;
  *imaginary = 2 * (R * S);
}

/// The square of a factor times a + v.
JULIA_SHARED void squareAndMultiplyFactor(Real a, Real s, Real* real, Real* imaginary) {
  const Real R = *real, S = *imaginary;
  const Real squareR = R * R - S * S * s, squareS = 2 * (R * S);
  *real = squareR * a - squareS * s;
  *imaginary = squareR + squareS * a;
}

/// u = u f.
JULIA_SHARED void multiplyQuaternion(Real fa, Real fb, Real fc, Real fd, Real* a, Real* b, Real* c, Real* d) {
  const Real ua = *a, ub = *b, uc = *c, ud = *d;
  *a = ua * fa - ub * fb - uc * fc - ud * fd;
  *b = ua * fb + ub * fa + uc * fd - ud * fc;
  *c = ua * fc - ub * fd + uc * fa + ud * fb;
  *d = ua * fd + ub * fc - uc * fb + ud * fa;
}
