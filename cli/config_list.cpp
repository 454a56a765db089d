// SPDX-License-Identifier: Apache-2.0
#include "config_list.h"

#include "vdbtools/base/text.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/recipe/recipe.h"

#include <stdexcept>

namespace cli {

// Boost.ProgramOptions is not used, because it hangs when it reports a name such as %canonical_option%: it searches for
// that in its message, to insert the name there.
vdbtools::Recipe readConfigList(const std::string& text, const std::string& file, const vdbtools::OptionTable& table) {
  vdbtools::Recipe recipe;
  for (const vdbtools::ListedOption& option : vdbtools::listedOptions(text)) {
    const std::string where = "'" + file + "', line " + std::to_string(option.line) + ": ";
    if (option.name.empty())
      throw std::invalid_argument(where + "'" + vdbtools::inOneLine(option.value) +
                                  "' does not read NAME = VALUE; a comment begins with #");
    const std::string entry = vdbtools::currentName(option.name);
    if (!table.knows(entry))
      throw std::invalid_argument(where + "there is no option '" + vdbtools::inOneLine(option.name) + "' here" +
                                  vdbtools::didYouMean(option.name, table.names()));
    if (!recipe.emplace(entry, option.value).second)
      throw std::invalid_argument(where + "'" + option.name + "' is set twice; keep only one of them");
  }
  return recipe;
}

}  // namespace cli
