// SPDX-License-Identifier: Apache-2.0
/// @file grain_versor.h
/// Versors of waves that follow the grain of a surface. Their phases do not come from the place itself, as those of
/// wave_versor.h, but from two fields of phases, u along the grain and v across it, and from the distance d to the
/// surface:
///
///   g = sum_k  c_k cos(m_k u + n_k v + 2 pi w_k d) + s_k sin(m_k u + n_k v + 2 pi w_k d),      (g / |g|)^P
///
/// u and v are known as cosine and sine, up to whole turns, so m and n are whole numbers; then the sum is continuous.
/// The squares of cosine and sine add up to r^2 <= 1. Where the phase is not certain, r is small, and the texture fades
/// into the versor 1: with t = min(2 r^2, 1), it counts as much as t^2 (3 - 2 t), for u times v.
#pragma once

#include "julia/embedding.h"
#include "julia/scalar_field.h"
#include "julia/versor_field.h"
#include "julia/wave_versor.h"

#include <any>
#include <array>
#include <memory>
#include <optional>
#include <span>

namespace julia {

/// Numbers of the five fields of a grain.
enum GrainField { kAlongCosine, kAlongSine, kAcrossCosine, kAcrossSine, kGrainDepth, kGrainFields };

struct GrainVersorDescription {
  WaveTexture texture;
  std::array<std::optional<PlacedBricks>, kGrainFields> fields;  ///< empty where a field does not describe itself
  DropAxis dropped = DropAxis::K;  ///< the component of q at which the fields are not read
};

template <class Real>
class GrainVersor final : public VersorField<Real> {
 public:
  using Fields = std::array<std::shared_ptr<const ScalarField<Real>>, kGrainFields>;

  /// @param texture     the frequency of a wave is (m, n, w, 0); the origin is not used
  /// @param wavelength  the length over which u turns once where that is longest, > 0
  /// @throw std::invalid_argument  as requireValid(), or m or n is not whole
  GrainVersor(const WaveTexture& texture, Fields fields, double wavelength, DropAxis dropped);
  ~GrainVersor() override;

  void versor(const QuaternionBatch<Real>& q, QuaternionBatch<Real>& u) const override;
  void cones(std::span<const Ball> balls, std::span<Cone> cones) const override;
  double usefulRadius() const override;
  std::any describe() const override;

 private:
  struct Plan;
  struct Joined;

  WaveTexture mTexture;
  Fields mFields;
  double mWavelength;
  Embedding mEmbedding;
  std::unique_ptr<const Plan> mPlan;
  std::unique_ptr<Joined> mJoined;
};

extern template class GrainVersor<float>;
extern template class GrainVersor<double>;

}  // namespace julia
