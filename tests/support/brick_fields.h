// SPDX-License-Identifier: Apache-2.0
/// @file brick_fields.h
/// Functions of space as fields of bricks.
#pragma once

#include "julia/brick_field.h"

#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <utility>

namespace law_tests {

/// A function of fractal space.
using SpaceFunction = std::function<double(double, double, double)>;

/// A ball of radius 3/8 with lumps.
inline double lumpy(double x, double y, double z) {
  return std::sqrt(x * x + y * y + z * z) - 0.375 - 0.04 * std::sin(8 * x) * std::sin(9 * y) * std::sin(7 * z);
}

/// A function of fractal space from -half to half, sampled every @a spacing. @param knee  julia/bricks.h
template <class Real>
std::shared_ptr<julia::BrickField<Real>> brickFieldOf(const SpaceFunction& value, julia::Interpolation interpolation,
                                                      double half, double spacing, const julia::Knee& knee = {}) {
  auto bricks = std::make_shared<julia::Bricks>();
  bricks->interpolation = interpolation;
  const auto nodes = static_cast<std::uint32_t>(2 * half / spacing) + 1;
  const std::uint32_t across = (nodes + 1) / julia::kBrickSide + 1;
  bricks->count = {across, across, across};
  for (std::uint32_t place = 0; place < across * across * across; ++place) {
    bricks->brickAt.push_back(place);
    const auto coordinate = [&](std::uint32_t brick, std::uint32_t k) {
      return -half + spacing * (static_cast<double>(brick * julia::kBrickSide + k) - bricks->before());
    };
    for (std::uint32_t x = 0; x < bricks->side(); ++x)
      for (std::uint32_t y = 0; y < bricks->side(); ++y)
        for (std::uint32_t z = 0; z < bricks->side(); ++z)
          bricks->values.push_back(
              static_cast<float>(value(coordinate(place / (across * across), x), coordinate(place / across % across, y),
                                       coordinate(place % across, z))));
  }
  julia::BrickPlacement placement{.knee = knee};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    placement.matrix[axis][axis] = 1 / spacing;
    placement.offset[axis] = half / spacing;
    placement.high[axis] = nodes - 1;
  }
  return std::make_shared<julia::BrickField<Real>>(bricks, placement);
}

/// A field that does not say that it is read from bricks.
template <class Real>
class UndescribedField final : public julia::ScalarField<Real> {
 public:
  explicit UndescribedField(std::shared_ptr<const julia::ScalarField<Real>> field) : mField(std::move(field)) {}
  void sample(std::span<const Real> x, std::span<const Real> y, std::span<const Real> z,
              std::span<Real> out) const override {
    mField->sample(x, y, z, out);
  }

 private:
  std::shared_ptr<const julia::ScalarField<Real>> mField;
};

}  // namespace law_tests
