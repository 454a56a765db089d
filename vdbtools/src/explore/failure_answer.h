// SPDX-License-Identifier: Apache-2.0
/// @file failure_answer.h
/// Converts exceptions to what the page receives: an HTTP status, and the line that the command would print.
#pragma once

#include <string>

namespace vdbtools::explore {

struct FailureAnswer {
  int status = 500;
  std::string text;  ///< one line
};

/// The answer for the exception that is being handled.
FailureAnswer currentFailureAnswer();

}  // namespace vdbtools::explore
