// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/files/frames.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <limits>
#include <stdexcept>

namespace vdbtools {
namespace {

// Promise: "`####` and `%04d` work too" ...
TEST(FrameName, FillsInEveryNotation) {
  EXPECT_EQ(expandFrame("a.$F4.vdb", 1), "a.0001.vdb");
  EXPECT_EQ(expandFrame("a.####.vdb", 1), "a.0001.vdb");
  EXPECT_EQ(expandFrame("a.%04d.vdb", 1), "a.0001.vdb");
  EXPECT_EQ(expandFrame("a.<frame>.vdb", 1), "a.0001.vdb");
  EXPECT_EQ(expandFrame("a.<frame>.vdb", -5), "a.-0005.vdb");
  EXPECT_EQ(expandFrame("a.$F.vdb", 17), "a.17.vdb");
  EXPECT_EQ(expandFrame("a.%d.vdb", 17), "a.17.vdb");
  EXPECT_EQ(expandFrame("a#.vdb", 17), "a17.vdb");
  EXPECT_EQ(expandFrame("$F3", 7), "007");
  EXPECT_EQ(expandFrame("%010d_left.vdb", 7), "0000000007_left.vdb");
  EXPECT_EQ(expandFrame("/x/a.$F4.vdb", 0), "/x/a.0000.vdb");
  EXPECT_EQ(expandFrame("a.${F4}_b.vdb", 7), "a.0007_b.vdb");
  EXPECT_EQ(expandFrame("a${F}b.vdb", 17), "a17b.vdb");
  EXPECT_EQ(expandFrame("a.<F4>.vdb", 7), "a.0007.vdb");
  EXPECT_EQ(expandFrame("a<F>b.vdb", 17), "a17b.vdb");
  EXPECT_EQ(expandFrame("a.@@@@.vdb", 7), "a.0007.vdb");
  EXPECT_EQ(expandFrame("you@@home/a@2x_@@.vdb", 7), "you@@home/a@2x_07.vdb");
}

// Promise: "`####` and `%04d` work too" ...
TEST(FrameName, WritesNegativeNumbersAsOthersDo) {
  for (const int frame : {-5, -42, -123456, std::numeric_limits<int>::min()}) {
    char printed[64];
    std::snprintf(printed, sizeof printed, "a.%04d.vdb", frame);
    EXPECT_EQ(expandFrame("a.%04d.vdb", frame), printed);
    std::snprintf(printed, sizeof printed, "a.%d.vdb", frame);
    for (const char* name : {"a.%d.vdb", "a.$F.vdb", "a.${F}.vdb"}) EXPECT_EQ(expandFrame(name, frame), printed);
    // A precision is the number of digits, without the sign.
    std::snprintf(printed, sizeof printed, "a.%.4d.vdb", frame);
    for (const char* name : {"a.####.vdb", "a.$F4.vdb", "a.${F4}.vdb", "a.<F4>.vdb", "a.@@@@.vdb", "a.vdb"})
      EXPECT_EQ(expandFrame(name, frame), printed) << name;
  }
}

TEST(FrameName, WritesNumbersTooLongForThePaddingInFull) {
  for (const char* name : {"a.$F4.vdb", "a.####.vdb", "a.%04d.vdb", "a.vdb"}) {
    EXPECT_EQ(expandFrame(name, 123456), "a.123456.vdb") << name;
    EXPECT_EQ(expandFrame(name, std::numeric_limits<int>::max()), "a.2147483647.vdb") << name;
  }
}

TEST(FrameName, PutsTheFrameBeforeTheExtensionWithoutAPattern) {
  EXPECT_EQ(expandFrame("name.vdb", 1), "name.0001.vdb");
  EXPECT_EQ(expandFrame("a.b/name", 1), "a.b/name.0001");
  EXPECT_EQ(expandFrame("a.b/.hidden", 1), "a.b/.hidden.0001");
  EXPECT_EQ(expandFrame("name.v2.vdb", 1), "name.v2.0001.vdb");
}

TEST(FrameName, LeavesNamesWithoutAPatternAloneWithoutAFrame) {
  for (const char* name :
       {"name.vdb", "", "a/b", "50%.vdb", "cost$.vdb", "$FOO.vdb", "$F_x.vdb", "${FOO}.vdb", "${F4.vdb", "${F",
        "%s.vdb", "%4x", "%", "me@home.vdb", "<F4.vdb", "<F", "<UDIM>.vdb", "<Fog>.vdb"}) {
    EXPECT_EQ(expandFrame(name, std::nullopt), name);
  }
}

TEST(FrameName, CountsHashMarksInTheFileNameOnly) {
  EXPECT_EQ(expandFrame("shot#12/a.vdb", std::nullopt), "shot#12/a.vdb");
  EXPECT_EQ(expandFrame("shot#12/a.vdb", 3), "shot#12/a.0003.vdb");
  EXPECT_EQ(expandFrame("shot#12/a.##.vdb", 3), "shot#12/a.03.vdb");
  EXPECT_EQ(expandFrame("out/$F4/a.vdb", 3), "out/0003/a.vdb");
}

// Promise: "`####` and `%04d` work too" ...
TEST(FrameName, RefusesWhatIsNotClear) {
  for (const char* name : {"a.$F4.vdb", "a.####.vdb", "a.%04d.vdb", "a.$F.vdb", "a#.vdb", "a.<F4>.vdb", "a.@@.vdb"}) {
    EXPECT_THROW(expandFrame(name, std::nullopt), std::invalid_argument) << name;
  }
  for (const char* name :
       {"$F4.####.vdb", "##.##.vdb", "<frame>.##.vdb", "%04d$F", "$F4/$F4.vdb", "a.%4d.vdb", "$F17", "<F4>.##", "@@.##",
        "<F17>", "%017d", "#################", "$F99999999999999999999999", "a/", "", ".", "a/.."}) {
    EXPECT_THROW(expandFrame(name, 1), std::invalid_argument) << name;
  }
}

TEST(FrameName, NamesThePatternInItsMessage) {
  try {
    expandFrame("a.$F4.vdb", std::nullopt);
    FAIL() << "nothing was thrown";
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("\"$F4\""), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace vdbtools
