// SPDX-License-Identifier: Apache-2.0
// The reference, run from nothing but an evaluator's description, finds the signs that the evaluator finds.
#include "julia/map_description.h"

#include "julia/brick_field.h"
#include "julia/cross_map.h"
#include "julia/evaluator.h"
#include "julia/expression_pair.h"
#include "julia/mandelbulb.h"
#include "julia/quadratic_map.h"
#include "julia/rational_map.h"
#include "julia/shape_modulus.h"
#include "support/float128.h"
#include "support/lumpy_bricks.h"
#include "support/reference.h"
#include "support/reference_triplex.h"
#include "support/reference_waves.h"

#include "support/random_waves.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

namespace reference = julia::reference;
using julia::CrossOptions;
using julia::CrossPair;
using julia::CrossScheme;
using julia::DropAxis;
using julia::Embedding;
using julia::FieldDescription;
using julia::FieldEvaluator;
using julia::Interpolation;
using julia::makeFieldEvaluator;
using julia::MandelbulbOptions;
using julia::OrbitOptions;
using julia::Point;
using julia::QuadraticDescription;
using julia::Quaternion;
using julia::Rational;
using julia::ShapeModulusDescription;
using law_tests::lumpyBricks;
using law_tests::Random;
using Long = long double;

// ------------------------------------------------------------------------------------- another back end, in a few
// lines

Long nodeOf(const julia::Bricks& bricks, const std::array<int, 3>& node) {
  std::size_t place = 0, offset = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const int side = julia::kBrickSide, last = static_cast<int>(bricks.count[axis]) - 1;
    const int brick = std::clamp((node[axis] + side) / side - 1, 0, last);
    place = place * bricks.count[axis] + static_cast<std::size_t>(brick);
    offset = offset * bricks.side() + static_cast<std::size_t>(node[axis] - brick * side) + bricks.before();
  }
  return static_cast<Long>(bricks.values[bricks.brickAt[place] * bricks.size() + offset]);
}

/// Weights of the nodes around a position along one axis, and the first of these nodes.
struct Weights {
  int first;
  std::vector<Long> of;
};
Weights weightsAt(Interpolation interpolation, Long position) {
  if (interpolation == Interpolation::Trilinear) {
    const Long t = position - std::floor(position);
    return {static_cast<int>(std::floor(position)), {1 - t, t}};
  }
  const Long nearest = std::floor(position + 0.5L), t = position - nearest;
  return {static_cast<int>(nearest) - 1, {(0.5L - t) * (0.5L - t) / 2, 0.75L - t * t, (0.5L + t) * (0.5L + t) / 2}};
}

Long read(const julia::PlacedBricks& field, const std::array<Long, 3>& x) {
  std::array<Weights, 3> along;
  for (std::size_t row = 0; row < 3; ++row) {
    Long position = field.placement.offset[row];
    for (std::size_t column = 0; column < 3; ++column) position += field.placement.matrix[row][column] * x[column];
    along[row] = weightsAt(field.bricks->interpolation,
                           std::clamp<Long>(position, field.placement.low[row], field.placement.high[row]));
  }
  const int width = static_cast<int>(along[0].of.size());
  Long sum = 0;
  for (int i = 0; i < width; ++i)
    for (int j = 0; j < width; ++j)
      for (int k = 0; k < width; ++k) {
        const std::array<int, 3> step{i, j, k};
        Long weight = 1;
        std::array<int, 3> node{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
          weight *= along[axis].of[static_cast<std::size_t>(step[axis])];
          node[axis] = along[axis].first + step[axis];
        }
        if (weight != 0) sum += weight * nodeOf(*field.bricks, node);
      }
  const julia::Knee& knee = field.placement.knee;
  return sum + knee.more * std::min<Long>(sum - knee.at, 0);
}

reference::FunctionPair<Long> pairOf(const CrossOptions& options) {
  if (options.pair != CrossPair::User) return reference::functionPair<Long>(options.pair);
  const auto user = std::make_shared<julia::ExpressionPair>(options.f, options.g);
  const auto part = [user](bool first) -> reference::VectorFunction<Long> {
    return [user, first](const reference::Vector<Long>& p) {
      julia::QuaternionBatch<double> at, f, g;
      at.resize(1);
      at.set(0, {static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2]), 0});
      user->evaluate(at, f, g);
      const Quaternion<double> value = (first ? f : g).get(0);
      return reference::Vector<Long>{value.a, value.b, value.c};
    };
  };
  return {part(true), part(false)};
}

reference::Orbit<Long> referenceOrbit(const FieldDescription& field, const Point& x) {
  const Quaternion<Long> start = field.embedding.quaternion<Long>(x);
  const int n = field.orbit.maxIterations;
  const Long escape = field.orbit.escapeRadius;
  const reference::Vector<Long> spatial{start.a, start.b, start.c};
  if (const auto* shape = std::any_cast<ShapeModulusDescription>(&field.map)) {
    const auto exponent = [shape](const Quaternion<Long>& q) {
      return read(*shape->exponent, Embedding{.dropped = shape->dropped}.point(q));
    };
    if (const auto* waves = std::any_cast<julia::WaveVersorDescription>(&shape->versor)) {
      const auto versor = [waves](const Quaternion<Long>& q) {
        Long least = 1;
        const Long octave = read(*waves->octave, Embedding{.dropped = waves->dropped}.point(q));
        return std::optional(reference::wavesAt<Long>(waves->texture, q, octave, least));
      };
      return reference::orbit<Long>(reference::shapeModulus<Long>(exponent, reference::MapFunction<Long>(versor)),
                                    start, n, escape);
    }
    const auto& rational = std::any_cast<const Rational&>(shape->versor);
    return reference::orbit<Long>(reference::shapeModulus<Long>(exponent, rational), start, n, escape);
  }
  if (const auto* rational = std::any_cast<Rational>(&field.map))
    return reference::orbit<Long>(reference::rationalMap<Long>(*rational), start, n, escape);
  if (const auto* quadratic = std::any_cast<QuadraticDescription>(&field.map)) {
    const Quaternion<double> c = quadratic->constant.value_or(start.as<double>());
    return reference::orbit<Long>(reference::quadraticMap<Long>(c), start, n, escape);
  }
  if (const auto* cross = std::any_cast<CrossOptions>(&field.map)) {
    const reference::Vector<Long> constant{cross->constant[0], cross->constant[1], cross->constant[2]};
    return reference::orbit<Long>(reference::crossStep<Long>(pairOf(*cross), cross->scheme, spatial, constant), spatial,
                                  n, escape);
  }
  if (const auto* triplex = std::any_cast<MandelbulbOptions>(&field.map))
    return reference::orbit<Long>(reference::mandelbulbStep<Long>(*triplex, spatial), spatial, n, escape);
  throw std::logic_error("a map of another kind");
}

// ------------------------------------------------------------------------------------------------------------ the laws

/// Where rounding may decide, the sign is not judged.
void expectSameSigns(const FieldEvaluator& evaluator, double halfWidth, const std::string& what) {
  constexpr int kPoints = 2000;
  constexpr Long kDoubt = 1e-7L;
  const FieldDescription description = evaluator.describe();
  ASSERT_TRUE(description.map.has_value()) << what;
  Random random(1100);
  std::vector<Point> points(kPoints);
  for (Point& x : points)
    for (double& coordinate : x) coordinate = random.between(-halfWidth, halfWidth);
  std::vector<double> field(points.size());
  evaluator.evaluate(points, field, {});
  int inside = 0, judged = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Long wanted = referenceOrbit(description, points[i]).logModulus - static_cast<Long>(description.level);
    if (std::abs(wanted) < kDoubt) continue;
    ++judged;
    inside += wanted < 0;
    EXPECT_EQ(field[i] < 0, wanted < 0) << what << ", point " << i << ": " << field[i] << " for " << wanted;
  }
  EXPECT_GT(judged, kPoints * 99 / 100) << what;
  EXPECT_GT(inside, 0) << what;
  EXPECT_LT(inside, judged) << what;
}

Rational someRoots(int count) {
  Random random(1101);
  Rational rational;
  for (int i = 0; i < count; ++i)
    rational.top.roots.push_back({random.inBall() * 0.4, i % 2 ? random.between(2, 9) : random.integer(2, 9)});
  return rational;
}

TEST(MapDescription, ofTheShapeModulusHoldsItsBricksRootsAndPowers) {
  for (const Interpolation interpolation : {Interpolation::Trilinear, Interpolation::Quadratic})
    for (const DropAxis dropped : {DropAxis::I, DropAxis::J, DropAxis::K}) {
      const julia::PlacedBricks bricks = lumpyBricks(interpolation);
      const auto field = std::make_shared<julia::BrickField<double>>(bricks.bricks, bricks.placement);
      const auto map = std::make_shared<julia::ShapeModulus<double>>(field, someRoots(4), dropped);
      const auto evaluator = makeFieldEvaluator<double>(map, Embedding{0.05, dropped}, OrbitOptions{});
      expectSameSigns(*evaluator, 0.6, "shape modulus, dropped axis " + std::to_string(static_cast<int>(dropped)));
    }
}

TEST(MapDescription, ofWavesHoldsTheirOctaveToo) {
  law_tests::Random random(51);
  for (const DropAxis dropped : {DropAxis::I, DropAxis::J, DropAxis::K}) {
    const julia::PlacedBricks bricks = lumpyBricks(Interpolation::Trilinear);
    const auto field = std::make_shared<julia::BrickField<double>>(bricks.bricks, bricks.placement);
    const auto versor = std::make_shared<julia::WaveVersor<double>>(law_tests::randomWaves(random), field, dropped);
    const auto map = std::make_shared<julia::ShapeModulus<double>>(field, versor, dropped);
    const auto evaluator = makeFieldEvaluator<double>(map, Embedding{0.05, dropped}, OrbitOptions{});
    expectSameSigns(*evaluator, 0.6, "waves, dropped axis " + std::to_string(static_cast<int>(dropped)));
  }
}

TEST(MapDescription, ofARationalIsTheRational) {
  Rational rational = someRoots(3);
  rational.logScale = -2;
  rational.top.powerScale = 0.75;
  rational.bottom.roots = {{{0.8, 0.1, 0, 0}, 3}, {{0, -0.7, 0.2, 0.3}, 1.5}};
  rational.bottom.powerScale = 1.25;
  const auto map = std::make_shared<julia::RationalMap<double>>(rational);
  expectSameSigns(*makeFieldEvaluator<double>(map, Embedding{-0.1}, OrbitOptions{}), 1, "rational");
}

TEST(MapDescription, ofTheQuadraticMapsIsTheirConstant) {
  const OrbitOptions orbit{.maxIterations = 5, .escapeRadius = 8};
  const Quaternion<double> c{-0.2, 0.6, 0.1, -0.3};
  const auto julia = std::make_shared<julia::QuadraticMap<double>>(c);
  expectSameSigns(*makeFieldEvaluator<double>(julia, Embedding{0.1}, orbit), 1.5, "Julia");
  const auto mandelbrot = std::make_shared<julia::QuadraticMandelbrot<double>>();
  expectSameSigns(*makeFieldEvaluator<double>(mandelbrot, Embedding{0.1, DropAxis::J}, orbit), 1.5, "Mandelbrot");
}

TEST(MapDescription, ofACrossMapIsItsOptions) {
  const OrbitOptions orbit{.maxIterations = 4, .escapeRadius = 2};
  for (const CrossScheme scheme : {CrossScheme::FixedFactor, CrossScheme::Mandelbrot, CrossScheme::Julia})
    for (const CrossPair pair :
         {CrossPair::A, CrossPair::APrime, CrossPair::B, CrossPair::C, CrossPair::D, CrossPair::E, CrossPair::User}) {
      const CrossOptions options{pair, scheme, {0.2, -0.3, 0.1}, "x*x, y, z*z", "cos(x), 1, y*y"};
      const auto map = std::make_shared<julia::CrossMap<double>>(options);
      expectSameSigns(
          *makeFieldEvaluator<double>(map, {}, orbit), 1.4,
          "pair " + std::to_string(static_cast<int>(pair)) + ", scheme " + std::to_string(static_cast<int>(scheme)));
    }
}

TEST(MapDescription, ofAMandelbulbIsItsOptions) {
  const OrbitOptions orbit{.maxIterations = 4, .escapeRadius = 2};
  for (const auto angle : {julia::TriplexAngle::AbovePlane, julia::TriplexAngle::FromPole})
    for (const double power : {2., 2.5, 8.})
      for (const bool fixed : {false, true}) {
        const MandelbulbOptions options{power, angle, fixed ? std::optional(Point{0.2, 0.3, -0.4}) : std::nullopt};
        const auto map = std::make_shared<julia::Mandelbulb<double>>(options);
        expectSameSigns(*makeFieldEvaluator<double>(map, {}, orbit), 1.2, "power " + std::to_string(power));
      }
}

TEST(FieldDescription, tellsWhatTheEvaluatorWasMadeFrom) {
  const OrbitOptions orbit{.maxIterations = 7, .escapeRadius = 5, .logTrap = -3, .confirmTrap = true};
  const Embedding embedding{0.25, DropAxis::I};
  const auto map = std::make_shared<julia::RationalMap<float>>(someRoots(2));
  const FieldDescription description = makeFieldEvaluator<float>(map, embedding, orbit)->describe();
  EXPECT_TRUE(description.inFloats);
  EXPECT_EQ(description.embedding.slice, 0.25);
  EXPECT_EQ(description.embedding.dropped, DropAxis::I);
  EXPECT_EQ(description.orbit.maxIterations, 7);
  EXPECT_EQ(description.orbit.escapeRadius, 5);
  EXPECT_EQ(description.orbit.logTrap, -3);
  EXPECT_TRUE(description.orbit.confirmTrap);
  EXPECT_EQ(description.level, 0);
  EXPECT_EQ(std::any_cast<const Rational&>(description.map), someRoots(2));
}

/// A map that does not describe itself.
class Identity final : public julia::CartesianMap<double> {
 public:
  int dimension() const override { return 4; }
  void begin(const julia::QuaternionBatch<double>& start, julia::QuaternionBatch<double>& carried,
             julia::QuaternionBatch<double>& next) const override {
    step(start, carried, next);
  }
  void step(const julia::QuaternionBatch<double>& q, const julia::QuaternionBatch<double>&,
            julia::QuaternionBatch<double>& next) const override {
    next = q;
  }
};

TEST(FieldDescription, hasNoMapWhereTheMapHasNoDescription) {
  const auto evaluator = makeFieldEvaluator<double>(
      std::shared_ptr<const julia::CartesianMap<double>>(std::make_shared<Identity>()), {}, OrbitOptions{});
  EXPECT_FALSE(evaluator->describe().map.has_value());
  EXPECT_EQ(evaluator->describe().orbit.maxIterations, OrbitOptions{}.maxIterations);
}

TEST(Embedding, pointIsTheInverseOfQuaternion) {
  for (const DropAxis dropped : {DropAxis::I, DropAxis::J, DropAxis::K}) {
    const Embedding embedding{7, dropped};
    const Point x{1, 2, 3};
    EXPECT_EQ(embedding.point(embedding.quaternion<double>(x)), x);
    EXPECT_EQ(embedding.slicePart(embedding.quaternion<double>(x)), 7);
  }
}

}  // namespace
