// SPDX-License-Identifier: Apache-2.0
/// @file expression.h
/// A formula that the user gives as text, over variables that the caller names. Its functions, constants and operators
/// are those of expression_pair.h.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

namespace julia {

/// The names in a formula that are no functions and no constants, in alphabetical order.
/// @throw std::invalid_argument  it is no formula for one value; says at which character, and why
std::vector<std::string> namesInExpression(const std::string& text);

/// A formula with several components, cut at the commas that are not within brackets.
std::vector<std::string> componentsOfExpression(const std::string& text);

/// For one thread at a time.
class Expression {
 public:
  /// @param variables  what the text may refer to; names of letters, digits and underscores
  /// @throw std::invalid_argument  as namesInExpression(), or it has other names
  Expression(const std::string& text, const std::vector<std::string>& variables);
  Expression(Expression&&) noexcept;
  ~Expression();

  /// The value, which may be infinite or not a number.
  /// @param values  of the variables, in their order
  double at(std::span<const double> values);

 private:
  struct State;
  std::unique_ptr<State> mState;
};

}  // namespace julia
