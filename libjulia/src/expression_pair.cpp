// SPDX-License-Identifier: Apache-2.0
#include "julia/expression_pair.h"

#include "expression_parser.h"
#include "kernels/elementary.h"
#include "object_pool.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <vector>

namespace julia {
namespace {

constexpr const char* kKnown = "x, y, z, r, cos2phi, sin2phi, cos2theta, sin2theta, pi, e";

/// One of the three expressions of f or g, and its position in the whole text.
struct Component {
  const char* function;  ///< "f" or "g"
  std::string whole;
  std::string text;
  std::size_t offset;
};

[[noreturn]] void refuse(const char* function, const std::string& whole, const std::string& why) {
  throw std::invalid_argument(std::string(function) + " is '" + whole + "': " + why);
}

/// Splits at the commas outside parentheses.
std::vector<Component> componentsOf(const char* function, const std::string& whole) {
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
[[noreturn]] void refuseComponentAt(const Component& component, std::size_t place, const std::string& token,
                                    const std::string& why) {
  const std::size_t character = std::min(component.offset + place, component.whole.size()) + 1;
  refuse(component.function, component.whole, "character " + std::to_string(character) + quoted(token) + ": " + why);
}

[[noreturn]] void refuseComponentAs(const Component& component, const mu::ParserError& error) {
  refuseComponentAt(component, placeOf(error, component.text), tokenOf(error, component.text),
                    meaningOf(error, std::string("the variables and constants are ") + kKnown));
}

/// An assignment in muParser would change a variable for the other components.
void refuseAssignment(const Component& component) {
  if (const std::optional<std::size_t> place = assignmentIn(component.text))
    refuseComponentAt(component, *place, "=", kAssignment);
}

/// The six expressions with their own variables. Only one thread at a time may use an object of muParser. Its bulk mode
/// starts threads itself and gives one result per expression, so points are evaluated one by one.
class Expressions {
 public:
  explicit Expressions(const std::vector<Component>& components) {
    const std::pair<const char*, double*> variables[] = {
        {"x", &mX},
        {"y", &mY},
        {"z", &mZ},
        {"r", &mR},
        {"cos2phi", &mAngles[0]},
        {"sin2phi", &mAngles[1]},
        {"cos2theta", &mAngles[2]},
        {"sin2theta", &mAngles[3]},
    };
    for (std::size_t i = 0; i < components.size(); ++i) {
      refuseAssignment(components[i]);
      mu::Parser& parser = mParsers[i];
      try {
        defineFunctions(parser);
        for (const auto& [name, value] : variables) parser.DefineVar(name, value);
        setFormula(parser, components[i].text);
        mValues[i] = parser.Eval();
        mIsConstant[i] = parser.GetUsedVar().empty();
      } catch (const mu::ParserError& error) {
        refuseComponentAs(components[i], error);
      }
    }
  }

  /// f1 f2 f3 g1 g2 g3.
  const std::array<double, 6>& at(double x, double y, double z) {
    mX = x;
    mY = y;
    mZ = z;
    mR = std::sqrt(x * x + y * y + z * z);
    kernels::doubleAngles(x, y, z, mAngles.data());
    for (std::size_t i = 0; i < mParsers.size(); ++i)
      if (!mIsConstant[i]) mValues[i] = mParsers[i].Eval();
    return mValues;
  }

 private:
  double mX = 0, mY = 0, mZ = 0, mR = 0;
  std::array<double, 4> mAngles{1, 0, 1, 0};  ///< cos 2phi, sin 2phi, cos 2theta, sin 2theta
  std::array<mu::Parser, 6> mParsers;
  std::array<double, 6> mValues{};
  std::array<bool, 6> mIsConstant{};
};

/// Tests the expressions at points in cubes of a few sizes, filled evenly by additive recurrences with irrational
/// steps.
void requireFiniteValues(Expressions& expressions, const std::vector<Component>& components) {
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
      refuseComponentAt(components[i], components[i].text.find_first_not_of(" \t\r\n"), "",
                        "component " + std::to_string(i % 3 + 1) +
                            " has a finite value at none of the points where it was tried; does it divide by 0?");
}

template <class Real>
Real rounded(double x) {
  constexpr double kMost = static_cast<double>(std::numeric_limits<Real>::max());
  return std::abs(x) <= kMost ? static_cast<Real>(x) : std::numeric_limits<Real>::infinity();  // a NaN too
}

}  // namespace

/// A pool with as many sets of expressions as threads at work.
class ExpressionPair::Pool : public ObjectPool<Expressions> {
 public:
  explicit Pool(const std::vector<Component>& components)
      : ObjectPool([components] { return std::make_unique<Expressions>(components); }) {
    requireFiniteValues(*borrow(), components);
  }
};

ExpressionPair::ExpressionPair(const std::string& f, const std::string& g) {
  std::vector<Component> components = componentsOf("f", f);
  for (Component& component : componentsOf("g", g)) components.push_back(std::move(component));
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
