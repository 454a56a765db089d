// SPDX-License-Identifier: Apache-2.0
/// @file wave_bodies.h
/// Versors of waves (julia/wave_versor.h). See kernel_bodies.h for the restrictions on this code.
#pragma once

#include "blocks.h"

namespace julia::kernels {
namespace {

/// A sum of waves, and its product with itself.
template <class Real>
using Rows4 = Row<Real>[4];

/// to = from / |from|; 1 if |from| is too small to have a direction.
template <class Real>
JULIA_INLINE void unitRows(const Rows4<Real>& from, Rows4<Real>& to, std::size_t padded) {
  JULIA_FOR_POINTS {
    const Real a = from[0][i], b = from[1][i], c = from[2][i], d = from[3][i];
    makeUnit(a, b, c, d, &to[0][i], &to[1][i], &to[2][i], &to[3][i]);
  }
}

/// u = u g. @param conjugated  -1 to multiply by the conjugate of g, else 1
template <class Real>
JULIA_INLINE void multiplyRows(Rows4<Real>& u, const Rows4<Real>& g, Real conjugated, std::size_t padded) {
  JULIA_FOR_POINTS {
    const Real ga = g[0][i], gb = conjugated * g[1][i], gc = conjugated * g[2][i], gd = conjugated * g[3][i];
    multiplyQuaternion(ga, gb, gc, gd, &u[0][i], &u[1][i], &u[2][i], &u[3][i]);
  }
}

template <class Real>
void waveVersor(const WaveTerm<Real>* waves, const WaveSpan<Real>* factors, std::size_t factorCount, const Real* origin,
                ConstBatch<Real> points, const Real* octave, Batch<Real> out, std::size_t size) {
  alignas(64) Rows4<Real> q, coarse, fine, sum, sumFine;
  alignas(64) Row<Real> blend;
  for (std::size_t begin = 0; begin < size; begin += kBlock) {
    const Range range = blockAt(begin, size);
    const std::size_t padded = range.padded;
    for (int k = 0; k < 4; ++k) load(points.component[k], q[k], range);
    load(octave, blend, range);
    JULIA_FOR_POINTS {
      // The points are in quadrants of waves with one cycle per unit.
      Real scale;
      splitOctave(blend[i], &blend[i], &scale);
      for (int c = 0; c < 4; ++c) {
        q[c][i] = (q[c][i] - origin[c]) * scale;
        coarse[c][i] = fine[c][i] = c == 0 ? Real(1) : Real(0);
      }
    }
    for (std::size_t number = 0; number < factorCount; ++number) {
      const WaveSpan<Real>& factor = factors[number];
      for (int c = 0; c < 4; ++c) JULIA_FOR_POINTS sum[c][i] = sumFine[c][i] = 0;
      for (std::size_t w = factor.first; w < factor.last; ++w) {
        const WaveTerm<Real> wave = waves[w];
        JULIA_FOR_POINTS {
          const Real angle = wavePhase(wave.frequency[0], wave.frequency[1], wave.frequency[2], wave.frequency[3],
                                       q[0][i], q[1][i], q[2][i], q[3][i]);
          Real sine, cosine, sineFine, cosineFine;
          sineCosine(angle, &sine, &cosine);
          doublePhase(sine, cosine, &sineFine, &cosineFine);
          for (int c = 0; c < 4; ++c) {
            sum[c][i] += wave.cosine[c] * cosine + wave.sine[c] * sine;
            sumFine[c][i] += wave.cosine[c] * cosineFine + wave.sine[c] * sineFine;
          }
        }
      }
      unitRows(sum, sum, padded);
      unitRows(sumFine, sumFine, padded);
      for (std::uint32_t times = 0; times < factor.power; ++times) {
        multiplyRows(coarse, sum, factor.conjugated, padded);
        multiplyRows(fine, sumFine, factor.conjugated, padded);
      }
    }
    for (int c = 0; c < 4; ++c) JULIA_FOR_POINTS sum[c][i] = coarse[c][i] + blend[i] * (fine[c][i] - coarse[c][i]);
    unitRows(sum, sum, padded);
    for (int c = 0; c < 4; ++c) store(sum[c], out.component[c], range);
  }
}

template <class Real>
void grainVersor(const WaveTerm<Real>* waves, const WaveSpan<Real>* factors, std::size_t factorCount,
                 const Real* const* fields, Batch<Real> out, std::size_t size) {
  alignas(64) Rows4<Real> versor, sum;
  alignas(64) Row<Real> read[5];
  alignas(64) Row<Real> certain;
  for (std::size_t begin = 0; begin < size; begin += kBlock) {
    const Range range = blockAt(begin, size);
    const std::size_t padded = range.padded;
    for (int k = 0; k < 5; ++k) load(fields[k], read[k], range);
    JULIA_FOR_POINTS {
      Real alongCertain, acrossCertain;
      read[0][i] = certainPhase(read[0][i], read[1][i], &alongCertain);
      read[1][i] = certainPhase(read[2][i], read[3][i], &acrossCertain);
      read[4][i] *= 4;
      certain[i] = alongCertain * acrossCertain;
      for (int c = 0; c < 4; ++c) versor[c][i] = c == 0 ? Real(1) : Real(0);
    }
    for (std::size_t number = 0; number < factorCount; ++number) {
      const WaveSpan<Real>& factor = factors[number];
      for (int c = 0; c < 4; ++c) JULIA_FOR_POINTS sum[c][i] = 0;
      for (std::size_t w = factor.first; w < factor.last; ++w) {
        const WaveTerm<Real> wave = waves[w];
        JULIA_FOR_POINTS {
          const Real angle =
              grainPhase(wave.frequency[0], wave.frequency[1], wave.frequency[2], read[0][i], read[1][i], read[4][i]);
          Real sine, cosine;
          sineCosine(angle, &sine, &cosine);
          for (int c = 0; c < 4; ++c) sum[c][i] += wave.cosine[c] * cosine + wave.sine[c] * sine;
        }
      }
      unitRows(sum, sum, padded);
      for (std::uint32_t times = 0; times < factor.power; ++times) multiplyRows(versor, sum, factor.conjugated, padded);
    }
    JULIA_FOR_POINTS {
      versor[0][i] = fadedPart(versor[0][i], Real(1), certain[i]);
      for (int c = 1; c < 4; ++c) versor[c][i] = fadedPart(versor[c][i], Real(0), certain[i]);
    }
    unitRows(versor, versor, padded);
    for (int c = 0; c < 4; ++c) store(versor[c], out.component[c], range);
  }
}

}  // namespace
}  // namespace julia::kernels
