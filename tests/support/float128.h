// SPDX-License-Identifier: Apache-2.0
/// @file float128.h
/// What the law tests of libjulia share: a 128-bit number to compare with, seeded random quaternions, and distances.
#pragma once

#include "julia/embedding.h"
#include "julia/quaternion.h"
#include "julia/rational.h"

// Boost 1.83 defines numeric_limits<__float128> unless the compiler is g++ 14 or newer, and clang calls itself g++ 4:
// with the libstdc++ of g++ 14, which has it, there are two.
#if defined(__clang__) && defined(_GLIBCXX_RELEASE) && _GLIBCXX_RELEASE >= 14
#define BOOST_CSTDFLOAT_NO_LIBQUADMATH_SUPPORT
#endif
#include <boost/multiprecision/float128.hpp>

#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <sstream>
#include <string>

namespace law_tests {

using Wide = boost::multiprecision::float128;
using julia::Quaternion;

template <class Real>
inline constexpr double kEpsilon = static_cast<double>(std::numeric_limits<Real>::epsilon());

/// The standard fixes the engine but not its distributions; with these every machine tests the same numbers.
class Random {
 public:
  explicit Random(std::uint64_t seed) : mEngine(seed) {}

  double unit() { return static_cast<double>(mEngine() >> 11) * 0x1p-53; }
  double between(double low, double high) { return low + (high - low) * unit(); }
  int integer(int low, int high) { return low + static_cast<int>(unit() * (high - low + 1)); }

  /// Evenly in the unit ball of R^4, never 0.
  Quaternion<double> inBall() {
    for (;;) {
      const Quaternion<double> q{between(-1, 1), between(-1, 1), between(-1, 1), between(-1, 1)};
      if (normSquared(q) < 1 && normSquared(q) > 1e-6) return q;
    }
  }

  Quaternion<double> direction() {
    const Quaternion<double> q = inBall();
    return q * (1 / std::sqrt(normSquared(q)));
  }

 private:
  std::mt19937_64 mEngine;
};

template <class P, class Q>
Wide distance(const Quaternion<P>& p, const Quaternion<Q>& q) {
  return sqrt(normSquared(p.template as<Wide>() - q.template as<Wide>()));
}

template <class Real>
Wide length(const Quaternion<Real>& q) {
  return sqrt(normSquared(q.template as<Wide>()));
}

/// Rounded to float, so that float, double and Wide start from the same number.
inline Quaternion<double> floatExact(const Quaternion<double>& q) { return q.as<float>().as<double>(); }

template <class Real>
std::string text(const Quaternion<Real>& q) {
  std::ostringstream out;
  out.precision(17);
  out << '[' << q.a << ' ' << q.b << ' ' << q.c << ' ' << q.d << ']';
  return out.str();
}

inline std::string text(const julia::Point& p) { return text(Quaternion<double>{p[0], p[1], p[2], 0}); }

inline std::string text(const julia::Rational& rational) {
  std::ostringstream out;
  out.precision(9);
  out << "C = " << rational.logScale;
  for (const auto* polynomial : {&rational.top, &rational.bottom}) {
    out << (polynomial == &rational.top ? "; top" : "; bottom") << " scale " << polynomial->powerScale;
    // Enough to see what kind of rational it was; the seed gives the rest.
    for (std::size_t i = 0; i < polynomial->roots.size() && i < 5; ++i)
      out << ' ' << text(polynomial->roots[i].position) << '^' << polynomial->roots[i].power;
    out << " (" << polynomial->roots.size() << " roots)";
  }
  return out.str();
}

}  // namespace law_tests
