// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/recipe/recipe.h"

#include "base/trimmed.h"
#include "vdbtools/base/text.h"

#include <algorithm>

namespace vdbtools {

std::vector<ListedOption> listedOptions(std::string_view text) {
  std::vector<ListedOption> options;
  text = withoutByteOrderMark(text);
  for (std::size_t number = 1; !text.empty(); ++number) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = trimmed(text.substr(0, std::min(end, text.substr(0, end).find('#'))));
    text.remove_prefix(std::min(end + 1, text.size()));
    if (line.empty()) continue;
    const std::size_t equals = line.find('=');
    const std::string_view name = equals == line.npos ? std::string_view() : trimmed(line.substr(0, equals));
    options.push_back({number, std::string(name), name.empty() ? line : trimmed(line.substr(equals + 1))});
  }
  return options;
}

}  // namespace vdbtools
