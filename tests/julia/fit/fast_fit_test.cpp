// SPDX-License-Identifier: Apache-2.0
// The fast fit: targets that it must find, what it promises of roots and powers, and that nothing but the seed decides.
#include "julia/fit/fast_fit.h"

#include "julia/fit/cancelled.h"
#include "julia/instruction_set.h"
#include "support/float128.h"
#include "support/limits.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

using julia::FastFit;
using julia::FastFitOptions;
using julia::FitCell;
using julia::FitStep;
using julia::Point;
using julia::Polynomial;
using julia::Rational;
using julia::Root;
using julia::RootCandidate;
using law_tests::Random;
using law_tests::text;
using test_limits::kNan;
using Distance = std::function<double(const Point&)>;

constexpr double kReach = 0.7;  // half the edge of the cube of cells
constexpr int kSide = 18;       // large cells along it
constexpr double kLargeCell = 2 * kReach / kSide, kCellSize = kLargeCell / 2;

Distance ballDistance(const Point& centre, double radius) {
  return [=](const Point& x) { return std::hypot(x[0] - centre[0], x[1] - centre[1], x[2] - centre[2]) - radius; };
}

Distance twoBallsDistance() {
  return [a = ballDistance({0.2, 0, 0}, 0.3), b = ballDistance({-0.2, 0, 0}, 0.3)](const Point& x) {
    return std::min(a(x), b(x));
  };
}

Distance boxDistance(const Point& half) {
  return [=](const Point& x) {
    double square = 0, most = -1;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double beyond = std::abs(x[axis]) - half[axis];
      most = std::max(most, beyond);
      square += beyond > 0 ? beyond * beyond : 0;
    }
    return most > 0 ? std::sqrt(square) : most;
  };
}

Point placeOf(int i, int side, double reach) {
  const double h = 2 * reach / side;
  return {-reach + h * (i % side + 0.5), -reach + h * (i / side % side + 0.5), -reach + h * (i / side / side + 0.5)};
}

struct CellTarget {
  std::vector<FitCell> cells;
  std::vector<RootCandidate> candidates;
};

/// Cells with a point somewhere in each, so that a face between two layers of them is known too; eight for one near
/// the surface.
CellTarget targetOf(const Distance& phi, std::size_t candidates) {
  CellTarget target;
  Random random(3);
  const auto add = [&](Point x, double size) {
    for (double& coordinate : x) coordinate += size * random.between(-0.5, 0.5);
    const double volume = size / kCellSize;
    target.cells.push_back({x, static_cast<float>(phi(x)), static_cast<float>(volume * volume * volume)});
  };
  for (int i = 0; i < kSide * kSide * kSide; ++i) {
    const Point x = placeOf(i, kSide, kReach);
    if (std::abs(phi(x)) > 1.5 * kLargeCell) {
      add(x, kLargeCell);
      continue;
    }
    for (int k = 0; k < 8; ++k) {
      const Point corner = placeOf(k, 2, kLargeCell / 2);
      add({x[0] + corner[0], x[1] + corner[1], x[2] + corner[2]}, kCellSize);
    }
  }
  while (target.candidates.size() < candidates) {
    const Point x{random.between(-kReach, kReach), random.between(-kReach, kReach), random.between(-kReach, kReach)};
    const double d = std::abs(phi(x));
    if (d < 0.3 * kCellSize || d > 4 * kCellSize) continue;
    target.candidates.push_back({x, phi(x) < 0 ? RootCandidate::Side::Top : RootCandidate::Side::Bottom});
  }
  return target;
}

FastFitOptions optionsOf(std::size_t maxRoots) {
  FastFitOptions options;
  options.maxRoots = maxRoots;
  options.cellSize = kCellSize;
  return options;
}

FastFit fastFitOf(const CellTarget& target, const FastFitOptions& options) {
  return fastFit(target.cells, target.candidates, options);
}

std::size_t rootCount(const Rational& rational) { return rational.top.roots.size() + rational.bottom.roots.size(); }

/// Of the shape and what the map has inside after so many iterates, at a point somewhere in each cell of a lattice that
/// is finer than that of the fit; a layer of them in one plane would say little of a flat face.
double measuredIou(const Distance& phi, const Rational& rational, int iterations) {
  constexpr int side = 34;
  Random random(11);
  const julia::RationalEvaluator<double> evaluator(rational);
  double both = 0, either = 0;
  for (int i = 0; i < side * side * side; ++i) {
    Point x = placeOf(i, side, kReach);
    for (double& coordinate : x) coordinate += 2 * kReach / side * random.between(-0.5, 0.5);
    julia::Quaternion<double> q{x[0], x[1], x[2], 0};
    double l = 0;
    for (int k = 0; k < iterations && l < std::log(20); ++k) {
      l = evaluator.logModulus(q);
      q = evaluator.versor(q) * std::exp(std::min(l, 3.0));
    }
    both += phi(x) < 0 && l < 0;
    either += phi(x) < 0 || l < 0;
  }
  return both / either;
}

TEST(FastFit, aSphereNeedsOneRoot) {
  for (const double radius : {0.25, 0.4, 0.55})
    for (const julia::CellWeights weights : {julia::CellWeights::InverseDistance, julia::CellWeights::Layers}) {
      const Distance sphere = ballDistance({0, 0, 0}, radius);
      FastFitOptions options = optionsOf(1);
      options.weights = weights;
      const FastFit found = fastFitOf(targetOf(sphere, 0), options);
      ASSERT_EQ(rootCount(found.rational), 1U);
      EXPECT_EQ(found.rational.top.roots.at(0).position, julia::Quaternion<double>{});
      EXPECT_NEAR(std::exp(-found.rational.logScale / found.rational.top.roots[0].power), radius, 0.1 * kCellSize);
      EXPECT_GT(measuredIou(sphere, found.rational, 1), 0.99) << radius;
      EXPECT_GT(found.iou, 0.99) << radius;
    }
}

struct Known {
  const char* name;
  Distance phi;
  double iou;
};

std::vector<Known> knownTargets() {
  return {{"two balls", twoBallsDistance(), 0.95},
          {"box", boxDistance({0.45, 0.3, 0.25}), 0.9},
          {"cube", boxDistance({0.4, 0.4, 0.4}), 0.9}};
}

/// The fits that the laws below look at, made once.
const FastFit& knownFit(const Known& known) {
  static std::map<std::string, FastFit> fits;
  const auto at = fits.find(known.name);
  if (at != fits.end()) return at->second;
  return fits.emplace(known.name, fastFitOf(targetOf(known.phi, 600), optionsOf(60))).first->second;
}

TEST(FastFit, findsShapes) {
  for (const Known& known : knownTargets()) {
    const FastFit& found = knownFit(known);
    EXPECT_LE(rootCount(found.rational), 60U) << known.name;
    const double iou = measuredIou(known.phi, found.rational, 1);
    EXPECT_GT(iou, known.iou) << known.name;
    EXPECT_NEAR(found.iou, iou, 0.03) << known.name;  // a tenth of the cells, and coarser ones
    // psi is that of [Kim15], on the cells that were not held out.
    const CellTarget target = targetOf(known.phi, 0);
    std::vector<Point> places;
    for (const FitCell& cell : target.cells) places.push_back(cell.x);
    const julia::ShapeEnergy energy(places, cellWeights(target.cells, julia::CellWeights::InverseDistance, kCellSize),
                                    found.rational, {});
    EXPECT_NEAR(found.psi, energy.evaluate(found.rational, nullptr), 0.01) << known.name;
  }
}

// Promise of fitting.md: "0 and infinity must both attract"; a root inside is a top root, one outside a bottom root
TEST(FastFit, powersArePositiveAndTheOriginAttracts) {
  for (const Known& known : knownTargets()) {
    const Rational& rational = knownFit(known).rational;
    for (const Polynomial* polynomial : {&rational.top, &rational.bottom}) {
      EXPECT_EQ(polynomial->powerScale, 1);
      for (const Root& root : polynomial->roots) EXPECT_GT(root.power, 0) << known.name;
    }
    ASSERT_FALSE(rational.top.roots.empty());
    EXPECT_EQ(rational.top.roots[0].position, julia::Quaternion<double>{}) << known.name;
    EXPECT_GE(rational.top.roots[0].power, 2) << known.name;
  }
}

// A degree above 1 makes |R(q)| > |q| far away; the cells alone gave a cube one of -40, and infinity was a root.
// Promise: "0 and infinity must both ..."
TEST(FastFit, infinityAttracts) {
  Random random(5);
  for (const Known& known : knownTargets()) {
    const Rational& rational = knownFit(known).rational;
    EXPECT_GT(summedPowers(rational.top) - summedPowers(rational.bottom), 1.9) << known.name;
    const julia::RationalEvaluator<double> evaluator(rational);
    for (int i = 0; i < 300; ++i) {
      const double length = 2 * std::exp(random.between(0, 20));
      EXPECT_GT(evaluator.logModulus(random.direction() * length), std::log(length)) << known.name << ' ' << length;
    }
    // So later iterates do not undo what the first one fits.
    EXPECT_GT(measuredIou(known.phi, rational, 4), known.iou - 0.05) << known.name;
  }
}

// Promise: In each stage of a fit "the roots ..."
// Promise: "0 and infinity must both ..."
TEST(FastFit, rootsKeepToTheirSides) {
  for (const Known& known : knownTargets()) {
    const Rational& rational = knownFit(known).rational;
    EXPECT_GT(rational.top.roots.size(), 3U) << known.name;
    EXPECT_GT(rational.bottom.roots.size(), 3U) << known.name;
    for (const Polynomial* polynomial : {&rational.top, &rational.bottom})
      for (const Root& root : polynomial->roots) {
        const Point x{root.position.a, root.position.b, root.position.c};
        EXPECT_EQ(known.phi(x) < 0, polynomial == &rational.top) << known.name << text(root.position);
        EXPECT_EQ(root.position.d, 0);
      }
  }
}

// Where the candidates leave it open, a root may be on the other side, and often there is a gain in it.
TEST(FastFit, candidatesMayLeaveTheSideOpen) {
  CellTarget target = targetOf(twoBallsDistance(), 300);
  for (RootCandidate& candidate : target.candidates) candidate.side = RootCandidate::Side::Either;
  EXPECT_GT(measuredIou(twoBallsDistance(), fastFitOf(target, optionsOf(40)).rational, 1), 0.9);
}

TEST(FastFit, energiesNeverRiseWithinARound) {
  for (const double penalty : {0., 1e-5}) {
    const CellTarget target = targetOf(boxDistance({0.45, 0.3, 0.25}), 300);
    FastFitOptions options = optionsOf(30);
    options.powerPenalty = penalty;
    std::string stage;
    double before = 0;
    int index = 0, rounds[2] = {}, falls = 0;
    bool sequenceEnded = true;
    Rational last;
    options.onStep = [&](const FitStep& step) {
      // New roots begin with powers of 0, so the loss goes on falling; a sharper energy is another one.
      if (step.stage != stage) sequenceEnded = true;
      if (!sequenceEnded) {
        EXPECT_LE(step.energy, before + 1e-12 * std::abs(before)) << step.stage << step.index;
        falls += step.energy < before;
      }
      before = step.energy;
      stage = step.stage;
      EXPECT_TRUE(stage == "roots" || stage == "energy");
      sequenceEnded = step.roundEnds && stage == "energy";
      rounds[stage == "energy"] += step.roundEnds;
      // A step, or a round that ends where the last step left it.
      EXPECT_TRUE(step.index == index + 1 || (step.roundEnds && step.index == index)) << step.index;
      index = step.index;
      ASSERT_NE(step.rational, nullptr);
      EXPECT_EQ(rootCount(*step.rational), step.roots);
      EXPECT_LE(step.roots, 30U);
      EXPECT_TRUE(step.iou >= 0 && step.iou <= 1);
      EXPECT_TRUE(step.psi >= -1 && step.psi <= 1);
      if (stage == "energy" && penalty == 0) {
        EXPECT_LE(step.energy, 0) << "the loss of another stage";
        EXPECT_GE(step.energy, -1);
      }
      last = *step.rational;
    };
    const FastFit found = fastFitOf(target, options);
    EXPECT_GT(rounds[0], 2);
    EXPECT_EQ(rounds[1], 4);  // sharpnesses
    EXPECT_GT(falls, 20);
    EXPECT_EQ(found.steps, index);
    EXPECT_EQ(last, found.rational);
  }
}

// Promise: In each stage of a fit "the roots ..."
TEST(FastFit, movedRootsFitBetter) {
  for (const Known& known : knownTargets()) {
    FastFitOptions options = optionsOf(60);
    options.moveRoots = false;
    const CellTarget target = targetOf(known.phi, 600);
    const FastFit kept = fastFitOf(target, options), &moved = knownFit(known);
    EXPECT_LT(moved.psi, kept.psi) << known.name;
    EXPECT_GT(measuredIou(known.phi, moved.rational, 1), measuredIou(known.phi, kept.rational, 1)) << known.name;
    // Without it, every root is where a candidate was.
    for (const Polynomial* polynomial : {&kept.rational.top, &kept.rational.bottom})
      for (const Root& root : polynomial->roots) {
        const Point x{root.position.a, root.position.b, root.position.c};
        EXPECT_TRUE(x == (Point{}) || std::any_of(target.candidates.begin(), target.candidates.end(),
                                                  [&](const RootCandidate& candidate) { return candidate.x == x; }))
            << known.name;
      }
  }
}

TEST(FastFit, penaltiesLowerThePowers) {
  const CellTarget target = targetOf(twoBallsDistance(), 300);
  FastFitOptions options = optionsOf(30);
  double before = std::numeric_limits<double>::infinity();
  for (const double penalty : {0., 1e-4, 1e-3}) {
    options.powerPenalty = penalty;
    const FastFit found = fastFitOf(target, options);
    const double powers = summedPowers(found.rational.top) + summedPowers(found.rational.bottom);
    EXPECT_LT(powers, before) << penalty;
    before = powers;
  }
}

TEST(FastFit, stopsAddingRootsAtTheTarget) {
  const CellTarget target = targetOf(twoBallsDistance(), 600);
  FastFitOptions options = optionsOf(60);
  const FastFit all = fastFitOf(target, options);
  options.targetIou = 0.8;
  const FastFit enough = fastFitOf(target, options);
  EXPECT_GT(enough.iou, 0.75);
  EXPECT_LT(rootCount(enough.rational), rootCount(all.rational) / 2);
}

TEST(FastFit, beginsWithTheRootsItIsGiven) {
  const Distance phi = twoBallsDistance();
  const CellTarget target = targetOf(phi, 0);
  FastFitOptions options = optionsOf(7);
  options.moveRoots = false;
  options.start = {{0.2, 0, 0}, {-0.2, 0, 0}, {0, 0.35, 0}, {0, -0.35, 0}, {0, 0, 0.35}, {0, 0, -0.35}};
  const FastFit found = fastFitOf(target, options);
  EXPECT_GT(rootCount(found.rational), 3U);
  for (const Polynomial* polynomial : {&found.rational.top, &found.rational.bottom})
    for (const Root& root : polynomial->roots) {
      const Point x{root.position.a, root.position.b, root.position.c};
      EXPECT_TRUE(x == (Point{}) || std::count(options.start.begin(), options.start.end(), x) == 1);
      EXPECT_EQ(phi(x) < 0, polynomial == &found.rational.top) << text(root.position);
    }
  EXPECT_GT(found.iou, fastFitOf(target, optionsOf(1)).iou + 0.1);
  // Those that there is no room for are left out.
  options.maxRoots = 3;
  EXPECT_LE(rootCount(fastFitOf(target, options).rational), 3U);
}

// Promise: "Every seed is in the recipe", and no library ...
TEST(FastFit, seedDecidesAndNothingElse) {
  const CellTarget target = targetOf(boxDistance({0.45, 0.3, 0.25}), 200);
  FastFitOptions options = optionsOf(20);
  const FastFit one = fastFitOf(target, options);
  const auto expectSame = [&](const std::string& what) {
    const FastFit again = fastFitOf(target, options);
    EXPECT_EQ(again.rational, one.rational) << what;
    EXPECT_EQ(again.iou, one.iou) << what;
    EXPECT_EQ(again.psi, one.psi) << what;
    EXPECT_EQ(again.steps, one.steps) << what;
  };
  expectSame("again");
  for (const std::size_t threads : {1, 3}) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    expectSame("threads: " + std::to_string(threads));
  }
  const julia::InstructionSet before = julia::instructionSet();
  for (const julia::InstructionSet set : julia::availableInstructionSets()) {
    julia::setInstructionSet(set);
    expectSame(std::string(julia::nameOf(set)));
  }
  julia::setInstructionSet(before);
  options.memoryLimit = 0;
  expectSame("logs made anew");
  options.memoryLimit = 10 * target.cells.size() * sizeof(float);
  expectSame("logs stored at first");

  options.seed = 2;
  const FastFit other = fastFitOf(target, options);
  EXPECT_NE(other.rational, one.rational);
  EXPECT_NEAR(other.psi, one.psi, 0.05);
  EXPECT_NEAR(measuredIou(boxDistance({0.45, 0.3, 0.25}), other.rational, 1),
              measuredIou(boxDistance({0.45, 0.3, 0.25}), one.rational, 1), 0.08);
}

// A cell or two a side, a root in each cell: nothing to fit, but nothing to fall over either.
TEST(FastFit, survivesTheSmallest) {
  const std::vector<FitCell> cells{{{0, 0, 0}, -0.5F, 1}, {{1, 0, 0}, 0.5F, 1}};
  for (const std::size_t roots : {1, 4}) {
    FastFitOptions options = optionsOf(roots);
    const std::vector<RootCandidate> candidates{{{0, 0, 0}}, {{1, 0, 0}}, {{1, 0, 0}}, {{0.5, 0, 0}}};
    options.onStep = [](const FitStep& step) {
      // Both cells are right from the start; what is reported is psi all the same.
      if (step.stage == "energy") {
        EXPECT_LT(step.energy, 0);
      }
    };
    const FastFit found = fastFit(cells, candidates, options);
    EXPECT_NO_THROW(requireFinite(found.rational));
    const julia::RationalEvaluator<double> evaluator(found.rational);
    EXPECT_LT(evaluator.logModulus({0, 0, 0, 0}), 0);
    EXPECT_GT(evaluator.logModulus({1, 0, 0, 0}), 0);
  }
}

TEST(FastFit, canBeCancelled) {
  const CellTarget target = targetOf(twoBallsDistance(), 100);
  for (const int after : {0, 1, 12}) {
    FastFitOptions options = optionsOf(10);
    int asked = 0;
    options.cancelled = [&] { return asked++ == after; };
    EXPECT_THROW(fastFitOf(target, options), julia::Cancelled) << after;
    EXPECT_EQ(asked, after + 1);
  }
}

TEST(FastFit, refusesNonsense) {
  const auto refused = [](const std::function<void(CellTarget&, FastFitOptions&)>& change, const std::string& word) {
    CellTarget target = targetOf(twoBallsDistance(), 20);
    FastFitOptions options = optionsOf(5);
    change(target, options);
    try {
      fastFitOf(target, options);
      ADD_FAILURE() << "accepted: " << word;
    } catch (const std::invalid_argument& error) {
      EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << word << " is not in: " << error.what();
    }
  };
  refused([](CellTarget& t, auto&) { t.cells.clear(); }, " 0 cells 0 are inside");
  const auto keepSide = [](CellTarget& t, bool inside) {
    std::erase_if(t.cells, [&](const FitCell& cell) { return (cell.phi < 0) != inside; });
  };
  refused([&](CellTarget& t, auto&) { keepSide(t, true); }, "are inside");
  refused([&](CellTarget& t, auto&) { keepSide(t, false); }, " 0 are inside");
  refused([](CellTarget& t, auto&) { t.cells[9].phi = static_cast<float>(kNan); }, "nan");
  refused([](CellTarget& t, auto&) { t.cells[9].x[2] = kNan; }, "nan");
  refused([](CellTarget& t, auto&) { t.cells[9].volume = -3; }, "-3");
  refused([](CellTarget& t, auto&) { t.candidates[9].x[0] = std::numeric_limits<double>::infinity(); }, "inf");
  refused([](auto&, FastFitOptions& o) { o.start = {{0, kNan, 0}}; }, "nan");
  refused([](auto&, FastFitOptions& o) { o.maxRoots = 0; }, "maxRoots is 0");
  for (const double bad : {0., -1., 2., kNan})
    refused([&](auto&, FastFitOptions& o) { o.targetIou = bad; }, bad == 2   ? "2"
                                                                  : bad == 0 ? "0"
                                                                  : bad < 0  ? "-1"
                                                                             : "nan");
  refused([](auto&, FastFitOptions& o) { o.cellSize = 0; }, "cells is 0");
  refused([](auto&, FastFitOptions& o) { o.cellSize = -1e-9; }, "cells is -1e-09");
  refused([](auto&, FastFitOptions& o) { o.cellSize = kNan; }, "cells is nan");
  refused([](auto&, FastFitOptions& o) { o.powerPenalty = -1e-9; }, "-1e-09");
  refused([](auto&, FastFitOptions& o) { o.powerPenalty = kNan; }, "nan");
}

}  // namespace
