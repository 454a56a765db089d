// SPDX-License-Identifier: Apache-2.0
// Gradients: lightness is what they are chosen for.
#include "vdbtools/picture/gradient.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <stdexcept>

namespace {

using namespace vdbtools;
using openvdb::Vec3d;

/// L* of CIE 1976, from linear RGB.
double lightness(const Vec3d& rgb) {
  const double y = 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
  return y > 216.0 / 24389 ? 116 * std::cbrt(y) - 16 : y * 24389 / 27;
}

TEST(Gradient, SequentialOnesGetLighterAtAnEvenRate) {
  for (const char* name : {"viridis", "magma", "inferno", "cividis"}) {
    const Gradient gradient = Gradient::named(name).value();
    const double first = lightness(gradient.at(0)), last = lightness(gradient.at(1));
    EXPECT_GT(last, first + 60) << name;
    double before = -1;
    for (int i = 0; i <= 100; ++i) {
      const double v = i / 100.0, light = lightness(gradient.at(v));
      EXPECT_GT(light, before) << name << " at " << v;
      // They are even in the lightness of CAM02, which is not quite that of CIE 1976.
      EXPECT_NEAR(light, first + v * (last - first), 6) << name << " at " << v;
      before = light;
    }
  }
}

TEST(Gradient, TheDivergingOneIsLightestInTheMiddleAndAlikeOnBothSides) {
  const Gradient gradient = Gradient::named("coolwarm").value();
  double before = 0;
  for (int i = 0; i <= 50; ++i) {
    const double v = i / 100.0, cool = lightness(gradient.at(v));
    EXPECT_GT(cool, before);
    EXPECT_NEAR(cool, lightness(gradient.at(1 - v)), 4) << v;
    before = cool;
  }
  EXPECT_GT(gradient.at(0)[2], gradient.at(0)[0]);
  EXPECT_GT(gradient.at(1)[0], gradient.at(1)[2]);
}

TEST(Gradient, AListOfCodesIsARamp) {
  for (const char* list : {"ff0000,00ff00,0000ff", "#FF0000,#00FF00,#0000FF"}) {
    const Gradient ramp = Gradient::ofCodes(list).value();
    EXPECT_EQ(ramp.at(0), Vec3d(1, 0, 0)) << list;
    EXPECT_EQ(ramp.at(0.5), Vec3d(0, 1, 0)) << list;
    EXPECT_EQ(ramp.at(1), Vec3d(0, 0, 1)) << list;
  }
  for (const char* none : {"", ",", "ff0000", "ff0000,", "ff0000,00ff0", "ff0000,00ff000", "ff0000,-0ff00", "magma",
                           "ff0000,00ff00,", "##ff0000,00ff00", "0xff00,00ff00", "ff0000 ,00ff00"})
    EXPECT_FALSE(Gradient::ofCodes(none)) << none;
}

TEST(Gradient, InterpolatesCodesAndHoldsItsEnds) {
  const Gradient grey = Gradient::named("grey").value();
  for (int c = 0; c < 3; ++c) {
    EXPECT_EQ(grey.at(0)[c], 0);
    EXPECT_NEAR(grey.at(1)[c], 1, 1e-12);
    EXPECT_NEAR(grey.at(0.5)[c], 0.21404, 1e-5);  // the code 0.5 of sRGB as linear light
  }
  const Gradient viridis;
  EXPECT_EQ(viridis.at(-3), viridis.at(0));
  EXPECT_EQ(viridis.at(7), viridis.at(1));
  EXPECT_EQ(viridis.at(std::numeric_limits<double>::quiet_NaN()), viridis.at(0));
  EXPECT_EQ(viridis.at(0.3), Gradient::named("viridis")->at(0.3));
  const Gradient one({{1, 0, 0}});
  EXPECT_EQ(one.at(0.7), Vec3d(1, 0, 0));
  EXPECT_FALSE(Gradient::named("jet"));
  EXPECT_THROW(Gradient(std::vector<Gradient::Stop>()), std::invalid_argument);
}

}  // namespace
