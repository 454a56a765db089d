// SPDX-License-Identifier: Apache-2.0
/// @file cancelled.h
/// The exception that ends the work when the function `cancelled` in its options returns true.
#pragma once

#include <stdexcept>

namespace julia {

class Cancelled : public std::runtime_error {
 public:
  Cancelled() : std::runtime_error("the work was cancelled") {}
};

}  // namespace julia
