// SPDX-License-Identifier: Apache-2.0
#include "julia/expression_pair.h"

#include "kernels/elementary.h"
#include "object_pool.h"

#include <muParser.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <vector>

namespace julia {
namespace {

constexpr const char* kKnown = "x, y, z, r, cos2phi, sin2phi, cos2theta, sin2theta, pi, e";

/// One of the three expressions of f or g, and where it stands in the whole text.
struct Component {
  const char* function;  ///< "f" or "g"
  std::string whole;
  std::string text;
  std::size_t offset;
};

[[noreturn]] void refuse(const char* function, const std::string& whole, const std::string& why) {
  throw std::invalid_argument(std::string(function) + " is '" + whole + "': " + why);
}

/// At the commas that stand in no parenthesis.
std::vector<Component> split(const char* function, const std::string& whole) {
  std::vector<Component> components;
  std::size_t begin = 0;
  int depth = 0;
  for (std::size_t at = 0; at <= whole.size(); ++at) {
    const char c = at < whole.size() ? whole[at] : ',';
    depth += c == '(' ? 1 : c == ')' ? -1 : 0;
    if (at < whole.size() && (c != ',' || depth > 0)) continue;
    components.push_back({function, whole, whole.substr(begin, at - begin), begin});
    begin = at + 1;
  }
  if (components.size() != 3)
    refuse(function, whole,
           "it has " + std::to_string(components.size()) + (components.size() == 1 ? " component" : " components") +
               "; it must have three, separated by commas, such as 'x*x, y*y, z*z'");
  for (std::size_t i = 0; i < 3; ++i)
    if (components[i].text.find_first_not_of(" \t\r\n") == std::string::npos)
      refuse(function, whole, "component " + std::to_string(i + 1) + " is empty");
  return components;
}

/// @param place  in the component, from 0
[[noreturn]] void refuseAt(const Component& component, std::size_t place, const std::string& token,
                           const std::string& why) {
  const std::size_t character = std::min(component.offset + place, component.whole.size()) + 1;
  refuse(component.function, component.whole,
         "character " + std::to_string(character) + (token.empty() ? "" : ", '" + token + "'") + ": " + why);
}

std::string meaningOf(mu::EErrorCodes code) {
  switch (code) {
    case mu::ecUNASSIGNABLE_TOKEN: return std::string("unknown name; the variables and constants are ") + kKnown;
    case mu::ecUNEXPECTED_EOF: return "the expression ends too early";
    case mu::ecMISSING_PARENS: return "a parenthesis is not closed";
    case mu::ecTOO_MANY_PARAMS: return "too many arguments";
    case mu::ecTOO_FEW_PARAMS: return "too few arguments";
    default: return "not expected here";
  }
}

/// muParser tells the place of some tokens by their end.
[[noreturn]] void refuseAs(const Component& component, const mu::ParserError& error) {
  const std::size_t told = error.GetPos() < 0 ? component.text.size() : static_cast<std::size_t>(error.GetPos());
  const std::string& token = error.GetToken();
  const std::size_t found = token.empty() ? std::string::npos : component.text.rfind(token, told);
  refuseAt(component, found == std::string::npos ? told : found, token, meaningOf(error.GetCode()));
}

/// muParser would change a variable under the other components.
void refuseAssignment(const Component& component) {
  const std::string& text = component.text;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '=') continue;
    if (i + 1 < text.size() && text[i + 1] == '=')
      ++i;
    else if (i == 0 || std::string("<>!").find(text[i - 1]) == std::string::npos)
      refuseAt(component, i, "=", "variables cannot be assigned to; a comparison is written ==");
  }
}

// As far as the kernels' sine and cosine go.
constexpr double kMostAngle = 0x1p30;

double sine(double x) {
  if (!(std::abs(x) < kMostAngle)) return std::sin(x);
  double result = 0, other = 0;
  kernels::sineCosineOfRadians(x, result, other);
  return result;
}
double cosine(double x) { return std::abs(x) < kMostAngle ? kernels::cosineOfRadians(x) : std::cos(x); }

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
}

/// The six expressions over variables of their own. muParser's objects are for one thread each; its bulk mode starts
/// threads itself and gives one result an expression, so that points go one by one.
class Expressions {
 public:
  explicit Expressions(const std::vector<Component>& components) {
    const std::pair<const char*, double*> variables[] = {
        {"x", &mX},
        {"y", &mY},
        {"z", &mZ},
        {"r", &mR},
        {"cos2phi", &mAngles.cos2phi},
        {"sin2phi", &mAngles.sin2phi},
        {"cos2theta", &mAngles.cos2theta},
        {"sin2theta", &mAngles.sin2theta},
    };
    for (std::size_t i = 0; i < components.size(); ++i) {
      refuseAssignment(components[i]);
      mu::Parser& parser = mParsers[i];
      try {
        defineFunctions(parser);
        parser.DefineConst("pi", std::numbers::pi);
        parser.DefineConst("e", std::numbers::e);
        for (const auto& [name, value] : variables) parser.DefineVar(name, value);
        parser.SetExpr(components[i].text);
        mValues[i] = parser.Eval();
        mIsConstant[i] = parser.GetUsedVar().empty();
      } catch (const mu::ParserError& error) {
        refuseAs(components[i], error);
      }
    }
  }

  /// f1 f2 f3 g1 g2 g3.
  const std::array<double, 6>& at(double x, double y, double z) {
    mX = x;
    mY = y;
    mZ = z;
    mR = std::sqrt(x * x + y * y + z * z);
    mAngles = kernels::doubleAngles(x, y, z);
    for (std::size_t i = 0; i < mParsers.size(); ++i)
      if (!mIsConstant[i]) mValues[i] = mParsers[i].Eval();
    return mValues;
  }

 private:
  double mX = 0, mY = 0, mZ = 0, mR = 0;
  kernels::DoubleAngles<double> mAngles{1, 0, 1, 0};
  std::array<mu::Parser, 6> mParsers;
  std::array<double, 6> mValues{};
  std::array<bool, 6> mIsConstant{};
};

/// Tries the expressions at points in cubes of a few sizes, which additive recurrences with irrational steps fill
/// evenly.
void requireFinite(Expressions& expressions, const std::vector<Component>& components) {
  std::array<bool, 6> finite{};
  for (const double size : {0.5, 2., 10., 57.})
    for (int k = 1; k <= 32; ++k) {
      const auto coordinate = [&](double step) { return size * (2 * (k * step - std::floor(k * step)) - 1); };
      const std::array<double, 6>& values = expressions.at(
          coordinate(0.8191725133961645), coordinate(0.6710436067037893), coordinate(0.5497004779019703));
      for (std::size_t i = 0; i < values.size(); ++i) finite[i] = finite[i] || std::isfinite(values[i]);
    }
  for (std::size_t i = 0; i < finite.size(); ++i)
    if (!finite[i])
      refuseAt(components[i], components[i].text.find_first_not_of(" \t\r\n"), "",
               "component " + std::to_string(i % 3 + 1) +
                   " has a finite value at none of the points where it was tried; does it divide by 0?");
}

template <class Real>
Real rounded(double x) {
  constexpr double kMost = static_cast<double>(std::numeric_limits<Real>::max());
  return std::abs(x) <= kMost ? static_cast<Real>(x) : std::numeric_limits<Real>::infinity();  // a NaN too
}

}  // namespace

/// As many sets of expressions as there are threads at work.
class ExpressionPair::Pool : public ObjectPool<Expressions> {
 public:
  explicit Pool(const std::vector<Component>& components)
      : ObjectPool([components] { return std::make_unique<Expressions>(components); }) {
    requireFinite(*borrow(), components);
  }
};

ExpressionPair::ExpressionPair(const std::string& f, const std::string& g) {
  std::vector<Component> components = split("f", f);
  for (Component& component : split("g", g)) components.push_back(std::move(component));
  mPool = std::make_unique<Pool>(components);
}

ExpressionPair::~ExpressionPair() = default;

template <class Real>
void ExpressionPair::evaluate(const QuaternionBatch<Real>& p, QuaternionBatch<Real>& f,
                              QuaternionBatch<Real>& g) const {
  f.resize(p.size());
  g.resize(p.size());
  const Pool::Loan expressions = mPool->borrow();
  for (std::size_t i = 0; i < p.size(); ++i) {
    const std::array<double, 6>& v = expressions->at(p.a[i], p.b[i], p.c[i]);
    f.set(i, {rounded<Real>(v[0]), rounded<Real>(v[1]), rounded<Real>(v[2]), 0});
    g.set(i, {rounded<Real>(v[3]), rounded<Real>(v[4]), rounded<Real>(v[5]), 0});
  }
}

template void ExpressionPair::evaluate(const QuaternionBatch<float>&, QuaternionBatch<float>&,
                                       QuaternionBatch<float>&) const;
template void ExpressionPair::evaluate(const QuaternionBatch<double>&, QuaternionBatch<double>&,
                                       QuaternionBatch<double>&) const;

}  // namespace julia
