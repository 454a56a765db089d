// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/farm/plans.h"

#include "base/smooth_step.h"

#include "vdbtools/base/text.h"
#include "vdbtools/recipe/option_value.h"
#include "vdbtools/recipe/recipe.h"

#include <cmath>
#include <cstdint>
#include <iterator>
#include <optional>
#include <set>
#include <stdexcept>
#include <utility>

namespace vdbtools::farm {
namespace {

/// A value split at its separators.
struct Parts {
  std::vector<std::string> texts{1};
  std::string separators;
};

Parts partsOf(const std::string& value) {
  Parts parts;
  for (const char c : value) {
    if (c == ',' || c == ':' || c == '@' || c == ';') {
      parts.separators += c;
      parts.texts.emplace_back();
    } else {
      parts.texts.back() += c;
    }
  }
  return parts;
}

/// A number between two others, as the shortest text that reads back as the same double; if both texts are equal, that
/// text.
std::optional<std::string> blended(const std::string& from, const std::string& to, double share) {
  if (from == to) return from;
  const std::optional<double> a = numberFromText(from), b = numberFromText(to);
  if (!a || !b || !std::isfinite(*a) || !std::isfinite(*b)) return std::nullopt;
  return numbersText({std::lerp(*a, *b, share)});
}

using Key = std::pair<const int, std::string>;

std::string blended(const std::string& option, const Key& from, const Key& to, double share) {
  const Parts a = partsOf(from.second), b = partsOf(to.second);
  std::string result;
  for (std::size_t i = 0; a.separators == b.separators && i < a.texts.size(); ++i) {
    const std::optional<std::string> part = blended(a.texts[i], b.texts[i], share);
    if (!part) break;
    result += *part;
    if (i == a.separators.size()) return result;
    result += a.separators[i];
  }
  throw std::invalid_argument("--" + option + " is '" + from.second + "' at frame " + std::to_string(from.first) +
                              " and '" + to.second + "' at frame " + std::to_string(to.first) +
                              "; only numbers can be blended, so give both keys the same form, or use --ease " +
                              option + "=step");
}

double shareAt(Ease ease, double t) {
  if (ease == Ease::Step) return 0;
  return ease == Ease::Smooth ? smoothStep(t) : t;
}

Ease parseEase(const std::string& text) {
  return chosen<Ease>("ease", text, {{"linear", Ease::Linear}, {"smooth", Ease::Smooth}, {"step", Ease::Step}});
}

}  // namespace

std::vector<int> parseFrames(const std::string& text) {
  const std::string most = std::to_string(kMostFrames);
  std::vector<int> frames;
  std::set<int> seen;
  for (const std::string& part : split(text, ',')) {
    // A minus sign may stand before each number, so the dash of a range is not the first character.
    const std::size_t times = part.find_first_of("x:"), dash = part.find('-', 1);
    const std::string range = part.substr(0, times);
    const std::optional<int> first = wholeFromText<int>(range.substr(0, dash));
    const std::optional<int> last = dash < times ? wholeFromText<int>(range.substr(dash + 1)) : first;
    const std::optional<int> step = times == std::string::npos ? 1 : wholeFromText<int>(part.substr(times + 1));
    // "1:6" would be taken for the frames 1 to 6.
    const bool isUnclear = times != std::string::npos && part[times] == ':' && dash >= times;
    if (!first || !last || !step || *last < *first || *step < 1 || isUnclear)
      refuse("frames", text,
             "frames and ranges of frames, such as 1-48, 1-48x2 or 1-48:2, 7,10-12 or -5-5, in each range the smaller "
             "number "
             "first");
    const std::int64_t length = (std::int64_t{*last} - *first) / *step;
    if (length >= kMostFrames) refuse("frames", text, "a range of at most " + most + " frames");
    for (std::int64_t i = 0; i <= length; ++i)
      if (const int frame = static_cast<int>(*first + i * *step); seen.insert(frame).second) frames.push_back(frame);
    if (frames.size() > kMostFrames) refuse("frames", text, "a list of at most " + most + " frames");
  }
  return frames;
}

std::vector<KeyedOption> parseKeys(const std::vector<std::string>& keys, const std::vector<std::string>& eases,
                                   const OptionTable& table) {
  std::map<std::string, KeyedOption> options;
  for (const std::string& text : keys) {
    const std::size_t at = text.find('@'), equals = text.find('=', at);
    if (at == 0 || at == std::string::npos || equals == std::string::npos)
      refuse("key", text, "NAME@FRAME=VALUE, such as alpha@48=120");
    const std::string name = currentName(text.substr(0, at));
    if (!table.knows(name))
      refuse("key", text, "for an option of a fractal; there is none with the name '" + text.substr(0, at) + "'");
    const std::optional<int> frame = wholeFromText<int>(text.substr(at + 1, equals - at - 1));
    if (!frame) refuse("key", text, "NAME@FRAME=VALUE with a whole number for the frame");
    KeyedOption& option = options[name];
    option.name = name;
    if (!option.keys.emplace(*frame, text.substr(equals + 1)).second)
      refuse("key", text, "the only key of '" + name + "' at frame " + std::to_string(*frame));
  }
  std::optional<Ease> ofAll;
  std::map<std::string, Ease> ofOne;
  for (const std::string& text : eases) {
    const std::size_t equals = text.find('=');
    const bool isNew =
        equals == std::string::npos
            ? !std::exchange(ofAll, parseEase(text))
            : ofOne.emplace(currentName(text.substr(0, equals)), parseEase(text.substr(equals + 1))).second;
    if (!isNew) refuse("ease", text, "given once for an option, and once for all others");
  }
  for (const auto& [name, ease] : ofOne)
    if (!options.contains(name)) refuse("ease", name, "for an option that has keys");
  std::vector<KeyedOption> result;
  for (auto& [name, option] : options) {
    const auto own = ofOne.find(name);
    option.ease = own != ofOne.end() ? own->second : ofAll.value_or(Ease::Linear);
    for (auto key = option.keys.begin(); option.ease != Ease::Step && std::next(key) != option.keys.end(); ++key)
      blended(name, *key, *std::next(key), 0.5);
    result.push_back(std::move(option));
  }
  return result;
}

std::string valueAt(const KeyedOption& option, int frame) {
  const auto next = option.keys.upper_bound(frame);
  if (next == option.keys.begin()) return next->second;
  const auto last = std::prev(next);
  if (next == option.keys.end() || last->first == frame || option.ease == Ease::Step) return last->second;
  const double t = (static_cast<double>(frame) - last->first) / (static_cast<double>(next->first) - last->first);
  return blended(option.name, *last, *next, shareAt(option.ease, t));
}

}  // namespace vdbtools::farm
