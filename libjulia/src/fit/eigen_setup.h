// SPDX-License-Identifier: Apache-2.0
/// @file eigen_setup.h
/// Eigen blocks its products by the sizes of the caches that it finds, and sums in another order on another machine.
/// Sources that use it include this header and call fixEigenBlocking() first.
#pragma once

#include <Eigen/Core>

namespace julia {

inline void fixEigenBlocking() {
  // A static's initialisation is done once, also when threads meet here.
  static const bool done = [] {
    Eigen::setCpuCacheSizes(32 << 10, 512 << 10, 4 << 20);
    return true;
  }();
  static_cast<void>(done);
}

}  // namespace julia
