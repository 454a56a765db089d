// SPDX-License-Identifier: Apache-2.0
// Reading a lattice of bricks (julia/brick_field.h) as text of C++ and OpenCL C (kernels/language.h).
// kernels/blocks.h includes it.

/// A point's position along one axis of the lattice, clamped to it.
JULIA_SHARED Real latticePosition(Real mx, Real my, Real mz, Real offset, Real low, Real high, Real x, Real y, Real z) {
  const Real at = mx * x + my * y + mz * z + offset;
  const Real above = at > low ? at : low;  // this handles a NaN, too
  return above < high ? above : high;
}

/// @param v  the corners' values, z running fastest
JULIA_SHARED Real trilinear(Real v0, Real v1, Real v2, Real v3, Real v4, Real v5, Real v6, Real v7, Real tx, Real ty,
                            Real tz) {
  const Real e0 = v0 + (v1 - v0) * tz, e1 = v2 + (v3 - v2) * tz;
  const Real e2 = v4 + (v5 - v4) * tz, e3 = v6 + (v7 - v6) * tz;
  const Real f0 = e0 + (e1 - e0) * ty, f1 = e2 + (e3 - e2) * ty;
  return f0 + (f1 - f0) * tx;
}

/// What is read, bent below a knee (julia/bricks.h). It grows with v, and does so after rounding, too.
JULIA_SHARED Real bent(Real v, Real knee, Real more) {
  const Real below = v - knee;
  return v + more * (below < 0 ? below : JULIA_REAL(0));
}

/// The weights of the nearest node and its two neighbours by the quadratic B-spline. @param t  from -1/2 to 1/2
JULIA_SHARED void splineWeights(Real t, Real* before, Real* at, Real* after) {
  const Real oneHalf = JULIA_REAL(0.5);
  *before = oneHalf * ((oneHalf - t) * (oneHalf - t));
  *at = JULIA_REAL(0.75) - t * t;
  *after = oneHalf * ((oneHalf + t) * (oneHalf + t));
}

JULIA_SHARED Real weightedSum(Real v0, Real v1, Real v2, Real w0, Real w1, Real w2) {
  return v0 * w0 + v1 * w1 + v2 * w2;
}
