// SPDX-License-Identifier: Apache-2.0
#include "julia/expression.h"

#include "expression_parser.h"

#include <algorithm>
#include <stdexcept>

namespace julia {
namespace {

[[noreturn]] void refuseAt(std::size_t place, const std::string& token, const std::string& why) {
  throw std::invalid_argument("character " + std::to_string(place + 1) + quoted(token) + ": " + why);
}

[[noreturn]] void refuseAs(const mu::ParserError& error, const std::string& text, const std::string& known) {
  refuseAt(std::min(placeOf(error, text), text.size()), tokenOf(error, text), meaningOf(error, known));
}

}  // namespace

std::vector<std::string> namesInExpression(const std::string& text) {
  if (text.find_first_not_of(" \t\r\n") == std::string::npos) refuseAt(0, "", "the expression is empty");
  if (const std::optional<std::size_t> place = assignmentIn(text)) refuseAt(*place, "=", kAssignment);
  try {
    mu::Parser parser;
    defineFunctions(parser);
    setFormula(parser, text);
    std::vector<std::string> names;
    for (const auto& [name, variable] : parser.GetUsedVar()) names.push_back(name);
    double one = 1;
    for (const std::string& name : names) parser.DefineVar(name, &one);
    parser.Eval();
    if (parser.GetNumResults() != 1)
      refuseAt(0, "", "it has " + std::to_string(parser.GetNumResults()) + " values, but one is wanted");
    return names;
  } catch (const mu::ParserError& error) {
    refuseAs(error, text, "there is no such function");
  }
}

std::vector<std::string> componentsOfExpression(const std::string& text) {
  std::vector<std::string> parts{{}};
  int depth = 0;
  for (const char c : text) {
    depth += c == '(' ? 1 : c == ')' ? -1 : 0;
    if (c == ',' && depth <= 0)
      parts.emplace_back();
    else
      parts.back() += c;
  }
  return parts;
}

struct Expression::State {
  std::vector<double> values;
  mu::Parser parser;
};

Expression::Expression(const std::string& text, const std::vector<std::string>& variables)
    : mState(std::make_unique<State>()) {
  namesInExpression(text);
  mState->values.resize(variables.size());
  std::string known;
  try {
    defineFunctions(mState->parser);
    for (std::size_t i = 0; i < variables.size(); ++i) {
      mState->parser.DefineVar(variables[i], &mState->values[i]);
      known += (i == 0 ? "" : ", ") + variables[i];
    }
    setFormula(mState->parser, text);
    mState->parser.Eval();
  } catch (const mu::ParserError& error) {
    refuseAs(error, text, "the variables are " + known);
  }
}

Expression::Expression(Expression&&) noexcept = default;
Expression::~Expression() = default;

double Expression::at(std::span<const double> values) {
  std::copy(values.begin(), values.end(), mState->values.begin());
  return mState->parser.Eval();
}

}  // namespace julia
