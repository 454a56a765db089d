// SPDX-License-Identifier: Apache-2.0
/// @file failure_answer.h
/// Exceptions as what the page is told: a status of HTTP, and the line that the command would print.
#pragma once

#include <string>

namespace vdbtools::explore {

struct FailureAnswer {
  int status = 500;
  std::string text;  ///< one line
};

/// Of the exception that is being handled.
FailureAnswer currentFailureAnswer();

}  // namespace vdbtools::explore
