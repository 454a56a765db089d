// SPDX-License-Identifier: Apache-2.0
/// @file placed_versor.h
/// The versor of the shape modulus in a scene.
#pragma once

#include "vdbtools/maps/map_descriptor.h"
#include "vdbtools/maps/map_registry.h"
#include "vdbtools/maps/versor_options.h"

#include "julia/function_versor.h"
#include "julia/versor_field.h"

#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace vdbtools {

/// A field in the form that evaluators read, made for each arithmetic when it is first needed. The evaluators of a
/// scene share it.
class SharedField {
 public:
  template <class Real>
  using Pointer = std::shared_ptr<const julia::ScalarField<Real>>;

  virtual ~SharedField() = default;

  template <class Real>
  Pointer<Real> get() const {
    const std::lock_guard lock(mMutex);
    Pointer<Real>& field = std::get<Pointer<Real>>(mFields);
    if (!field) make(field);
    return field;
  }

 private:
  virtual void make(Pointer<float>& field) const = 0;
  virtual void make(Pointer<double>& field) const = 0;

  mutable std::mutex mMutex;
  mutable std::pair<Pointer<float>, Pointer<double>> mFields;
};
using SharedFieldPtr = std::shared_ptr<const SharedField>;

SharedFieldPtr sharedField(const ExponentGrid& grid);
SharedFieldPtr sharedField(const ControlGrid& grid);

/// One layer of the texture.
struct PlacedLayer {
  VersorSource source;
  PlacedRoots roots{};  ///< if the layer is made from roots
  std::optional<julia::WaveTexture> waves{};
  SharedFieldPtr octave{};                   ///< if the layer is made from waves
  std::vector<SharedFieldPtr> grain{};       ///< if these follow a grain, its fields (julia::GrainField)
  GrainScale scale{};                        ///< of the grain, with its wavelength in units of fractal space
  std::vector<SharedFieldPtr> directions{};  ///< the components of a field
  julia::DirectionFunction function{};       ///< a formula, or a function of the calling program
};

/// The versor of the settings. The parts of it that do not depend on the seed of the random roots are made once.
class PlacedVersor {
 public:
  /// @throw DataError  a formula or a field that has no direction in a part of the target
  PlacedVersor(const VersorSettings& settings, const julia::Embedding& embedding, const MapContext& context,
               const VersorFunction& function);

  template <class Real>
  std::shared_ptr<const julia::VersorField<Real>> field() const;

  /// Whether floats are as accurate as doubles.
  bool floatsServe(const julia::OrbitOptions& orbit) const;
  /// The roots of a versor that consists of roots alone; otherwise nullptr.
  const julia::Rational* roots() const;
  std::map<std::string, std::string> metadata() const;
  std::optional<std::uint64_t> seed() const;
  /// Draws new random roots for the first layer.
  void reseed(std::uint64_t seed, const MapContext& context);

 private:
  template <class Real>
  std::shared_ptr<const julia::VersorField<Real>> layer(const PlacedLayer& layer) const;

  julia::Embedding mEmbedding;
  PlacedLayer mUnder;
  std::optional<PlacedLayer> mOver{};
  SharedFieldPtr mMix{};
  std::optional<julia::Symmetry> mSymmetry{};
};

}  // namespace vdbtools
