// SPDX-License-Identifier: Apache-2.0
#include "help_output.h"

#include "vdbtools/base/errors.h"

#include <cerrno>

#include <unistd.h>

namespace cli {

void writeHelp(std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = ::write(STDOUT_FILENO, text.data(), text.size());
    if (written >= 0)
      text.remove_prefix(static_cast<std::size_t>(written));
    else if (errno == EPIPE)
      return;
    else if (errno != EINTR)
      throw vdbtools::IoError("writing to the standard output failed");
  }
}

}  // namespace cli
