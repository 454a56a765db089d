// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/picture/slice_image.h"

#include "support/limits.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

using openvdb::BBoxd;
using openvdb::Vec3d;
using openvdb::Vec3s;
using vdbtools::Axis;
using vdbtools::Image;
using vdbtools::SlicePlane;

namespace {

using test_limits::kFloatInfinity;
using test_limits::kFloatNan;
using vdbtools::Colour;

const BBoxd kUnitBox(Vec3d(-1), Vec3d(1));

Vec3d sign(const Vec3d& v) {
  const auto of = [](double c) { return std::abs(c) < 1e-12 ? 0.0 : std::copysign(1.0, c); };
  return {of(v[0]), of(v[1]), of(v[2])};
}

float luminance(const Colour& c) { return 0.2126F * c[0] + 0.7152F * c[1] + 0.0722F * c[2]; }

/// CIE L*a*b* under D65, as a yardstick that the implementation does not use.
Vec3d cieLab(const Colour& c) {
  const double x = (0.4124 * c[0] + 0.3576 * c[1] + 0.1805 * c[2]) / 0.9505;
  const double y = 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];
  const double z = (0.0193 * c[0] + 0.1192 * c[1] + 0.9505 * c[2]) / 1.0890;
  const auto f = [](double t) { return t > 0.008856 ? std::cbrt(t) : 7.787 * t + 16.0 / 116; };
  return {116 * f(y) - 16, 500 * (f(x) - f(y)), 200 * (f(y) - f(z))};
}

/// One row of the given values, free of zero crossings between neighbours of the same sign.
Image row(const std::vector<float>& values, double range) {
  const SlicePlane plane(Axis::Z, 0, BBoxd(Vec3d(0), Vec3d(double(values.size()), 1, 1)), int(values.size()));
  EXPECT_EQ(plane.height(), 1);
  return signedSlice(plane, values, range);
}

TEST(SlicePlane, LooksDownTheAxisRightHandedly) {
  struct Case {
    Axis axis;
    Vec3d right, up;
  };
  for (const Case& c : {Case{Axis::X, {0, 0, -1}, {0, 1, 0}}, Case{Axis::Y, {1, 0, 0}, {0, 0, -1}},
                        Case{Axis::Z, {1, 0, 0}, {0, 1, 0}}}) {
    const int a = static_cast<int>(c.axis);
    const SlicePlane plane(c.axis, 0.25, kUnitBox, 10);
    EXPECT_EQ(sign(plane.position(1, 0) - plane.position(0, 0)), c.right) << "axis " << a;
    EXPECT_EQ(sign(plane.position(0, 0) - plane.position(0, 1)), c.up) << "axis " << a;
    Vec3d towardsViewer(0);
    towardsViewer[a] = 1;
    EXPECT_EQ(c.right.cross(c.up), towardsViewer) << "axis " << a;
    for (int y = 0; y < plane.height(); ++y) {
      for (int x = 0; x < plane.width(); ++x) EXPECT_EQ(plane.position(x, y)[a], 0.25);
    }
  }
}

TEST(SlicePlane, FramesTheBoxWithSquarePixels) {
  const BBoxd box(Vec3d(1, 2, 3), Vec3d(5, 4, 4));  // 4 x 2 x 1
  struct Case {
    Axis axis;
    int width, height;
  };
  for (const Case& c : {Case{Axis::Z, 100, 50}, Case{Axis::Y, 100, 25}, Case{Axis::X, 50, 100}}) {
    const SlicePlane plane(c.axis, 3.5, box, 100);
    EXPECT_EQ(plane.width(), c.width) << "axis " << int(c.axis);
    EXPECT_EQ(plane.height(), c.height) << "axis " << int(c.axis);
    const double across = (plane.position(1, 0) - plane.position(0, 0)).length();
    EXPECT_NEAR(across, (plane.position(0, 1) - plane.position(0, 0)).length(), 1e-12);
    // The centres of opposite corners are half a pixel within the box.
    Vec3d middle = 0.5 * (plane.position(0, 0) + plane.position(c.width - 1, c.height - 1));
    Vec3d expected = 0.5 * (box.min() + box.max());
    expected[int(c.axis)] = 3.5;
    EXPECT_NEAR((middle - expected).length(), 0, 1e-12);
  }
  const SlicePlane plane(Axis::Z, 0, box, 4);
  EXPECT_TRUE(plane.position(0, 0).eq(Vec3d(1.5, 3.5, 0), 1e-12)) << plane.position(0, 0);
}

TEST(SlicePlane, CoversTheShorterSideWhole) {
  const SlicePlane plane(Axis::Z, 0, BBoxd(Vec3d(0), Vec3d(10, 3.1, 1)), 10);
  EXPECT_EQ(plane.height(), 4);
  const SlicePlane line(Axis::Z, 0, BBoxd(Vec3d(0), Vec3d(10, 0, 1)), 10);
  EXPECT_EQ(line.height(), 1);
}

TEST(SlicePlane, RefusesWhatItCannotFrame) {
  EXPECT_THROW(SlicePlane(Axis::Z, 0, kUnitBox, 0), std::invalid_argument);
  EXPECT_THROW(SlicePlane(Axis::Z, 0, kUnitBox, -3), std::invalid_argument);
  EXPECT_THROW(SlicePlane(Axis::Z, 0, BBoxd(), 10), std::invalid_argument);
  EXPECT_THROW(SlicePlane(Axis::Z, 0, BBoxd(Vec3d(2), Vec3d(2)), 10), std::invalid_argument);
  EXPECT_THROW(SlicePlane(Axis::Z, 0, BBoxd(Vec3d(0), Vec3d(0, 0, 5)), 10), std::invalid_argument);
  EXPECT_THROW(SlicePlane(Axis::Z, 0, BBoxd(Vec3d(0), Vec3d(kFloatInfinity, 1, 1)), 10), std::invalid_argument);
  EXPECT_THROW(SlicePlane(Axis::Z, kFloatNan, kUnitBox, 10), std::invalid_argument);
}

TEST(SlicePlane, OneValueForEachPixel) {
  const SlicePlane plane(Axis::Y, 0, kUnitBox, 4);
  const std::vector<float> values(15);
  const std::vector<Vec3s> versors(17);
  EXPECT_THROW(vdbtools::signedSlice(plane, values, 1), std::invalid_argument);
  EXPECT_THROW(vdbtools::membershipSlice(plane, values), std::invalid_argument);
  EXPECT_THROW(vdbtools::versorSlice(plane, versors), std::invalid_argument);
  EXPECT_THROW(vdbtools::signedSlice(plane, std::vector<float>(16), kFloatNan), std::invalid_argument);
}

TEST(SignedSlice, BlueInsideWhiteAtZeroRedOutside) {
  const Image inside = row({-1.0F, -0.5F, -0.25F}, 1);
  for (const Colour& c : inside.pixels) EXPECT_GT(c[2], 1.2F * c[0]);
  const Image outside = row({0.0F, 0.5F, 1.0F}, 1);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(outside.at(0, 0)[i], 1, 1e-3);
  for (int x : {1, 2}) EXPECT_GT(outside.at(x, 0)[0], 1.2F * outside.at(x, 0)[2]);
}

TEST(SignedSlice, ColoursAreEvenAndSymmetricInLightness) {
  constexpr int kSteps = 16;
  std::vector<float> values;
  for (int i = 0; i <= kSteps; ++i) values.push_back(i / float(kSteps));
  const Image outside = row(values, 1);
  for (float& v : values) v = -v;  // -0 is not inside
  const Image inside = row(values, 1);

  for (const Image& side : {outside, inside}) {
    // Pixel 0 of the inside is a piece of the zero line.
    const double whole = (cieLab(side.at(kSteps, 0)) - cieLab(side.at(1, 0))).length() / (kSteps - 1);
    for (int i = 2; i <= kSteps; ++i) {
      EXPECT_LT(luminance(side.at(i, 0)), luminance(side.at(i - 1, 0)));
      const double step = (cieLab(side.at(i, 0)) - cieLab(side.at(i - 1, 0))).length();
      EXPECT_NEAR(step / whole, 1, 0.35) << "step " << i;
    }
  }
  for (int i = 1; i <= kSteps; ++i) {
    EXPECT_NEAR(cieLab(inside.at(i, 0))[0], cieLab(outside.at(i, 0))[0], 5) << "step " << i;
    for (const float channel : inside.at(i, 0)) EXPECT_GT(channel, 0) << "outside the gamut at step " << i;
    for (const float channel : outside.at(i, 0)) EXPECT_GT(channel, 0) << "outside the gamut at step " << i;
  }
}

TEST(SignedSlice, ClampsBeyondTheRange) {
  const Image image = row({2.0F, 5.0F, 1e30F, kFloatInfinity}, 2);
  for (int x = 1; x < 4; ++x) EXPECT_EQ(image.at(x, 0), image.at(0, 0));
  const Image inside = row({-2.0F, -kFloatInfinity}, 2);
  EXPECT_EQ(inside.at(0, 0), inside.at(1, 0));
}

TEST(SignedSlice, AutomaticRangeIsThe95thPercentile) {
  std::vector<float> values(101);
  for (int i = 0; i <= 100; ++i) values[i] = float(i);
  values[100] = 1e20F;
  EXPECT_EQ(row(values, 0).pixels, row(values, 95).pixels);
  EXPECT_EQ(row(values, -1).pixels, row(values, 95).pixels);
  // Almost all 0: the largest is taken; all 0 or nothing finite: white, and no division by 0.
  std::vector<float> sparse(101, 0.0F);
  sparse[7] = 3;
  EXPECT_EQ(row(sparse, 0).pixels, row(sparse, 3).pixels);
  for (const Colour& c : row(std::vector<float>(5, 0.0F), 0).pixels) EXPECT_NEAR(luminance(c), 1, 1e-3);
  for (const Colour& c : row({kFloatInfinity, kFloatNan, kFloatInfinity}, 0).pixels)
    EXPECT_TRUE(std::isfinite(luminance(c)));
}

TEST(SignedSlice, DrawsTheZeroSetOnce) {
  const int n = 101;
  const SlicePlane plane(Axis::Z, 0, kUnitBox, n);
  std::vector<float> values;
  for (int y = 0; y < n; ++y) {
    for (int x = 0; x < n; ++x) values.push_back(float(plane.position(x, y).length() - 0.7));
  }
  const Image image = vdbtools::signedSlice(plane, values, 1);
  int line = 0;
  for (int y = 0; y < n; ++y) {
    for (int x = 0; x < n; ++x) {
      const double distance = std::abs(plane.position(x, y).length() - 0.7);
      const bool dark = luminance(image.at(x, y)) < 0.05F;
      line += dark;
      EXPECT_TRUE(!dark || distance < 2 * 2.0 / n) << x << ' ' << y;
    }
  }
  // A digital circle of radius r has about 4 sqrt(2) r pixels, a thicker one up to 8 r.
  const double radius = 0.7 * n / 2;
  EXPECT_GT(line, 5 * radius);
  EXPECT_LT(line, 8.5 * radius);
}

TEST(SignedSlice, NaNIsGreyAndHasNoSign) {
  const Image image = row({1.0F, kFloatNan, -1.0F, -1.0F}, 1);
  EXPECT_EQ(image.at(1, 0)[0], image.at(1, 0)[2]);
  EXPECT_GT(luminance(image.at(0, 0)), 0.05F);
  EXPECT_GT(luminance(image.at(1, 0)), 0.05F);
}

TEST(MembershipSlice, BlackInside) {
  const SlicePlane plane(Axis::Z, 0, BBoxd(Vec3d(0), Vec3d(4, 1, 1)), 4);
  const Image image = vdbtools::membershipSlice(plane, std::vector<float>{-1.0F, -kFloatInfinity, 0.0F, kFloatNan});
  const std::vector<float> expected = {0, 0, 1, 1};
  for (int x = 0; x < 4; ++x) EXPECT_EQ(luminance(image.at(x, 0)), expected[x]) << x;
}

TEST(CountSlice, WhiteAtNoneBlackAtMost) {
  const SlicePlane plane(Axis::Z, 0, BBoxd(Vec3d(0), Vec3d(4, 1, 1)), 4);
  const std::vector<int> counts{0, 3, 6, 9};
  const Image image = vdbtools::countSlice(plane, counts, 6);
  EXPECT_EQ(image.at(0, 0), (Colour{1, 1, 1}));
  EXPECT_NEAR(image.at(1, 0)[0], 0.214, 1e-3);  // the middle of sRGB
  EXPECT_EQ(image.at(2, 0), (Colour{0, 0, 0}));
  EXPECT_EQ(image.at(3, 0), (Colour{0, 0, 0}));
  EXPECT_THROW(vdbtools::countSlice(plane, counts, 0), std::invalid_argument);
}

TEST(VersorSlice, ComponentsBecomeSrgb) {
  const SlicePlane plane(Axis::Z, 0, BBoxd(Vec3d(0), Vec3d(2, 1, 1)), 2);
  const Image image = vdbtools::versorSlice(plane, std::vector<Vec3s>{{-1, 0, 1}, {2, -2, 0.5F}});
  EXPECT_EQ(image.at(0, 0)[0], 0);
  EXPECT_NEAR(image.at(0, 0)[1], 0.21404F, 1e-4F);  // the linear light of the sRGB value one half
  EXPECT_EQ(image.at(0, 0)[2], 1);
  EXPECT_EQ(image.at(1, 0)[0], 1);
  EXPECT_EQ(image.at(1, 0)[1], 0);
  EXPECT_NEAR(image.at(1, 0)[2], 0.52252F, 1e-4F);
}

TEST(SlicePlane, ProjectsToTheCentresOfItsPixels) {
  for (const Axis axis : {Axis::X, Axis::Y, Axis::Z}) {
    const SlicePlane plane(axis, 0.25, BBoxd(Vec3d(-1, -2, -3), Vec3d(2, 1, 4)), 40);
    for (const auto& [x, y] : {std::pair{0, 0}, {7, 3}, {plane.width() - 1, plane.height() - 1}}) {
      Vec3d position = plane.position(x, y);
      position[static_cast<int>(axis)] += 5;  // off the plane
      const vdbtools::CanvasPoint point = plane.project(position);
      EXPECT_NEAR(point.x, x + 0.5, 1e-9);
      EXPECT_NEAR(point.y, y + 0.5, 1e-9);
    }
  }
}

TEST(SlicePlane, CutsABallInItsCircle) {
  const SlicePlane plane(Axis::Y, 1, kUnitBox, 20);  // 10 pixels a unit
  EXPECT_NEAR(plane.circle({0.3, 1, -0.2}, 0.5), 5, 1e-9);
  EXPECT_NEAR(plane.circle({0, 4, 0}, 5), 40, 1e-9);
  EXPECT_EQ(plane.circle({0, 4, 0}, 2), 0);
}

TEST(SliceArrows, LieBetweenTheirEndsAndOnTheCircle) {
  const SlicePlane plane(Axis::Z, 0, kUnitBox, 100);  // 50 pixels a unit
  const Colour grey{0.2F, 0.2F, 0.2F};
  Image field(100, 100);
  std::fill(field.pixels.begin(), field.pixels.end(), grey);
  for (const bool inside : {true, false}) {
    const vdbtools::SliceArrow arrow{
        .from = {-0.5, 0.5, 0}, .to = {0.3, -0.4, 0}, .centre = {0, 0, 0}, .radius = 0.5, .inside = inside};
    const Image drawn = withArrows(plane, field, {&arrow, 1});
    const Colour colour = inside ? Colour{1, 1, 1} : Colour{0, 0, 0};
    EXPECT_EQ(drawn.at(25, 25), colour);                                // its start
    EXPECT_EQ(drawn.at(44, 46), colour);                                // on the way
    EXPECT_EQ(drawn.at(63, 67), colour);                                // inside the head
    for (const auto& [x, y] : {std::pair{50, 25}, {25, 50}, {74, 50}})  // the circle, half a pixel from each
      EXPECT_NE(drawn.at(x, y), drawn.at(5, 5)) << x << ' ' << y;
    EXPECT_NEAR(drawn.at(5, 5)[0], grey[0], 0.01);
    EXPECT_NEAR(drawn.at(90, 90)[0], grey[0], 0.01);
  }
}

}  // namespace
