// SPDX-License-Identifier: Apache-2.0
// Formulas of users: their values, the names in them, and why some cannot be read.
#include "julia/expression.h"

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

TEST(Expression, KnowsItsNames) {
  EXPECT_EQ(namesInExpression("b2 * sin(a_) + pi ^ e - b2"), (Names{"a_", "b2"}));
  EXPECT_EQ(namesInExpression("2"), Names());
}

TEST(Expression, RefusesWhatCannotBeRead) {
  const std::pair<const char*, const char*> cases[] = {
      {"", "empty"},        {"2 *", "too early"},    {"(x", "not closed"},       {"x = 2", "character 3, '='"},
      {"x, y", "2 values"}, {"atan2(x)", "too few"}, {"3 + + * x", "character"}, {"no(x)", "character"}};
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
