// SPDX-License-Identifier: Apache-2.0
#include "help_output.h"

#include "vdbtools/base/errors.h"

#include <algorithm>
#include <cerrno>
#include <sstream>

#include <sys/ioctl.h>
#include <unistd.h>

namespace cli {

unsigned helpWidth() {
  constexpr unsigned kLeast = 60, kMost = 120, kUsual = 110;
  winsize size{};
  if (::ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col == 0) return kUsual;
  return std::clamp<unsigned>(size.ws_col, kLeast, kMost);
}

std::string wrapped(std::string_view text, std::size_t width) {
  std::string result, line;
  std::size_t indent = 0;  // of the continuation lines of a paragraph
  const auto finish = [&] {
    if (!line.empty()) result += line + '\n';
    line.clear();
  };
  std::istringstream lines{std::string(text)};
  for (std::string next; std::getline(lines, next);) {
    const std::size_t begin = next.find_first_not_of(' ');
    if (begin == std::string::npos) {
      finish();
      result += '\n';
      indent = 0;
      continue;
    }
    const bool isRow = begin == 2;
    if (isRow || (begin == 0 && indent > 0)) {
      finish();
      indent = 0;
      if (isRow) {
        const std::size_t gap = next.find("  ", begin);
        const std::size_t meaning = gap == std::string::npos ? begin : next.find_first_not_of(' ', gap);
        indent = std::min(meaning, width / 2);
        line = next.substr(0, meaning);
        next.erase(0, line.size());
      }
    }
    std::istringstream words(next);
    for (std::string word; words >> word;) {
      if (!line.empty() && line.back() != ' ') {
        if (line.size() + 1 + word.size() > width) {
          result += line + '\n';
          line.assign(indent, ' ');
        } else {
          line += ' ';
        }
      }
      line += word;
    }
  }
  finish();
  while (result.ends_with("\n\n") || (!text.ends_with('\n') && result.ends_with('\n'))) result.pop_back();
  return result;
}

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
