// SPDX-License-Identifier: Apache-2.0
#include "expression_parser.h"

#include "kernels/elementary.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace julia {
namespace {

// As far as the kernels' sine and cosine go.
constexpr double kMostAngle = 0x1p30;

double sine(double x) {
  if (!(std::abs(x) < kMostAngle)) return std::sin(x);
  double result = 0, other = 0;
  kernels::sineCosineOfRadians(x, result, other);
  return result;
}
double cosine(double x) { return std::abs(x) < kMostAngle ? kernels::cosineOfRadians(x) : std::cos(x); }

}  // namespace

void defineFunctions(mu::Parser& parser) {
  using One = double (*)(double);
  using Two = double (*)(double, double);
  using Many = double (*)(const double*, int);
  parser.ClearFun();
  parser.DefineFun("sin", &sine);
  parser.DefineFun("cos", &cosine);
  const std::pair<const char*, One> functions[] = {
      {"tan", [](double x) { return std::tan(x); }},
      {"asin", [](double x) { return std::asin(x); }},
      {"acos", [](double x) { return std::acos(x); }},
      {"atan", [](double x) { return std::atan(x); }},
      {"sinh", [](double x) { return std::sinh(x); }},
      {"cosh", [](double x) { return std::cosh(x); }},
      {"tanh", [](double x) { return std::tanh(x); }},
      {"exp", [](double x) { return std::exp(x); }},
      {"ln", [](double x) { return std::log(x); }},
      {"log", [](double x) { return std::log(x); }},
      {"log2", [](double x) { return std::log2(x); }},
      {"log10", [](double x) { return std::log10(x); }},
      {"sqrt", [](double x) { return std::sqrt(x); }},
      {"abs", [](double x) { return std::abs(x); }},
      {"sign", [](double x) { return x < 0   ? -1.
                                     : x > 0 ? 1.
                                             : 0.; }},
  };
  for (const auto& [name, function] : functions) parser.DefineFun(name, function);
  parser.DefineFun("atan2", Two([](double y, double x) { return std::atan2(y, x); }));
  parser.DefineFun("min", Many([](const double* x, int count) { return *std::min_element(x, x + count); }));
  parser.DefineFun("max", Many([](const double* x, int count) { return *std::max_element(x, x + count); }));
  parser.DefineConst("pi", std::numbers::pi);
  parser.DefineConst("e", std::numbers::e);
}

std::optional<std::size_t> assignmentIn(const std::string& text) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '=') continue;
    if (i + 1 < text.size() && text[i + 1] == '=')
      ++i;
    else if (i == 0 || std::string("<>!").find(text[i - 1]) == std::string::npos)
      return i;
  }
  return std::nullopt;
}

std::size_t placeOf(const mu::ParserError& error, const std::string& text) {
  const std::size_t told = error.GetPos() < 0 ? text.size() : static_cast<std::size_t>(error.GetPos());
  const std::string& token = error.GetToken();
  const std::size_t found = token.empty() ? std::string::npos : text.rfind(token, told);
  return found == std::string::npos ? told : found;
}

std::string quoted(const std::string& token) {
  constexpr std::size_t kLongest = 60;
  if (token.empty()) return "";
  if (token.size() <= kLongest) return ", '" + token + "'";
  std::size_t end = kLongest;
  while (end > 0 && (static_cast<unsigned char>(token[end]) & 0xC0) == 0x80) --end;  // no character of UTF-8 is cut
  return ", '" + token.substr(0, end) + "...'";
}

std::string meaningOf(const mu::ParserError& error, const std::string& known) {
  switch (error.GetCode()) {
    case mu::ecUNASSIGNABLE_TOKEN: return "unknown name; " + known;
    case mu::ecUNEXPECTED_EOF: return "the expression ends too early";
    case mu::ecMISSING_PARENS: return "a parenthesis is not closed";
    case mu::ecTOO_MANY_PARAMS: return "too many arguments";
    case mu::ecTOO_FEW_PARAMS: return "too few arguments";
    case mu::ecEXPRESSION_TOO_LONG: return "an expression must be shorter than 20 000 characters";
    case mu::ecIDENTIFIER_TOO_LONG: return "a name must not be longer than 100 characters";
    default: return "not expected here";
  }
}

}  // namespace julia
