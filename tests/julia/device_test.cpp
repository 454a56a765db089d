// SPDX-License-Identifier: Apache-2.0
// What a device evaluates has the bits of what the processor evaluates, for every map, and its failures change no bit.
#include "julia/device/device.h"

#include "julia/brick_field.h"
#include "julia/cross_map.h"
#include "julia/function_versor.h"
#include "julia/mandelbulb.h"
#include "julia/mixed_versor.h"
#include "julia/moved_versor.h"
#include "julia/quadratic_map.h"
#include "julia/rational_map.h"
#include "julia/rational_versor.h"
#include "julia/shape_modulus.h"
#include "julia/vector_versor.h"
#include "julia/wave_versor.h"
#include "support/float128.h"
#include "support/lumpy_bricks.h"
#include "support/random_grain.h"
#include "support/random_waves.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

using julia::CrossOptions;
using julia::CrossPair;
using julia::CrossScheme;
using julia::Device;
using julia::DropAxis;
using julia::Embedding;
using julia::FieldEvaluator;
using julia::Interpolation;
using julia::OrbitOptions;
using julia::Point;
using julia::Rational;

/// The first device that can be used; nullptr if there is none at all. That none of some can be used is a failure.
std::shared_ptr<const Device> firstDevice() {
  static const std::shared_ptr<const Device> device = [] {
    std::string refusal;
    const auto devices = julia::openDevices({}, refusal);
    for (const auto& each : devices) {
      if (each->info().refusal.empty()) return each;
      refusal += each->info().name + ": " + each->info().refusal + "; ";
    }
    if (!devices.empty()) throw std::runtime_error(refusal);
    return std::shared_ptr<const Device>();
  }();
  return device;
}

template <class Real>
class Devices : public testing::Test {
 protected:
  void SetUp() override {
    if (!firstDevice()) GTEST_SKIP() << "no device of OpenCL; on Debian, pocl-opencl-icd makes the processor one";
    if (sizeof(Real) == sizeof(double) && !firstDevice()->info().doubles) GTEST_SKIP() << "the device has no doubles";
  }
};
using Reals = testing::Types<float, double>;
TYPED_TEST_SUITE(Devices, Reals);

/// Points about the origin, some far out and some next to each other, and those given.
std::vector<Point> pointsAbout(double radius, const std::vector<Point>& others) {
  law_tests::Random random(7);
  std::vector<Point> points = others;
  for (int i = 0; i < 20000; ++i) {
    const double scale = i % 50 == 0 ? 40 * radius : i % 7 == 0 ? 1e-3 : i % 97 == 0 ? 1e-24 : radius;
    points.push_back({scale * random.between(-1, 1), scale * random.between(-1, 1), scale * random.between(-1, 1)});
  }
  points.push_back({0, 0, 0});
  points.push_back({1e30, 0, 0});
  return points;
}

/// Edges of a lattice, in all three directions, on which the sign of F changes. Of some ends, only the sign is known.
std::vector<julia::CrossedEdge> crossedEdges(const FieldEvaluator& evaluator, const julia::SearchLattice& lattice,
                                             int side) {
  std::vector<julia::CrossedEdge> edges;
  std::vector<Point> points;
  for (int x = -side; x <= side; ++x)
    for (int y = -side; y <= side; ++y)
      for (int z = -side; z <= side; ++z)
        for (int axis = 0; axis < 3; ++axis) {
          const double node[3] = {x + 0.25, y - 0.125, z + 0.5};
          const Point begin{lattice.at(node[0], 0), lattice.at(node[1], 1), lattice.at(node[2], 2)};
          Point end = begin;
          end[static_cast<std::size_t>(axis)] = lattice.at(node[axis] + 1, axis);
          edges.push_back({begin, axis, node[axis], 0, 0});
          points.insert(points.end(), {begin, end});
        }
  std::vector<double> field(points.size());
  evaluator.evaluate(points, field, {});
  std::size_t kept = 0;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const double from = field[2 * i], to = field[2 * i + 1];
    if ((from < 0) == (to < 0)) continue;
    julia::CrossedEdge edge = edges[i];
    edge.from = julia::storedField(from);
    edge.to = julia::storedField(to);
    if (i % 5 == 0) (from < 0 ? edge.to : edge.from) = static_cast<float>(julia::kFieldLimit);
    edges[kept++] = edge;
  }
  edges.resize(kept);
  return edges;
}

/// The device's search ends at the processor's places, to the bit. @return the number of edges
std::size_t expectSameCrossings(const FieldEvaluator& host, const FieldEvaluator& there, double radius,
                                const std::string& what) {
  std::size_t searched = 0;
  for (const double tolerance : {0.1, 1e-3, 1e-9}) {
    const julia::SearchLattice lattice{
        .voxelSize = radius / 10, .centre = {0.1, -0.2, 0.03}, .scale = 1.25, .tolerance = tolerance};
    const auto edges = crossedEdges(host, lattice, 12);
    std::vector<double> expected(edges.size()), found(edges.size());
    host.findCrossings(edges, lattice, expected);
    there.findCrossings(edges, lattice, found);
    EXPECT_EQ(expected, found) << what;
    EXPECT_TRUE(std::ranges::all_of(found, [](double t) { return t >= 0 && t <= 1; })) << what;
    searched += edges.size();
  }
  return searched;
}

/// Where a ray meets the set, sample by sample, as julia/ray_march.h says it.
julia::RayMeeting meetingOf(const FieldEvaluator& host, const julia::RayMarch& march, const julia::MarchedRay& ray) {
  std::vector<double> along = {ray.t};
  for (double t = march.members[0]; t <= ray.end; t += std::max(march.alpha * (march.delta == 0   ? 1
                                                                               : march.delta == 1 ? t
                                                                                                  : t * t),
                                                                march.epsilon))
    if (t > ray.t) along.push_back(t);
  std::vector<Point> points;
  for (const double t : along) points.push_back(julia::pointAlong(march.eye, t, ray.direction));
  std::vector<double> field(points.size());
  host.evaluate(points, field, {});
  const auto isSkipped = [&](const Point& x) {
    if (march.occupied.empty()) return false;
    std::size_t number = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double cell = std::floor((x[axis] - march.corner[axis]) * (1 / march.side));
      if (cell < 0 || cell >= march.count[axis]) return false;
      number = number * static_cast<std::size_t>(march.count[axis]) + static_cast<std::size_t>(cell);
    }
    return (march.occupied[number / 32] >> number % 32 & 1) == 0;
  };
  for (std::size_t i = 0; i < along.size(); ++i) {
    if (!(field[i] < 0) || isSkipped(points[i])) continue;
    julia::RayMeeting met{julia::RayEnd::Met, along[i == 0 ? 0 : i - 1], along[i], 0};
    for (int k = 0; i != 0 && k < march.bisections; ++k) {
      const double middle = 0.5 * (met.outside + met.inside);
      const Point at = julia::pointAlong(march.eye, middle, ray.direction);
      double value = 0;
      host.evaluate({&at, 1}, {&value, 1}, {});
      (value < 0 ? met.inside : met.outside) = middle;
    }
    return met;
  }
  return {julia::RayEnd::Missed, 0, 0, 0};
}

/// The device meets the set where the rule says it, to the bit, with cubes that are left out and without.
/// @param mostLeft  the largest share of rays that may be left to the processor, whose orbits a device cannot decide
/// @return the number of rays that met it
std::size_t expectSameMeetings(const FieldEvaluator& host, const FieldEvaluator& there, double radius, double mostLeft,
                               const std::string& what) {
  constexpr int kRays = 60, kCubes = 12;
  law_tests::Random random(31);
  std::vector<std::uint32_t> occupied(kCubes * kCubes * kCubes / 32);
  for (std::uint32_t& word : occupied)
    for (int bit = 0; bit < 32; ++bit) word |= std::uint32_t{random.between(0, 1) < 0.6} << bit;
  std::size_t met = 0;
  for (int round = 0; round < 4; ++round) {
    julia::RayMarch march{
        .eye = {0.3 * radius, -1.9 * radius, 0.4 * radius}, .epsilon = 2e-3 * radius, .bisections = 12};
    march.delta = round % 3;
    march.alpha = std::array{2.5e-3 * radius, 3e-3, 2e-3 / radius}[static_cast<std::size_t>(march.delta)];
    const double first = 0.2 * radius;
    march.members = {&first, 1};
    if (round % 2 == 1) {
      march.occupied = occupied;
      march.count = {kCubes, kCubes, kCubes};
      march.corner = {-radius, -radius, -radius};
      march.side = 2 * radius / kCubes;
    }
    std::vector<julia::MarchedRay> rays;
    for (int i = 0; i < kRays; ++i) {
      Point direction;
      for (std::size_t axis = 0; axis < 3; ++axis)
        direction[axis] = 0.6 * radius * random.between(-1, 1) - march.eye[axis];
      const double length = std::hypot(direction[0], direction[1], direction[2]);
      for (double& x : direction) x /= length;
      // Some begin within the set.
      const double begin = first * 1.01 + (i % 3 == 0 ? random.between(0, 2 * radius) : 0);
      rays.push_back({direction, begin, begin, begin + random.between(0.5, 3) * radius});
    }
    std::vector<julia::RayMeeting> found(rays.size());
    there.followRays(march, rays, found);
    std::size_t left = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      const julia::RayMeeting expected = meetingOf(host, march, rays[i]);
      if (found[i].end == julia::RayEnd::Left) {
        ++left;
        EXPECT_TRUE(found[i].inside >= rays[i].t && found[i].inside <= rays[i].end) << what;
        continue;
      }
      EXPECT_EQ(found[i].end, expected.end) << what << ", ray " << i;
      if (expected.end != julia::RayEnd::Met) continue;
      ++met;
      EXPECT_EQ(found[i].inside, expected.inside) << what << ", ray " << i;
      EXPECT_EQ(found[i].outside, expected.outside) << what << ", ray " << i;
    }
    EXPECT_LE(static_cast<double>(left), mostLeft * static_cast<double>(rays.size())) << what;
  }
  return met;
}

/// Points that the device makes around others have the bits of points that are given.
void expectSameAround(const FieldEvaluator& host, const FieldEvaluator& there, const std::vector<Point>& centres,
                      const std::string& what) {
  const std::vector<Point> directions = {{1, 0, 0}, {-0.6, 0, 0.8}, {1 / 3.0, 1 / 7.0, -0.9}};
  std::vector<double> distances;
  std::vector<Point> points;
  for (std::size_t i = 0; i < centres.size(); ++i) {
    distances.push_back(1e-3 * static_cast<double>(1 + i % 100));
    for (const Point& direction : directions) points.push_back(julia::pointAlong(centres[i], distances[i], direction));
  }
  std::vector<double> expected(points.size()), found(points.size());
  std::vector<int> expectedSteps(points.size()), foundSteps(points.size());
  host.evaluate(points, expected, expectedSteps);
  there.evaluateAround(centres, distances, directions, found, foundSteps);
  EXPECT_EQ(expected, found) << what;
  EXPECT_EQ(expectedSteps, foundSteps) << what;
}

/// The device's evaluator of a field has the bits of @a host at all of the points, on edges about them, and along rays.
/// @return the number of edges
std::size_t expectSameBitsOnDevice(std::unique_ptr<FieldEvaluator> host, double radius, const std::string& what,
                                   const std::vector<Point>& others = {}, bool rays = true, double mostLeft = 0.1) {
  const std::vector<Point> points = pointsAbout(radius, others);
  std::vector<double> expected(points.size()), found(points.size());
  std::vector<int> expectedSteps(points.size()), foundSteps(points.size());
  host->evaluate(points, expected, expectedSteps);
  std::string reason = "not asked";
  // The evaluator on the device keeps the host.
  const FieldEvaluator& here = *host;
  const auto there = firstDevice()->evaluator(std::move(host), reason);
  EXPECT_EQ(reason, "") << what;
  there->evaluate(points, found, foundSteps);
  std::size_t different = 0;
  for (std::size_t i = 0; i < points.size(); ++i)
    different += std::bit_cast<std::uint64_t>(expected[i]) != std::bit_cast<std::uint64_t>(found[i]) ||
                 expectedSteps[i] != foundSteps[i];
  EXPECT_EQ(different, 0u) << what;
  // Without the steps, and a few points at a time.
  std::vector<double> again(points.size());
  for (std::size_t first = 0; first < points.size(); first += 1000) {
    const std::size_t count = std::min<std::size_t>(1000, points.size() - first);
    there->evaluate(std::span(points).subspan(first, count), std::span(again).subspan(first, count), {});
  }
  EXPECT_EQ(again, found) << what;
  if (rays) {
    expectSameAround(here, *there, std::vector<Point>(points.begin(), points.begin() + 5000), what);
    expectSameMeetings(here, *there, radius, mostLeft, what);
  }
  return expectSameCrossings(here, *there, radius, what);
}

Rational rationalOf(const std::vector<double>& powers, const std::vector<double>& bottomPowers) {
  law_tests::Random random(11);
  Rational rational;
  rational.logScale = -1.5;
  for (const double power : powers) rational.top.roots.push_back({random.inBall(), power});
  for (const double power : bottomPowers) rational.bottom.roots.push_back({random.inBall(), power});
  return rational;
}

/// Roots of each kind of power: by products, by more products than their norms allow, and from angles.
const std::vector<Rational>& rationals() {
  static const std::vector<Rational> all = {
      rationalOf({4, 1, 2}, {}),
      rationalOf({64, 63, 50, 33, 17, 60, 61}, {7, 2}),
      rationalOf({100, 3}, {900}),
      rationalOf({2.5, 0.3, 7.25}, {1.5, 3}),
  };
  return all;
}

// Promise: "The files have the same bytes with every choice"
// Promise: "have the device follow rays, some ..."
// Promise of gpu.md: "All rounds of a search are one call"
TYPED_TEST(Devices, theShapeModulusOfRoots) {
  using Real = TypeParam;
  std::size_t searched = 0;
  for (const Interpolation interpolation : {Interpolation::Trilinear, Interpolation::Quadratic})
    for (std::size_t k = 0; k < rationals().size(); ++k) {
      const julia::PlacedBricks bricks = law_tests::lumpyBricks(interpolation);
      const auto field = std::make_shared<julia::BrickField<Real>>(bricks.bricks, bricks.placement);
      const auto dropped = static_cast<DropAxis>(k % 3);
      const auto map = std::make_shared<const julia::ShapeModulus<Real>>(field, rationals()[k], dropped);
      const julia::Quaternion<double> root = rationals()[k].top.roots[0].position;
      // A root of the slice is hit exactly.
      const auto hit = Embedding{0, dropped}.point(root);
      const double slice = Embedding{0, dropped}.slicePart(root);
      searched +=
          expectSameBitsOnDevice(julia::makeFieldEvaluator<Real>(map, Embedding{k == 0 ? slice : 0.05, dropped},
                                                                 OrbitOptions{.maxIterations = 5, .logTrap = -6}),
                                 0.6, "roots " + std::to_string(k), {hit});
    }
  EXPECT_GT(searched, 1000u);
}

// Promise: "The files have the same bytes with every choice"
TYPED_TEST(Devices, theShapeModulusOfWaves) {
  using Real = TypeParam;
  law_tests::Random random(51);
  for (int round = 0; round < 6; ++round) {
    const auto interpolation = round % 2 ? Interpolation::Quadratic : Interpolation::Trilinear;
    const julia::PlacedBricks bricks = law_tests::lumpyBricks(interpolation);
    const auto field = std::make_shared<julia::BrickField<Real>>(bricks.bricks, bricks.placement);
    const auto dropped = static_cast<DropAxis>(round % 3);
    const auto versor = std::make_shared<julia::WaveVersor<Real>>(law_tests::randomWaves(random), field, dropped);
    const auto map = std::make_shared<const julia::ShapeModulus<Real>>(field, versor, dropped);
    expectSameBitsOnDevice(
        julia::makeFieldEvaluator<Real>(map, Embedding{0.05, dropped}, OrbitOptions{.maxIterations = 6}), 0.6,
        "waves " + std::to_string(round));
  }
}

// Promise: A fractal with a grain is the same ...
TYPED_TEST(Devices, theShapeModulusOfAGrain) {
  using Real = TypeParam;
  law_tests::Random random(52);
  for (int round = 0; round < 6; ++round) {
    const julia::PlacedBricks bricks = law_tests::lumpyBricks(Interpolation::Trilinear);
    const auto field = std::make_shared<julia::BrickField<Real>>(bricks.bricks, bricks.placement);
    const auto dropped = static_cast<DropAxis>(round % 3);
    const auto map = std::make_shared<const julia::ShapeModulus<Real>>(
        field, law_tests::randomGrainVersor<Real>(random, dropped), dropped);
    expectSameBitsOnDevice(
        julia::makeFieldEvaluator<Real>(map, Embedding{0.05, dropped}, OrbitOptions{.maxIterations = 6}), 0.6,
        "grain " + std::to_string(round));
  }
}

/// Textures made of others: everything that a versor can be, alone and nested.
template <class Real>
std::vector<std::shared_ptr<const julia::VersorField<Real>>> composedVersors(DropAxis dropped) {
  using Versor = std::shared_ptr<const julia::VersorField<Real>>;
  using Field = std::shared_ptr<const julia::ScalarField<Real>>;
  law_tests::Random random(17);
  // Fields that differ by where their bricks lie. The mask is below 0, between, and above 1.
  const auto shifted = [&](Interpolation interpolation, double by, double scale) -> Field {
    const julia::PlacedBricks from = law_tests::lumpyBricks(interpolation);
    auto bricks = std::make_shared<julia::Bricks>(*from.bricks);
    for (float& value : bricks->values) value = static_cast<float>(0.5 + scale * static_cast<double>(value));
    julia::BrickPlacement placement = from.placement;
    for (double& x : placement.offset) x += by;
    return std::make_shared<julia::BrickField<Real>>(bricks, placement);
  };
  const auto trilinear = Interpolation::Trilinear, quadratic = Interpolation::Quadratic;
  const Versor roots = std::make_shared<julia::RationalVersor<Real>>(rationals()[3]);
  const Versor waves =
      std::make_shared<julia::WaveVersor<Real>>(law_tests::randomWaves(random), shifted(trilinear, 0.3, 0.5), dropped);
  const Versor vectors = std::make_shared<julia::VectorVersor<Real>>(
      std::vector{shifted(trilinear, 0.1, 1), shifted(quadratic, -0.4, -1), shifted(trilinear, 0.2, 3)}, dropped);
  const Versor quaternions =
      std::make_shared<julia::VectorVersor<Real>>(std::vector{shifted(quadratic, 0, 1), shifted(trilinear, 0.3, 1),
                                                              shifted(trilinear, 0.7, -2), shifted(quadratic, -0.2, 1)},
                                                  dropped);
  const Versor moved =
      std::make_shared<julia::MovedVersor<Real>>(vectors, -0.7, julia::Quaternion<double>{0.1, -0.2, 0.05, 0.3});
  const auto symmetric = [&](const Versor& of, int fold, int axis, bool kaleidoscope, std::array<bool, 3> mirrored) {
    const julia::Symmetry symmetry{fold, axis, kaleidoscope, mirrored, {0.05, -0.1, 0.02}};
    return Versor(std::make_shared<julia::SymmetricVersor<Real>>(of, symmetry, dropped));
  };
  const auto mixed = [&](const Versor& under, const Versor& over, double by, double scale) {
    return Versor(std::make_shared<julia::MixedVersor<Real>>(under, over, shifted(trilinear, by, scale), dropped));
  };
  return {vectors,
          quaternions,
          moved,
          symmetric(roots, 1, 0, false, {true, false, true}),
          symmetric(waves, 3, 1, false, {}),
          symmetric(roots, 5, 2, true, {false, false, true}),
          symmetric(moved, 7, 0, false, {true, false, false}),
          mixed(roots, waves, 0.4, 0.8),
          mixed(symmetric(waves, 4, 0, true, {}), symmetric(moved, 2, 2, false, {}), -0.3, 1.5)};
}

// Promise: "The files have the same bytes with every choice"
TYPED_TEST(Devices, theShapeModulusOfTexturesMadeOfOthers) {
  using Real = TypeParam;
  for (const DropAxis dropped : {DropAxis::I, DropAxis::J, DropAxis::K}) {
    const julia::PlacedBricks bricks = law_tests::lumpyBricks(Interpolation::Trilinear);
    const auto field = std::make_shared<julia::BrickField<Real>>(bricks.bricks, bricks.placement);
    const auto versors = composedVersors<Real>(dropped);
    for (std::size_t k = 0; k < versors.size(); ++k) {
      const auto map = std::make_shared<const julia::ShapeModulus<Real>>(field, versors[k], dropped);
      expectSameBitsOnDevice(
          julia::makeFieldEvaluator<Real>(map, Embedding{0.05, dropped}, OrbitOptions{.maxIterations = 4}), 0.6,
          "texture " + std::to_string(k) + ", dropped " + std::to_string(static_cast<int>(dropped)), {}, k % 4 == 0);
    }
  }
}

// Promise: "The files have the same bytes with every choice"
TYPED_TEST(Devices, rationalMaps) {
  using Real = TypeParam;
  for (std::size_t k = 0; k < rationals().size(); ++k) {
    const auto map = std::make_shared<const julia::RationalMap<Real>>(rationals()[k]);
    expectSameBitsOnDevice(julia::makeFieldEvaluator<Real>(map, Embedding{-0.1}, OrbitOptions{}), 1,
                           "rational " + std::to_string(k));
  }
}

// Promise: "The files have the same bytes with every choice"
TYPED_TEST(Devices, quadraticMaps) {
  using Real = TypeParam;
  const OrbitOptions orbit{.maxIterations = 9, .escapeRadius = 8};
  const julia::Quaternion<double> c{-0.2, 0.6, 0.1, -0.3};
  const auto fixed = std::make_shared<const julia::QuadraticMap<Real>>(c);
  expectSameBitsOnDevice(julia::makeFieldEvaluator<Real>(std::shared_ptr<const julia::Map<Real>>(fixed), {0.1}, orbit),
                         1.5, "Julia");
  const auto mandelbrot = std::make_shared<const julia::QuadraticMandelbrot<Real>>();
  expectSameBitsOnDevice(julia::makeFieldEvaluator<Real>(std::shared_ptr<const julia::CartesianMap<Real>>(mandelbrot),
                                                         {0.1, DropAxis::J}, orbit),
                         1.5, "Mandelbrot");
}

// Promise: "The files have the same bytes with every choice"
TYPED_TEST(Devices, crossMaps) {
  using Real = TypeParam;
  if (!firstDevice()->info().doubles) GTEST_SKIP() << "cosines of radians need doubles";
  const OrbitOptions orbit{.maxIterations = 6, .escapeRadius = 2};
  for (const CrossScheme scheme : {CrossScheme::FixedFactor, CrossScheme::Mandelbrot, CrossScheme::Julia})
    for (const CrossPair pair :
         {CrossPair::A, CrossPair::APrime, CrossPair::B, CrossPair::C, CrossPair::D, CrossPair::E}) {
      const auto map =
          std::make_shared<const julia::CrossMap<Real>>(CrossOptions{pair, scheme, {0.2, -0.3, 0.1}, "", ""});
      // Most orbits of one of them take it out of the range of floats.
      const bool farOut = pair == CrossPair::B && scheme == CrossScheme::Julia && sizeof(Real) == sizeof(float);
      expectSameBitsOnDevice(
          julia::makeFieldEvaluator<Real>(std::shared_ptr<const julia::CartesianMap<Real>>(map), {}, orbit), 1.4,
          "pair " + std::to_string(static_cast<int>(pair)) + ", scheme " + std::to_string(static_cast<int>(scheme)),
          {{0, 0, 0.5}, {0.3, 0.3, 0.1}}, /*rays=*/true, farOut ? 0.75 : 0.1);
    }
}

// Promise: "The files have the same bytes with every choice"
// Promise: "have the device follow rays, some ..."
TYPED_TEST(Devices, mandelbulbs) {
  using Real = TypeParam;
  const OrbitOptions orbit{.maxIterations = 6, .escapeRadius = 2};
  for (const auto angle : {julia::TriplexAngle::AbovePlane, julia::TriplexAngle::FromPole})
    for (const double power : {2., 8., 2.5, -3.})
      for (const bool fixed : {false, true}) {
        const julia::MandelbulbOptions options{power, angle,
                                               fixed ? std::optional(Point{0.2, 0.3, -0.4}) : std::nullopt};
        const auto map = std::make_shared<const julia::Mandelbulb<Real>>(options);
        expectSameBitsOnDevice(
            julia::makeFieldEvaluator<Real>(std::shared_ptr<const julia::CartesianMap<Real>>(map), {}, orbit), 1.2,
            "power " + std::to_string(power), {{0, 0, 0.5}, {0.5, 0, 0}});
      }
}

TYPED_TEST(Devices, blocksHaveTheSignsOfTheirNodes) {
  using Real = TypeParam;
  const julia::PlacedBricks bricks = law_tests::lumpyBricks(Interpolation::Trilinear);
  const auto field = std::make_shared<julia::BrickField<Real>>(bricks.bricks, bricks.placement);
  const auto map = std::make_shared<const julia::ShapeModulus<Real>>(field, rationals()[0], DropAxis::K);
  const auto make = [&] { return julia::makeFieldEvaluator<Real>(map, {}, OrbitOptions{.maxIterations = 5}); };
  const auto host = make();
  std::string reason;
  const auto there = firstDevice()->evaluator(make(), reason);
  ASSERT_EQ(reason, "");
  std::vector<float> here(julia::NodeBlock::kSize, 0.5f), onDevice(julia::NodeBlock::kSize, 0.5f);
  const auto blockOf = [](std::vector<float>& values) {
    julia::NodeBlock block{.wanted = 0x5b, .field = std::span<float, julia::NodeBlock::kSize>(values)};
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (std::size_t k = 0; k < julia::NodeBlock::kSide; ++k)
        block.at[axis][k] = (axis == 0 ? 0.06 : 0.02) * static_cast<double>(k);
    return block;
  };
  host->evaluateBlocks(std::vector{blockOf(here)});
  there->evaluateBlocks(std::vector{blockOf(onDevice)});
  int inside = 0;
  for (std::size_t i = 0; i < here.size(); ++i) {
    EXPECT_EQ(here[i] < 0, onDevice[i] < 0) << i;
    EXPECT_EQ(here[i] == 0.5f, onDevice[i] == 0.5f) << i;  // eighths that are not wanted keep their values
    inside += here[i] < 0;
  }
  EXPECT_GT(inside, 10);
  EXPECT_LT(inside, 400);
}

/// The map of the tests of blocks and edges of a lattice, and a lattice that its surface crosses.
template <class Real>
std::unique_ptr<FieldEvaluator> evaluatorOfRoots() {
  const julia::PlacedBricks bricks = law_tests::lumpyBricks(Interpolation::Trilinear);
  const auto field = std::make_shared<julia::BrickField<Real>>(bricks.bricks, bricks.placement);
  const auto map = std::make_shared<const julia::ShapeModulus<Real>>(field, rationals()[0], DropAxis::K);
  return julia::makeFieldEvaluator<Real>(map, {}, OrbitOptions{.maxIterations = 5});
}
constexpr julia::SearchLattice kLattice{.voxelSize = 0.03, .centre = {0.1, -0.2, 0.03}, .scale = 1.25};

/// Blocks side by side, some of which want a part of their nodes only, and one beyond the escape radius.
std::vector<julia::SignBlock> blocksOfLattice(int side) {
  std::vector<julia::SignBlock> blocks;
  for (int x = -side; x < side; ++x)
    for (int y = -side; y < side; ++y)
      for (int z = -side; z < side; ++z) {
        julia::SignBlock block{.origin = {8 * x, 8 * y, 8 * z}};
        if (blocks.size() % 5 == 1) block.wanted = static_cast<std::uint8_t>(blocks.size() * 37 % 256);
        blocks.push_back(block);
      }
  blocks.push_back({.origin = {100000, -100000, 3}});
  return blocks;
}

TYPED_TEST(Devices, signsOfALatticeAreThoseOfItsNodes) {
  using Real = TypeParam;
  const auto host = evaluatorOfRoots<Real>();
  std::string reason;
  const auto there = firstDevice()->evaluator(evaluatorOfRoots<Real>(), reason);
  ASSERT_EQ(reason, "");
  std::vector<julia::SignBlock> blocks = blocksOfLattice(3), here = blocks;
  const julia::DeviceUse before = firstDevice()->use();
  there->evaluateSigns(kLattice, blocks);
  const julia::DeviceUse after = firstDevice()->use();
  host->evaluateSigns(kLattice, here);
  std::size_t inside = 0, wanted = 0;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    EXPECT_EQ(here[i].inside, blocks[i].inside) << i;
    for (std::size_t x = 0; x < 8; ++x)
      for (std::size_t k = 0; k < 64; ++k) {
        const Point at{kLattice.at(blocks[i].origin[0] + static_cast<double>(x), 0),
                       kLattice.at(blocks[i].origin[1] + static_cast<double>(k / 8), 1),
                       kLattice.at(blocks[i].origin[2] + static_cast<double>(k % 8), 2)};
        const bool isWanted = blocks[i].wanted >> (x / 4 * 4 + k / 32 * 2 + k % 8 / 4) & 1;
        const bool isInside = blocks[i].inside[x] >> k & 1;
        double field = 0;
        if (isWanted && (i * 512 + x * 64 + k) % 7 == 0) {
          host->evaluate({&at, 1}, {&field, 1}, {});
          EXPECT_EQ(isInside, field < 0) << i;
        }
        if (!isWanted) EXPECT_FALSE(isInside) << i;
        wanted += isWanted;
        inside += isInside;
      }
  }
  EXPECT_GT(inside, wanted / 100);
  EXPECT_LT(inside, wanted * 9 / 10);
  // All of them in one call, without a coordinate that is copied and without a value of F.
  EXPECT_EQ(after.calls - before.calls, 1u);
  EXPECT_EQ(after.points - before.points, 512 * blocks.size());
  EXPECT_LE(after.bytesTo - before.bytesTo, 16 * blocks.size() + 64);
  EXPECT_LE(after.bytesFrom - before.bytesFrom, 128 * blocks.size());
}

TYPED_TEST(Devices, edgesOfALatticeHaveThePlacesOfTheProcessor) {
  using Real = TypeParam;
  const auto host = evaluatorOfRoots<Real>();
  std::string reason;
  const auto there = firstDevice()->evaluator(evaluatorOfRoots<Real>(), reason);
  ASSERT_EQ(reason, "");
  std::vector<julia::NodeEdge> edges;
  std::vector<julia::CrossedEdge> crossed;
  for (int axis = 0; axis < 3; ++axis)
    for (int x = -20; x < 20; ++x)
      for (int y = -20; y < 20; ++y)
        for (int z = -20; z < 20; ++z) {
          std::array<Point, 2> ends;
          for (std::size_t end = 0; end < 2; ++end)
            ends[end] = {kLattice.at(x + (axis == 0 && end), 0), kLattice.at(y + (axis == 1 && end), 1),
                         kLattice.at(z + (axis == 2 && end), 2)};
          std::array<double, 2> field{};
          host->evaluate(ends, field, {});
          if ((field[0] < 0) == (field[1] < 0)) continue;
          const std::array<std::int32_t, 3> node = {x, y, z};
          edges.push_back({node, axis, julia::storedField(field[0]), julia::storedField(field[1])});
          crossed.push_back({ends[0], axis, static_cast<double>(node[static_cast<std::size_t>(axis)]),
                             edges.back().from, edges.back().to});
        }
  ASSERT_GT(edges.size(), 500u);
  std::vector<double> expected(edges.size()), found(edges.size());
  host->findCrossings(crossed, kLattice, expected);
  const auto signAlone = [](float& field) {
    field = static_cast<float>(field < 0 ? -julia::kFieldLimit : julia::kFieldLimit);
  };
  // F at both ends, at one end, at the other, and at none: its signs are enough.
  for (int unknown = 0; unknown < 4; ++unknown) {
    std::vector<julia::NodeEdge> some = edges;
    for (julia::NodeEdge& edge : some) {
      if (unknown & 1) signAlone(edge.from);
      if (unknown & 2) signAlone(edge.to);
    }
    const julia::DeviceUse before = firstDevice()->use();
    there->findNodeCrossings(some, kLattice, found);
    const julia::DeviceUse after = firstDevice()->use();
    EXPECT_EQ(found, expected) << unknown;
    EXPECT_EQ(after.calls - before.calls, 1u);
    EXPECT_EQ(after.edges - before.edges, edges.size());
    EXPECT_LE(after.bytesTo - before.bytesTo, (unknown == 3 ? 16 : 24) * edges.size() + 64);
    EXPECT_LE(after.bytesFrom - before.bytesFrom, 8 * edges.size());
    std::ranges::fill(found, -1);
    host->findNodeCrossings(some, kLattice, found);
    EXPECT_EQ(found, expected) << unknown;
  }
}

// Promise: "It also evaluates fields ..."
TYPED_TEST(Devices, leaveToTheProcessorWhatTheyCannotEvaluate) {
  using Real = TypeParam;
  const auto reasonOf = [](std::unique_ptr<FieldEvaluator> host) {
    const FieldEvaluator* const before = host.get();
    std::string reason;
    const auto evaluator = firstDevice()->evaluator(std::move(host), reason);
    EXPECT_EQ(evaluator.get(), before);
    return reason;
  };
  const auto user = std::make_shared<const julia::CrossMap<Real>>(
      CrossOptions{CrossPair::User, CrossScheme::Mandelbrot, {}, "x, y, z", "1, x, y"});
  EXPECT_NE(reasonOf(julia::makeFieldEvaluator<Real>(std::shared_ptr<const julia::CartesianMap<Real>>(user), {}, {}))
                .find("expressions"),
            std::string::npos);
  const julia::PlacedBricks bricks = law_tests::lumpyBricks(Interpolation::Trilinear);
  const auto field = std::make_shared<julia::BrickField<Real>>(bricks.bricks, bricks.placement);
  const auto function = std::make_shared<julia::FunctionVersor<Real>>(
      [](auto points, auto directions) { std::ranges::copy(points, directions.begin()); });
  const auto moved = std::make_shared<julia::MovedVersor<Real>>(function, 2, julia::Quaternion<double>{});
  const auto map = std::make_shared<const julia::ShapeModulus<Real>>(field, moved, DropAxis::K);
  EXPECT_NE(reasonOf(julia::makeFieldEvaluator<Real>(map, {}, {})).find("formula"), std::string::npos);
  const auto rational = std::make_shared<const julia::RationalMap<Real>>(rationals()[0]);
  EXPECT_NE(reasonOf(julia::makeFieldEvaluator<Real>(rational, {}, OrbitOptions{.logTrap = -3, .confirmTrap = true}))
                .find("trap"),
            std::string::npos);
}

TEST(Device, currentIsNoneUntilOneIsSet) {
  EXPECT_EQ(julia::currentDevice(), nullptr);
  const auto rational = std::make_shared<const julia::RationalMap<float>>(rationals()[0]);
  auto host = julia::makeFieldEvaluator<float>(rational, {}, {});
  const FieldEvaluator* const before = host.get();
  EXPECT_EQ(julia::onCurrentDevice(std::move(host)).get(), before);
}

}  // namespace
