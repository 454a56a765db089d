// SPDX-License-Identifier: Apache-2.0
#include "recipe/option_rows.h"

#include "vdbtools/base/text.h"

#include <algorithm>

namespace vdbtools {

double readNumber(const RecipeReader& reader, const std::string& name, const OptionType& range) {
  const double value = reader.number(name);
  if (!range.holds(value)) reader.refuse(name, range.bounds());
  return value;
}

std::vector<std::size_t> listedWords(const RecipeReader& reader, const std::string& name,
                                     const std::vector<std::string>& words) {
  std::vector<std::size_t> places;
  for (const std::string& word : split(reader.text(name), ',')) {
    const auto found = std::find(words.begin(), words.end(), word);
    const auto place = static_cast<std::size_t>(found - words.begin());
    if (found == words.end()) reader.refuse(name, "a list of " + joined(words) + didYouMean(word, words));
    if (std::find(places.begin(), places.end(), place) != places.end())
      reader.refuse(name, "a list in which no name occurs twice");
    places.push_back(place);
  }
  return places;
}

}  // namespace vdbtools
