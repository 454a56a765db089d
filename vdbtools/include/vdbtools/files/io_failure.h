// SPDX-License-Identifier: Apache-2.0
/// @file io_failure.h
/// Operating system errors in reading and writing: permanent ones, such as a full disk, and transient ones.
#pragma once

#include "vdbtools/base/errors.h"

#include <string>

namespace vdbtools {

/// A file system of another machine did not respond, or has forgotten the file; a retry may succeed.
class UnreachableError : public IoError {
  using IoError::IoError;
};

/// The system's description of an error. @param error  errno
std::string errorText(int error);

/// @param error  errno
/// @throw UnreachableError  for ESTALE, ETIMEDOUT, ECONNRESET, ECONNABORTED, ENOTCONN, ESHUTDOWN, EHOSTDOWN,
///                          EHOSTUNREACH, ENETDOWN, ENETUNREACH, ENETRESET and EREMOTEIO
/// @throw IoError           for any other; both messages have @a what, a colon and the system's description of @a error
[[noreturn]] void throwIoError(const std::string& what, int error);

}  // namespace vdbtools
