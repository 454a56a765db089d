// SPDX-License-Identifier: Apache-2.0
#include "base/students_t.h"

#include <gtest/gtest.h>

#include <boost/math/distributions/students_t.hpp>

namespace {

TEST(StudentsT, IsTheOneOfTheBooks) {
  for (int degrees = 1; degrees <= 300; ++degrees) {
    const double known = boost::math::quantile(boost::math::students_t(degrees), 0.975);
    EXPECT_NEAR(vdbtools::studentsT95(degrees) / known, 1, 1e-13) << degrees;
  }
  // Of many it is the normal distribution's.
  EXPECT_NEAR(vdbtools::studentsT95(100'000), 1.95998, 1e-4);
}

}  // namespace
