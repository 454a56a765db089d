// SPDX-License-Identifier: Apache-2.0
// Borrowed objects, and evaluators that are called again from within their own map.
#include "object_pool.h"

#include "julia/evaluator.h"
#include "julia/quadratic_map.h"

#include <gtest/gtest.h>

#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace {

using julia::ObjectPool;
using julia::Point;
using julia::Quaternion;

TEST(ObjectPool, lendsAnObjectToOneBorrowerAtATime) {
  int made = 0;
  ObjectPool<int> pool([&] { return std::make_unique<int>(made++); });
  {
    const auto first = pool.borrow(), second = pool.borrow();
    EXPECT_NE(*first, *second);
    EXPECT_EQ(made, 2);
  }
  const auto third = pool.borrow(), fourth = pool.borrow();
  EXPECT_NE(*third, *fourth);
  EXPECT_EQ(made, 2) << "what was returned is lent again";
}

/// q^2 + c that evaluates other points with its own evaluator in every step.
class NestedMap final : public julia::Map<float> {
 public:
  explicit NestedMap(const Quaternion<double>& c) : mMap(c) {}

  void logModulus(const julia::QuaternionBatch<float>& q, std::span<float> l) const override {
    const julia::FieldEvaluator* const again = std::exchange(evaluator, nullptr);
    if (again) {
      const std::vector<Point> points(100, Point{0.1, 0.2, 0.3});
      std::vector<double> field(points.size());
      again->evaluate(points, field, {});
    }
    mMap.logModulus(q, l);
    evaluator = again;
  }
  void versor(const julia::QuaternionBatch<float>& q, julia::QuaternionBatch<float>& u) const override {
    mMap.versor(q, u);
  }
  float surfaceLevel(float logEscape) const override { return logEscape; }

  mutable const julia::FieldEvaluator* evaluator = nullptr;

 private:
  julia::QuadraticMap<float> mMap;
};

TEST(FieldEvaluator, mayBeCalledAgainFromWithinItsMap) {
  std::vector<Point> points;
  for (int i = 0; i < 3000; ++i) points.push_back({-1.5 + i * 1e-3, 0.3, 0.1});
  const julia::OrbitOptions orbit{.maxIterations = 12, .escapeRadius = 20};
  const auto map = std::make_shared<NestedMap>(Quaternion<double>{-0.2, 0.8, 0, 0});
  const auto evaluator = julia::makeFieldEvaluator<float>(map, {}, orbit);
  std::vector<double> expected(points.size()), field(points.size());
  evaluator->evaluate(points, expected, {});
  map->evaluator = evaluator.get();
  evaluator->evaluate(points, field, {});
  EXPECT_EQ(field, expected);
}

}  // namespace
