// SPDX-License-Identifier: Apache-2.0
// A ramp along an axis of the target's box.
#include "base/smooth_step.h"
#include "control/control_kinds.h"
#include "vdbtools/base/text.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace vdbtools {
namespace {

class RampField final : public ControlField {
 public:
  RampField(const Ramp& ramp, const openvdb::BBoxd& targetBox) : mRamp(ramp) {
    if (!(std::isfinite(ramp.from) && std::isfinite(ramp.to)))
      throw std::invalid_argument("a ramp's values must be finite numbers");
    if (!(ramp.startAt < ramp.endAt))
      throw std::invalid_argument("a ramp starts at " + shortText(ramp.startAt) + " and ends at " +
                                  shortText(ramp.endAt) + "; the start must come first");
    const double low = targetBox.min()[ramp.axis], extent = targetBox.extents()[ramp.axis];
    mStart = low + ramp.startAt * extent;
    mEnd = low + ramp.endAt * extent;
  }

  void sample(std::span<const openvdb::Vec3d> points, std::span<double> values) const override {
    for (std::size_t i = 0; i < points.size(); ++i) values[i] = at(points[i][mRamp.axis]);
  }
  std::pair<double, double> range() const override { return std::minmax({mRamp.from, mRamp.to}); }

 private:
  double at(double world) const {
    const double t = std::clamp((world - mStart) / (mEnd - mStart), 0.0, 1.0);
    // std::lerp stays between its ends.
    return std::lerp(mRamp.from, mRamp.to, mRamp.smooth ? smoothStep(t) : t);
  }

  Ramp mRamp;
  double mStart = 0, mEnd = 0;  ///< world coordinates
};

class RampSource final : public ControlSource {
 public:
  RampSource(const Ramp& ramp, std::string text) : mRamp(ramp), mText(std::move(text)) {}
  std::string text() const override { return mText; }
  Control bind(const ControlContext& context) const override { return Control(mRamp, context.targetBox); }

 private:
  Ramp mRamp;
  std::string mText;
};

}  // namespace

Control::Control(const Ramp& ramp, const openvdb::BBoxd& targetBox)
    : mField(std::make_shared<RampField>(ramp, targetBox)) {}

ControlSourcePtr parseRampControl(const RecipeReader& reader, const std::string& option) {
  const std::string text = reader.text(option);
  const std::vector<std::string> parts = split(text, ':');
  if (parts.size() < 3 || parts[0].size() != 1 || parts[0][0] < 'x' || parts[0][0] > 'z') return nullptr;
  // "VALUE" or "VALUE@POSITION".
  const auto parseEnd = [&](const std::string& end, double& value, double& position) {
    const std::vector<std::string> numbers = split(end, '@');
    try {
      if (numbers.size() > 2) throw std::invalid_argument(end);
      value = parseNumber(option, numbers[0]);
      if (numbers.size() == 2) position = parseNumber(option, numbers[1]);
    } catch (const std::invalid_argument&) {
      reader.refuse(option, "a ramp of finite numbers, VALUE or VALUE@POSITION, such as x:10@0.2:300@0.8:smooth; '" +
                                end + "' is neither");
    }
  };
  Ramp ramp;
  ramp.axis = parts[0][0] - 'x';
  parseEnd(parts[1], ramp.from, ramp.startAt);
  parseEnd(parts[2], ramp.to, ramp.endAt);
  ramp.smooth = parts.size() == 4 && parts[3] == "smooth";
  if (parts.size() > 3 && !ramp.smooth)
    reader.refuse(option, "a ramp that ends after its second value or with ':smooth'");
  if (!(ramp.startAt < ramp.endAt)) reader.refuse(option, "a ramp whose first position comes before the second");
  return std::make_shared<RampSource>(ramp, text);
}

}  // namespace vdbtools
