// SPDX-License-Identifier: Apache-2.0
/// @file cancelled.h
/// What work throws that was asked to stop by the function its options hold.
#pragma once

#include <stdexcept>

namespace julia {

class Cancelled : public std::runtime_error {
 public:
  Cancelled() : std::runtime_error("the work was cancelled") {}
};

}  // namespace julia
