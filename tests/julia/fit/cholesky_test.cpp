// SPDX-License-Identifier: Apache-2.0
// Cholesky's factors in tiles: what they solve, on any number of threads, and what they refuse.
#include "fit/cholesky.h"

#include "support/float128.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <optional>

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using julia::Cholesky;
using law_tests::Random;

// Within a tile, whole tiles, and sizes that end within one.
constexpr Index kSizes[] = {1, 2, 63, 64, 65, 128, 300, 385};

std::optional<VectorXd> solveCholesky(const MatrixXd& A, const VectorXd& b) {
  const std::optional<Cholesky> factor = Cholesky::of(A);
  if (!factor) return std::nullopt;
  return factor->solve(b);
}

VectorXd randomVector(Random& random, Index n) {
  return VectorXd::NullaryExpr(n, [&](Index) { return random.between(-1, 1); });
}

/// Positive definite, with eigenvalues from @a least on.
MatrixXd randomMatrix(Random& random, Index n, double least) {
  const MatrixXd A = MatrixXd::NullaryExpr(n, n, [&](Index, Index) { return random.between(-1, 1); });
  return A.transpose() * A + least * MatrixXd::Identity(n, n);
}

TEST(Cholesky, solves) {
  Random random(1);
  for (const Index n : kSizes)
    for (const double least : {1e-3, 1.}) {
      const MatrixXd A = randomMatrix(random, n, least);
      const VectorXd b = randomVector(random, n), x = solveCholesky(A, b).value();
      ASSERT_EQ(x.size(), n);
      // Backward stable: the x of a matrix that differs by n rounding errors.
      EXPECT_LE((A * x - b).norm(), 4 * law_tests::kEpsilon<double> * double(n) * A.norm() * x.norm()) << n;
    }
}

TEST(Cholesky, readsTheLowerTriangle) {
  Random random(2);
  for (const Index n : kSizes) {
    const MatrixXd A = randomMatrix(random, n, 1);
    const VectorXd b = randomVector(random, n);
    MatrixXd lower = A;
    lower.triangularView<Eigen::StrictlyUpper>().setConstant(-1e9);
    EXPECT_EQ(solveCholesky(lower, b).value(), solveCholesky(A, b).value()) << n;
  }
}

TEST(Cholesky, threadsChangeNothing) {
  Random random(3);
  const MatrixXd A = randomMatrix(random, 385, 1e-3);
  const VectorXd b = randomVector(random, 385), expected = solveCholesky(A, b).value();
  for (const std::size_t threads : {1, 2, 5}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    EXPECT_EQ(solveCholesky(A, b).value(), expected) << threads;
  }
}

// L^-1 of the columns of the unit matrix is the inverse factor: L^-T L^-1 A = 1.
TEST(Cholesky, solvesManyColumnsAtOnce) {
  Random random(5);
  for (const Index n : kSizes)
    for (const Index columns : {1, 64, 70}) {
      const Cholesky factor = Cholesky::of(randomMatrix(random, n, 1)).value();
      const MatrixXd B = MatrixXd::NullaryExpr(n, columns, [&](Index, Index) { return random.between(-1, 1); });
      const MatrixXd X = factor.forwardAll(B);
      ASSERT_EQ(X.rows(), n);
      ASSERT_EQ(X.cols(), columns);
      for (Index j = 0; j < columns; ++j) {
        const VectorXd expected = factor.forward(B.col(j));
        EXPECT_LE((X.col(j) - expected).norm(), 1e-12 * double(n) * (1 + expected.norm())) << j << " of " << n;
      }
    }
}

TEST(Cholesky, nothingWhereTheMatrixIsNotPositive) {
  Random random(4);
  for (const Index n : kSizes) {
    const VectorXd b = randomVector(random, n);
    MatrixXd A = randomMatrix(random, n, 1);
    A(n - 1, n - 1) = -1;  // of the last pivot
    EXPECT_FALSE(solveCholesky(A, b)) << n;
    A = -randomMatrix(random, n, 1);
    EXPECT_FALSE(solveCholesky(A, b)) << n;
    A.setZero();
    EXPECT_FALSE(solveCholesky(A, b)) << n;
  }
}

}  // namespace
