// SPDX-License-Identifier: Apache-2.0
/// @file wave_discs.h
/// Versors of waves over balls, by their derivatives. See kernel_bodies.h for the restrictions on this code.
///
/// A quaternion over a ball is written as value + J x + e, where x is the place from the centre, the columns of J are
/// its derivatives by the components of the place, and |e| <= rest.
#pragma once

#include "blocks.h"

namespace julia::kernels {
namespace {

/// One number for each component of the place. A vector type, because compilers leave plain loops over four numbers
/// scalar here.
using Place [[gnu::vector_size(4 * sizeof(double))]] = double;
/// The derivatives, component by component.
using Derivatives = Place[4];

/// Covers the roundings of doubles in the bounds.
constexpr double kDiscSlack = 1 + 1e-12;

struct LinearVersor {
  double value[4];
  Derivatives by;
  double rest;
  double change;  ///< upper bound of |J x + e|
};

JULIA_INLINE double sumOf(const Place& v) { return (v[0] + v[1]) + (v[2] + v[3]); }

JULIA_INLINE double dotOf(const double (&p)[4], const double (&q)[4]) {
  return p[0] * q[0] + p[1] * q[1] + p[2] * q[2] + p[3] * q[3];
}

/// The Frobenius norm, which is not below the largest singular value.
JULIA_INLINE double frobeniusNorm(const Derivatives& by) {
  return squareRoot(sumOf(by[0] * by[0] + by[1] * by[1] + by[2] * by[2] + by[3] * by[3])) * kDiscSlack;
}

/// The square root of the Frobenius norm of the Gram matrix: closer to the largest singular value.
JULIA_INLINE double gramNorm(const Derivatives& by) {
  Place sums = {};
  for (std::size_t row = 0; row < 4; ++row) {
    const Place gram = by[0][row] * by[0] + by[1][row] * by[1] + by[2][row] * by[2] + by[3][row] * by[3];
    sums += gram * gram;
  }
  return squareRoot(squareRoot(sumOf(sums))) * kDiscSlack;
}

/// Makes a versor of a quaternion. With s the largest change relative to |q|, the change loses its part along q, and
/// terms of higher order add up to less than 3/2 s^2 / (1 - s)^2: across q at most s^2 / (1 - s), and along it
/// s^2 / (2 (1 - s)^2). @return whether s is small enough to be useful
JULIA_INLINE bool makeVersor(LinearVersor& q, double radius) {
  const double length = squareRoot(dotOf(q.value, q.value)), inverse = 1 / length;
  const double relative = frobeniusNorm(q.by) * radius * inverse, s = relative + q.rest * inverse;
  if (!(s < 0.5)) return false;
  for (double& component : q.value) component *= inverse;
  const Place along = q.value[0] * q.by[0] + q.value[1] * q.by[1] + q.value[2] * q.by[2] + q.value[3] * q.by[3];
  for (std::size_t c = 0; c < 4; ++c) q.by[c] = (q.by[c] - q.value[c] * along) * inverse;
  q.rest = (q.rest * inverse + 1.5 * s * s / ((1 - s) * (1 - s))) * kDiscSlack;
  q.change = relative + q.rest;
  return true;
}

/// p = p q. The rest gains the product of the changes.
JULIA_INLINE void multiplyLinear(LinearVersor& p, const LinearVersor& q) {
  const double a = q.value[0], b = q.value[1], c = q.value[2], d = q.value[3];
  const double pa = p.value[0], pb = p.value[1], pc = p.value[2], pd = p.value[3];
  const Place ja = p.by[0], jb = p.by[1], jc = p.by[2], jd = p.by[3];
  const Place ga = q.by[0], gb = q.by[1], gc = q.by[2], gd = q.by[3];
  p.by[0] = (ja * a - jb * b - jc * c - jd * d) + (pa * ga - pb * gb - pc * gc - pd * gd);
  p.by[1] = (ja * b + jb * a + jc * d - jd * c) + (pa * gb + pb * ga + pc * gd - pd * gc);
  p.by[2] = (ja * c - jb * d + jc * a + jd * b) + (pa * gc - pb * gd + pc * ga + pd * gb);
  p.by[3] = (ja * d + jb * c - jc * b + jd * a) + (pa * gd + pb * gc - pc * gb + pd * ga);
  p.value[0] = pa * a - pb * b - pc * c - pd * d;
  p.value[1] = pa * b + pb * a + pc * d - pd * c;
  p.value[2] = pa * c - pb * d + pc * a + pd * b;
  p.value[3] = pa * d + pb * c - pc * b + pd * a;
  p.rest = (p.rest + q.rest + p.change * q.change) * kDiscSlack;
  p.change = (p.change + q.change) * kDiscSlack;
}

/// Adds a wave at one octave. @param frequency  radians per unit at that octave
JULIA_INLINE void addWave(LinearVersor& sum, const WaveTerm<double>& wave, double sine, double cosine,
                          const Place& frequency) {
  for (std::size_t c = 0; c < 4; ++c) {
    sum.value[c] += wave.cosine[c] * cosine + wave.sine[c] * sine;
    sum.by[c] += (wave.sine[c] * cosine - wave.cosine[c] * sine) * frequency;
  }
}

/// The versors of the two octaves that are blended over a ball. @return whether something is known
JULIA_INLINE bool findOctaves(const WaveTerm<double>* waves, const WaveSpan<double>* factors,
                              const WaveFactorBound* bounds, std::size_t factorCount, double slack,
                              const WaveBall& ball, LinearVersor& coarse, LinearVersor& fine) {
  constexpr double kTurn = 6.28318530717958647693;
  LinearVersor* const octaves[2] = {&coarse, &fine};
  for (std::size_t number = 0; number < factorCount; ++number) {
    const WaveSpan<double>& factor = factors[number];
    LinearVersor sums[2] = {};
    for (std::size_t w = factor.first; w < factor.last; ++w) {
      const WaveTerm<double>& wave = waves[w];
      const Place frequency =
          (kTurn * ball.scale) * Place{wave.frequency[0], wave.frequency[1], wave.frequency[2], wave.frequency[3]};
      double sine, cosine, sineFine, cosineFine;
      sineCosine(4 * ball.scale * dotOf(wave.frequency, ball.place), &sine, &cosine);
      doublePhase(sine, cosine, &sineFine, &cosineFine);
      addWave(sums[0], wave, sine, cosine, frequency);
      addWave(sums[1], wave, sineFine, cosineFine, 2 * frequency);
    }
    for (std::size_t octave = 0; octave < 2; ++octave) {
      LinearVersor& sum = sums[octave];
      const double scale = octave == 0 ? ball.scale : 2 * ball.scale, turn = scale * ball.radius;
      const WaveFactorBound& bound = bounds[number];
      sum.rest =
          0.5 * bound.curvature * turn * turn * kDiscSlack + bound.rounding + bound.perSize * (ball.size * scale);
      if (!makeVersor(sum, ball.radius)) return false;
      sum.rest += slack;
      sum.change += slack;
      if (factor.conjugated < 0)
        for (std::size_t c = 1; c < 4; ++c) {
          sum.value[c] = -sum.value[c];
          sum.by[c] = -sum.by[c];
        }
      for (std::uint32_t times = 0; times < factor.power; ++times)
        if (number == 0 && times == 0)
          *octaves[octave] = sum;
        else
          multiplyLinear(*octaves[octave], sum);
    }
  }
  return true;
}

JULIA_INLINE void waveDisc(const WaveTerm<double>* waves, const WaveSpan<double>* factors,
                           const WaveFactorBound* bounds, std::size_t factorCount, double slack, const WaveBall& ball,
                           VersorDisc& disc) {
  disc.radius = __builtin_inf();
  LinearVersor coarse, fine;
  if (!findOctaves(waves, factors, bounds, factorCount, slack, ball, coarse, fine)) return;
  // Another weight moves the blend along the segment between the two versors, wherever these are.
  const double middle = 0.5 * (ball.least + ball.most), half = 0.5 * (ball.most - ball.least);
  LinearVersor blend;
  double squares = 0;
  for (std::size_t c = 0; c < 4; ++c) {
    const double apart = fine.value[c] - coarse.value[c];
    squares += apart * apart;
    blend.value[c] = coarse.value[c] + apart * middle;
    blend.by[c] = coarse.by[c] + (fine.by[c] - coarse.by[c]) * middle;
  }
  const double atLeast = coarse.rest + (fine.rest - coarse.rest) * ball.least;
  const double atMost = coarse.rest + (fine.rest - coarse.rest) * ball.most;
  blend.rest = ((atLeast > atMost ? atLeast : atMost) + half * (squareRoot(squares) + coarse.change + fine.change)) *
                   kDiscSlack +
               slack;
  if (!makeVersor(blend, ball.radius)) return;
  for (std::size_t c = 0; c < 4; ++c) disc.centre[c] = blend.value[c];
  disc.radius = (gramNorm(blend.by) * ball.radius + blend.rest) * kDiscSlack + slack;
}

void waveDiscs(const WaveTerm<double>* waves, const WaveSpan<double>* factors, const WaveFactorBound* bounds,
               std::size_t factorCount, double slack, const WaveBall* balls, VersorDisc* discs, std::size_t size) {
  for (std::size_t i = 0; i < size; ++i) waveDisc(waves, factors, bounds, factorCount, slack, balls[i], discs[i]);
}

}  // namespace
}  // namespace julia::kernels
