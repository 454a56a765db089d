// SPDX-License-Identifier: Apache-2.0
/// @file errors.h
/// The exceptions of vdbtools. Each says, in words for the user, what was found and what to do about it.
/// An option outside its domain is a std::invalid_argument; a broken promise of our own is a std::logic_error.
#pragma once

#include <stdexcept>

namespace vdbtools {

/// The input was read, but cannot be used: truncated, leaky, empty, not finite.
class DataError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// There is no such input, or it may not be opened.
class MissingInputError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The output cannot be created where it was asked for.
class CreateError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Reading or writing broke off: a full disk, a lost mount.
class IoError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The work was cancelled through its Monitor.
class Interrupted : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace vdbtools
