// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/picture/slice_image.h"

#include "base/elementary.h"
#include "base/srgb.h"
#include "vdbtools/base/memory.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

namespace vdbtools {
namespace {

/// A colour of Oklab (B. Ottosson, "A perceptual color space for image processing", 2020), where equal distances look
/// approximately equal.
struct Oklab {
  float lightness, a, b;
};

constexpr Colour kBlack{0, 0, 0};
constexpr Colour kPaper{1, 1, 1};
constexpr Colour kZeroLine{0.01F, 0.01F, 0.01F};
constexpr Colour kUndefined{0.214F, 0.214F, 0.214F};  ///< middle grey for NaN

// The ends differ from the middle by the same lightness and the same chroma, at the hues 257 and 27 degrees; the
// straight lines between them stay inside the gamut of sRGB.
constexpr Oklab kMiddle{1.0F, 0, 0};
constexpr Oklab kInside{0.44F, -0.0315F, -0.1364F};
constexpr Oklab kOutside{0.44F, 0.1247F, 0.0636F};

Colour toLinearRgb(const Oklab& c) {
  const auto cube = [](float v) { return v * v * v; };
  const float l = cube(c.lightness + 0.3963377774F * c.a + 0.2158037573F * c.b);
  const float m = cube(c.lightness - 0.1055613458F * c.a - 0.0638541728F * c.b);
  const float s = cube(c.lightness - 0.0894841775F * c.a - 1.2914855480F * c.b);
  const auto clamped = [](float v) { return std::clamp(v, 0.0F, 1.0F); };
  return {clamped(4.0767416621F * l - 3.3077115913F * m + 0.2309699292F * s),
          clamped(-1.2684380046F * l + 2.6097574011F * m - 0.3413193965F * s),
          clamped(-0.0041960863F * l - 0.7034186147F * m + 1.7076147010F * s)};
}

/// @param t  in [-1, 1], negative inside
Colour divergingColour(float t) {
  const Oklab& end = t < 0 ? kInside : kOutside;
  const float w = std::abs(t);
  return toLinearRgb({kMiddle.lightness + w * (end.lightness - kMiddle.lightness), w * end.a, w * end.b});
}

/// Draws lines of arrows and circles, each on a wider line of the contrasting colour, so that they are visible on any
/// field.
void outlined(Canvas& canvas, std::span<const CanvasPoint> points, bool inside, double width) {
  canvas.line(points, {inside ? kBlack : kPaper, width + 2});
  canvas.line(points, {inside ? kPaper : kBlack, width});
}

void drawCircle(Canvas& canvas, const CanvasPoint& centre, double radius, bool inside) {
  constexpr int kSides = 180;
  std::vector<CanvasPoint> points;
  for (int i = 0; i <= kSides; ++i) {
    const double angle = 2 * std::numbers::pi * (i % kSides) / kSides;
    points.push_back({centre.x + radius * elementary::cos(angle), centre.y + radius * elementary::sin(angle)});
  }
  outlined(canvas, points, inside, 1);
}

/// Cairo draws no line beyond 32768 pixels.
constexpr double kFarthest = 2e4;

void drawArrow(Canvas& canvas, const CanvasPoint& from, CanvasPoint to, bool inside) {
  constexpr double kHead = 9, kHalfHead = 0.45, kDot = 7, kShaft = 2;  // pixels; kHalfHead is a slope
  const double x = to.x - from.x, y = to.y - from.y, length = std::sqrt(x * x + y * y);
  if (!(length > 1)) return outlined(canvas, {&from, 1}, inside, kDot);
  const double dx = x / length, dy = y / length, head = std::min(kHead, length);
  if (length > kFarthest) to = {from.x + kFarthest * dx, from.y + kFarthest * dy};
  const CanvasPoint foot{to.x - head * dx, to.y - head * dy};
  const double side = kHalfHead * head;
  const std::array shaft{from, foot};
  const std::array tip{CanvasPoint{foot.x - side * dy, foot.y + side * dx}, to,
                       CanvasPoint{foot.x + side * dy, foot.y - side * dx},
                       CanvasPoint{foot.x - side * dy, foot.y + side * dx}};
  outlined(canvas, shaft, inside, kShaft);
  outlined(canvas, tip, inside, 1);
  canvas.fill(tip, inside ? kPaper : kBlack);
  outlined(canvas, {&from, 1}, inside, kDot);
}

void requireSize(const SlicePlane& plane, std::size_t size) {
  const std::size_t expected = static_cast<std::size_t>(plane.width()) * static_cast<std::size_t>(plane.height());
  if (size != expected) {
    throw std::invalid_argument("a slice of " + std::to_string(plane.width()) + " x " + std::to_string(plane.height()) +
                                " pixels needs " + std::to_string(expected) + " values, not " + std::to_string(size));
  }
}

/// The 95th percentile of the magnitudes, so that a few huge values do not dominate. If that is 0, the largest
/// magnitude; if that is 0 too, 1.
float automaticRange(std::span<const float> values) {
  constexpr double kPercentile = 0.95;
  std::vector<float> magnitudes;
  magnitudes.reserve(values.size());
  for (const float v : values) {
    if (std::isfinite(v)) magnitudes.push_back(std::abs(v));
  }
  if (magnitudes.empty()) return 1;
  const auto rank = static_cast<std::ptrdiff_t>(kPercentile * static_cast<double>(magnitudes.size() - 1));
  std::nth_element(magnitudes.begin(), magnitudes.begin() + rank, magnitudes.end());
  if (magnitudes[rank] > 0) return magnitudes[rank];
  const float largest = *std::max_element(magnitudes.begin(), magnitudes.end());
  return largest > 0 ? largest : 1;
}

}  // namespace

SlicePlane::SlicePlane(Axis axis, double position, const openvdb::BBoxd& box, int longestSide) {
  if (longestSide < 1) {
    throw std::invalid_argument("a slice needs a longest side of at least 1 pixel, not " + std::to_string(longestSide));
  }
  if (!std::isfinite(position)) throw std::invalid_argument("the position of a slice must be finite");

  openvdb::Vec3d right(0), down(0);
  switch (axis) {
    case Axis::X: right = {0, 0, -1}, down = {0, -1, 0}; break;
    case Axis::Y: right = {1, 0, 0}, down = {0, 0, 1}; break;
    case Axis::Z: right = {1, 0, 0}, down = {0, -1, 0}; break;
    default: throw std::invalid_argument("the axis of a slice is X, Y or Z");
  }
  const openvdb::Vec3d extents = box.max() - box.min();
  const double across = std::abs(extents.dot(right)), along = std::abs(extents.dot(down));
  const double longest = std::max(across, along);
  // Written so that a NaN fails too.
  if (!(extents[0] >= 0 && extents[1] >= 0 && extents[2] >= 0 && longest > 0 && std::isfinite(longest))) {
    throw std::invalid_argument("the box of a slice has no extent in its plane");
  }

  const double pixel = longest / longestSide;
  // The shorter side must be covered completely, but a rounding error must not add a row.
  constexpr double kRounding = 1e-9;
  const auto pixels = [&](double extent) {
    return std::clamp(static_cast<int>(std::ceil(extent / pixel - kRounding * longestSide)), 1, longestSide);
  };
  mWidth = pixels(across);
  mHeight = pixels(along);
  // A value, a colour as floats, and codes for the file.
  constexpr double kBytesOfPixel = 19;
  requireMemory(kBytesOfPixel * mWidth * mHeight, MemoryUse::Picture,
                "a picture of " + std::to_string(mWidth) + " x " + std::to_string(mHeight) + " pixels");
  mRight = right * pixel;
  mDown = down * pixel;
  openvdb::Vec3d centre = (box.min() + box.max()) * 0.5;
  centre[static_cast<int>(axis)] = position;
  mTopLeft = centre - mRight * (0.5 * (mWidth - 1)) - mDown * (0.5 * (mHeight - 1));
}

openvdb::Vec3d SlicePlane::position(int x, int y) const { return mTopLeft + mRight * x + mDown * y; }

CanvasPoint SlicePlane::project(const openvdb::Vec3d& world) const {
  const openvdb::Vec3d offset = world - mTopLeft;
  return {0.5 + offset.dot(mRight) / mRight.lengthSqr(), 0.5 + offset.dot(mDown) / mDown.lengthSqr()};
}

double SlicePlane::circle(const openvdb::Vec3d& centre, double radius) const {
  const double height = (centre - mTopLeft).dot(mRight.cross(mDown).unit());
  return std::sqrt(std::max(0.0, radius * radius - height * height)) / mRight.length();
}

Image signedSlice(const SlicePlane& plane, std::span<const float> values, double range) {
  requireSize(plane, values.size());
  if (!std::isfinite(range)) throw std::invalid_argument("the range of a slice must be finite; 0 chooses one");
  const float largest = range > 0 ? static_cast<float>(range) : automaticRange(values);

  Image image(plane.width(), plane.height());
  const auto value = [&](int x, int y) { return values[static_cast<std::size_t>(y) * plane.width() + x]; };
  const auto signsDiffer = [](float u, float v) { return !std::isnan(u) && !std::isnan(v) && (u < 0) != (v < 0); };
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const float v = value(x, y);
      const bool onZeroSet = (x + 1 < image.width && signsDiffer(v, value(x + 1, y))) ||
                             (y + 1 < image.height && signsDiffer(v, value(x, y + 1)));
      image.at(x, y) = std::isnan(v) ? kUndefined
                       : onZeroSet   ? kZeroLine
                                     : divergingColour(std::clamp(v / largest, -1.0F, 1.0F));
    }
  }
  return image;
}

Image membershipSlice(const SlicePlane& plane, std::span<const float> values) {
  requireSize(plane, values.size());
  Image image(plane.width(), plane.height());
  std::transform(values.begin(), values.end(), image.pixels.begin(), [](float v) { return v < 0 ? kBlack : kPaper; });
  return image;
}

Image countSlice(const SlicePlane& plane, std::span<const int> counts, int most) {
  requireSize(plane, counts.size());
  if (most < 1)
    throw std::invalid_argument("the largest count of a slice is " + std::to_string(most) + "; it must be 1 or more");
  Image image(plane.width(), plane.height());
  std::transform(counts.begin(), counts.end(), image.pixels.begin(), [&](int count) {
    const float share = static_cast<float>(count) / static_cast<float>(most);
    const float grey = linearFromSrgb(1 - std::clamp(share, 0.0F, 1.0F));
    return Colour{grey, grey, grey};
  });
  return image;
}

Image versorSlice(const SlicePlane& plane, std::span<const openvdb::Vec3s> versors) {
  requireSize(plane, versors.size());
  Image image(plane.width(), plane.height());
  // The paper's RGB is what the screen shows, i.e. sRGB, while an Image is linear.
  const auto channel = [](float v) { return linearFromSrgb(std::clamp(0.5F * (v + 1), 0.0F, 1.0F)); };
  std::transform(versors.begin(), versors.end(), image.pixels.begin(), [&](const openvdb::Vec3s& v) {
    return Colour{channel(v[0]), channel(v[1]), channel(v[2])};
  });
  return image;
}

Image withArrows(const SlicePlane& plane, const Image& image, std::span<const SliceArrow> arrows) {
  Canvas canvas(CanvasKind::Pixels, image.width, image.height);
  canvas.image(image, 0, 0);
  for (const SliceArrow& arrow : arrows) {
    if (const double radius = plane.circle(arrow.centre, arrow.radius); radius > 0 && radius < kFarthest)
      drawCircle(canvas, plane.project(arrow.centre), radius, arrow.inside);
  }
  for (const SliceArrow& arrow : arrows)
    drawArrow(canvas, plane.project(arrow.from), plane.project(arrow.to), arrow.inside);
  return canvas.pixels();
}

}  // namespace vdbtools
