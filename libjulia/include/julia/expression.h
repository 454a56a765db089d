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

/// Returns the names in a formula that are neither functions nor constants, in alphabetical order.
/// @throw std::invalid_argument  the text is not a formula for one value; the message says at which character, and why
std::vector<std::string> namesInExpression(const std::string& text);

/// Splits a formula with several components at the commas that are outside brackets.
std::vector<std::string> componentsOfExpression(const std::string& text);

/// A parsed formula. Only one thread at a time may use it.
class Expression {
 public:
  /// @param variables  the names to which the text may refer, made of letters, digits and underscores
  /// @throw std::invalid_argument  as namesInExpression(), or the text contains other names
  Expression(const std::string& text, const std::vector<std::string>& variables);
  Expression(Expression&&) noexcept;
  ~Expression();

  /// Returns the value, which may be infinite or not a number.
  /// @param values  the values of the variables, in their order
  double at(std::span<const double> values);

 private:
  struct State;
  std::unique_ptr<State> mState;
};

}  // namespace julia
