// SPDX-License-Identifier: Apache-2.0
// Laws of the quaternions and of their log-polar form, in float and double against 128 bits.
#include "support/float128.h"

#include "careful.h"
#include "support/reference.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace {

using julia::conjugate;
using julia::Quaternion;
using julia::careful::logNorm;
using julia::careful::versorOf;
using julia::careful::versorPower;
using law_tests::distance;
using law_tests::kEpsilon;
using law_tests::length;
using law_tests::Random;
using law_tests::text;
using law_tests::Wide;

// Whole numbers below 10 and three factors stay far below 2^53: every product here is exact, and so are the laws.
std::vector<Quaternion<double>> smallIntegers() {
  std::vector<Quaternion<double>> all = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}, {0, 0, 0, 0}};
  Random random(1);
  const auto digit = [&random] { return static_cast<double>(random.integer(-9, 9)); };
  for (int i = 0; i < 20; ++i) all.push_back({digit(), digit(), digit(), digit()});
  return all;
}

TEST(Quaternion, hamiltonsTable) {
  const Quaternion<double> one = Quaternion<double>::one(), i{0, 1, 0, 0}, j{0, 0, 1, 0}, k{0, 0, 0, 1};
  const Quaternion<double> minusOne = one * -1.0;
  EXPECT_EQ(i * i, minusOne);
  EXPECT_EQ(j * j, minusOne);
  EXPECT_EQ(k * k, minusOne);
  EXPECT_EQ(i * j * k, minusOne);
  EXPECT_EQ(i * j, k);
  EXPECT_EQ(j * k, i);
  EXPECT_EQ(k * i, j);
  EXPECT_EQ(j * i, k * -1.0);
}

TEST(Quaternion, algebraIsExactOnIntegers) {
  const auto all = smallIntegers();
  const Quaternion<double> one = Quaternion<double>::one();
  for (const auto& p : all) {
    EXPECT_EQ(p * one, p) << text(p);
    EXPECT_EQ(one * p, p) << text(p);
    EXPECT_EQ(conjugate(conjugate(p)), p) << text(p);
    EXPECT_EQ(p * conjugate(p), one * normSquared(p)) << text(p);
    for (const auto& q : all) {
      EXPECT_EQ(normSquared(p * q), normSquared(p) * normSquared(q)) << text(p) << text(q);
      EXPECT_EQ(conjugate(p * q), conjugate(q) * conjugate(p)) << text(p) << text(q);
      for (const auto& r : all) {
        EXPECT_EQ((p * q) * r, p * (q * r)) << text(p) << text(q) << text(r);
        EXPECT_EQ(p * (q + r), p * q + p * r) << text(p) << text(q) << text(r);
        EXPECT_EQ((p - q) * r, p * r - q * r) << text(p) << text(q) << text(r);
      }
    }
  }
}

template <class Real>
class LogPolarLaws : public testing::Test {
 protected:
  static constexpr double eps = kEpsilon<Real>;

  /// Directions times lengths of all the orders that Real has, denormals among them.
  static std::vector<Quaternion<Real>> samples() {
    const double low = std::numeric_limits<Real>::denorm_min(), high = std::numeric_limits<Real>::max() / 2;
    Random random(2);
    std::vector<Quaternion<Real>> all;
    for (int i = 0; i < 600; ++i) {
      const double size = std::exp(random.between(std::log(low) + 3, std::log(high)));
      Quaternion<double> q = random.direction();
      // Some lie in a coordinate plane, some have components of very different size.
      if (i % 5 == 1) q.a = q.d = 0;
      if (i % 5 == 2) q.b *= 1e-12;
      if (i % 5 == 3) q = {-1, 0, q.c * 1e-3, 0};
      all.push_back((q * size).as<Real>());
    }
    for (const double size : {1e-30, 1e-10, 1., 1e10, 1e30}) all.push_back((random.direction() * size).as<Real>());
    for (const double c : {low, 7 * low, static_cast<double>(std::numeric_limits<Real>::min()), high})
      all.push_back({Real(0), Real(c), Real(-c), Real(0)});
    std::erase_if(all, [](const auto& q) { return q == Quaternion<Real>{}; });
    return all;
  }

  // Squares and their sum cost 4 roundings of eps/2, halved by the square root: eps. Scaling by the largest component,
  // where the square leaves Real's range, costs two more. The logarithm and the sum of two of them are good to eps |l|
  // each. A square that underflows while the sum does not adds 1.5 eps.
  static double logTolerance(const Wide& l) { return eps * (2 * std::abs(static_cast<double>(l)) + 4); }
  // The same squares, a root, a division and a product for each component.
  static constexpr double kVersorTolerance = 5 * eps;
};

using Reals = testing::Types<float, double>;
TYPED_TEST_SUITE(LogPolarLaws, Reals);

TYPED_TEST(LogPolarLaws, partsAreThoseOfTheWideNumber) {
  for (const auto& q : this->samples()) {
    const Wide size = length(q);
    const Wide l = log(size);
    EXPECT_LE(abs(Wide(logNorm(q)) - l), this->logTolerance(l)) << text(q);
    EXPECT_LE(distance(versorOf(q), q.template as<Wide>() * Wide(1 / size)), this->kVersorTolerance) << text(q);
  }
}

// Promise of design.md: "The versor of 0 is 1", and "coincident top and bottom roots cancel"
TYPED_TEST(LogPolarLaws, zeroAndInfinity) {
  using Real = TypeParam;
  const Real infinity = std::numeric_limits<Real>::infinity();
  const Quaternion<Real> zero;
  EXPECT_EQ(logNorm(zero), -infinity);
  EXPECT_EQ(versorOf(zero), Quaternion<Real>::one());
  EXPECT_EQ(logNorm(Quaternion<Real>{Real(-0.0), Real(-0.0), Real(-0.0), Real(-0.0)}), -infinity);
  for (int component = 0; component < 4; ++component) {
    Quaternion<Real> q{Real(1), Real(-2), Real(3), Real(4)};
    (component == 0 ? q.a : component == 1 ? q.b : component == 2 ? q.c : q.d) = -infinity;
    EXPECT_EQ(logNorm(q), infinity) << component;
    EXPECT_EQ(versorOf(q), Quaternion<Real>::one()) << component;
  }
}

template <class Real>
class VersorPower : public testing::Test {
 protected:
  static constexpr double eps = kEpsilon<Real>;
  static std::vector<Quaternion<Real>> versors() {
    Random random(3);
    std::vector<Quaternion<Real>> all = {
        {Real(1), 0, 0, 0}, {0, Real(1), 0, 0}, {0, 0, Real(-1), 0}, {0, 0, 0, Real(1)}};
    for (int i = 0; i < 100; ++i) all.push_back(versorOf(random.direction().template as<Real>()));
    return all;
  }
  // The versor's own rounding (norm and direction, 5 eps) is multiplied by |p|; squaring repeatedly adds 4 eps a
  // factor; p times an angle within pi, that angle and its sine and cosine cost less than that.
  static double tolerance(double p) { return 12 * eps * (std::abs(p) + 1); }
};
TYPED_TEST_SUITE(VersorPower, Reals);

TYPED_TEST(VersorPower, agreesWithTheWideNumber) {
  for (const auto& u : this->versors()) {
    const Quaternion<Wide> wide = u.template as<Wide>() * Wide(1 / length(u));
    for (int n = -20; n <= 20; ++n) {
      Quaternion<Wide> expected = Quaternion<Wide>::one();
      for (int i = 0; i < std::abs(n); ++i) expected = expected * (n < 0 ? conjugate(wide) : wide);
      EXPECT_LE(distance(versorPower(u, std::int64_t{n}), expected), this->tolerance(n)) << text(u) << '^' << n;
    }
  }
}

TYPED_TEST(VersorPower, exponentsAdd) {
  for (const auto& u : this->versors())
    for (const std::int64_t m : {-13, -2, 0, 1, 3, 11})
      for (const std::int64_t n : {-7, -1, 0, 2, 12})
        EXPECT_LE(distance(versorPower(u, m) * versorPower(u, n), versorPower(u, m + n)),
                  this->tolerance(static_cast<double>(m)) + this->tolerance(static_cast<double>(n)) +
                      this->tolerance(static_cast<double>(m + n)))
            << text(u) << ' ' << m << ' ' << n;
}

TYPED_TEST(VersorPower, zeroOneAndInverse) {
  using Real = TypeParam;
  for (const auto& u : this->versors()) {
    EXPECT_EQ(versorPower(u, std::int64_t{0}), Quaternion<Real>::one()) << text(u);
    EXPECT_EQ(versorPower(u, std::int64_t{1}), u) << text(u);
    EXPECT_EQ(versorPower(u, std::int64_t{-1}), conjugate(u)) << text(u);
  }
}

// The error grows with the power, whatever the way it was computed; the size must not.
TYPED_TEST(VersorPower, hugePowersStayFinite) {
  for (const auto& u : this->versors())
    for (const std::int64_t n : {1'000'000, -123'457}) {
      const auto power = versorPower(u, n);
      EXPECT_LE(abs(length(power) - 1), 4 * this->eps * std::abs(static_cast<double>(n))) << text(u) << '^' << n;
    }
}

}  // namespace
