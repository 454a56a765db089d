// SPDX-License-Identifier: Apache-2.0
// Options that take several values: lists, ranges in decimals, and what is refused.
#include "vdbtools/recipe/recipe.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <stdexcept>

namespace {

using namespace vdbtools;

const OptionTable& variedTable() {
  static const OptionTable kTable({{.name = "alpha", .argument = "A"}, {.name = "shift", .argument = "X,Y,Z"}});
  return kTable;
}

constexpr std::size_t kMost = 400;

std::vector<std::string> values(const std::string& list) {
  const VariedOption option = parseVaried("alpha=" + list, variedTable(), kMost);
  EXPECT_EQ(option.name, "alpha");
  return option.values;
}

using Values = std::vector<std::string>;

TEST(VariedOption, ListsAreTakenAsTheyStand) {
  EXPECT_EQ(values("10,20,1e2"), (Values{"10", "20", "1e2"}));
  EXPECT_EQ(values("x:10:300:smooth,40"), (Values{"x:10:300:smooth", "40"}));
  EXPECT_EQ(values("a=b"), (Values{"a=b"})) << "only the first equals sign ends the name";
}

// Promise: A range of values goes "from A to B ..."
TEST(VariedOption, SemicolonsLetValuesHoldCommas) {
  const Values expected{"0,0,0", "0.1,0,0"};
  EXPECT_EQ(values("0,0,0;0.1,0,0"), expected);
  EXPECT_EQ(values("0,0,0;0.1,0,0;"), expected);
  EXPECT_EQ(values("0,0,0;"), (Values{"0,0,0"}));
}

// Promise: A range of values goes "from A to B ..."
TEST(VariedOption, RangesStopAtTheirEnd) {
  EXPECT_EQ(values("10:40:10"), (Values{"10", "20", "30", "40"}));
  EXPECT_EQ(values("10:45:10"), (Values{"10", "20", "30", "40"}));
  EXPECT_EQ(values("1:-1:-0.5"), (Values{"1", "0.5", "0", "-0.5", "-1"}));
  EXPECT_EQ(values("3:3:1"), (Values{"3"}));
  EXPECT_EQ(values("5,1:2:1;"), (Values{"5,1:2:1"}));
  EXPECT_EQ(values("5,1:2:1,7"), (Values{"5", "1", "2", "7"}));
  EXPECT_EQ(values("2:11"), (Values{"2:11"})) << "two numbers are a value of some options";
}

// Promise of controls.md: A range of values goes "from A to B in steps, computed in decimals"; a semicolon lets values
//   hold commas
TEST(VariedOption, RangesAreExactDecimals) {
  for (const int places : {1, 2, 3, 5, 9}) {
    std::int64_t one = 1;
    for (int i = 0; i < places; ++i) one *= 10;
    const std::string zeros(static_cast<std::size_t>(places - 1), '0');
    const Values made = values("-0." + zeros + "7:0." + zeros + "9:0." + zeros + "1");
    ASSERT_EQ(made.size(), 17U);
    for (std::size_t i = 0; i < made.size(); ++i) {
      const auto units = static_cast<double>(static_cast<int>(i) - 7);
      // A quotient of two exact numbers is rounded once, as text is.
      EXPECT_EQ(std::strtod(made[i].c_str(), nullptr), units / static_cast<double>(one)) << made[i];
      EXPECT_LE(made[i].size(), static_cast<std::size_t>(places) + 3) << made[i];
    }
  }
}

TEST(VariedOption, RefusesWhatIsNoList) {
  for (const char* text : {"alpha",
                           "=1,2",
                           "alpha=",
                           "alpha=1,,2",
                           "alpha=,1",
                           "alpha=1,",
                           "alpha=;",
                           "alpha=1;;2",
                           "alhpa=1,2",
                           "--alpha=1",
                           "alpha=0:1:0",
                           "alpha=0:1:-0.1",
                           "alpha=1:0:0.1",
                           "alpha=1:0:5",
                           "alpha=0:1:1e-3",
                           "alpha=0:inf:1",
                           "alpha=0:1:nan",
                           "alpha=0:12345678901:1000000000",
                           "alpha=0:1:0.0000000001",
                           "alpha=1:401:1",
                           "alpha=0:999999999:0.000000001"}) {
    EXPECT_THROW(parseVaried(text, variedTable(), kMost), std::invalid_argument) << text;
  }
  EXPECT_EQ(values("1:400:1").size(), kMost);
}

TEST(VariedOption, RefusalsNameTheOptionAndTheValue) {
  try {
    parseVaried("alhpa=1,2", variedTable(), kMost);
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("--vary is 'alhpa=1,2'"), std::string::npos) << error.what();
  }
}

}  // namespace
