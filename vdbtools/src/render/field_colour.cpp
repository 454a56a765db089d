// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/render/field_colour.h"

#include "base/elementary.h"
#include "base/srgb.h"
#include "formats/picture_file.h"
#include "render/neighbourhood.h"
#include "render/view.h"

#include "vdbtools/files/file_bytes.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

namespace vdbtools {
namespace {

using openvdb::Vec3d;
using openvdb::Vec3s;

/// The saturation of the colours of directions: less than that of [ZB25], where full saturation hides the shape.
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

/// The first row of a picture.
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

std::vector<Vec3d> fieldColours(const FieldColouring& colouring, const julia::FieldEvaluator& evaluator,
                                const ColourContext& context, std::span<const julia::Point> points,
                                std::span<const double> iterations) {
  std::vector<Vec3d> result(points.size(), kClay);
  const auto through = [&](std::span<const double> numbers, double low, double high) {
    for (std::size_t i = 0; i < result.size(); ++i)
      result[i] = colouring.gradient.at((numbers[i] - low) / (high - low));
  };
  switch (colouring.by) {
    case FieldColour::Clay: break;
    case FieldColour::Iterations: through(iterations, 0, context.maxIterations); break;
    case FieldColour::Trap: through(trapRadii(evaluator, points), 0, 1); break;
    case FieldColour::Depth: {
      if (!colouring.depth) throw std::logic_error("colours by depth need the target's distances");
      through(depthsOf(*colouring.depth, points), colouring.depth->low, colouring.depth->high);
      break;
    }
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
  std::vector<julia::Point> around;
  around.reserve(kNeighbours * points.size());
  for (const julia::Point& point : points) addNeighbours({point[0], point[1], point[2]}, step, around);
  std::vector<double> field(around.size());
  std::vector<int> iterations(around.size());
  evaluator.evaluate(around, field, iterations);
  std::vector<double> result;
  result.reserve(points.size());
  for (std::size_t i = 0; i < around.size(); i += kNeighbours)
    result.push_back(
        meanIterationsOutside(std::span(field).subspan(i, kNeighbours), std::span(iterations).subspan(i, kNeighbours)));
  return result;
}

OptionSpec colourOptionSpec() {
  return {.name = "colour",
          .argument = "WHAT[:GRADIENT]",
          .help =
              "colours, in pictures of the set and as Cd in files: direction (of the first step, as RGB), versor, "
              "clay, or trap, iterations or depth through a gradient: one of " +
              gradientNames() + ", or the first row of a picture. gradient:NAME is trap:NAME",
          .defaultNote = "direction; contact sheets: clay",
          .hash = "colour-sha256"};
}

std::optional<ColourChoice> parseColour(const RecipeReader& reader) {
  if (!reader.has("colour")) return std::nullopt;
  static const std::map<std::string, FieldColour> kKinds = {
      {"direction", FieldColour::Direction}, {"versor", FieldColour::Versor}, {"clay", FieldColour::Clay},
      {"trap", FieldColour::Trap},           {"depth", FieldColour::Depth},   {"iterations", FieldColour::Iterations},
      {"gradient", FieldColour::Trap}};
  const std::string text = reader.text("colour");
  const std::size_t colon = text.find(':');
  const std::string name = text.substr(0, colon);
  const auto kind = kKinds.find(name);
  if (kind == kKinds.end() || (name == "gradient" && colon == std::string::npos))
    reader.refuse("colour",
                  "direction, versor, clay, or trap, iterations or depth, behind which :GRADIENT may stand, such as "
                  "trap:magma");
  ColourChoice choice{.by = kind->second};
  if (colon == std::string::npos) return choice;
  if (choice.by == FieldColour::Direction || choice.by == FieldColour::Versor || choice.by == FieldColour::Clay)
    reader.refuse("colour", "'" + name + "' without a gradient, as it has colours of its own");
  choice.gradient = text.substr(colon + 1);
  if (Gradient::named(choice.gradient)) return choice;
  if (lowerExtension(choice.gradient).empty())
    reader.refuse("colour", "'" + name + ":' and one of " + gradientNames() + ", or the name of a picture");
  choice.picture = reader.file("colour", choice.gradient);
  return choice;
}

FieldColouring colouringOf(const ColourChoice& choice) {
  FieldColouring colouring(choice.by);
  if (choice.picture)
    colouring.gradient = rowOf(choice.picture->path);
  else if (!choice.gradient.empty())
    colouring.gradient = Gradient::named(choice.gradient).value();
  return colouring;
}

}  // namespace vdbtools
