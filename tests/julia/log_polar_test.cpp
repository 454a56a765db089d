// SPDX-License-Identifier: Apache-2.0
// Laws of the quaternions and of their log-polar form, in float and double against 128 bits.
#include "julia/log_polar.h"
#include "julia/reference.h"
#include "support/float128.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace {

using julia::conjugate;
using julia::logNorm;
using julia::LogPolar;
using julia::Quaternion;
using julia::toCartesian;
using julia::toLogPolar;
using julia::versorOf;
using julia::versorPower;
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

TYPED_TEST(LogPolarLaws, roundTrip) {
  using Real = TypeParam;
  for (const auto& q : this->samples()) {
    const auto back = toCartesian(toLogPolar(q));
    const double l = static_cast<double>(log(length(q)));
    // An error in l is a relative one in e^l; exp and the product add one each. Near zero the grid of Real is coarser.
    const Wide tolerance =
        length(q) * Wide(this->logTolerance(l) + this->kVersorTolerance + 2 * this->eps) +
        Wide(2 * std::exp(std::abs(this->logTolerance(l)))) * Wide(std::numeric_limits<Real>::denorm_min()) * 2;
    EXPECT_LE(distance(back, q), tolerance) << text(q) << " -> " << text(back);
  }
}

TYPED_TEST(LogPolarLaws, productIsTheCartesianOne) {
  const auto all = this->samples();
  for (std::size_t i = 0; i + 1 < all.size(); ++i) {
    const auto product = toLogPolar(all[i]) * toLogPolar(all[i + 1]);
    const Quaternion<Wide> expected = all[i].template as<Wide>() * all[i + 1].template as<Wide>();
    const Wide size = length(expected), l1 = log(length(all[i])), l2 = log(length(all[i + 1]));
    EXPECT_LE(abs(Wide(product.l) - log(size)),
              this->logTolerance(l1) + this->logTolerance(l2) + this->eps * (abs(l1) + abs(l2)))
        << text(all[i]) << text(all[i + 1]);
    // A product of unit quaternions: each component four products, three sums of numbers within 1.
    EXPECT_LE(distance(product.u, expected * Wide(1 / size)), 2 * this->kVersorTolerance + 8 * this->eps)
        << text(all[i]) << text(all[i + 1]);
  }
}

TYPED_TEST(LogPolarLaws, inverseUndoes) {
  using Real = TypeParam;
  for (const auto& q : this->samples()) {
    const LogPolar<Real> p = toLogPolar(q), one = p * inverse(p);
    EXPECT_EQ(one.l, Real(0)) << text(q);
    EXPECT_LE(distance(one.u, Quaternion<Real>::one()), 2 * this->kVersorTolerance + 8 * this->eps) << text(q);
    EXPECT_EQ(inverse(inverse(p)).l, p.l) << text(q);
    EXPECT_EQ(inverse(inverse(p)).u, p.u) << text(q);
  }
}

TYPED_TEST(LogPolarLaws, zeroAndInfinity) {
  using Real = TypeParam;
  const Real infinity = std::numeric_limits<Real>::infinity();
  const LogPolar<Real> zero = toLogPolar(Quaternion<Real>{});
  EXPECT_EQ(zero.l, -infinity);
  EXPECT_EQ(zero.u, Quaternion<Real>::one());
  EXPECT_EQ(toLogPolar(Quaternion<Real>{Real(-0.0), Real(-0.0), Real(-0.0), Real(-0.0)}).l, -infinity);
  EXPECT_EQ(toCartesian(zero), Quaternion<Real>{});
  EXPECT_EQ(toCartesian(LogPolar<Real>{-infinity, {Real(0.6), Real(0), Real(-0.8), Real(0)}}), Quaternion<Real>{});
  EXPECT_EQ(inverse(zero).l, infinity);
  for (int component = 0; component < 4; ++component) {
    Quaternion<Real> q{Real(1), Real(-2), Real(3), Real(4)};
    (component == 0 ? q.a : component == 1 ? q.b : component == 2 ? q.c : q.d) = -infinity;
    EXPECT_EQ(toLogPolar(q).l, infinity) << component;
    EXPECT_EQ(toLogPolar(q).u, Quaternion<Real>::one()) << component;
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

TYPED_TEST(VersorPower, integersAndRealsAgreeWithTheWideNumber) {
  using Real = TypeParam;
  for (const auto& u : this->versors()) {
    const Quaternion<Wide> wide = u.template as<Wide>() * Wide(1 / length(u));
    for (int n = -20; n <= 20; ++n) {
      Quaternion<Wide> expected = Quaternion<Wide>::one();
      for (int i = 0; i < std::abs(n); ++i) expected = expected * (n < 0 ? conjugate(wide) : wide);
      EXPECT_LE(distance(versorPower(u, std::int64_t{n}), expected), this->tolerance(n)) << text(u) << '^' << n;
      EXPECT_LE(distance(versorPower(u, Real(n)), expected), this->tolerance(n)) << text(u) << '^' << n;
    }
    for (const double p : {0.5, -0.5, 1.25, 2.75, -7.125, 12.5, 49.75})
      EXPECT_LE(distance(versorPower(u, Real(p)), julia::reference::power<Wide>(wide, Wide(p))), this->tolerance(p))
          << text(u) << '^' << p;
  }
}

TYPED_TEST(VersorPower, exponentsAdd) {
  using Real = TypeParam;
  for (const auto& u : this->versors())
    for (const double p : {-13., -2.5, -0.25, 0., 0.75, 1., 3., 11.5})
      for (const double q : {-7.25, -1., 0., 0.125, 2., 12.}) {
        const double tolerance = this->tolerance(p) + this->tolerance(q) + this->tolerance(p + q);
        EXPECT_LE(distance(versorPower(u, Real(p)) * versorPower(u, Real(q)), versorPower(u, Real(p + q))), tolerance)
            << text(u) << ' ' << p << ' ' << q;
        if (p == std::floor(p) && q == std::floor(q)) {
          const auto m = static_cast<std::int64_t>(p), n = static_cast<std::int64_t>(q);
          EXPECT_LE(distance(versorPower(u, m) * versorPower(u, n), versorPower(u, m + n)), tolerance)
              << text(u) << ' ' << m << ' ' << n;
        }
      }
}

TYPED_TEST(VersorPower, zeroOneAndInverse) {
  using Real = TypeParam;
  for (const auto& u : this->versors()) {
    EXPECT_EQ(versorPower(u, std::int64_t{0}), Quaternion<Real>::one()) << text(u);
    EXPECT_EQ(versorPower(u, Real(0)), Quaternion<Real>::one()) << text(u);
    EXPECT_EQ(versorPower(u, std::int64_t{1}), u) << text(u);
    EXPECT_EQ(versorPower(u, std::int64_t{-1}), conjugate(u)) << text(u);
    EXPECT_LE(distance(versorPower(u, Real(1)), u), this->tolerance(1)) << text(u);
    for (const double p : {0.5, 3., 7.75}) {
      EXPECT_LE(distance(versorPower(u, Real(-p)), conjugate(versorPower(u, Real(p)))), this->tolerance(p)) << p;
      EXPECT_LE(distance(versorPower(u, Real(p)) * versorPower(u, Real(-p)), Quaternion<Real>::one()),
                2 * this->tolerance(p))
          << text(u) << '^' << p;
    }
  }
}

TYPED_TEST(VersorPower, negativeRealTakesI) {
  using Real = TypeParam;
  const Quaternion<Real> minusOne{Real(-1), 0, 0, 0};
  for (int n = -9; n <= 9; ++n) {
    const Quaternion<Real> expected{Real(n % 2 == 0 ? 1 : -1), 0, 0, 0};
    EXPECT_EQ(versorPower(minusOne, std::int64_t{n}), expected) << n;
    EXPECT_LE(distance(versorPower(minusOne, Real(n)), expected), this->tolerance(n)) << n;
  }
  // Also where the zeros are negative, as conjugation leaves them.
  EXPECT_EQ(versorPower(conjugate(minusOne), Real(0.5)), versorPower(minusOne, Real(0.5)));
  EXPECT_EQ(versorPower(Quaternion<Real>{Real(-1), Real(-0.0), Real(-0.0), Real(-0.0)}, Real(0.5)),
            versorPower(minusOne, Real(0.5)));
  const Real h = std::sqrt(Real(0.5));
  EXPECT_LE(distance(versorPower(minusOne, Real(0.5)), Quaternion<Real>{0, Real(1), 0, 0}), this->tolerance(1));
  EXPECT_LE(distance(versorPower(minusOne, Real(-0.5)), Quaternion<Real>{0, Real(-1), 0, 0}), this->tolerance(1));
  EXPECT_LE(distance(versorPower(minusOne, Real(1.5)), Quaternion<Real>{0, Real(-1), 0, 0}), this->tolerance(2));
  EXPECT_LE(distance(versorPower(minusOne, Real(0.25)), Quaternion<Real>{h, h, 0, 0}), this->tolerance(1));
}

// However little separates a versor from a negative real, that little is its axis; and a power is a versor again.
TYPED_TEST(VersorPower, axisSurvivesBesideTheNegativeReals) {
  using Real = TypeParam;
  for (double small = 1e-3; small > std::numeric_limits<Real>::min() * 10.; small /= 10)
    for (const double p : {0.5, 1.5, -2.25}) {
      const Quaternion<Real> u{Real(-1), 0, Real(-0.6 * small), Real(0.8 * small)};
      const Quaternion<Wide> wide = u.template as<Wide>() * Wide(1 / length(u));
      EXPECT_LE(distance(versorPower(u, Real(p)), julia::reference::power<Wide>(wide, Wide(p))), this->tolerance(p))
          << small << ' ' << p;
    }
}

// The error grows with the power, whatever the way it was computed; the size must not.
TYPED_TEST(VersorPower, hugePowersStayFinite) {
  using Real = TypeParam;
  for (const auto& u : this->versors())
    for (const double p : {1e6, -123456.5, 999999999.}) {
      const auto power = versorPower(u, Real(p));
      EXPECT_LE(abs(length(power) - 1), 4 * this->eps) << text(u) << '^' << p;
    }
}

}  // namespace
