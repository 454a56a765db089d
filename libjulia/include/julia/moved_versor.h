// SPDX-License-Identifier: Apache-2.0
/// @file moved_versor.h
/// Versors that evaluate another versor at other points: moved, scaled, or made symmetric.
#pragma once

#include "julia/embedding.h"
#include "julia/versor_field.h"

#include <any>
#include <array>
#include <memory>
#include <span>
#include <vector>

namespace julia {

/// What MovedVersor::describe() returns.
struct MovedVersorDescription {
  std::any versor;  ///< as VersorField::describe() of v
  double scale = 1;
  Quaternion<double> translate{};
};

/// u(q) = v((q - t) / s), which is v scaled by s about the origin and then moved by t.
template <class Real>
class MovedVersor final : public VersorField<Real> {
 public:
  /// @throw std::invalid_argument  the scale is 0, or a number is not finite
  MovedVersor(std::shared_ptr<const VersorField<Real>> versor, double scale, const Quaternion<double>& translate);

  void versor(const QuaternionBatch<Real>& q, QuaternionBatch<Real>& u) const override;
  void cones(std::span<const Ball> balls, std::span<Cone> cones) const override;
  std::any describe() const override { return MovedVersorDescription{mVersor->describe(), mScale, mTranslate}; }

 private:
  std::shared_ptr<const VersorField<Real>> mVersor;
  double mScale;
  Quaternion<double> mTranslate;
};

/// The symmetry of a texture in space; it does not affect the dropped component of the quaternions.
struct Symmetry {
  /// How often the texture repeats around the axis, 1 to kMostFold.
  int fold = 1;
  int axis = 2;  ///< the axis of the rotations: 0 X, 1 Y, 2 Z
  /// Whether each sector is mirrored in its middle, as in a kaleidoscope.
  bool kaleidoscope = false;
  std::array<bool, 3> mirrored{};  ///< at the planes through the centre at right angles to X, Y and Z
  Point centre{};                  ///< units of the map's space
};

inline constexpr int kMostFold = 64;

/// @throw std::invalid_argument  a number out of its range
void requireValid(const Symmetry& symmetry);

/// A rotation of the plane.
struct SectorTurn {
  double cosine, sine;
};

/// The rotations onto which a texture of @a fold sectors repeats, beginning with none.
std::vector<SectorTurn> sectorTurns(int fold);

/// What SymmetricVersor::describe() returns.
struct SymmetricVersorDescription {
  std::any versor;  ///< as VersorField::describe() of the versor that is made symmetric
  Symmetry symmetry;
  DropAxis dropped = DropAxis::K;  ///< the component of q on which the symmetry does not act
};

/// A versor with the same value at all points that the symmetry maps to each other. The shape modulus then maps these
/// points to the same image, and the set over a target of that symmetry has the symmetry too.
///
/// Mirrors fold space at their planes, so that the versor is evaluated on one side only. A kaleidoscope folds space
/// into half a sector. Both folds are continuous and never increase the distance of two points. Rotations without
/// mirrors have no such fold, because the borders of a sector do not match. The versor is then the direction of the sum
/// over all rotations R, u(q) ~ sum of v(R q).
template <class Real>
class SymmetricVersor final : public VersorField<Real> {
 public:
  /// @throw std::invalid_argument  as requireValid()
  SymmetricVersor(std::shared_ptr<const VersorField<Real>> versor, const Symmetry& symmetry, DropAxis dropped);

  void versor(const QuaternionBatch<Real>& q, QuaternionBatch<Real>& u) const override;
  void cones(std::span<const Ball> balls, std::span<Cone> cones) const override;
  std::any describe() const override {
    return SymmetricVersorDescription{mVersor->describe(), mSymmetry, mEmbedding.dropped};
  }

 private:
  /// Folds @a q into its half-space or sector.
  template <class Number>
  Quaternion<Number> folded(const Quaternion<Number>& q) const;
  template <class Number>
  Quaternion<Number> turned(const Quaternion<Number>& q, const SectorTurn& by) const;
  template <class Number>
  static void turn(Number& first, Number& second, const SectorTurn& by);
  double roundingOf(const Ball& ball) const;

  std::shared_ptr<const VersorField<Real>> mVersor;
  Symmetry mSymmetry;
  Embedding mEmbedding;            ///< only its dropped axis is used
  std::vector<SectorTurn> mTurns;  ///< one for each sector
};

extern template class MovedVersor<float>;
extern template class MovedVersor<double>;
extern template class SymmetricVersor<float>;
extern template class SymmetricVersor<double>;

}  // namespace julia
