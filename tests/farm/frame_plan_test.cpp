// SPDX-License-Identifier: Apache-2.0
// Keys: what an option is at each frame.
#include "vdbtools/base/text.h"
#include "vdbtools/farm/plans.h"
#include "vdbtools/recipe/option_value.h"
#include "vdbtools/scene/fractal_options.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>

namespace {

using namespace vdbtools;
using namespace vdbtools::farm;

KeyedOption keyed(const std::vector<std::string>& keys, const std::vector<std::string>& eases = {}) {
  const std::vector<KeyedOption> options = parseKeys(keys, eases, fractalOptionTable());
  EXPECT_EQ(options.size(), 1U);
  return options.at(0);
}

double numberAt(const KeyedOption& option, int frame) { return numberFromText(valueAt(option, frame)).value(); }

// Promise: "`--frames LIST` means the same" ...
TEST(Frames, AreAListOfRanges) {
  using List = std::vector<int>;
  EXPECT_EQ(parseFrames("3-6"), (List{3, 4, 5, 6}));
  EXPECT_EQ(parseFrames("7"), List{7});
  EXPECT_EQ(parseFrames("0-0"), List{0});
  EXPECT_EQ(parseFrames("1-8x3"), (List{1, 4, 7}));
  EXPECT_EQ(parseFrames("1-7x3"), (List{1, 4, 7}));
  EXPECT_EQ(parseFrames("1-6:2,-3--1:2"), (List{1, 3, 5, -3, -1}));
  EXPECT_EQ(parseFrames("9,1-5x4,1-3"), (List{9, 1, 5, 2, 3})) << "in the order of the list, each once";
  EXPECT_EQ(parseFrames("1-2147483647x1000000").size(), 2148U);
  EXPECT_EQ(parseFrames("-5"), List{-5});
  EXPECT_EQ(parseFrames("-1-2"), (List{-1, 0, 1, 2}));
  EXPECT_EQ(parseFrames("-8--4x2,3"), (List{-8, -6, -4, 3}));
  EXPECT_EQ(parseFrames("-2147483648-2147483647x2000000000"), (List{-2147483648, -147483648, 1852516352}));
  for (const char* bad : {",",
                          "1,",
                          "1-5x",
                          "1-5x0",
                          "1-5x-1",
                          "1x5-7",
                          "x2",
                          "1-90000,90001-180002",
                          "",
                          "-",
                          "48-1",
                          "5--5",
                          "1-",
                          "--5",
                          "1-2-3",
                          "a-b",
                          "1.5-2",
                          "1-100001",
                          "0x1-2",
                          "1 - 2",
                          "-1--2",
                          "-",
                          "-1---1",
                          "-5-",
                          "1-6:",
                          "1-6:0",
                          "1-6x2:2",
                          "1:6",
                          "-2147483648-2147483647"})
    EXPECT_THROW(parseFrames(bad), std::invalid_argument) << bad;
}

// Promise: Between two keys "every number ..."
TEST(Keys, KeepTheirTextAndAreConstantOutside) {
  for (const char* ease : {"linear", "smooth", "step"}) {
    const KeyedOption option = keyed({"alpha@40=1e1", "alpha@10=40.0", "alpha@48=+120"}, {ease});
    EXPECT_EQ(valueAt(option, 10), "40.0") << ease;
    EXPECT_EQ(valueAt(option, 40), "1e1") << ease;
    EXPECT_EQ(valueAt(option, 48), "+120") << ease;
    EXPECT_EQ(valueAt(option, 0), "40.0") << ease;
    EXPECT_EQ(valueAt(option, 9), "40.0") << ease;
    EXPECT_EQ(valueAt(option, 1'000'000), "+120") << ease;
  }
}

// Promise: "`--frames LIST` means the same" ...
TEST(Keys, FramesMayBeNegative) {
  const KeyedOption option = keyed({"alpha@-10=0", "alpha@10=20"});
  EXPECT_EQ(valueAt(option, -11), "0");
  for (int frame = -10; frame <= 10; ++frame) EXPECT_NEAR(numberAt(option, frame), frame + 10, 1e-12);
}

// Promise of farm.md: Between two keys "every number in the option changes gradually"
TEST(Keys, AreMonotonicBetweenTwo) {
  for (const char* ease : {"linear", "smooth"})
    for (const auto& [from, to] : {std::pair("0.1", "0.3"), {"-1e-9", "1e9"}, {"300", "-7.7"}}) {
      SCOPED_TRACE(std::string(ease) + " from " + from + " to " + to);
      const KeyedOption option = keyed({std::string("beta@5=") + from, std::string("beta@1005=") + to}, {ease});
      const bool up = numberAt(option, 5) < numberAt(option, 1005);
      for (int frame = 5; frame < 1005; ++frame) {
        const double now = numberAt(option, frame), next = numberAt(option, frame + 1);
        EXPECT_TRUE(up ? now < next : now > next) << "at frame " << frame;
      }
    }
}

TEST(Keys, LinearHasOneSlopeAndSmoothIsAtRestAtKeys) {
  const KeyedOption linear = keyed({"beta@0=-2", "beta@100=3"});
  for (int frame = 0; frame <= 100; ++frame) EXPECT_NEAR(numberAt(linear, frame), -2 + 0.05 * frame, 1e-14);
  const KeyedOption smooth = keyed({"beta@0=0", "beta@1000=1"}, {"smooth"});
  // At rest: the first step is of second order in the share of the way, 3 t^2.
  EXPECT_NEAR(numberAt(smooth, 1), 3e-6, 1e-8);
  EXPECT_NEAR(numberAt(smooth, 999), 1 - 3e-6, 1e-8);
  for (int frame = 0; frame <= 500; ++frame)
    EXPECT_NEAR(numberAt(smooth, frame) + numberAt(smooth, 1000 - frame), 1, 1e-14) << "odd about the middle";
}

// Promise: Between two keys "every number ..."
TEST(Keys, NumbersOfAListAreBlendedOneByOne) {
  const KeyedOption list = keyed({"origin-shift@1=0,1,-2", "origin-shift@5=4,1,2"});
  EXPECT_EQ(valueAt(list, 2), "1,1,-1");
  EXPECT_EQ(valueAt(list, 3), "2,1,0");
  const KeyedOption ramp = keyed({"detail@1=x:0.125:0.5:smooth", "detail@3=x:0.375:1:smooth"});
  EXPECT_EQ(valueAt(ramp, 2), "x:0.25:0.75:smooth");
  const KeyedOption placed = keyed({"alpha@1=y:10@0.25:300@1", "alpha@3=y:20@0.75:300@1"});
  EXPECT_EQ(valueAt(placed, 2), "y:15@0.5:300@1");
  const KeyedOption file = keyed({"alpha@1=texture:a/b-2.png:0:1", "alpha@3=texture:a/b-2.png:1:3"});
  EXPECT_EQ(valueAt(file, 2), "texture:a/b-2.png:0.5:2");
}

TEST(Keys, StepsTakeAnyText) {
  const KeyedOption option = keyed({"versor@1=random", "versor@10=a=b@c.json"}, {"versor=step", "smooth"});
  EXPECT_EQ(valueAt(option, 9), "random");
  EXPECT_EQ(valueAt(option, 10), "a=b@c.json");
}

TEST(Keys, AnEaseOfOneOptionCountsMore) {
  for (const std::vector<std::string>& eases :
       {std::vector<std::string>{"smooth", "beta=linear"}, {"beta=linear", "smooth"}, {"alpha=smooth"}}) {
    const std::vector<KeyedOption> options =
        parseKeys({"beta@0=0", "alpha@0=0", "alpha@4=4", "beta@4=4"}, eases, fractalOptionTable());
    ASSERT_EQ(options.size(), 2U);
    EXPECT_EQ(options[0].name, "alpha");
    EXPECT_EQ(options[0].ease, Ease::Smooth);
    EXPECT_EQ(options[1].ease, Ease::Linear);
    EXPECT_LT(numberAt(options[0], 1), 1);
    EXPECT_EQ(numberAt(options[1], 1), 1);
  }
}

TEST(Keys, RefuseWhatIsNone) {
  const OptionTable table = fractalOptionTable();
  for (const std::vector<std::string>& keys : {std::vector<std::string>{""},
                                               {"alpha"},
                                               {"alpha=40"},
                                               {"alpha@40"},
                                               {"@1=40"},
                                               {"alpha@=40"},
                                               {"alpha@1.5=40"},
                                               {"alfa@1=40"},
                                               {"source-sha256@1=40"},
                                               {"alpha@1=40", "alpha@01=41"},
                                               {"alpha@1=40", "alpha@2=x:10:300"},
                                               {"detail@1=x:0.1:0.2", "detail@2=y:0.1:0.2"},
                                               {"detail@1=x:0.1:0.2", "detail@2=x:0.1:0.2:smooth"},
                                               {"origin-shift@1=0,0,0", "origin-shift@2=0,0"},
                                               {"alpha@1=40", "alpha@2=inf"},
                                               {"alpha@1=nan", "alpha@2=1"},
                                               {"alpha@1=40", "alpha@2=forty"}})
    EXPECT_THROW(parseKeys(keys, {}, table), std::invalid_argument) << keys.back();
  for (const std::vector<std::string>& eases : {std::vector<std::string>{"quick"},
                                                {""},
                                                {"beta=smooth"},
                                                {"alpha="},
                                                {"smooth", "linear"},
                                                {"alpha=smooth", "alpha=step"}})
    EXPECT_THROW(parseKeys({"alpha@1=1"}, eases, table), std::invalid_argument) << eases.back();
}

}  // namespace
