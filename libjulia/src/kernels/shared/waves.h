// SPDX-License-Identifier: Apache-2.0
// Versors of waves (julia/wave_versor.h) as text of C++ and OpenCL C (kernels/language.h). kernels/blocks.h includes
// it.

/// Splits an octave: the weight of the finer of the two octaves that are blended, and 2^k of the coarser.
JULIA_SHARED void splitOctave(Real octave, Real* weight, Real* scale) {
  const Real nearest = (octave + JULIA_IEEE(kRounder)) - JULIA_IEEE(kRounder);
  const Real k = nearest > octave ? nearest - 1 : nearest;
  const Real f = octave - k;
  *weight = f * f * (3 - 2 * f);
  *scale = JULIA_FROM_BITS(JULIA_TO_BITS(JULIA_REAL(4)) +
                           (JULIA_TO_BITS(k + JULIA_IEEE(kRounder)) << JULIA_IEEE(kMantissaBits)));
}

/// The phase of a wave at q, in quadrants.
JULIA_SHARED Real wavePhase(Real wa, Real wb, Real wc, Real wd, Real a, Real b, Real c, Real d) {
  return wa * a + wb * b + wc * c + wd * d;
}

/// Sine and cosine of twice an angle.
JULIA_SHARED void doublePhase(Real sine, Real cosine, Real* sineFine, Real* cosineFine) {
  *sineFine = 2 * (sine * cosine);
  *cosineFine = 1 - 2 * (sine * sine);
}

/// q / |q|; 1 if |q| is too small to have a direction.
JULIA_SHARED void makeUnit(Real a, Real b, Real c, Real d, Real* ua, Real* ub, Real* uc, Real* ud) {
  const Real square = a * a + b * b + c * c + d * d;
  const bool has = square >= JULIA_IEEE(kTiny);
  const Real by = has ? 1 / squareRoot(has ? square : JULIA_REAL(1)) : JULIA_REAL(0);
  *ua = has ? a * by : JULIA_REAL(1);
  *ub = b * by;
  *uc = c * by;
  *ud = d * by;
}
