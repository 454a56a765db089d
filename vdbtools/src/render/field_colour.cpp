// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/render/field_colour.h"

#include "base/elementary.h"
#include "base/srgb.h"
#include "formats/picture_file.h"
#include "render/neighbourhood.h"
#include "vdbtools/render/look.h"

#include "vdbtools/base/text.h"
#include "vdbtools/files/file_bytes.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

namespace vdbtools {
namespace {

using openvdb::Vec3d;
using openvdb::Vec3s;

/// The saturation of the colours of directions. It is lower than in [ZB25], where full saturation hides the shape.
constexpr double kSaturation = 0.85;

/// The components of a direction, from -1 to 1, as sRGB.
Vec3d directionColour(const Vec3d& direction) {
  Vec3d rgb;
  for (int i = 0; i < 3; ++i) rgb[i] = linearFromSrgb(std::clamp(0.5 + 0.5 * kSaturation * direction[i], 0.0, 1.0));
  return rgb;
}

std::vector<julia::Quaternion<double>> versorsOf(const julia::FieldEvaluator& evaluator,
                                                 std::span<const julia::Point> points) {
  std::vector<julia::Quaternion<double>> versors(points.size());
  evaluator.versors(points, versors);
  return versors;
}

Vec3d inSpace(const julia::Quaternion<double>& versor, julia::DropAxis dropped) {
  const julia::Point at = julia::Embedding{.dropped = dropped}.point(versor);
  return {at[0], at[1], at[2]};
}

std::vector<double> depthsOf(const DepthColouring& depth, std::span<const julia::Point> points) {
  std::vector<Vec3d> world;
  world.reserve(points.size());
  for (const julia::Point& point : points) world.push_back(depth.space.toWorld(point));
  std::vector<double> result(points.size());
  depth.distance.sample(world, result);
  return result;
}

/// The first row of a picture as a gradient.
Gradient rowOf(const std::filesystem::path& path) {
  const DecodedImage image = readPicture(path);
  const bool isGrey = image.channels - (image.alphaChannel >= 0 ? 1 : 0) < 3;
  std::vector<Gradient::Stop> stops;
  for (int x = 0; x < image.width; ++x) {
    const float* pixel = &image.values[static_cast<std::size_t>(x) * static_cast<std::size_t>(image.channels)];
    Gradient::Stop& stop = stops.emplace_back();
    for (std::size_t c = 0; c < 3; ++c) {
      const double value = std::clamp<double>(pixel[isGrey ? 0 : c], 0, 1);
      stop[c] = image.isLinear ? srgbFromLinear(value) : value;
    }
  }
  return Gradient(std::move(stops));
}

}  // namespace

std::vector<double> colourNumbers(const FieldColouring& colouring, const julia::FieldEvaluator& evaluator,
                                  std::span<const julia::Point> points, std::span<const double> iterations) {
  switch (colouring.by) {
    case FieldColour::Iterations: return {iterations.begin(), iterations.end()};
    case FieldColour::Trap: return trapRadii(evaluator, points);
    case FieldColour::Depth:
      if (!colouring.depth) throw std::logic_error("colours by depth need the target's distances");
      return depthsOf(*colouring.depth, points);
    case FieldColour::Clay:
    case FieldColour::Direction:
    case FieldColour::Versor: break;
  }
  return {};
}

std::vector<Vec3d> fieldColours(const FieldColouring& colouring, const julia::FieldEvaluator& evaluator,
                                const ColourContext& context, std::span<const julia::Point> points,
                                std::span<const double> iterations) {
  std::vector<Vec3d> result(points.size(), Material{}.albedo);
  const auto through = [&](const GradientRange& usual) {
    const std::vector<double> numbers = colourNumbers(colouring, evaluator, points, iterations);
    const auto [low, high] = colouring.range.value_or(usual);
    for (std::size_t i = 0; i < result.size(); ++i)
      result[i] = colouring.gradient.at((numbers[i] - low) / (high - low));
  };
  switch (colouring.by) {
    case FieldColour::Clay: break;
    case FieldColour::Iterations: through({0, static_cast<double>(context.maxIterations)}); break;
    case FieldColour::Trap: through({0, 1}); break;
    case FieldColour::Depth:
      through(colouring.depth ? GradientRange{colouring.depth->low, colouring.depth->high} : GradientRange());
      break;
    case FieldColour::Direction:
    case FieldColour::Versor: {
      const std::vector<julia::Quaternion<double>> versors = versorsOf(evaluator, points);
      for (std::size_t i = 0; i < result.size(); ++i) {
        const julia::Quaternion<double>& u = versors[i];
        result[i] =
            directionColour(colouring.by == FieldColour::Versor ? Vec3d(u.b, u.c, u.d) : inSpace(u, context.dropAxis));
      }
      break;
    }
  }
  return result;
}

std::vector<Vec3s> firstDirections(const julia::FieldEvaluator& evaluator, julia::DropAxis dropAxis,
                                   std::span<const julia::Point> points) {
  std::vector<Vec3s> result;
  result.reserve(points.size());
  for (const julia::Quaternion<double>& versor : versorsOf(evaluator, points))
    result.emplace_back(inSpace(versor, dropAxis));
  return result;
}

std::vector<double> trapRadii(const julia::FieldEvaluator& evaluator, std::span<const julia::Point> points) {
  std::vector<double> nearest(points.size());
  evaluator.orbitTraps(points, nearest);
  for (double& value : nearest) value = elementary::exp(value);
  return nearest;
}

std::vector<double> meanIterations(const julia::FieldEvaluator& evaluator, std::span<const julia::Point> points,
                                   double step) {
  std::vector<double> field(kNeighbours * points.size());
  std::vector<int> iterations(field.size());
  evaluator.evaluateAround(points, std::vector<double>(points.size(), step), neighbourDirections(), field, iterations);
  std::vector<double> result;
  result.reserve(points.size());
  for (std::size_t i = 0; i < field.size(); i += kNeighbours)
    result.push_back(
        meanIterationsOutside(std::span(field).subspan(i, kNeighbours), std::span(iterations).subspan(i, kNeighbours)));
  return result;
}

OptionSpec colourOptionSpec() {
  return {.name = "colour",
          .argument = "WHAT[:GRADIENT][:LOW:HIGH]",
          .help =
              "colours, in pictures of the set and as Cd in files: direction (of the first step, as RGB), versor, "
              "clay, or trap, iterations or depth through a gradient: one of " +
              joined(gradientNames()) +
              ", a list of colours (000000,ff8800,ffffff), or the first row of a picture. The gradient runs from LOW "
              "to HIGH, or over the numbers that occur. gradient:NAME is trap:NAME",
          .defaultNote = "direction; contact sheets: clay",
          .hash = "colour-sha256"};
}

namespace {

const std::map<std::string, FieldColour>& colourKinds() {
  static const std::map<std::string, FieldColour> kinds = {
      {"direction", FieldColour::Direction}, {"versor", FieldColour::Versor}, {"clay", FieldColour::Clay},
      {"trap", FieldColour::Trap},           {"depth", FieldColour::Depth},   {"iterations", FieldColour::Iterations},
      {"gradient", FieldColour::Trap}};
  return kinds;
}

/// Removes LOW:HIGH, if present, from the end of what follows the kind.
std::optional<GradientRange> takeRange(const RecipeReader& reader, std::vector<std::string>& parts) {
  const auto numberAt = [&](std::size_t back) {
    return parts.size() >= back ? numberFromText(parts[parts.size() - back]) : std::nullopt;
  };
  const std::optional<double> low = numberAt(2), high = numberAt(1);
  // Six digits may be a colour.
  const bool isCode = parts.size() == 1 && parts[0].size() == 6;
  if (!high) {
    if (low) reader.refuse("colour", "with two numbers at its end, LOW:HIGH, such as trap:inferno:0.1:0.9");
    return std::nullopt;
  }
  if (!low && isCode) return std::nullopt;
  if (!low) reader.refuse("colour", "with two numbers at its end, LOW:HIGH, such as trap:inferno:0.1:0.9");
  if (!std::isfinite(*low) || !std::isfinite(*high) || !(*low < *high) || !std::isfinite(*high - *low))
    reader.refuse("colour", "with a range LOW:HIGH from a lower to a higher number, such as trap:inferno:0.1:0.9");
  parts.resize(parts.size() - 2);
  return GradientRange{*low, *high};
}

}  // namespace

std::optional<ColourChoice> parseColour(const RecipeReader& reader) {
  if (!reader.has("colour")) return std::nullopt;
  std::vector<std::string> parts = split(reader.text("colour"), ':');
  const std::string name = parts.front();
  parts.erase(parts.begin());
  const auto kind = colourKinds().find(name);
  if (kind == colourKinds().end() || (name == "gradient" && parts.empty())) {
    std::vector<std::string> names;
    for (const auto& [each, unused] : colourKinds()) names.push_back(each);
    reader.refuse("colour",
                  "direction, versor, clay, or trap, iterations or depth, behind which :GRADIENT and :LOW:HIGH may "
                  "stand, such as trap:magma or trap:magma:0.1:0.9" +
                      (kind == colourKinds().end() ? didYouMean(name, names) : ""));
  }
  ColourChoice choice{.by = kind->second};
  if (parts.empty()) return choice;
  if (choice.by == FieldColour::Direction || choice.by == FieldColour::Versor || choice.by == FieldColour::Clay)
    reader.refuse("colour", "'" + name + "' without a gradient, as it has colours of its own");
  choice.range = takeRange(reader, parts);
  if (parts.empty()) return choice;
  // File names may contain colons.
  for (const std::string& part : parts) choice.gradient += (&part == &parts.front() ? "" : ":") + part;
  if (Gradient::named(choice.gradient) || Gradient::ofCodes(choice.gradient)) return choice;
  if (lowerExtension(choice.gradient).empty())
    reader.refuse("colour", "'" + name + ":' and one of " + joined(gradientNames()) +
                                ", a list of two colours or more such as 000000,ff8800,ffffff, or the name of a "
                                "picture" +
                                didYouMean(choice.gradient, gradientNames()));
  choice.picture = reader.file("colour", choice.gradient);
  return choice;
}

FieldColouring colouringOf(const ColourChoice& choice) {
  FieldColouring colouring(choice.by);
  colouring.range = choice.range;
  if (choice.picture)
    colouring.gradient = rowOf(choice.picture->path);
  else if (const std::optional<Gradient> own = Gradient::ofCodes(choice.gradient))
    colouring.gradient = *own;
  else if (!choice.gradient.empty())
    colouring.gradient = Gradient::named(choice.gradient).value();
  return colouring;
}

}  // namespace vdbtools
