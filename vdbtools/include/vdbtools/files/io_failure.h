// SPDX-License-Identifier: Apache-2.0
/// @file io_failure.h
/// Errors of the operating system in reading and writing: those that last, such as a full disk, and those that pass.
#pragma once

#include "vdbtools/base/errors.h"

#include <string>

namespace vdbtools {

/// A file system of another machine did not answer, or has forgotten the file: to try again may help.
class UnreachableError : public IoError {
  using IoError::IoError;
};

/// The system's words for an error. @param error  errno
std::string errorText(int error);

/// @param error  errno
/// @throw UnreachableError  for ESTALE, ETIMEDOUT, ECONNRESET, ECONNABORTED, ENOTCONN, ESHUTDOWN, EHOSTDOWN,
///                          EHOSTUNREACH, ENETDOWN, ENETUNREACH, ENETRESET and EREMOTEIO
/// @throw IoError           for any other; both have @a what, a colon and the system's words for @a error
[[noreturn]] void throwIoError(const std::string& what, int error);

}  // namespace vdbtools
