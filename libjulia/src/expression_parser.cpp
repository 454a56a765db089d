// SPDX-License-Identifier: Apache-2.0
#include "expression_parser.h"

#include "kernels/elementary.h"

#include "julia/elementary.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace julia {
namespace {

// The limit of the kernels' sine and cosine.
constexpr double kMostAngle = 0x1p30;

double sine(double x) {
  if (!(std::abs(x) < kMostAngle)) return elementary::sin(x);
  double result = 0, other = 0;
  kernels::sineCosineOfRadians(x, &result, &other);
  return result;
}
double cosineOfAny(double x) { return std::abs(x) < kMostAngle ? kernels::cosineOfRadians(x) : elementary::cos(x); }

// muParser computes ^ with the C library's power, and does not let that be replaced. Therefore ^ is replaced by another
// character, which has no other meaning.
constexpr char kPower = '^', kReadAs = '$';

std::string replaced(std::string text, char from, char to) {
  std::replace(text.begin(), text.end(), from, to);
  return text;
}

}  // namespace

void defineFunctions(mu::Parser& parser) {
  using One = double (*)(double);
  using Many = double (*)(const double*, int);
  parser.ClearFun();
  parser.DefineFun("sin", &sine);
  parser.DefineFun("cos", &cosineOfAny);
  const std::pair<const char*, One> functions[] = {
      {"tan", &elementary::tan},
      {"asin", &elementary::asin},
      {"acos", &elementary::acos},
      {"atan", &elementary::atan},
      {"sinh", &elementary::sinh},
      {"cosh", &elementary::cosh},
      {"tanh", &elementary::tanh},
      {"exp", &elementary::exp},
      {"ln", &elementary::log},
      {"log", &elementary::log},
      {"log2", &elementary::log2},
      {"log10", &elementary::log10},
      {"sqrt", [](double x) { return std::sqrt(x); }},
      {"abs", [](double x) { return std::abs(x); }},
      {"sign", [](double x) { return x < 0   ? -1.
                                     : x > 0 ? 1.
                                             : 0.; }},
  };
  for (const auto& [name, function] : functions) parser.DefineFun(name, function);
  parser.DefineFun("atan2", &elementary::atan2);
  parser.DefineFun("min", Many([](const double* x, int count) { return *std::min_element(x, x + count); }));
  parser.DefineFun("max", Many([](const double* x, int count) { return *std::max_element(x, x + count); }));
  parser.DefineConst("pi", std::numbers::pi);
  parser.DefineConst("e", std::numbers::e);
  parser.DefineOprt(std::string(1, kReadAs), &elementary::pow, mu::prPOW, mu::oaRIGHT);
}

void setFormula(mu::Parser& parser, const std::string& text) {
  const std::size_t place = text.find(kReadAs);
  if (place != std::string::npos)
    throw mu::ParserError(mu::ecUNASSIGNABLE_TOKEN, text.substr(place, 1), text, static_cast<int>(place));
  parser.SetExpr(replaced(text, kPower, kReadAs));
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
  const std::size_t found = token.empty() ? std::string::npos : replaced(text, kPower, kReadAs).rfind(token, told);
  return found == std::string::npos ? told : found;
}

std::string tokenOf(const mu::ParserError& error, const std::string& text) {
  const std::string& token = error.GetToken();
  if (!token.starts_with(kReadAs)) return replaced(token, kReadAs, kPower);
  // Where no operator may stand, muParser takes the operator and everything after it for one name.
  const std::size_t place = placeOf(error, text);
  return place < text.size() ? text.substr(place, 1) : std::string(1, kPower);
}

std::string quoted(const std::string& token) {
  constexpr std::size_t kLongest = 60;
  if (token.empty()) return "";
  if (token.size() <= kLongest) return ", '" + token + "'";
  std::size_t end = kLongest;
  while (end > 0 && (static_cast<unsigned char>(token[end]) & 0xC0) == 0x80) --end;  // does not split a UTF-8 character
  return ", '" + token.substr(0, end) + "...'";
}

std::string meaningOf(const mu::ParserError& error, const std::string& known) {
  switch (error.GetCode()) {
    case mu::ecUNASSIGNABLE_TOKEN:
      if (error.GetToken().starts_with(kReadAs)) break;
      return "unknown name; " + known;
    case mu::ecUNEXPECTED_EOF: return "the expression ends too early";
    case mu::ecMISSING_PARENS: return "a parenthesis is not closed";
    case mu::ecTOO_MANY_PARAMS: return "too many arguments";
    case mu::ecTOO_FEW_PARAMS: return "too few arguments";
    case mu::ecEXPRESSION_TOO_LONG: return "an expression must be shorter than 20 000 characters";
    case mu::ecIDENTIFIER_TOO_LONG: return "a name must not be longer than 100 characters";
    default: break;
  }
  return "not expected here";
}

}  // namespace julia
