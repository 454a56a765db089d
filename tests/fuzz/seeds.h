// SPDX-License-Identifier: Apache-2.0
/// @file seeds.h
/// Inputs to begin with, at least one for each harness: what the program itself writes, in small, and what others write
/// and it reads.
#pragma once

#include <string>
#include <vector>

namespace fuzz {

struct Seed {
  std::string harness;
  std::string name;  ///< says what it is
  std::string bytes;
};

std::vector<Seed> seeds();

}  // namespace fuzz
