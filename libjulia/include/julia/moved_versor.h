// SPDX-License-Identifier: Apache-2.0
/// @file moved_versor.h
/// Versors that ask another one at other points: moved, scaled, or made symmetric.
#pragma once

#include "julia/embedding.h"
#include "julia/versor_field.h"

#include <array>
#include <memory>
#include <span>
#include <vector>

namespace julia {

/// u(q) = v((q - t) / s): v made s times as large about the origin, and then moved by t.
template <class Real>
class MovedVersor final : public VersorField<Real> {
 public:
  /// @throw std::invalid_argument  the scale is 0, or a number is not finite
  MovedVersor(std::shared_ptr<const VersorField<Real>> versor, double scale, const Quaternion<double>& translate);

  void versor(const QuaternionBatch<Real>& q, QuaternionBatch<Real>& u) const override;
  void cones(std::span<const Ball> balls, std::span<Cone> cones) const override;

 private:
  std::shared_ptr<const VersorField<Real>> mVersor;
  double mScale;
  Quaternion<double> mTranslate;
};

/// Of a texture in space; the dropped component of the quaternions takes no part.
struct Symmetry {
  /// How often the texture repeats around the axis, 1 to kMostFold.
  int fold = 1;
  int axis = 2;  ///< of the rotations: 0 X, 1 Y, 2 Z
  /// Mirrors each of the sectors in its middle, as a kaleidoscope does.
  bool kaleidoscope = false;
  std::array<bool, 3> mirrored{};  ///< across the planes through the centre at right angles to X, Y and Z
  Point centre{};                  ///< units of the map's space
};

inline constexpr int kMostFold = 64;

/// @throw std::invalid_argument  a number out of its range
void requireValid(const Symmetry& symmetry);

/// A versor that is the same at points which the symmetry takes to each other. So the map takes them to one and the
/// same image, and the set over a target of that symmetry has it too.
///
/// Mirrors fold space at their planes, and ask the versor on one side alone. A kaleidoscope folds it into half a
/// sector. Both are continuous and bring no two points farther from each other. Rotations without mirrors have no such
/// fold: the borders of a sector do not fit. There it is the versor of the sum over all rotations R, u(q) ~ sum of v(R
/// q).
template <class Real>
class SymmetricVersor final : public VersorField<Real> {
 public:
  /// @throw std::invalid_argument  as requireValid()
  SymmetricVersor(std::shared_ptr<const VersorField<Real>> versor, const Symmetry& symmetry, DropAxis dropped);

  void versor(const QuaternionBatch<Real>& q, QuaternionBatch<Real>& u) const override;
  void cones(std::span<const Ball> balls, std::span<Cone> cones) const override;

 private:
  struct Turn {
    double cosine, sine;
  };
  /// @a q in its half-space or sector.
  template <class Number>
  Quaternion<Number> folded(const Quaternion<Number>& q) const;
  template <class Number>
  Quaternion<Number> turned(const Quaternion<Number>& q, const Turn& by) const;
  template <class Number>
  static void turn(Number& first, Number& second, const Turn& by);
  double roundingOf(const Ball& ball) const;

  std::shared_ptr<const VersorField<Real>> mVersor;
  Symmetry mSymmetry;
  Embedding mEmbedding;      ///< for its dropped axis
  std::vector<Turn> mTurns;  ///< one for each sector
};

extern template class MovedVersor<float>;
extern template class MovedVersor<double>;
extern template class SymmetricVersor<float>;
extern template class SymmetricVersor<double>;

}  // namespace julia
