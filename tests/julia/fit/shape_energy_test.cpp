// SPDX-License-Identifier: Apache-2.0
// The shape energy against [Kim15] Eqs. 5-7 in 128 bits, and its gradient against differences of them and against the
// ordered products of [Kim15] Appendix A.
#include "julia/fit/shape_energy.h"

#include "julia/instruction_set.h"
#include "support/float128.h"
#include "support/limits.h"
#include "support/reference.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numeric>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

using julia::cellWeights;
using julia::CellWeights;
using julia::FitCell;
using julia::Point;
using julia::Polynomial;
using julia::Quaternion;
using julia::Rational;
using julia::RationalGradient;
using julia::reweighted;
using julia::ShapeEnergy;
using julia::ShapeEnergyOptions;
using law_tests::floatExact;
using law_tests::Random;
using law_tests::text;
using law_tests::Wide;
using test_limits::kInfinity;
using test_limits::kNan;

/// What is done in doubles, sums of a few hundred terms of about 1.
constexpr double kDoubles = 1e-12;

struct Scene {
  std::vector<Point> cells;
  std::vector<double> weights;
  Rational rational;
  ShapeEnergyOptions options;
};

Point randomPoint(Random& random, double size) {
  const Quaternion<double> q =
      floatExact({random.between(-size, size), random.between(-size, size), random.between(-size, size), 0});
  return {q.a, q.b, q.c};
}

Scene randomScene(std::uint64_t seed, int cells, int tops, int bottoms, bool withRest) {
  Random random(seed);
  Scene scene;
  for (int i = 0; i < cells; ++i) {
    scene.cells.push_back(randomPoint(random, 1));
    scene.weights.push_back(random.between(-1, 1) / (0.05 + random.unit()));
  }
  const auto polynomial = [&](int count) {
    Polynomial result;
    for (int i = 0; i < count; ++i) {
      Quaternion<double> position = floatExact(random.inBall());
      if (!withRest) position.d = 0;
      // Every fourth power is 0.
      result.roots.push_back({position, random.integer(0, 3) == 0 ? 0 : random.between(0, 3)});
    }
    result.powerScale = random.between(0.1, 1.5);
    return result;
  };
  scene.rational = {random.between(-1, 1), polynomial(tops), polynomial(bottoms)};
  scene.options.alpha = random.between(0.2, 3);
  return scene;
}

/// Those that the laws of the gradient are tried on.
std::vector<Scene> gradientScenes() {
  std::vector<Scene> scenes;
  for (const std::uint64_t seed : {1, 2, 3}) scenes.push_back(randomScene(seed, 30, 4, 3, seed == 2));
  scenes.push_back(randomScene(4, 30, 5, 0, false));
  scenes.push_back(randomScene(5, 30, 0, 4, true));
  scenes.push_back(randomScene(6, 30, 0, 0, false));
  for (const int which : {0, 1, 2}) {
    scenes.push_back(randomScene(7 + static_cast<std::uint64_t>(which), 30, 3, 4, true));
    Rational& rational = scenes.back().rational;
    if (which != 1) rational.top.powerScale = 0;
    if (which != 0) rational.bottom.powerScale = 0;
  }
  scenes.push_back(randomScene(10, 30, 4, 4, false));
  for (Polynomial* polynomial : {&scenes.back().rational.top, &scenes.back().rational.bottom})
    for (julia::Root& root : polynomial->roots) root.power = 0;
  return scenes;
}

/// A rational whose variables are wide: a difference needs no room for rounding.
struct WideSide {
  std::vector<Quaternion<Wide>> roots;
  std::vector<Wide> powers;
  Wide scale;

  explicit WideSide(const Polynomial& polynomial) : scale(polynomial.powerScale) {
    for (const julia::Root& root : polynomial.roots) {
      roots.push_back(root.position.as<Wide>());
      powers.emplace_back(root.power);
    }
  }

  std::size_t size() const { return roots.size(); }
  /// (q - t_j)^(tau T_j)
  Quaternion<Wide> factor(std::size_t j, const Quaternion<Wide>& q) const {
    return julia::reference::power<Wide>(q - roots[j], scale * powers[j]);
  }
  Quaternion<Wide> inverseFactor(std::size_t j, const Quaternion<Wide>& q) const {
    return julia::reference::power<Wide>(q - roots[j], -scale * powers[j]);
  }
};

struct WideRational {
  Wide logScale;
  WideSide top, bottom;

  explicit WideRational(const Rational& rational)
      : logScale(rational.logScale), top(rational.top), bottom(rational.bottom) {}

  /// The three coordinates of the t_i and of the b_i in their slice, and the one off it.
  std::vector<Wide*> coordinates() {
    std::vector<Wide*> all;
    for (WideSide* side : {&top, &bottom})
      for (Quaternion<Wide>& root : side->roots) all.insert(all.end(), {&root.a, &root.b, &root.c, &root.d});
    return all;
  }

  /// C, tau, beta, the T_i, the B_i.
  std::vector<Wide*> variables() {
    std::vector<Wide*> all{&logScale, &top.scale, &bottom.scale};
    for (WideSide* side : {&top, &bottom})
      for (Wide& power : side->powers) all.push_back(&power);
    return all;
  }
};

Quaternion<Wide> wide(const Point& x) { return {Wide(x[0]), Wide(x[1]), Wide(x[2]), Wide(0)}; }

Wide sumOfMagnitudes(const std::vector<double>& weights) {
  Wide eta = 0;
  for (const double weight : weights) eta += std::abs(weight);
  return eta;
}

/// [Kim15] Eqs. 2 and 8: e^C T B^-1.
Quaternion<Wide> value(const WideRational& rational, const Quaternion<Wide>& q) {
  Quaternion<Wide> top = Quaternion<Wide>::one(), bottom = Quaternion<Wide>::one();
  for (std::size_t j = 0; j < rational.top.size(); ++j) top = top * rational.top.factor(j, q);
  for (std::size_t j = 0; j < rational.bottom.size(); ++j) bottom = bottom * rational.bottom.factor(j, q);
  return top * (conjugate(bottom) * Wide(exp(rational.logScale) / normSquared(bottom)));
}

/// [Kim15] Eqs. 5-7, with the penalty on powers.
Wide directEnergy(const Scene& scene, const WideRational& rational) {
  Wide sum = 0;
  for (std::size_t i = 0; i < scene.cells.size(); ++i) {
    const Wide l = log(julia::reference::norm(value(rational, wide(scene.cells[i]))));
    sum -= tanh(Wide(scene.options.alpha * l)) * scene.weights[i];
  }
  Wide powers = 0;
  for (const WideSide* side : {&rational.top, &rational.bottom})
    for (const Wide& power : side->powers) powers += side->scale * power;
  return sum / sumOfMagnitudes(scene.weights) + scene.options.powerPenalty * powers;
}

/// What float logarithms may do to an energy and to its gradient, to first order.
///   A distance of float coordinates: half an eps for each difference, so 3/2 eps for its square, and as much again for
///   the sum of them. Half of that is left in the logarithm, whose own error is 2 eps of it. So
///   e = eps (2 + 2 |ln d|), times a power tau T of the L that it is part of.
///   psi moves with L by alpha |W| / eta at most. Its slope by a variable is f dL/dv with f = alpha W / eta sech^2,
///   which moves by at most 0.77 alpha^2 |W| / eta with L. dL/dt is tau T times a difference over a square, 4 eps of
///   at most tau T / d together.
struct LogErrors {
  double energy = kDoubles;
  std::vector<double> gradient;  // in the order of WideRational::variables()
  std::vector<double> places;    // of each root, for each of its coordinates
};

LogErrors logErrors(const Scene& scene) {
  constexpr double eps = law_tests::kEpsilon<float>;
  const Rational& rational = scene.rational;
  const std::size_t tops = rational.top.roots.size(), bottoms = rational.bottom.roots.size();
  LogErrors errors;
  errors.gradient.assign(3 + tops + bottoms, kDoubles);
  errors.places.assign(tops + bottoms, kDoubles);
  const double eta = static_cast<double>(sumOfMagnitudes(scene.weights)), alpha = scene.options.alpha;
  for (std::size_t i = 0; i < scene.cells.size(); ++i) {
    // |dL/dv|, and how wrong it is.
    std::vector<double> slope(errors.gradient.size()), wrong(errors.gradient.size());
    slope[0] = 1;
    std::vector<double> steepness;  // tau T / d
    double ofL = 0;
    std::size_t at = 3, scaleAt = 1;
    for (const Polynomial* polynomial : {&rational.top, &rational.bottom}) {
      const double scale = std::abs(polynomial->powerScale);
      for (const julia::Root& root : polynomial->roots) {
        const Wide distance = law_tests::length(wide(scene.cells[i]) - root.position.as<Wide>());
        const double l = std::abs(static_cast<double>(log(distance))), e = eps * (2 + 2 * l);
        slope[at] = scale * l;
        wrong[at] = scale * e;
        slope[scaleAt] += std::abs(root.power) * l;
        wrong[scaleAt] += std::abs(root.power) * e;
        ofL += scale * std::abs(root.power) * e;
        steepness.push_back(scale * std::abs(root.power) / static_cast<double>(distance));
        ++at;
      }
      ++scaleAt;
    }
    const double share = alpha * std::abs(scene.weights[i]) / eta;
    errors.energy += share * ofL;
    for (std::size_t k = 0; k < slope.size(); ++k)
      errors.gradient[k] += share * (wrong[k] + 0.77 * alpha * ofL * slope[k]);
    for (std::size_t j = 0; j < steepness.size(); ++j)
      errors.places[j] += share * steepness[j] * (4 * eps + 0.77 * alpha * ofL);
  }
  return errors;
}

ShapeEnergy energyOf(const Scene& scene) {
  return ShapeEnergy(scene.cells, scene.weights, scene.rational, scene.options);
}

std::vector<double> flattened(const RationalGradient& gradient) {
  std::vector<double> all{gradient.logScale, gradient.topScale, gradient.bottomScale};
  all.insert(all.end(), gradient.top.begin(), gradient.top.end());
  all.insert(all.end(), gradient.bottom.begin(), gradient.bottom.end());
  return all;
}

TEST(ShapeEnergy, isTheEnergyOfThePaper) {
  for (Scene scene : gradientScenes())
    for (const double penalty : {0., 0.25}) {
      scene.options.powerPenalty = penalty;
      const double expected = static_cast<double>(directEnergy(scene, WideRational(scene.rational)));
      EXPECT_NEAR(energyOf(scene).evaluate(scene.rational, nullptr), expected, logErrors(scene).energy)
          << text(scene.rational);
    }
}

/// The slope of the energy by a variable of the rational, which comes back as it was.
double differenceQuotient(const Scene& scene, WideRational& rational, Wide& variable) {
  const Wide h = Wide(1e-9);  // the third derivative adds 1e-18 of its size
  const Wide at = variable;
  variable = at + h;
  const Wide above = directEnergy(scene, rational);
  variable = at - h;
  const Wide below = directEnergy(scene, rational);
  variable = at;
  return static_cast<double>(Wide(above - below) / (2 * h));
}

// Promise: The gradient of a fit is that of Kim's ...
TEST(ShapeEnergy, gradientIsThatOfDifferences) {
  for (Scene scene : gradientScenes())
    for (const double penalty : {0., 0.25}) {
      scene.options.powerPenalty = penalty;
      RationalGradient gradient;
      energyOf(scene).evaluate(scene.rational, &gradient);
      const std::vector<double> found = flattened(gradient);
      const LogErrors allowed = logErrors(scene);
      WideRational rational(scene.rational);
      const std::vector<Wide*> variables = rational.variables();
      ASSERT_EQ(found.size(), variables.size());
      for (std::size_t k = 0; k < found.size(); ++k) {
        EXPECT_NEAR(found[k], differenceQuotient(scene, rational, *variables[k]), allowed.gradient[k])
            << "variable " << k << ": " << text(scene.rational);
      }
    }
}

std::vector<double> flattenedPlaces(const RationalGradient& gradient) {
  std::vector<double> all;
  for (const auto* places : {&gradient.topPlaces, &gradient.bottomPlaces})
    for (const Quaternion<double>& by : *places) all.insert(all.end(), {by.a, by.b, by.c, by.d});
  return all;
}

// Promise of fitting.md: In each stage of a fit "the roots also move", and "A root moves only where the distances of
//   the cells prove that it stays on its side"
TEST(ShapeEnergy, gradientByPlacesIsThatOfDifferences) {
  std::size_t tried = 0;
  for (const Scene& scene : gradientScenes()) {
    RationalGradient gradient, powersOnly;
    const ShapeEnergy energy = energyOf(scene);
    const double value = energy.evaluate(scene.rational, &gradient, julia::GradientOf::PowersAndPlaces);
    EXPECT_EQ(energy.evaluate(scene.rational, &powersOnly), value);
    EXPECT_EQ(flattened(gradient), flattened(powersOnly));
    EXPECT_TRUE(flattenedPlaces(powersOnly).empty());
    const std::vector<double> found = flattenedPlaces(gradient);
    const LogErrors allowed = logErrors(scene);
    WideRational rational(scene.rational);
    const std::vector<Wide*> coordinates = rational.coordinates();
    ASSERT_EQ(found.size(), coordinates.size());
    for (std::size_t k = 0; k < found.size(); ++k) {
      EXPECT_NEAR(found[k], differenceQuotient(scene, rational, *coordinates[k]), allowed.places[k / 4])
          << "coordinate " << k << ": " << text(scene.rational);
      tried += found[k] != 0;
    }
  }
  EXPECT_GT(tried, 50U);
}

TEST(ShapeEnergy, movedRootsAreAsAnotherEnergy) {
  const Scene scene = randomScene(26, 700, 5, 4, true);
  for (const std::size_t memoryLimit : {std::size_t{0}, std::size_t{1} << 30}) {
    Scene moved = scene;
    moved.options.memoryLimit = memoryLimit;
    ShapeEnergy energy = energyOf(moved);
    moved.rational.top.roots = randomScene(27, 1, 5, 4, true).rational.top.roots;
    energy.moveRoots(moved.rational);
    RationalGradient found, expected;
    EXPECT_EQ(energy.evaluate(moved.rational, &found, julia::GradientOf::PowersAndPlaces),
              energyOf(moved).evaluate(moved.rational, &expected, julia::GradientOf::PowersAndPlaces));
    EXPECT_EQ(flattened(found), flattened(expected));
    EXPECT_EQ(flattenedPlaces(found), flattenedPlaces(expected));
  }
}

/// ln|q| + n t of q = |q| (cos t + n sin t).
Quaternion<Wide> logarithm(const Quaternion<Wide>& q) {
  const Wide length = julia::reference::norm(q), imaginary = sqrt(Wide(q.b * q.b + q.c * q.c + q.d * q.d));
  const Wide along = imaginary == 0 ? Wide(0) : Wide(atan2(imaginary, q.a) / imaginary);
  return {log(length), q.b * along, q.c * along, q.d * along};
}

/// [Kim15] Appendix A for one cell: dL by C, tau, beta, the T_i and the B_i, from ordered products of quaternions with
/// the caches of its Eq. 9. The dots of Eqs. 23-26 are products of 4-vectors: R . dR / R . R is the real part of
/// conj(R) dR / |R|^2, which is d ln|R|.
///
/// As printed the formulas cannot all be meant. Here
/// - the numerators of Eqs. 23 and 25 are divided by B, on the right, as R itself is;
/// - Eq. 10 has T_i where it prints tau, as the formula above it and Eq. 25 have;
/// - Eq. 26 divides by a sum of products; but d(B^-1) is the sum of the inverses, each as Eq. 27 has it, with B_i for
///   beta.
std::vector<Wide> appendixA(const WideRational& rational, const Quaternion<Wide>& q) {
  using Q = Quaternion<Wide>;
  const WideSide &top = rational.top, &bottom = rational.bottom;
  const std::size_t tops = top.size(), bottoms = bottom.size();
  // Eq. 9: forward[i] = product of the first i factors, reverse[i] = of those from i on.
  std::vector<Q> forward(tops + 1, Q::one()), reverse(tops + 1, Q::one());
  for (std::size_t i = 0; i < tops; ++i) forward[i + 1] = forward[i] * top.factor(i, q);
  for (std::size_t i = tops; i-- > 0;) reverse[i] = top.factor(i, q) * reverse[i + 1];
  // Of B^-1, in which the last factor comes first: last[i] = the inverses from the last one to i, first[i] = those
  // from i - 1 to the first.
  std::vector<Q> last(bottoms + 1, Q::one()), first(bottoms + 1, Q::one());
  for (std::size_t i = bottoms; i-- > 0;) last[i] = last[i + 1] * bottom.inverseFactor(i, q);
  for (std::size_t i = 0; i < bottoms; ++i) first[i + 1] = bottom.inverseFactor(i, q) * first[i];

  const Wide scale = exp(rational.logScale);
  const Q R = forward[tops] * last[0] * scale;
  const auto dLog = [&](const Q& dR) -> Wide {
    return (R.a * dR.a + R.b * dR.b + R.c * dR.c + R.d * dR.d) / normSquared(R);
  };
  std::vector<Wide> byTop, byBottom;
  Q byTau{}, byBeta{};
  for (std::size_t i = 0; i < tops; ++i) {
    const Q logOfRoot = forward[i] * logarithm(q - top.roots[i]) * reverse[i];
    byTop.push_back(dLog(logOfRoot * top.scale * last[0] * scale));
    byTau = byTau + logOfRoot * top.powers[i];
  }
  for (std::size_t i = 0; i < bottoms; ++i) {
    const Q logOfRoot = last[i] * logarithm(q - bottom.roots[i]) * first[i];
    byBottom.push_back(dLog(forward[tops] * (logOfRoot * bottom.scale) * Wide(-scale)));
    byBeta = byBeta + logOfRoot * bottom.powers[i];
  }
  std::vector<Wide> all{1, dLog(byTau * last[0] * scale), dLog(forward[tops] * byBeta * Wide(-scale))};
  all.insert(all.end(), byTop.begin(), byTop.end());
  all.insert(all.end(), byBottom.begin(), byBottom.end());
  return all;
}

// Promise of fitting.md: The gradient of a fit is that of Kim's appendix: "A test compares all this with the products
//   of Appendix A in 128 bits"
TEST(ShapeEnergy, gradientIsThatOfAppendixA) {
  for (const Scene& scene : gradientScenes()) {
    RationalGradient gradient;
    energyOf(scene).evaluate(scene.rational, &gradient);
    const std::vector<double> found = flattened(gradient);
    const WideRational rational(scene.rational);
    std::vector<Wide> expected(found.size(), Wide(0));
    const Wide alpha = scene.options.alpha, eta = sumOfMagnitudes(scene.weights);
    for (std::size_t i = 0; i < scene.cells.size(); ++i) {
      const Quaternion<Wide> q = wide(scene.cells[i]);
      const Wide l = log(julia::reference::norm(value(rational, q)));  // Eq. 20
      // Eq. 21 prints neither the minus of Eq. 5 nor 1 / eta.
      const Wide t = tanh(Wide(alpha * l)), byL = -alpha * scene.weights[i] * (1 - t * t) / eta;
      const std::vector<Wide> slopes = appendixA(rational, q);
      ASSERT_EQ(slopes.size(), expected.size());
      for (std::size_t k = 0; k < slopes.size(); ++k) expected[k] += byL * slopes[k];
    }
    const LogErrors allowed = logErrors(scene);
    for (std::size_t k = 0; k < found.size(); ++k)
      EXPECT_NEAR(found[k], static_cast<double>(expected[k]), allowed.gradient[k])
          << "variable " << k << ": " << text(scene.rational);
  }
}

/// Cells inside and outside a sphere about 0, none of them near it.
Scene sphereScene(double radius) {
  Random random(20);
  Scene scene;
  while (scene.cells.size() < 600) {
    const Point x = randomPoint(random, 1);
    const double distance = std::hypot(x[0], x[1], x[2]) - radius;
    if (std::abs(distance) < 0.02) continue;
    scene.cells.push_back(x);
    scene.weights.push_back(1 / distance);
  }
  scene.rational = {-2.5 * std::log(radius), {{{{0, 0, 0, 0}, 2.5}}}, {}};
  return scene;
}

// Promise of fitting.md: psi "is -1 for a perfect match and 1 for the exact opposite"
TEST(ShapeEnergy, isMinusOneForAPerfectMatchAndOneForItsOpposite) {
  for (const double radius : {0.3, 0.7, 1.2}) {
    Scene scene = sphereScene(radius);
    scene.options.alpha = 1000;
    EXPECT_NEAR(energyOf(scene).evaluate(scene.rational, nullptr), -1, 1e-12) << radius;
    for (double& weight : scene.weights) weight = -weight;
    EXPECT_NEAR(energyOf(scene).evaluate(scene.rational, nullptr), 1, 1e-12) << radius;
  }
}

// Promise: psi "is -1 for a perfect ..."
TEST(ShapeEnergy, isNeverBeyondOne) {
  Random random(21);
  for (std::uint64_t seed = 100; seed < 160; ++seed) {
    Scene scene = randomScene(seed, random.integer(1, 700), random.integer(0, 6), random.integer(0, 6), true);
    scene.options.alpha = std::pow(10, random.between(-4, 6));
    for (double& weight : scene.weights) weight *= std::pow(10, random.between(-8, 8));
    if (seed % 3 == 0) {
      // All cells on one side: the sum is 1 but for rounding.
      scene.rational.logScale = random.between(-1e6, 1e6);
      for (double& weight : scene.weights) weight = std::abs(weight);
    }
    const double psi = energyOf(scene).evaluate(scene.rational, nullptr);
    EXPECT_GE(psi, -1) << seed;
    EXPECT_LE(psi, 1) << seed;
  }
}

std::vector<std::uint64_t> bitsOf(const std::vector<double>& values) {
  std::vector<std::uint64_t> bits;
  for (const double value : values) bits.push_back(std::bit_cast<std::uint64_t>(value));
  return bits;
}

/// Energy, gradient and every log-modulus.
std::vector<std::uint64_t> bitsOfEnergy(const Scene& scene) {
  const ShapeEnergy energy = energyOf(scene);
  RationalGradient gradient;
  std::vector<double> all{energy.evaluate(scene.rational, &gradient, julia::GradientOf::PowersAndPlaces),
                          energy.evaluate(scene.rational, nullptr)};
  for (const std::vector<double>& slopes : {flattened(gradient), flattenedPlaces(gradient)})
    all.insert(all.end(), slopes.begin(), slopes.end());
  std::vector<double> l(scene.cells.size());
  energy.logModuli(scene.rational, l);
  all.insert(all.end(), l.begin(), l.end());
  return bitsOf(all);
}

TEST(ShapeEnergy, scalingAllWeightsChangesNothing) {
  Scene scene = randomScene(22, 500, 5, 4, false);
  const std::vector<std::uint64_t> expected = bitsOfEnergy(scene);
  const double energy = energyOf(scene).evaluate(scene.rational, nullptr);
  for (double& weight : scene.weights) weight *= 0x1p-40;
  EXPECT_EQ(bitsOfEnergy(scene), expected);
  for (double& weight : scene.weights) weight *= 12345.678;
  EXPECT_NEAR(energyOf(scene).evaluate(scene.rational, nullptr), energy, kDoubles);
}

TEST(ShapeEnergy, otherWeightsAreAsAnotherEnergy) {
  const Scene scene = randomScene(24, 300, 4, 4, false);
  Scene other = randomScene(25, 300, 0, 0, false);
  other.cells = scene.cells;
  other.rational = scene.rational;
  other.options = scene.options;
  ShapeEnergy energy = energyOf(scene);
  energy.setWeights(other.weights);
  EXPECT_EQ(energy.weights(), other.weights);
  RationalGradient found, expected;
  EXPECT_EQ(energy.evaluate(scene.rational, &found), energyOf(other).evaluate(scene.rational, &expected));
  EXPECT_EQ(flattened(found), flattened(expected));
  EXPECT_THROW(energy.setWeights(std::vector<double>(299, 1)), std::invalid_argument);
  EXPECT_THROW(energy.setWeights(std::vector<double>(300, 0)), std::invalid_argument);
  EXPECT_EQ(energy.weights(), other.weights);
}

// 5000 cells are 20 blocks, the last of them padded, and three parts.
TEST(ShapeEnergy, memoryThreadsAndInstructionSetsChangeNoBit) {
  for (const int cells : {1, 256, 5000}) {
    Scene scene = randomScene(23, cells, 9, 6, true);
    const std::vector<std::uint64_t> expected = bitsOfEnergy(scene);
    scene.options.memoryLimit = 0;
    EXPECT_EQ(bitsOfEnergy(scene), expected) << cells << " cells, logs made anew";
    for (const std::size_t memoryLimit : {std::size_t{0}, std::size_t{1} << 30}) {
      scene.options.memoryLimit = memoryLimit;
      for (const std::size_t threads : {1, 2, 5}) {
        const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
        EXPECT_EQ(bitsOfEnergy(scene), expected) << cells << " cells, threads: " << threads;
      }
      const julia::InstructionSet before = julia::instructionSet();
      for (const julia::InstructionSet set : julia::availableInstructionSets()) {
        julia::setInstructionSet(set);
        EXPECT_EQ(bitsOfEnergy(scene), expected) << cells << " cells, " << julia::nameOf(set);
      }
      julia::setInstructionSet(before);
    }
  }
}

TEST(ShapeEnergy, penaltyAddsTheSummedPowers) {
  for (std::uint64_t seed = 30; seed < 40; ++seed) {
    Scene scene = randomScene(seed, 100, 4, 5, false);
    const double psi = energyOf(scene).evaluate(scene.rational, nullptr);
    scene.options.powerPenalty = 0.01 * static_cast<double>(seed);
    double powers = 0;
    for (const Polynomial* polynomial : {&scene.rational.top, &scene.rational.bottom})
      for (const julia::Root& root : polynomial->roots) powers += polynomial->powerScale * root.power;
    EXPECT_NEAR(energyOf(scene).evaluate(scene.rational, nullptr), psi + scene.options.powerPenalty * powers, kDoubles);
  }
}

// The fourth component of a root is its distance from the slice of the cells.
TEST(ShapeEnergy, logModuliAreThoseOfTheRational) {
  for (const bool withRest : {false, true}) {
    const Scene scene = randomScene(40, 1000, 7, 6, withRest);
    std::vector<double> l(scene.cells.size());
    energyOf(scene).logModuli(scene.rational, l);
    const julia::RationalEvaluator<double> evaluator(scene.rational);
    for (std::size_t i = 0; i < l.size(); ++i) {
      const Point& x = scene.cells[i];
      Scene cell = scene;
      cell.cells = {x};
      cell.weights = {1};
      // By C the slope of psi is alpha; so is the error of psi that of L, alpha times.
      const double allowed = logErrors(cell).energy / scene.options.alpha + kDoubles;
      EXPECT_NEAR(l[i], evaluator.logModulus({x[0], x[1], x[2], 0}), allowed) << i;
    }
  }
}

TEST(ShapeEnergy, aCellOnARootIsFarInside) {
  Scene scene = randomScene(41, 300, 5, 4, false);
  for (Polynomial* polynomial : {&scene.rational.top, &scene.rational.bottom})
    for (julia::Root& root : polynomial->roots) root.power += 0.5;
  const std::size_t onTop = scene.cells.size(), onBottom = onTop + 1;
  for (const Polynomial* polynomial : {&scene.rational.top, &scene.rational.bottom}) {
    const Quaternion<double> r = polynomial->roots[1].position;
    scene.cells.push_back({r.a, r.b, r.c});
    scene.weights.push_back(1);
  }
  RationalGradient gradient;
  EXPECT_TRUE(std::isfinite(energyOf(scene).evaluate(scene.rational, &gradient)));
  for (const double slope : flattened(gradient)) EXPECT_TRUE(std::isfinite(slope));
  std::vector<double> l(scene.cells.size());
  energyOf(scene).logModuli(scene.rational, l);
  EXPECT_EQ(std::min_element(l.begin(), l.end()) - l.begin(), static_cast<std::ptrdiff_t>(onTop));
  EXPECT_EQ(std::max_element(l.begin(), l.end()) - l.begin(), static_cast<std::ptrdiff_t>(onBottom));
  EXPECT_TRUE(std::isfinite(l[onTop]) && std::isfinite(l[onBottom]));
}

/// That @a work is refused, with @a word in the message.
void expectRefused(const std::function<void()>& work, const std::string& word) {
  try {
    work();
    ADD_FAILURE() << "accepted: " << word;
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << word << " is not in: " << error.what();
  }
}

TEST(ShapeEnergy, refusesNonsense) {
  const auto refused = [](const std::function<void(Scene&)>& change, const std::string& word) {
    Scene scene = randomScene(50, 17, 2, 2, false);
    change(scene);
    expectRefused([&] { energyOf(scene); }, word);
  };
  refused([](Scene& s) { s.cells.clear(), s.weights.clear(); }, " 0 cells");
  refused([](Scene& s) { s.weights.pop_back(); }, "16 weights");
  refused([](Scene& s) { s.cells.pop_back(); }, "16 cells");
  refused([](Scene& s) { s.weights.assign(17, 0); }, "sum to 0");
  refused([](Scene& s) { s.weights[3] = kNan; }, "nan");
  refused([](Scene& s) { s.weights[3] = -kInfinity; }, "inf");
  refused([](Scene& s) { s.options.alpha = 0; }, "alpha is 0");
  refused([](Scene& s) { s.options.alpha = -1e-9; }, "alpha is -1e-09");
  refused([](Scene& s) { s.options.alpha = kInfinity; }, "alpha is inf");
  refused([](Scene& s) { s.options.alpha = kNan; }, "alpha is nan");
  refused([](Scene& s) { s.options.powerPenalty = -1e-9; }, "-1e-09");
  refused([](Scene& s) { s.options.powerPenalty = kNan; }, "nan");
  refused([](Scene& s) { s.options.powerPenalty = kInfinity; }, "inf");
  refused([](Scene& s) { s.cells[4][1] = kNan; }, "nan");
  refused([](Scene& s) { s.rational.bottom.roots[1].position.c = kInfinity; }, "inf");

  const Scene scene = randomScene(51, 17, 2, 3, false);
  const ShapeEnergy energy = energyOf(scene);
  Rational other = scene.rational;
  other.top.roots.push_back(other.bottom.roots.back());
  other.bottom.roots.pop_back();  // as many together
  std::vector<double> l(17);
  expectRefused([&] { energy.evaluate(other, nullptr); }, "3 and 2 roots");
  expectRefused([&] { energy.logModuli(other, l); }, "3 and 2 roots");
  ShapeEnergy moving = energyOf(scene);
  expectRefused([&] { moving.moveRoots(other); }, "3 and 2 roots");
  other = scene.rational;
  other.top.roots[0].position.b = kNan;
  expectRefused([&] { moving.moveRoots(other); }, "nan");
}

std::vector<FitCell> cellsAt(const std::vector<float>& distances) {
  std::vector<FitCell> cells;
  for (const float phi : distances) cells.push_back({{0, 0, 0}, phi, 1});
  return cells;
}

TEST(CellWeights, inverseDistanceIsTheInverse) {
  constexpr double h = 0.25;
  std::vector<FitCell> cells = cellsAt({-2, -0.5F, 0.5F, 3, -0.01F, 0, 1e-30F});
  const std::vector<double> weights = cellWeights(cells, CellWeights::InverseDistance, h);
  // The ratio of two far cells is the inverse of their distances' ratio; near ones weigh as at half a cell.
  EXPECT_DOUBLE_EQ(weights[0] / weights[1], 0.5 / 2);
  EXPECT_DOUBLE_EQ(weights[2] / weights[3], 3 / 0.5);
  EXPECT_DOUBLE_EQ(weights[4] / weights[1], 0.5 / (h / 2));
  EXPECT_EQ(weights[5], -weights[4]);
  EXPECT_EQ(weights[6], weights[5]);
  for (std::size_t i = 0; i < cells.size(); ++i) EXPECT_EQ(std::signbit(weights[i]), cells[i].phi < 0) << i;
  for (FitCell& cell : cells) cell.volume = 8;
  const std::vector<double> larger = cellWeights(cells, CellWeights::InverseDistance, h);
  for (std::size_t i = 0; i < cells.size(); ++i) EXPECT_EQ(larger[i], 8 * weights[i]) << i;
}

TEST(CellWeights, layersOfEachSideSumToOneHalf) {
  constexpr double h = 0.25;
  std::vector<FitCell> cells = cellsAt({-0.1F, -0.2F, -0.3F, -0.9F, 0, 0.1F, 0.26F, 0.6F, 5});
  const auto layer = std::vector<double>{1, 1, 2, 4, 1, 1, 2, 3, 20};
  const std::vector<double> weights = cellWeights(cells, CellWeights::Layers, h);
  double inside = 0, outside = 0;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    (cells[i].phi < 0 ? inside : outside) += weights[i];
    // Within a side, a cell weighs the inverse of its layer.
    EXPECT_DOUBLE_EQ(weights[i] * layer[i], weights[cells[i].phi < 0 ? 0 : 4]) << i;
  }
  EXPECT_DOUBLE_EQ(inside, -0.5);
  EXPECT_DOUBLE_EQ(outside, 0.5);
  cells = cellsAt({1, 2, 3});
  const std::vector<double> oneSide = cellWeights(cells, CellWeights::Layers, h);
  EXPECT_DOUBLE_EQ(std::accumulate(oneSide.begin(), oneSide.end(), 0.0), 0.5);
}

TEST(Reweighted, theTwoRegionsBecomeEqual) {
  Random random(60);
  for (const double alpha : {0.5, 4.}) {
    std::vector<double> weights, l;
    std::vector<char> fractalInside;
    for (int i = 0; i < 500; ++i) {
      weights.push_back(random.between(-1, 1));
      l.push_back(random.between(-2, 1));
      fractalInside.push_back(l.back() < 0);
    }
    const std::vector<double> result = reweighted(weights, l, alpha, fractalInside);
    ASSERT_EQ(result.size(), weights.size());
    double before[2] = {}, after[2] = {};
    std::vector<double> factors[2];
    for (std::size_t i = 0; i < weights.size(); ++i) {
      if (weights[i] >= 0) {
        EXPECT_EQ(result[i], weights[i]) << i;
        continue;
      }
      const int region = fractalInside[i] ? 1 : 0;
      before[region] += std::abs(std::tanh(alpha * l[i]) * weights[i]);
      after[region] += std::abs(std::tanh(alpha * l[i]) * result[i]);
      factors[region].push_back(result[i] / weights[i]);
    }
    ASSERT_GT(std::abs(before[0] - before[1]), 1);  // or there was nothing to do
    EXPECT_NEAR(after[0], after[1], kDoubles * after[0]);
    EXPECT_NEAR(after[0] + after[1], before[0] + before[1], kDoubles * after[0]);
    for (const std::vector<double>& region : factors)
      for (const double factor : region) EXPECT_NEAR(factor, region[0], 1e-14 * region[0]);
  }
}

TEST(Reweighted, anEmptyRegionChangesNothing) {
  const std::vector<double> weights{-1, -2, 3, -4}, l{-1, -2, 3, 0.5};
  for (const std::vector<char>& fractalInside : {std::vector<char>{1, 1, 0, 1}, std::vector<char>{0, 0, 1, 0}})
    EXPECT_EQ(reweighted(weights, l, 1, fractalInside), weights);
  // A region whose cells all lie on the surface has nothing to scale.
  EXPECT_EQ(reweighted(weights, std::vector<double>{0, 0, 3, 0.5}, 1, std::vector<char>{1, 1, 0, 0}), weights);
  EXPECT_TRUE(reweighted({}, {}, 1, {}).empty());
}

}  // namespace
