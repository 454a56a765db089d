// SPDX-License-Identifier: Apache-2.0
// Quadratic programs with signs: the conditions of Karush, Kuhn and Tucker, and every active set there is.
#include "fit/bounded_quadratic.h"

#include "support/float128.h"

#include <gtest/gtest.h>
#include <Eigen/Cholesky>

#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using julia::BoundedQuadratic;
using law_tests::Random;

std::optional<VectorXd> minimiseBounded(const MatrixXd& H, const VectorXd& b, const std::vector<char>& bounded,
                                        std::vector<char>& passive) {
  return BoundedQuadratic(H).minimise(b, bounded, passive);
}

struct Program {
  MatrixXd H;
  VectorXd b;
  std::vector<char> bounded;

  Index size() const { return b.size(); }
  double value(const VectorXd& x) const { return 0.5 * x.dot(H * x) - b.dot(x); }
};

/// @param rank  of H but for a small diagonal: the lower, the more the variables depend on each other
/// @param low   of the entries, up to 1, that H is the square of: from 0 on, all columns point one way
Program randomProgram(Random& random, Index n, Index rank, double diagonal, double low = -1) {
  MatrixXd A(rank, n);
  Program program{{}, VectorXd(n), std::vector<char>(static_cast<std::size_t>(n))};
  for (Index i = 0; i < n; ++i) {
    for (Index k = 0; k < rank; ++k) A(k, i) = random.between(low, 1);
    program.b[i] = random.between(-1, 1);
    program.bounded[static_cast<std::size_t>(i)] = random.integer(0, 4) > 0;
  }
  program.H = A.transpose() * A + diagonal * MatrixXd::Identity(n, n);
  return program;
}

std::vector<char> randomGuess(Random& random, Index n) {
  std::vector<char> guess(static_cast<std::size_t>(n));
  for (char& passive : guess) passive = static_cast<char>(random.integer(0, 1));
  return guess;
}

/// The least value over all sets of variables that are at their bound.
VectorXd leastOverAllSets(const Program& program) {
  const Index n = program.size();
  VectorXd best;
  double lowest = std::numeric_limits<double>::infinity();
  for (std::uint32_t set = 0; set < 1U << n; ++set) {
    std::vector<Index> free;
    bool allowed = true;
    for (Index i = 0; i < n; ++i) {
      if (set >> i & 1)
        allowed = allowed && program.bounded[static_cast<std::size_t>(i)];
      else
        free.push_back(i);
    }
    if (!allowed) continue;
    VectorXd x = VectorXd::Zero(n);
    if (!free.empty()) {
      const MatrixXd part = program.H(free, free);
      const VectorXd right = program.b(free), solution = part.ldlt().solve(right);
      x(free) = solution;
    }
    bool feasible = true;
    for (Index i = 0; i < n; ++i) feasible = feasible && (!program.bounded[static_cast<std::size_t>(i)] || x[i] >= 0);
    if (!feasible || !(program.value(x) < lowest)) continue;
    lowest = program.value(x);
    best = x;
  }
  return best;
}

void expectOptimal(const Program& program, const VectorXd& x, const std::vector<char>& passive, double tolerance) {
  const VectorXd slope = program.H * x - program.b;
  for (Index i = 0; i < program.size(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    if (!program.bounded[k]) {
      EXPECT_TRUE(passive[k]) << i;
    }
    if (passive[k]) {
      EXPECT_NEAR(slope[i], 0, tolerance) << i << " of " << program.size();
      EXPECT_TRUE(x[i] >= 0 || !program.bounded[k]) << i << " of " << program.size() << ": " << x[i];
    } else {
      EXPECT_EQ(x[i], 0) << i << " of " << program.size();
      EXPECT_GE(slope[i], -tolerance) << i << " of " << program.size();
    }
  }
}

TEST(BoundedQuadratic, isTheBestOfAllActiveSets) {
  Random random(1);
  for (int round = 0; round < 4000; ++round) {
    const Index n = random.integer(1, 8);
    const double diagonal = std::pow(10, random.between(-4, 0));
    const Program program =
        randomProgram(random, n, random.integer(1, static_cast<int>(n) + 2), diagonal, round % 2 == 0 ? -1 : 0.3);
    std::vector<char> passive = randomGuess(random, n);
    const VectorXd x = minimiseBounded(program.H, program.b, program.bounded, passive).value();
    expectOptimal(program, x, passive, 1e-9);
    const VectorXd expected = leastOverAllSets(program);
    for (Index i = 0; i < n; ++i) EXPECT_NEAR(x[i], expected[i], 1e-9 / diagonal) << round << ": " << i << " of " << n;
  }
}

TEST(BoundedQuadratic, conditionsHoldForLargeOnes) {
  Random random(2);
  for (const Index n : {30, 100, 300})
    for (const double rankShare : {0.2, 1., 2.}) {
      Program program = randomProgram(random, n, std::max<Index>(1, static_cast<Index>(rankShare * double(n))), 1e-3);
      std::vector<char> passive = randomGuess(random, n);
      const VectorXd x = minimiseBounded(program.H, program.b, program.bounded, passive).value();
      expectOptimal(program, x, passive, 1e-8);
      int atBound = 0, free = 0;
      for (const char p : passive) ++(p ? free : atBound);
      EXPECT_GT(atBound, n / 10);
      EXPECT_GT(free, n / 10);
    }
}

// A guess changes how long it takes, not what comes out.
TEST(BoundedQuadratic, theGuessDoesNotMatter) {
  Random random(3);
  const Program program = randomProgram(random, 60, 60, 0.1);
  std::vector<char> expectedPassive(60, 0);
  const VectorXd expected = minimiseBounded(program.H, program.b, program.bounded, expectedPassive).value();
  for (int round = 0; round < 20; ++round) {
    std::vector<char> passive = randomGuess(random, 60);
    const VectorXd x = minimiseBounded(program.H, program.b, program.bounded, passive).value();
    EXPECT_EQ(passive, expectedPassive) << round;
    EXPECT_LT((x - expected).cwiseAbs().maxCoeff(), 1e-10) << round;
  }
}

// Programs of one matrix, whose free variables differ a little from one to the next: the factor of the first serves.
TEST(BoundedQuadratic, anEarlierProgramChangesNothing) {
  Random random(6);
  for (const Index n : {5, 60, 200})
    for (const double drift : {0., 0.02, 0.1, 2.}) {
      Program program = randomProgram(random, n, n, 0.1);
      BoundedQuadratic quadratic(program.H);
      std::vector<char> passive = randomGuess(random, n);
      for (int round = 0; round < 6; ++round) {
        const VectorXd x = quadratic.minimise(program.b, program.bounded, passive).value();
        expectOptimal(program, x, passive, 1e-9);
        std::vector<char> fresh = randomGuess(random, n);
        const VectorXd expected = minimiseBounded(program.H, program.b, program.bounded, fresh).value();
        EXPECT_EQ(passive, fresh) << round << " of " << n << ", " << drift;
        EXPECT_LT((x - expected).cwiseAbs().maxCoeff(), 1e-8) << round << " of " << n << ", " << drift;
        for (double& value : program.b) value += drift * random.between(-1, 1);
      }
    }
}

TEST(BoundedQuadratic, withoutBoundsItIsALinearSystem) {
  Random random(4);
  Program program = randomProgram(random, 40, 60, 0.1);
  program.bounded.assign(40, 0);
  std::vector<char> passive(40, 0);
  const VectorXd x = minimiseBounded(program.H, program.b, program.bounded, passive).value();
  EXPECT_LT((program.H * x - program.b).cwiseAbs().maxCoeff(), 1e-10);
  EXPECT_LT(x.minCoeff(), 0);
  EXPECT_EQ(passive, std::vector<char>(40, 1));
}

TEST(BoundedQuadratic, nothingToGainMeansZero) {
  const MatrixXd H = MatrixXd::Identity(5, 5);
  std::vector<char> passive(5, 1);
  EXPECT_EQ(minimiseBounded(H, VectorXd::Constant(5, -1), std::vector<char>(5, 1), passive).value(), VectorXd::Zero(5));
  EXPECT_EQ(passive, std::vector<char>(5, 0));
  EXPECT_EQ(minimiseBounded(H, VectorXd::Zero(5), std::vector<char>(5, 1), passive).value(), VectorXd::Zero(5));
}

TEST(BoundedQuadratic, nothingWhereTheMatrixIsNotPositive) {
  std::vector<char> passive(5, 1);
  EXPECT_FALSE(minimiseBounded(-MatrixXd::Identity(5, 5), VectorXd::Ones(5), std::vector<char>(5, 0), passive));
}

}  // namespace
