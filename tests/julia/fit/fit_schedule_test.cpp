// SPDX-License-Identifier: Apache-2.0
// Optimisation schedules: the paper's are read, and what is wrong is pointed at.
#include "julia/fit/schedule.h"

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace {

using julia::FitPass;
using julia::parseSchedule;
using julia::toString;
using enum julia::FitPassKind;

TEST(FitSchedule, readsThoseOfThePaper) {
  const std::vector<FitPass> vfr25{{25, VariableCoarsened}, {25, Full}, {25, Reweighted}};
  std::vector<FitPass> tooth;
  for (const int resolution : {25, 50})
    for (const auto kind : {VariableCoarsened, Full, Reweighted, Full}) tooth.push_back({resolution, kind});
  tooth.push_back({97, VariableCoarsened});
  tooth.push_back({97, Full});
  std::vector<FitPass> bunny = tooth;
  tooth.push_back({97, Reweighted});
  EXPECT_EQ(parseSchedule("25(VFRF) 50(VFRF) 97(VFR)"), tooth);
  EXPECT_EQ(parseSchedule("25(VFRF) 50(VFRF) 97(VF)"), bunny);
  std::vector<FitPass> frog = vfr25;
  for (const auto kind : {VariableCoarsened, Full, Reweighted}) frog.push_back({50, kind});
  frog.push_back({97, VariableCoarsened});
  EXPECT_EQ(parseSchedule("25(VFR) 50(VFR) 97(V)"), frog);
  std::vector<FitPass> armadillo = vfr25, dragon = vfr25;
  armadillo.push_back({50, VariableCoarsened});
  EXPECT_EQ(parseSchedule("25(VFR) 50(V)"), armadillo);
  dragon.push_back({25, Full});
  dragon.push_back({50, VariableCoarsened});
  EXPECT_EQ(parseSchedule("25(VFRF) 50(V)"), dragon);
}

// A parenthesis ends a group as well as a blank does, and blanks between the parts mean nothing.
TEST(FitSchedule, blanksAreFree) {
  const std::vector<FitPass> expected{{25, VariableCoarsened}, {50, Full}};
  for (const char* const text : {"25(V) 50(F)", "25(V)50(F)", "  25 (V)   50  (F)  ", "025(V) 50(F)"})
    EXPECT_EQ(parseSchedule(text), expected) << text;
}

TEST(FitSchedule, isReadAsItIsWritten) {
  for (const std::string text : {"25(VFRF) 50(VFRF) 97(VFR)", "4(V) 1000(R)", "25(F) 50(F) 25(F)"})
    EXPECT_EQ(toString(parseSchedule(text)), text);
  // Every two passes in a row.
  const std::vector<FitPass> all{{4, Full}, {4, Reweighted}, {97, VariableCoarsened}, {1000, Full}};
  for (const FitPass& first : all)
    for (const FitPass& second : all) {
      const std::vector<FitPass> schedule{first, second};
      EXPECT_EQ(parseSchedule(toString(schedule)), schedule) << toString(schedule);
    }
  EXPECT_EQ(toString(parseSchedule("25(V) 25(F)")), "25(VF)");
  EXPECT_EQ(toString({}), "");
}

TEST(FitSchedule, pointsAtWhatIsWrong) {
  const std::vector<std::pair<std::string, int>> wrong{
      {"", 1},         {"   ", 4},     {"25", 3},         {"25(", 4},           {"25(V", 5},
      {"25()", 4},     {"25(X)", 4},   {"25(VFX)", 6},    {"(V)", 1},           {"25(V) junk", 7},
      {"25(V)x", 6},   {"3(V)", 1},    {"5000(V)", 1},    {"1001(V)", 1},       {"99999999999999999999(V)", 1},
      {"-25(V)", 1},   {"25.5(V)", 3}, {"25(v)", 4},      {"25(VF) 50(f)", 11}, {"25(V F)", 5},
      {"25(V) 50", 9}, {"25(V))", 6},  {"25(V) 3(F)", 7}, {"25\t(V)", 3},       {"25(V), 50(F)", 6},
      {"25((V)", 4},   {"V", 1}};
  for (const auto& [text, character] : wrong) {
    try {
      parseSchedule(text);
      ADD_FAILURE() << "'" << text << "' was accepted";
    } catch (const std::invalid_argument& error) {
      EXPECT_NE(std::string(error.what()).find(" at character " + std::to_string(character) + " "), std::string::npos)
          << "'" << text << "': " << error.what();
    }
  }
}

}  // namespace
