// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/files/io_failure.h"

#include <cerrno>
#include <system_error>

namespace vdbtools {

std::string errorText(int error) { return std::generic_category().message(error); }

void throwIoError(const std::string& what, int error) {
  const std::string text = what + ": " + errorText(error);
  switch (error) {
    case ESTALE:
    case ETIMEDOUT:
    case ECONNRESET:
    case ECONNABORTED:
    case ENOTCONN:
    case ESHUTDOWN:
    case EHOSTDOWN:
    case EHOSTUNREACH:
    case ENETDOWN:
    case ENETUNREACH:
    case ENETRESET:
    case EREMOTEIO: throw UnreachableError(text);
    default: throw IoError(text);
  }
}

}  // namespace vdbtools
