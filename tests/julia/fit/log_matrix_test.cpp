// SPDX-License-Identifier: Apache-2.0
// The constant matrix of a fit: its passes against sums over its entries, and what is kept of it against a fresh one.
#include "fit/log_matrix.h"

#include "support/float128.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <vector>

namespace {

using julia::LogMatrix;
using julia::Point;
using julia::Quaternion;
using law_tests::floatExact;
using law_tests::Random;

constexpr std::size_t kUnlimited = std::size_t{1} << 40;

std::vector<Point> randomCells(std::uint64_t seed, std::size_t count) {
  Random random(seed);
  std::vector<Point> cells;
  for (std::size_t i = 0; i < count; ++i) {
    const Quaternion<double> q = floatExact(random.inBall());
    cells.push_back({q.a, q.b, q.c});
  }
  return cells;
}

std::vector<Quaternion<double>> randomRoots(std::uint64_t seed, std::size_t count) {
  Random random(seed);
  std::vector<Quaternion<double>> roots;
  for (std::size_t j = 0; j < count; ++j) roots.push_back(floatExact(random.inBall()));
  return roots;
}

double logDistance(const Point& x, const Quaternion<double>& r) {
  return 0.5 * std::log(normSquared(Quaternion<double>{x[0], x[1], x[2], 0} - r));
}

/// The entries as a matrix reads them: what comes out for a weight of one root only.
std::vector<std::vector<double>> entries(const LogMatrix& matrix) {
  std::vector<std::vector<double>> columns(matrix.rootCount(), std::vector<double>(matrix.cellCount()));
  for (std::size_t j = 0; j < columns.size(); ++j) {
    std::vector<double> weights(columns.size());
    weights[j] = 1;
    matrix.logModuli(weights, 0, columns[j]);
  }
  return columns;
}

TEST(LogMatrix, holdsLogarithms) {
  const std::vector<Point> cells = randomCells(1, 700);
  const auto roots = randomRoots(2, 9);
  LogMatrix matrix(cells, kUnlimited);
  matrix.append(roots);
  EXPECT_EQ(matrix.cellCount(), 700U);
  EXPECT_EQ(matrix.roots(), roots);
  const auto columns = entries(matrix);
  for (std::size_t j = 0; j < roots.size(); ++j)
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const double expected = logDistance(cells[i], roots[j]);
      EXPECT_NEAR(columns[j][i], expected, law_tests::kEpsilon<float> * (2 + 2 * std::abs(expected))) << i << ' ' << j;
    }
}

TEST(LogMatrix, passIsTwoProducts) {
  for (const std::size_t count : {1, 255, 256, 257, 2049, 5000}) {
    const std::vector<Point> cells = randomCells(3, count);
    LogMatrix matrix(cells, kUnlimited);
    matrix.append(randomRoots(4, 11));
    const auto columns = entries(matrix);
    Random random(5);
    std::vector<double> weights(11), factors(count), summands(count);
    for (std::vector<double>* values : {&weights, &factors, &summands})
      for (double& value : *values) value = random.between(-1, 1);
    std::vector<int> visits(count);
    const LogMatrix::Pass pass = matrix.pass(
        weights, 0.25,
        [&](std::size_t begin, std::span<const double> l, std::span<double> out) {
          double sum = 0;
          for (std::size_t i = 0; i < l.size(); ++i) {
            double expected = 0.25;
            for (std::size_t j = 0; j < weights.size(); ++j) expected += weights[j] * columns[j][begin + i];
            EXPECT_NEAR(l[i], expected, 1e-13) << begin + i;
            ++visits[begin + i];
            out[i] = factors[begin + i];
            sum += summands[begin + i];
          }
          return sum;
        },
        LogMatrix::Products::Logs);
    EXPECT_EQ(visits, std::vector<int>(count, 1));
    EXPECT_NEAR(pass.sum, std::accumulate(summands.begin(), summands.end(), 0.0), 1e-11);
    ASSERT_EQ(pass.products.size(), weights.size() + 1);
    for (std::size_t j = 0; j < weights.size(); ++j)
      EXPECT_NEAR(pass.products[j], std::inner_product(factors.begin(), factors.end(), columns[j].begin(), 0.0), 1e-10)
          << j << " of " << count;
    EXPECT_NEAR(pass.products.back(), std::accumulate(factors.begin(), factors.end(), 0.0), 1e-11);
  }
}

// Products of floats, summed in floats over one panel at a time: eps times the count of a panel's cells, at worst.
TEST(LogMatrix, gramIsTheSumOfItsProducts) {
  for (const auto& [count, rootCount] : {std::pair<std::size_t, std::size_t>{100, 3}, {2500, 20}, {700, 200}}) {
    const std::vector<Point> cells = randomCells(6, count);
    LogMatrix matrix(cells, kUnlimited);
    matrix.append(randomRoots(7, rootCount));
    auto columns = entries(matrix);
    columns.emplace_back(count, 1.0);
    Random random(8);
    std::vector<double> d(count);
    for (double& value : d) value = random.integer(0, 4) == 0 ? 0 : random.unit() * random.unit();
    Eigen::MatrixXd gram;
    matrix.extendGram(julia::sampleCells(d, count), gram);
    ASSERT_EQ(gram.rows(), static_cast<Eigen::Index>(rootCount + 1));
    ASSERT_EQ(gram.cols(), gram.rows());
    EXPECT_EQ(gram, Eigen::MatrixXd(gram.transpose()));
    for (std::size_t a = 0; a < columns.size(); ++a)
      for (std::size_t b = 0; b <= a; ++b) {
        double sum = 0, magnitude = 0;
        for (std::size_t i = 0; i < count; ++i) {
          sum += d[i] * columns[a][i] * columns[b][i];
          magnitude += d[i] * std::abs(columns[a][i] * columns[b][i]);
        }
        // Sums of n floats err by the root of n rounding errors rather than by n.
        EXPECT_NEAR(gram(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b)), sum,
                    16 * law_tests::kEpsilon<float> * magnitude)
            << a << ' ' << b << " of " << count;
      }
  }
}

// Roots that come later add rows and columns; what was there stays as it was, the constant last.
TEST(LogMatrix, extendedGramIsAsFresh) {
  const std::vector<Point> cells = randomCells(9, 3000);
  const auto roots = randomRoots(10, 200);
  const std::vector<double> d(cells.size(), 0.7);
  const julia::CellSample sample = julia::sampleCells(d, 1500);
  for (const std::size_t before : {1, 63, 64, 130, 199, 200}) {
    LogMatrix fresh(cells, kUnlimited), grown(cells, kUnlimited);
    fresh.append(roots);
    grown.append(std::span(roots).first(before));
    Eigen::MatrixXd expected, gram;
    fresh.extendGram(sample, expected);
    grown.extendGram(sample, gram);
    grown.append(std::span(roots).subspan(before));
    grown.extendGram(sample, gram);
    EXPECT_EQ(gram, expected) << before;
  }
}

/// Everything that a matrix computes.
std::vector<std::uint64_t> bitsOfMatrix(const LogMatrix& matrix) {
  std::vector<double> weights(matrix.rootCount()), d(matrix.cellCount());
  for (std::size_t j = 0; j < weights.size(); ++j) weights[j] = std::sin(1.0 + static_cast<double>(j));
  for (std::size_t i = 0; i < d.size(); ++i) d[i] = 1 + std::sin(static_cast<double>(i));
  std::vector<double> all(matrix.cellCount());
  matrix.logModuli(weights, 0.5, all);
  const LogMatrix::Pass pass = matrix.pass(
      weights, 0.5,
      [](std::size_t, std::span<const double> l, std::span<double> factors) {
        std::copy(l.begin(), l.end(), factors.begin());
        return l[0];
      },
      LogMatrix::Products::Logs);
  all.push_back(pass.sum);
  all.insert(all.end(), pass.products.begin(), pass.products.end());
  Eigen::MatrixXd gram;
  matrix.extendGram(julia::sampleCells(d, matrix.cellCount() / 2), gram);
  all.insert(all.end(), gram.data(), gram.data() + gram.size());
  std::vector<std::uint64_t> bits;
  for (const double value : all) bits.push_back(std::bit_cast<std::uint64_t>(value));
  return bits;
}

TEST(LogMatrix, appendedAndKeptIsAsFresh) {
  const std::vector<Point> cells = randomCells(11, 3000);
  const auto roots = randomRoots(12, 12);
  const std::array<std::size_t, 5> kept{0, 3, 4, 9, 11};
  std::vector<Quaternion<double>> keptRoots;
  for (const std::size_t j : kept) keptRoots.push_back(roots[j]);
  const auto more = randomRoots(13, 3);
  // The second is stored at first and then too large; the third is never stored.
  for (const std::size_t memoryLimit : {kUnlimited, 13 * 3072 * sizeof(float), std::size_t{0}}) {
    LogMatrix fresh(cells, kUnlimited), changed(cells, memoryLimit);
    fresh.append(roots);
    changed.append(std::span(roots).first(7));
    EXPECT_EQ(changed.stored(), memoryLimit > 0);
    changed.append(std::span(roots).subspan(7));
    EXPECT_EQ(bitsOfMatrix(changed), bitsOfMatrix(fresh)) << memoryLimit;
    LogMatrix freshKept(cells, kUnlimited);
    freshKept.append(keptRoots);
    changed.keep(kept);
    EXPECT_EQ(changed.roots(), keptRoots);
    EXPECT_EQ(bitsOfMatrix(changed), bitsOfMatrix(freshKept)) << memoryLimit;
    freshKept.append(more);
    changed.append(more);
    changed.append(roots);
    freshKept.append(roots);
    EXPECT_EQ(bitsOfMatrix(changed), bitsOfMatrix(freshKept)) << memoryLimit;
    EXPECT_EQ(changed.stored(), memoryLimit == kUnlimited);
    changed.keep({});
    EXPECT_EQ(changed.rootCount(), 0U);
    std::vector<double> l(3000);
    changed.logModuli({}, 0.75, l);
    EXPECT_EQ(l, std::vector<double>(3000, 0.75));
  }
}

TEST(LogMatrix, movedIsAsFresh) {
  const std::vector<Point> cells = randomCells(16, 3000);
  const auto roots = randomRoots(17, 7), places = randomRoots(18, 7);
  for (const std::size_t memoryLimit : {std::size_t{0}, kUnlimited}) {
    LogMatrix fresh(cells, memoryLimit), moved(cells, memoryLimit);
    fresh.append(places);
    moved.append(roots);
    moved.move(places);
    EXPECT_EQ(moved.roots(), places);
    EXPECT_EQ(bitsOfMatrix(moved), bitsOfMatrix(fresh)) << memoryLimit;
  }
}

TEST(LogMatrix, placesAreTheSlopesOfItsProducts) {
  const std::vector<Point> cells = randomCells(19, 2100);
  const auto roots = randomRoots(20, 6);
  Random random(21);
  std::vector<double> factors(cells.size());
  for (double& factor : factors) factor = random.between(-1, 1);
  LogMatrix matrix(cells, kUnlimited);
  matrix.append(roots);
  const LogMatrix::Pass pass = matrix.pass(
      std::vector<double>(roots.size()), 0,
      [&](std::size_t begin, std::span<const double> l, std::span<double> out) {
        std::copy_n(factors.begin() + static_cast<std::ptrdiff_t>(begin), l.size(), out.begin());
        return 0.0;
      },
      LogMatrix::Products::LogsAndPlaces);
  ASSERT_EQ(pass.places.size(), roots.size());
  for (std::size_t j = 0; j < roots.size(); ++j) {
    Quaternion<double> expected;
    double magnitude = 0;
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const Quaternion<double> d = roots[j] - Quaternion<double>{cells[i][0], cells[i][1], cells[i][2], 0};
      expected = expected + d * (factors[i] / normSquared(d));
      magnitude += std::abs(factors[i]) / std::sqrt(normSquared(d));
    }
    EXPECT_LT(std::sqrt(normSquared(pass.places[j] - expected)), 4 * law_tests::kEpsilon<float> * magnitude) << j;
  }
}

TEST(LogMatrix, threadsChangeNoBit) {
  const std::vector<Point> cells = randomCells(14, 6000);
  for (const std::size_t memoryLimit : {std::size_t{0}, kUnlimited}) {
    LogMatrix matrix(cells, memoryLimit);
    matrix.append(randomRoots(15, 150));
    const std::vector<std::uint64_t> expected = bitsOfMatrix(matrix);
    for (const std::size_t threads : {1, 3}) {
      const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
      EXPECT_EQ(bitsOfMatrix(matrix), expected) << threads;
    }
  }
}

}  // namespace
