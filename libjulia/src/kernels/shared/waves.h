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

/// The angle of a cosine and a sine in quadrants, from -2 to 2. @param certain  how much it counts, from 0 to 1
JULIA_SHARED Real certainPhase(Real cosine, Real sine, Real* certain) {
  // Small enough to be no angle, and large enough that no square underflows.
  const Real least = JULIA_REAL(0x1p-40), size = magnitude(sine);
  Real inverse;
  const Real angle = angleInQuadrants(cosine, size > least ? size : least, &inverse);
  const Real twice = 2 * (cosine * cosine + sine * sine), t = twice < 1 ? twice : JULIA_REAL(1);
  *certain = t * t * (3 - 2 * t);
  return sine < 0 ? -angle : angle;
}

/// The phase of a wave that follows a grain, in quadrants.
JULIA_SHARED Real grainPhase(Real m, Real n, Real w, Real along, Real across, Real depth) {
  return m * along + n * across + w * depth;
}

/// A component of a versor that fades into another one.
JULIA_SHARED Real fadedPart(Real part, Real other, Real certain) { return other + certain * (part - other); }
