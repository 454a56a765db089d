// SPDX-License-Identifier: Apache-2.0
#include "support/temporary_folder.h"

#include "vdbtools/formats/versor_file.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/formats/peer_formats.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <limits>
#include <random>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace vdbtools {
namespace {

namespace fs = std::filesystem;

julia::Rational example() {
  return {-2.5, {{{{0.5, 0, -1, 0}, 2}, {{0.1, 0.2, 0.3, -0.4}, -1.0 / 3}}, 3}, {{{{1, 2, 3, 4}, 5}}, 0.1}};
}

const std::string kText = R"({
  "juliavdb": "rational",
  "version": 1,
  "note": "a \"note\"",
  "logScale": -2.5,
  "top": {
    "powerScale": 3,
    "roots": [
      {"position": [0.5, 0, -1, 0], "power": 2},
      {"position": [0.1, 0.2, 0.3, -0.4], "power": -0.3333333333333333}
    ]
  },
  "bottom": {
    "powerScale": 0.1,
    "roots": [
      {"position": [1, 2, 3, 4], "power": 5}
    ]
  }
}
)";

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

std::string versorRefusal(const std::string& text) {
  try {
    rationalFileFromJson(text, "folder/a\nfile.json");
  } catch (const DataError& error) {
    const std::string message = error.what();
    EXPECT_TRUE(message.starts_with("folder/a?file.json: ")) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    return message;
  } catch (const std::exception& error) {
    ADD_FAILURE() << "not a DataError: " << error.what();
    return {};
  }
  ADD_FAILURE() << "accepted";
  return {};
}

TEST(VersorFile, ReadsAndWritesTheDocumentedText) {
  const RationalFile file = rationalFileFromJson(kText, "x");
  EXPECT_EQ(file.rational, example());
  EXPECT_EQ(file.note, "a \"note\"");
  EXPECT_EQ(rationalToJson(example(), "a \"note\""), kText);
}

TEST(VersorFile, WorksWithoutANoteAndWithoutRoots) {
  const RationalFile file = rationalFileFromJson(rationalToJson({}), "x");
  EXPECT_EQ(file.rational, julia::Rational{});
  EXPECT_EQ(file.note, "");
}

TEST(VersorFile, BringsBackEveryBit) {
  const auto bits = [](double value) { return std::bit_cast<std::uint64_t>(value); };
  std::vector<double> numbers{
      0.0,  -0.0,           5e-324,   -5e-324, 2.2250738585072014e-308, 0.1, 1e9, -1e9, 999999999.9999999,
      1e-7, 1e100 * 1e-100, 123456789};
  std::mt19937_64 random(3);
  while (numbers.size() < 2000) {
    const double number = std::bit_cast<double>(std::uint64_t{random()});
    if (std::abs(number) <= 1e9) numbers.push_back(number);
  }
  for (const double number : numbers) {
    julia::Rational rational;
    rational.logScale = number;
    rational.top.roots.push_back({{number, number, number, number}, number});
    rational.bottom.powerScale = number;
    const julia::Rational back = rationalFileFromJson(rationalToJson(rational), "x").rational;
    const julia::Root& root = back.top.roots.at(0);
    for (const double value : {back.logScale, root.position.a, root.position.b, root.position.c, root.position.d,
                               root.power, back.bottom.powerScale}) {
      EXPECT_EQ(bits(value), bits(number)) << number;
    }
  }
}

TEST(VersorFile, BringsBackAnyNote) {
  for (const std::string& note : {std::string("line\nline\t\"\\/"), std::string("\0\x01", 2),
                                  std::string("\xE2\x88\x87\xC3\xA9"), std::string(100000, 'n')}) {
    EXPECT_EQ(rationalFileFromJson(rationalToJson({}, note), "x").note, note);
  }
  EXPECT_EQ(rationalFileFromJson(rationalToJson({}, "a\xFF"), "x").note, "a\xEF\xBF\xBD");
}

// Promise: "A file that is broken, or made ..."
TEST(VersorFile, RefusesEveryPrefixAndEveryTail) {
  const std::string text = kText.substr(0, kText.size() - 1);  // without the last line end, which nobody misses
  for (std::size_t size = 0; size < text.size(); ++size) {
    SCOPED_TRACE(size);
    versorRefusal(text.substr(0, size));
  }
  for (const std::string& tail : {std::string("x"), std::string("{}"), std::string(","), std::string("\0", 1),
                                  std::string("\0garbage", 8), std::string("// comment"), kText}) {
    SCOPED_TRACE(tail);
    versorRefusal(kText + tail);
  }
  EXPECT_EQ(rationalFileFromJson(kText + "  \n", "x").rational, example());
}

TEST(VersorFile, RefusesWhatIsNotTheFormat) {
  const std::vector<std::pair<std::string, std::string>> changes{
      {"\"rational\"", "\"mesh\""},
      {"\"rational\"", "1"},
      {"\"version\": 1", "\"version\": 2"},
      {"\"version\": 1", "\"version\": \"1\""},
      {"\"version\": 1", "\"version\": true"},
      {"\"juliavdb\": \"rational\",", ""},
      {"\"version\": 1,", ""},
      {"\"logScale\": -2.5,", ""},
      {"\"logScale\": -2.5", "\"logScale\": null"},
      {"\"logScale\": -2.5", "\"logScale\": \"-2.5\""},
      {"\"logScale\": -2.5", "\"logScale\": NaN"},
      {"\"logScale\": -2.5", "\"logScale\": 1e999"},
      {"\"logScale\": -2.5", "\"logScale\": -1e999"},
      {"\"logScale\": -2.5", "\"logScale\": 1000000001"},
      {"\"logScale\": -2.5", "\"logScale\": 99999999999999999999999"},
      {"\"logScale\": -2.5", "\"logScale\": -2.5, \"logScale\": 1"},
      {"\"logScale\": -2.5", "\"logscale\": -2.5"},
      {"\"logScale\": -2.5", "\"logScale\": -2.5, \"more\": 1"},
      {"\"note\": \"a", "\"note\": 5, \"x\": \"a"},
      {"\"note\": \"a", "\"note\": \"\xFF"},
      {"\"powerScale\": 3,", ""},
      {"\"powerScale\": 3", "\"powerScale\": true"},
      {"\"powerScale\": 3", "\"powerScale\": 1e9"},  // times the power 2
      {"\"powerScale\": 3", "\"powerScale\": 3, \"x\": []"},
      {"\"power\": 2}", "\"power\": 2, \"extra\": 1}"},
      {"\"power\": 2}", "\"power\": [2]}"},
      {", \"power\": 2}", "}"},
      {"\"power\": 2}", "\"power\": 2, \"power\": 3}"},
      {"[0.5, 0, -1, 0]", "[0.5, 0, -1]"},
      {"[0.5, 0, -1, 0]", "[0.5, 0, -1, 0, 0]"},
      {"[0.5, 0, -1, 0]", "[0.5, 0, -1, \"0\"]"},
      {"[0.5, 0, -1, 0]", "{\"a\": 1}"},
      {"[0.5, 0, -1, 0]", "[0.5, 0, -1, 2e9]"},
      {"{\"position\": [1, 2, 3, 4], \"power\": 5}", "[1, 2, 3, 4]"},
      {"\"bottom\"", "\"down\""},
  };
  for (const auto& [from, to] : changes) {
    SCOPED_TRACE(from + " -> " + to);
    versorRefusal(replaced(kText, from, to));
  }
  for (const char* text : {"", " ", "null", "1", "[]", "{}", "\"rational\"", "not json", "\xEF\xBB\xBF"}) {
    SCOPED_TRACE(text);
    versorRefusal(text);
  }
}

const std::string kWaveText = R"({
  "juliavdb": "waves",
  "version": 1,
  "note": "two factors",
  "factors": [
    {"power": 1, "waves": [
      {"frequency": [0.5, 0, -1, 0], "cosine": [1, 0, 0, 0], "sine": [0, 1, 0, 0]}
    ]},
    {"power": -2, "waves": [
      {"frequency": [0.1, 0.2, 0.3, 0.4], "cosine": [0.5, 0.5, 0.5, 0.5], "sine": [-0.5, 0.5, -0.5, 0.5]},
      {"frequency": [1, 2, 3, -4], "cosine": [0, 0, 1, 0], "sine": [0, 0, 0, 1]}
    ]}
  ]
}
)";

std::string waveRefusal(const std::string& text) {
  try {
    waveFileFromJson(text, "w.json");
  } catch (const DataError& error) {
    EXPECT_TRUE(std::string(error.what()).starts_with("w.json: ")) << error.what();
    return error.what();
  }
  ADD_FAILURE() << "accepted: " << text;
  return {};
}

TEST(WaveFile, ReadsAndWritesTheDocumentedText) {
  const WaveFile file = waveFileFromJson(kWaveText, "x");
  ASSERT_EQ(file.waves.factors.size(), 2u);
  EXPECT_EQ(file.waves.factors[1].power, -2);
  EXPECT_EQ(file.waves.factors[1].waves.at(0).frequency, (julia::Quaternion<double>{0.1, 0.2, 0.3, 0.4}));
  EXPECT_EQ(file.waves.factors[1].waves.at(0).sine, (julia::Quaternion<double>{-0.5, 0.5, -0.5, 0.5}));
  EXPECT_EQ(wavesToJson(file.waves, file.note), kWaveText);
}

// Promise: Waves in files: "changed ..."
TEST(WaveFile, BringsBackEveryBit) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  julia::WaveTexture waves;
  for (int f = 0; f < 20; ++f) {
    julia::WaveFactor factor{{}, f - 10 ? f - 10 : 1};
    const auto any = [&] {
      return julia::Quaternion<double>{normal(random), normal(random), normal(random), normal(random)};
    };
    for (int i = 0; i <= f; ++i) factor.waves.push_back({any(), any(), any()});
    waves.factors.push_back(factor);
  }
  EXPECT_EQ(waveFileFromJson(wavesToJson(waves), "x").waves, waves);
}

// Promise: Waves in files: "changed ..."
TEST(WaveFile, RefusesWhatIsNotTheFormat) {
  const std::vector<std::pair<std::string, std::string>> changes{
      {"\"waves\",", "\"rational\","},
      {"\"version\": 1", "\"version\": 2"},
      {"\"factors\"", "\"factor\""},
      {"\"power\": 1,", ""},
      {"\"power\": 1,", "\"power\": 0,"},
      {"\"power\": 1,", "\"power\": 1.5,"},
      {"\"power\": 1,", "\"power\": 65,"},
      {"\"power\": 1,", "\"power\": 1e300,"},
      {"\"power\": 1,", "\"power\": 1, \"more\": 1,"},
      {"[0.5, 0, -1, 0]", "[0.5, 0, -1]"},
      {"[0.5, 0, -1, 0]", "[0.5, 0, -1, \"0\"]"},
      {"[0.5, 0, -1, 0]", "[0.5, 0, -1, 1e999]"},
      {"\"cosine\": [1, 0, 0, 0], ", ""},
      {"{\"frequency\": [0.5, 0, -1, 0], \"cosine\": [1, 0, 0, 0], \"sine\": [0, 1, 0, 0]}", ""},
  };
  for (const auto& [from, to] : changes) {
    SCOPED_TRACE(from + " -> " + to);
    waveRefusal(replaced(kWaveText, from, to));
  }
  waveRefusal(kText);
  for (std::size_t size = 0; size + 1 < kWaveText.size(); size += 7) waveRefusal(kWaveText.substr(0, size));
  EXPECT_NE(versorRefusal(kWaveText).find("waves:folder/a?file.json"), std::string::npos);
}

TEST(VersorFile, NamesThePlace) {
  const auto contains = [](const std::string& text, const std::string& part) {
    EXPECT_NE(text.find(part), std::string::npos) << text;
  };
  contains(versorRefusal(replaced(kText, "[0.1, 0.2,", "[0.1, \"two\",")),
           "top.roots[1].position[1] is \"two\"; it must be a number");
  contains(versorRefusal(replaced(kText, "\"power\": 5", "\"Power\": 5")),
           "bottom.roots[0] has the unknown key \"Power\"");
  contains(versorRefusal(replaced(kText, "-0.4", "1e999")), "line 10");
  contains(versorRefusal(replaced(kText, "-0.4", "1e999")), "1e999");
  contains(versorRefusal(replaced(kText, "-0.4", "1e10")), "top root 1");
  contains(versorRefusal(replaced(kText, "\"power\": 5", "\"power\": 5, \"power\": 6")),
           "bottom.roots.power occurs twice");
  contains(versorRefusal(replaced(kText, "\"version\": 1", "\"version\": 2, \"new\": 0")),
           "version is 2; this program reads 1");
}

TEST(VersorFile, SurvivesDeepNesting) {
  const std::string deep(1000000, '[');
  versorRefusal(deep);
  versorRefusal(deep + std::string(deep.size(), ']'));
  versorRefusal(replaced(kText, "\"power\": 5", "\"power\": " + deep + std::string(deep.size(), ']')));
}

TEST(VersorFile, DoesNotWriteWhatCannotBeRead) {
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 1.1e9}) {
    julia::Rational rational = example();
    rational.top.roots[0].position.d = bad;
    EXPECT_THROW(rationalToJson(rational), std::invalid_argument) << bad;
  }
}

// The text of kText with a target, which its last lines hold.
const std::string kFitted =
    kText.substr(0, kText.size() - 3) +
    ",\n  \"target\": {\"centre\": [0.5, -20, 0.125], \"scale\": 4, \"box\": [-1.5, -22, -2, 2.5, "
    "-18, 2]}\n}\n";

FittedTo fittedTo() { return {{{0.5, -20, 0.125}, 4}, {{-1.5, -22, -2}, {2.5, -18, 2}}}; }

TEST(VersorFile, BringsBackTheTarget) {
  EXPECT_EQ(rationalToJson(example(), "a \"note\"", fittedTo()), kFitted);
  const RationalFile file = rationalFileFromJson(kFitted, "x");
  EXPECT_EQ(file.rational, example());
  ASSERT_TRUE(file.target);
  EXPECT_EQ(file.target->space.centre, fittedTo().space.centre);
  EXPECT_EQ(file.target->space.scale, fittedTo().space.scale);
  EXPECT_EQ(file.target->box, fittedTo().box);
  EXPECT_FALSE(rationalFileFromJson(kText, "x").target);
}

TEST(VersorFile, BringsBackEveryBitOfTheTarget) {
  const auto bits = [](const FittedTo& target) {
    std::vector<std::uint64_t> result{std::bit_cast<std::uint64_t>(target.space.scale)};
    for (const openvdb::Vec3d& v : {target.space.centre, target.box.min(), target.box.max()})
      for (int axis = 0; axis < 3; ++axis) result.push_back(std::bit_cast<std::uint64_t>(v[axis]));
    return result;
  };
  std::mt19937_64 random(5);
  const auto any = [&] {
    for (;;)
      if (const double number = std::bit_cast<double>(std::uint64_t{random()}); std::abs(number) <= 1e300)
        return number;
  };
  for (int n = 0; n < 300; ++n) {
    FittedTo target;
    target.space.centre = {any(), n % 3 ? any() : -0.0, any()};
    target.space.scale = std::max(std::abs(any()), 5e-324);
    for (int axis = 0; axis < 3; ++axis)
      std::tie(target.box.min()[axis], target.box.max()[axis]) = std::minmax({any(), any()});
    const RationalFile back = rationalFileFromJson(rationalToJson(example(), {}, target), "x");
    ASSERT_TRUE(back.target);
    EXPECT_EQ(bits(*back.target), bits(target)) << n;
  }
}

TEST(VersorFile, RefusesABadTargetAndNamesThePlace) {
  const std::string box = "\"box\": [-1.5, -22, -2, 2.5, -18, 2]";
  const std::vector<std::array<std::string, 3>> changes{
      {"\"centre\": [0.5, -20, 0.125], ", "", "target has no \"centre\""},
      {"\"scale\": 4, ", "", "target has no \"scale\""},
      {", " + box, "", "target has no \"box\""},
      {"[0.5, -20, 0.125]", "[0.5, -20]", "target.centre has 2 numbers; it must have 3"},
      {"[0.5, -20, 0.125]", "[0.5, -20, 0, 0]", "target.centre has 4 numbers"},
      {"[0.5, -20, 0.125]", "[0.5, null, 0]", "target.centre[1] is null"},
      {"[0.5, -20, 0.125]", "0.5", "target.centre is 0.5"},
      {"[0.5, -20, 0.125]", "[0.5, 1e999, 0]", "line 19"},
      {"[0.5, -20, 0.125]", "[0.5, NaN, 0]", "line 19"},
      {"\"scale\": 4", "\"scale\": 0", "target.scale is 0"},
      {"\"scale\": 4", "\"scale\": -4", "target.scale is -4"},
      {"\"scale\": 4", "\"scale\": -1e-9", "target.scale is -1e-09"},
      {"\"scale\": 4", "\"scale\": \"4\"", "target.scale is \"4\""},
      {"\"scale\": 4", "\"scale\": 1e999", "line 19"},
      {"\"scale\": 4", "\"scale\": Infinity", "line 19"},
      {"\"scale\": 4", "\"scale\": 4, \"unit\": 1", "target has the unknown key \"unit\""},
      {"\"scale\": 4", "\"scale\": 4, \"scale\": 4", "target.scale occurs twice"},
      {"2.5, -18, 2]", "2.5, -18]", "target.box has 5 numbers; it must have 6"},
      {"2.5, -18, 2]", "2.5, -22, 2]", "target.box has no extent"},
      {"2.5, -18, 2]", "-2.5, -18, 2]", "target.box has no extent"},
      {"[-1.5, -22, -2, 2.5, -18, 2]", "[-1e308, -22, -2, 1e308, -18, 2]", "target.box is too large"},
      {"{\"centre\": [0.5, -20, 0.125], \"scale\": 4, " + box + "}", "[1]", "target is an array"},
      {"{\"centre\": [0.5, -20, 0.125], \"scale\": 4, " + box + "}", "null", "target is null"},
  };
  for (const auto& [from, to, words] : changes) {
    SCOPED_TRACE(from + " -> " + to);
    const std::string message = versorRefusal(replaced(kFitted, from, to));
    EXPECT_NE(message.find(words), std::string::npos) << message;
  }
}

TEST(VersorFile, DoesNotWriteATargetThatCannotBeRead) {
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    FittedTo target = fittedTo();
    target.space.centre[1] = bad;
    EXPECT_THROW(rationalToJson(example(), {}, target), std::invalid_argument) << bad;
    target = fittedTo();
    target.space.scale = bad;
    EXPECT_THROW(rationalToJson(example(), {}, target), std::invalid_argument) << bad;
    target = fittedTo();
    target.box.max()[2] = bad;
    EXPECT_THROW(rationalToJson(example(), {}, target), std::invalid_argument) << bad;
  }
  FittedTo target = fittedTo();
  target.space.scale = 0;
  EXPECT_THROW(rationalToJson(example(), {}, target), std::invalid_argument);
  target = fittedTo();
  target.box.max()[0] = target.box.min()[0];
  EXPECT_THROW(rationalToJson(example(), {}, target), std::invalid_argument);
}

class RationalPath : public ::testing::Test {
 protected:
  fs::path write(const std::string& name, const std::string& bytes) const {
    std::ofstream(mFolder / name, std::ios::binary) << bytes;
    return mFolder / name;
  }

  const TemporaryFolder mTemporary;
  const fs::path mFolder = mTemporary.path();
};

TEST_F(RationalPath, ChoosesTheFormatByExtension) {
  const julia::Rational topOnly{0, example().top, {}};
  const std::string p4d = rationalToP4d(example().top);
  EXPECT_EQ(readRational(write("a.json", kText)), example());
  EXPECT_EQ(readRational(write("a.JSON", kText)), example());
  EXPECT_EQ(readRational(write("a.p4d", p4d)), topOnly);
  EXPECT_EQ(readRational(write("a.b.Poly4D", p4d)), topOnly);
  EXPECT_EQ(readRationalFile(write("a.json", kText)).note, "a \"note\"");

  // A box of one cell, e^0, no history, and three fields without cells.
  std::string o3d;
  const std::string one("\1\0\0\0", 4), oneDouble("\0\0\0\0\0\0\xF0\x3F", 8);
  for (int i = 0; i < 3; ++i) o3d += one;
  for (int i = 0; i < 6; ++i) o3d += oneDouble;
  o3d += p4d + rationalToP4d(example().bottom) + oneDouble + std::string(4 + 3 * (3 * 4 + 6 * 8), '\0');
  EXPECT_EQ(readRational(write("a.o3d", o3d)), (julia::Rational{0, example().top, example().bottom}));
  EXPECT_EQ(readRational(write("A.O3D", o3d)), (julia::Rational{0, example().top, example().bottom}));
}

TEST_F(RationalPath, RefusesTheRest) {
  EXPECT_THROW(readRational(write("a.txt", kText)), std::invalid_argument);
  EXPECT_THROW(readRational(write("json", kText)), std::invalid_argument);
  for (const char* name : {"a.json", "a.p4d", "a.poly4d", "a.o3d"}) {
    EXPECT_THROW(readRational(mFolder / name), MissingInputError) << name;
    EXPECT_THROW(readRational(write(name, "")), DataError) << name;
    EXPECT_THROW(readRational(write(name, "nonsense")), DataError) << name;
    fs::remove(mFolder / name);
    fs::create_directory(mFolder / name);
    EXPECT_THROW(readRational(mFolder / name), MissingInputError) << name;
  }
}

}  // namespace
}  // namespace vdbtools
