// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/target/control.h"

#include "vdbtools/base/errors.h"

#include <openvdb/tools/Interpolation.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <memory>
#include <optional>
#include <stdexcept>
#include <vector>

namespace vdbtools {
namespace {

std::optional<double> parseNumber(std::string_view text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error == std::errc::invalid_argument || end != text.data() + text.size()) return std::nullopt;
  if (error != std::errc{} || !std::isfinite(value))
    throw std::invalid_argument("'" + std::string(text) + "' is not a finite number");
  return value;
}

std::vector<std::string_view> split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  for (;;) {
    const std::size_t end = text.find(separator);
    parts.push_back(text.substr(0, end));
    if (end == std::string_view::npos) return parts;
    text.remove_prefix(end + 1);
  }
}

/// "VALUE" or "VALUE@POSITION".
void parseEnd(std::string_view text, double& value, double& position, const std::string& whole) {
  const std::vector<std::string_view> parts = split(text, '@');
  const std::optional<double> first = parseNumber(parts[0]);
  const std::optional<double> second = parts.size() == 2 ? parseNumber(parts[1]) : std::nullopt;
  if (!first || parts.size() > 2 || (parts.size() == 2 && !second))
    throw std::invalid_argument("'" + std::string(text) + "' in the ramp '" + whole +
                                "' is not a value; write VALUE or VALUE@POSITION, as in x:10@0.2:300@0.8:smooth");
  value = *first;
  if (second) position = *second;
}

}  // namespace

Control::Control(const Ramp& ramp, const openvdb::BBoxd& targetBox) {
  if (!(std::isfinite(ramp.from) && std::isfinite(ramp.to)))
    throw std::invalid_argument("a ramp's values must be finite numbers");
  if (!(ramp.startAt < ramp.endAt))
    throw std::invalid_argument("a ramp starts at " + std::to_string(ramp.startAt) + " and ends at " +
                                std::to_string(ramp.endAt) + "; the start must come first");
  const double low = targetBox.min()[ramp.axis], extent = targetBox.extents()[ramp.axis];
  mSource = PlacedRamp{ramp, low + ramp.startAt * extent, low + ramp.endAt * extent};
}

Control::Control(openvdb::FloatGrid::ConstPtr grid) {
  for (auto value = grid->tree().cbeginValueAll(); value; ++value)
    if (!std::isfinite(*value)) throw DataError("the grid '" + grid->getName() + "' holds a value that is not finite");
  mSource = std::move(grid);
}

std::function<double(const openvdb::Vec3d&)> Control::reader() const {
  if (const double* number = std::get_if<double>(&mSource))
    return [value = *number](const openvdb::Vec3d&) { return value; };
  if (const PlacedRamp* placed = std::get_if<PlacedRamp>(&mSource))
    return [placed = *placed](const openvdb::Vec3d& world) {
      const Ramp& ramp = placed.ramp;
      double t = std::clamp((world[ramp.axis] - placed.start) / (placed.end - placed.start), 0.0, 1.0);
      if (ramp.smooth) t = t * t * (3 - 2 * t);
      return ramp.from + (ramp.to - ramp.from) * t;
    };
  const auto& grid = std::get<openvdb::FloatGrid::ConstPtr>(mSource);
  // std::function must be copyable; the accessor is not meant to be shared, so it lives on the heap of its own reader.
  const auto accessor = std::make_shared<openvdb::FloatGrid::ConstAccessor>(grid->getConstAccessor());
  return [grid, accessor](const openvdb::Vec3d& world) -> double {
    return openvdb::tools::BoxSampler::sample(*accessor, grid->worldToIndex(world));
  };
}

std::optional<double> Control::constant() const {
  if (const double* number = std::get_if<double>(&mSource)) return *number;
  return std::nullopt;
}

std::pair<double, double> Control::range() const {
  if (const std::optional<double> number = constant()) return {*number, *number};
  if (const PlacedRamp* placed = std::get_if<PlacedRamp>(&mSource))
    return std::minmax({placed->ramp.from, placed->ramp.to});
  const auto& grid = std::get<openvdb::FloatGrid::ConstPtr>(mSource);
  double low = grid->background(), high = low;
  for (auto value = grid->tree().cbeginValueAll(); value; ++value) {
    low = std::min<double>(low, *value);
    high = std::max<double>(high, *value);
  }
  return {low, high};
}

std::variant<std::monostate, double, Ramp> parseControl(const std::string& text) {
  if (const std::optional<double> number = parseNumber(text)) return *number;
  const std::vector<std::string_view> parts = split(text, ':');
  if (parts.size() < 3 || parts[0].size() != 1 || parts[0][0] < 'x' || parts[0][0] > 'z') return {};
  Ramp ramp;
  ramp.axis = parts[0][0] - 'x';
  parseEnd(parts[1], ramp.from, ramp.startAt, text);
  parseEnd(parts[2], ramp.to, ramp.endAt, text);
  if (parts.size() == 4 && parts[3] == "smooth")
    ramp.smooth = true;
  else if (parts.size() > 3)
    throw std::invalid_argument("'" + std::string(parts[3]) + "' at the end of the ramp '" + text +
                                "' is not known; only 'smooth' may stand there");
  return ramp;
}

}  // namespace vdbtools
