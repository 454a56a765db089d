// SPDX-License-Identifier: Apache-2.0
// Formulas of users: their values, the names in them, and why some cannot be read.
#include "julia/expression.h"

#include "julia/elementary.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

using julia::Expression;
using julia::namesInExpression;
using Names = std::vector<std::string>;

TEST(Expression, HasTheValueThatItSays) {
  Expression expression("wet > 0.5 ? x^2 + max(wet, 3) : atan2(x, 2)", {"x", "unused", "wet"});
  EXPECT_EQ(expression.at(std::array{3., 9., 1.}), 12);
  EXPECT_EQ(expression.at(std::array{3., 9., 0.}), std::atan2(3., 2.));
  EXPECT_TRUE(std::isnan(Expression("sqrt(x)", {"x"}).at(std::array{-1.})));
}

// Promise: "neither the instruction set ..."
TEST(Expression, FunctionsAndPowersAreThoseOfTheLibrary) {
  namespace elementary = julia::elementary;
  using Function = double (*)(double);
  const std::pair<const char*, Function> functions[] = {
      {"tan(x)", elementary::tan},
      {"asin(x)", elementary::asin},
      {"acos(x)", elementary::acos},
      {"atan(x)", elementary::atan},
      {"sinh(x)", elementary::sinh},
      {"cosh(x)", elementary::cosh},
      {"tanh(x)", elementary::tanh},
      {"exp(x)", elementary::exp},
      {"ln(x)", elementary::log},
      {"log(x)", elementary::log},
      {"log2(x)", elementary::log2},
      {"log10(x)", elementary::log10},
      {"sin(x + 2^40)", [](double x) { return elementary::sin(x + 0x1p40); }},
      {"cos(x + 2^40)", [](double x) { return elementary::cos(x + 0x1p40); }},
      {"x^1.7", [](double x) { return elementary::pow(x, 1.7); }},
      {"x^3", [](double x) { return elementary::pow(x, 3); }},
      {"3^x", [](double x) { return elementary::pow(3, x); }},
      {"atan2(x, 3)", [](double x) { return elementary::atan2(x, 3); }}};
  for (const auto& [text, function] : functions) {
    Expression expression(text, {"x"});
    for (double x = 0.003; x < 1; x += 0.0031)
      ASSERT_EQ(expression.at(std::array{x}), function(x)) << text << " at " << x;
  }
}

TEST(Expression, PowersBindAsInMathematics) {
  const std::pair<const char*, double> values[] = {{"2^3^2", 512},        {"(2^3)^2", 64},
                                                   {"-2^2", -4},          {"(-2)^3", -8},
                                                   {"2*3^2", 18},         {"2^-1", 0.5},
                                                   {"x^2^0", 3},          {"x^2*x", 27},
                                                   {"-x^2 + x^-1*3", -8}, {"2 ^ (x < 4 ? 3 : 1)", 8},
                                                   {"x^2^x", 6561},       {"(x^2)^0.5", 3},
                                                   {"10^-3*1000", 1},     {"x^2 == 9 && x^3 > 26", 1}};
  for (const auto& [text, value] : values) EXPECT_EQ(Expression(text, {"x"}).at(std::array{3.}), value) << text;
}

TEST(Expression, KnowsItsNames) {
  EXPECT_EQ(namesInExpression("b2 * sin(a_) + pi ^ e - b2"), (Names{"a_", "b2"}));
  EXPECT_EQ(namesInExpression("2"), Names());
}

TEST(Expression, RefusesWhatCannotBeRead) {
  const std::pair<const char*, const char*> cases[] = {{"", "empty"},
                                                       {"2 *", "too early"},
                                                       {"(x", "not closed"},
                                                       {"x = 2", "character 3, '='"},
                                                       {"x, y", "2 values"},
                                                       {"atan2(x)", "too few"},
                                                       {"3 + + * x", "character"},
                                                       {"no(x)", "character"},
                                                       {"x ^", "too early"},
                                                       {"x ^ ^ 2", "character 5, '^': not expected"},
                                                       {"^ x", "character 1, '^': not expected"},
                                                       {"x $ 2", "character 3, '$'"}};
  for (const auto& [text, words] : cases) try {
      namesInExpression(text);
      ADD_FAILURE() << "'" << text << "' was read";
    } catch (const std::invalid_argument& error) {
      EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << text << ": " << error.what();
    }
  try {
    Expression("x + other", {"x", "y"});
    ADD_FAILURE() << "an unknown name was taken";
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("'other': unknown name; the variables are x, y"), std::string::npos)
        << error.what();
  }
}

}  // namespace
