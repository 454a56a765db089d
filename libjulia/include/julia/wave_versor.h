// SPDX-License-Identifier: Apache-2.0
/// @file wave_versor.h
/// Versors of waves, whose scale may vary in space: the thinner a part is, the finer its texture.
///
/// A *factor* is the versor of a sum of plane waves with quaternion amplitudes, raised to an integer power,
///
///   g(p) = sum_k  c_k cos(2 pi w_k . p) + s_k sin(2 pi w_k . p),        (g / |g|)^P
///
/// With one wave, c = 1 and s a unit imaginary, g is a rotation about an axis: bands across w. A sum of many waves has
/// zeros at isolated points of the four dimensions. About each zero its direction takes all values, as about a root or
/// a pole of a rational map ([Kim15] Eq. 2). The shorter the waves, the more zeros there are, everywhere and at no
/// extra cost. A texture B is an ordered product of factors.
///
/// The *octave* o is a scalar on space: there, the frequencies of the versor are 2^o times those of the texture. With k
/// the largest integer that is not above o,
///
///   u(q) = the versor of  (1 - t) B(2^k q) + t B(2^(k+1) q),   t = f^2 (3 - 2 f),   f = o - k
///
/// as octaves of noise are blended; compare the phasor noise of [Tri19], whose phases are waves of varying frequency.
/// The double-angle formulas give the waves of the finer octave from those of the coarser one.
#pragma once

#include "julia/embedding.h"
#include "julia/quaternion.h"
#include "julia/scalar_field.h"
#include "julia/versor_field.h"

#include <any>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace julia {

struct Wave {
  Quaternion<double> frequency;     ///< w, cycles per unit
  Quaternion<double> cosine, sine;  ///< the amplitudes c and s

  friend bool operator==(const Wave&, const Wave&) = default;
};

struct WaveFactor {
  std::vector<Wave> waves;
  int power = 1;  ///< P, -kMostWavePower to kMostWavePower and not 0

  friend bool operator==(const WaveFactor&, const WaveFactor&) = default;
};

inline constexpr int kMostWavePower = 64;

struct WaveTexture {
  std::vector<WaveFactor> factors;
  Quaternion<double> origin{};  ///< where the phases are 0 at every octave; p is measured from it

  friend bool operator==(const WaveTexture&, const WaveTexture&) = default;
};

/// What WaveVersor::describe() returns.
struct WaveVersorDescription {
  WaveTexture texture;
  std::optional<PlacedBricks> octave;  ///< o; empty if the octave's field does not describe itself
  DropAxis dropped = DropAxis::K;      ///< the component of q at which the octave is not read
};

/// @throw std::invalid_argument  no factor or no wave, a power out of range, numbers that are not finite
void requireValid(const WaveTexture& texture);

template <class Real>
class WaveVersor final : public VersorField<Real> {
 public:
  /// @param octave  values from -kMostOctave to kMostOctave; values outside are clamped
  /// @throw std::invalid_argument  as requireValid()
  WaveVersor(const WaveTexture& texture, std::shared_ptr<const ScalarField<Real>> octave, DropAxis dropped);
  ~WaveVersor() override;

  void versor(const QuaternionBatch<Real>& q, QuaternionBatch<Real>& u) const override;
  void cones(std::span<const Ball> balls, std::span<Cone> cones) const override;
  double usefulRadius() const override;
  std::any describe() const override {
    return WaveVersorDescription{mTexture, mOctave->describe(), mEmbedding.dropped};
  }

 private:
  struct Plan;

  double sizeOf(const Ball& ball) const;
  Cone coneBySlopes(const Ball& ball, double low, double high, double slack) const;

  WaveTexture mTexture;
  std::shared_ptr<const ScalarField<Real>> mOctave;
  Embedding mEmbedding;
  std::unique_ptr<const Plan> mPlan;
};

inline constexpr double kMostOctave = 40;

extern template class WaveVersor<float>;
extern template class WaveVersor<double>;

}  // namespace julia
