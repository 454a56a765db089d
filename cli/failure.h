// SPDX-License-Identifier: Apache-2.0
/// @file failure.h
/// What an exception means for the user: an exit code and one line.
#pragma once

#include <stdexcept>
#include <string>

namespace cli {

struct Failure {
  int code;
  std::string text;
};

/// Describes the exception that is being handled; call it in a catch block.
Failure currentFailure();

/// A failure with a known exit code.
class FailedWith : public std::runtime_error {
 public:
  explicit FailedWith(const Failure& failure) : std::runtime_error(failure.text), mCode(failure.code) {}
  int code() const { return mCode; }

 private:
  int mCode;
};

}  // namespace cli
