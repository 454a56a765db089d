// SPDX-License-Identifier: Apache-2.0
// The same number everywhere.
#include "control/control_kinds.h"

#include <algorithm>
#include <cmath>

namespace vdbtools {
namespace {

class NumberField final : public ControlField {
 public:
  explicit NumberField(double value) : mValue(value) {}

  void sample(std::span<const openvdb::Vec3d>, std::span<double> values) const override {
    std::fill(values.begin(), values.end(), mValue);
  }
  std::pair<double, double> range() const override { return {mValue, mValue}; }
  std::optional<double> constant() const override { return mValue; }

 private:
  double mValue;
};

class NumberSource final : public ControlSource {
 public:
  NumberSource(double value, std::string text) : mValue(value), mText(std::move(text)) {}
  std::string text() const override { return mText; }
  Control bind(const ControlContext&) const override { return Control(mValue); }

 private:
  double mValue;
  std::string mText;
};

}  // namespace

Control::Control(double value) : mField(std::make_shared<NumberField>(value)) {}

ControlSourcePtr numberSource(double value, std::string text) {
  return std::make_shared<NumberSource>(value, std::move(text));
}

ControlSourcePtr parseNumberControl(const RecipeReader& reader, const std::string& option) {
  const std::string text = reader.text(option);
  const std::optional<double> value = numberFromText(text);
  if (!value) return nullptr;
  if (!std::isfinite(*value)) reader.refuse(option, "a finite number");
  return numberSource(*value, text);
}

}  // namespace vdbtools
