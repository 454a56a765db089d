// SPDX-License-Identifier: Apache-2.0
// Numbers as people read them: short, near, and on the right side of what they bound.
#include "vdbtools/base/text.h"

#include "base/counter_random.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace {

using namespace vdbtools;

// Promise: "Messages have numbers of four ..."
TEST(NumberText, ShortNumbersAreNearAndBoundsHold) {
  for (std::size_t i = 0; i < 20000; ++i) {
    const double size = std::pow(10, 40 * randomUnit(1, 0, i) - 20), value = i % 2 == 0 ? size : -size;
    const double nearest = numberFromText(shortText(value)).value(),
                 above = numberFromText(shortText(value, Rounding::Up)).value(),
                 below = numberFromText(shortText(value, Rounding::Down)).value();
    EXPECT_LE(std::abs(nearest - value), 0.0005001 * size) << value;
    EXPECT_GE(above, value);
    EXPECT_LE(below, value);
    EXPECT_LE(above - below, 0.001001 * size) << value;
    EXPECT_LE(shortText(value).size(), std::string("-1.234e-20").size());
  }
}

// Promise: "Messages have numbers of four ..."
TEST(NumberText, ShortNumbersStandForThemselvesWhereTheyAreShort) {
  for (const char* text : {"0", "1", "0.25", "-3.5", "1000", "0.001234"})
    for (const Rounding rounding : {Rounding::Nearest, Rounding::Up, Rounding::Down})
      EXPECT_EQ(shortText(numberFromText(text).value(), rounding), text);
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  for (const double value : {kInfinity, -kInfinity, std::numeric_limits<double>::denorm_min(),
                             std::numeric_limits<double>::max(), std::numeric_limits<double>::quiet_NaN()})
    for (const Rounding rounding : {Rounding::Nearest, Rounding::Up, Rounding::Down})
      EXPECT_FALSE(shortText(value, rounding).empty());
}

}  // namespace
