// SPDX-License-Identifier: Apache-2.0
#include "config_list.h"

#include "vdbtools/base/near_words.h"
#include "vdbtools/files/file_bytes.h"

#include <algorithm>
#include <sstream>
#include <stdexcept>
#include <string_view>
#include <vector>

namespace cli {
namespace {

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlanks = " \t\r\v\f";
  const std::size_t begin = text.find_first_not_of(kBlanks);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(kBlanks) + 1 - begin);
}

}  // namespace

// Not by Boost.ProgramOptions, which never ends where it reports a name such as %canonical_option%: it looks for that
// in its message, to put the name there.
vdbtools::Recipe readConfigList(const std::string& text, const std::string& file, const vdbtools::OptionTable& table) {
  std::vector<std::string> known;
  for (const vdbtools::OptionListing& option : table.listing()) known.push_back(option.name);
  vdbtools::Recipe recipe;
  std::istringstream stream(text);
  std::string whole;
  for (std::size_t number = 1; std::getline(stream, whole); ++number) {
    const std::string_view line = trimmed(std::string_view(whole).substr(0, whole.find('#')));
    if (line.empty()) continue;
    const std::string where = "'" + file + "', line " + std::to_string(number) + ": ";
    const std::size_t equals = line.find('=');
    const std::string name(trimmed(line.substr(0, equals)));
    if (equals == std::string_view::npos || name.empty())
      throw std::invalid_argument(where + "'" + vdbtools::inOneLine(std::string(line)) +
                                  "' does not read NAME = VALUE; a comment begins with #");
    if (std::find(known.begin(), known.end(), name) == known.end())
      throw std::invalid_argument(where + "there is no option '" + vdbtools::inOneLine(name) + "' here" +
                                  vdbtools::didYouMean(name, known));
    if (!recipe.emplace(name, trimmed(line.substr(equals + 1))).second)
      throw std::invalid_argument(where + "'" + name + "' is set twice; keep only one of them");
  }
  return recipe;
}

}  // namespace cli
