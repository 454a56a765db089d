// SPDX-License-Identifier: Apache-2.0
#include "python_words.h"

#include "made.h"

#include "vdbtools/fit/fit_job.h"
#include "vdbtools/scene/fractal_options.h"

#include <algorithm>
#include <cctype>
#include <set>

namespace {

/// The names of options in Python, with dashes as on the command line.
const std::set<std::string, std::less<>>& namesInPython() {
  static const std::set<std::string, std::less<>> all = [] {
    std::set<std::string, std::less<>> names{"memory", "device"};
    for (const vdbtools::OptionTable& table :
         {vdbtools::fractalOptionTable(), vdbtools::fit::fitOptionTable(), viewTable()})
      for (const vdbtools::OptionListing& option : table.listing()) names.insert(option.name);
    return names;
  }();
  return all;
}

bool isLetter(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0; }

}  // namespace

std::string inPythonsWords(std::string_view message) {
  constexpr std::string_view kHelp = "is not an option of this command; see --help";
  if (const std::size_t at = message.find(kHelp); at != std::string_view::npos) {
    std::string meant(message.substr(at + kHelp.size()));  // the option that it may have been, in quotes
    if (const std::size_t dashes = meant.find("'--"); dashes != std::string::npos) meant.erase(dashes + 1, 2);
    std::replace(meant.begin(), meant.end(), '-', '_');
    return inPythonsWords(message.substr(0, at)) + "is not an option of this function; help() of it lists them" + meant;
  }
  std::string text;
  bool quoted = false;
  for (std::size_t at = 0; at < message.size();) {
    const bool afterLetter = at > 0 && isLetter(message[at - 1]);
    // An apostrophe, as in "the target's", stands between letters.
    if (message[at] == '\'' && !(afterLetter && at + 1 < message.size() && isLetter(message[at + 1]))) quoted = !quoted;
    if (!quoted && message.substr(at).starts_with("--")) {
      const auto end = std::find_if(message.begin() + static_cast<std::ptrdiff_t>(at) + 2, message.end(),
                                    [](char c) { return !isLetter(c) && c != '-'; });
      std::string name(message.begin() + static_cast<std::ptrdiff_t>(at) + 2, end);
      // The first word names the option that was given, which may be none at all.
      if (at == 0 || namesInPython().contains(name)) {
        at += 2 + name.size();
        std::replace(name.begin(), name.end(), '-', '_');
        text += name;
        continue;
      }
    }
    text += message[at++];
  }
  return text;
}
