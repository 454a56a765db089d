// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/files/frames.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/files/standard_streams.h"

#include <algorithm>
#include <stdexcept>
#include <system_error>

namespace vdbtools {
namespace {

constexpr int kDefaultWidth = 4;     ///< the width of the usual $F4
constexpr std::size_t kWidest = 16;  ///< more digits than any int; a wider pattern must be a mistake

struct Pattern {
  std::size_t begin, size;
  int width;                   ///< minimum number of digits
  bool countsTheSign = false;  ///< whether a minus sign takes the place of a digit, as printf has it
};

bool isDigit(char c) { return c >= '0' && c <= '9'; }
bool isLetter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }

std::size_t fileNameBegin(std::string_view path) {
  const std::size_t slash = path.rfind('/');
  return slash == std::string_view::npos ? 0 : slash + 1;
}

/// @return the width
int requireWidth(std::size_t width, std::string_view pattern) {
  if (width <= kWidest) return static_cast<int>(width);
  throw std::invalid_argument("the frame pattern \"" + std::string(pattern) + "\" asks for more than " +
                              std::to_string(kWidest) + " digits");
}

int widthOf(std::string_view digits, std::string_view pattern) {
  std::size_t width = 0;
  // Capped at "too wide", so that a long number does not overflow.
  for (const char digit : digits) width = std::min(10 * width + static_cast<std::size_t>(digit - '0'), kWidest + 1);
  return requireWidth(width, pattern);
}

/// The pattern that begins at @a begin, if there is one.
std::optional<Pattern> patternAt(std::string_view path, std::size_t begin, bool inFileName) {
  const std::string_view rest = path.substr(begin);
  const auto digitsFrom = [rest](std::size_t i) {
    const auto end = std::find_if_not(rest.begin() + static_cast<std::ptrdiff_t>(i), rest.end(), isDigit);
    return rest.substr(i, static_cast<std::size_t>(end - rest.begin()) - i);
  };
  if (rest.starts_with("${F")) {
    const std::string_view digits = digitsFrom(3);
    const std::size_t size = 4 + digits.size();
    if (size > rest.size() || rest[size - 1] != '}') return std::nullopt;
    return Pattern{begin, size, widthOf(digits, rest.substr(0, size))};
  }
  if (rest.starts_with("$F")) {
    const std::string_view digits = digitsFrom(2);
    const std::size_t size = 2 + digits.size();
    if (digits.empty() && size < rest.size() && isLetter(rest[size])) return std::nullopt;
    return Pattern{begin, size, widthOf(digits, rest.substr(0, size))};
  }
  if (rest.starts_with('%')) {
    const std::string_view digits = digitsFrom(1);
    const std::size_t size = 2 + digits.size();
    if (size > rest.size() || rest[size - 1] != 'd') return std::nullopt;
    const std::string_view pattern = rest.substr(0, size);
    if (!digits.empty() && digits.front() != '0') {
      throw std::invalid_argument("the frame pattern \"" + std::string(pattern) + "\" pads with blanks; write \"%0" +
                                  std::string(pattern.substr(1)) + "\" to pad with zeros");
    }
    return Pattern{begin, size, widthOf(digits, pattern), true};
  }
  if (constexpr std::string_view kWord = "<frame>"; rest.starts_with(kWord))
    return Pattern{begin, kWord.size(), kDefaultWidth};
  if (rest.starts_with("<F")) {
    const std::string_view digits = digitsFrom(2);
    const std::size_t size = 3 + digits.size();
    if (size > rest.size() || rest[size - 1] != '>') return std::nullopt;
    return Pattern{begin, size, widthOf(digits, rest.substr(0, size))};
  }
  if ((rest.starts_with('#') || rest.starts_with("@@")) && inFileName) {
    const std::size_t size = std::min(rest.find_first_not_of(rest.front()), rest.size());
    return Pattern{begin, size, requireWidth(size, rest.substr(0, size))};
  }
  return std::nullopt;
}

std::optional<Pattern> findPattern(std::string_view path) {
  const std::size_t nameBegin = fileNameBegin(path);
  std::optional<Pattern> found;
  for (std::size_t i = 0; i < path.size();) {
    const std::optional<Pattern> pattern = patternAt(path, i, i >= nameBegin);
    if (!pattern) {
      ++i;
      continue;
    }
    if (found) {
      throw std::invalid_argument("\"" + std::string(path) + "\" has more than one frame pattern, \"" +
                                  std::string(path.substr(found->begin, found->size)) + "\" and \"" +
                                  std::string(path.substr(pattern->begin, pattern->size)) + "\"; leave one");
    }
    found = pattern;
    i += pattern->size;
  }
  return found;
}

/// The beginning of the extension, including its dot; a leading dot makes a hidden file, not an extension.
std::size_t extensionBegin(std::string_view path) {
  const std::size_t nameBegin = fileNameBegin(path);
  const std::size_t dot = path.rfind('.');
  return dot == std::string_view::npos || dot <= nameBegin ? path.size() : dot;
}

std::string padded(int frame, int width, bool countsTheSign) {
  const bool isNegative = frame < 0;
  const std::string digits = std::to_string(frame).substr(isNegative ? 1 : 0);
  const int zeros = width - static_cast<int>(digits.size()) - (isNegative && countsTheSign ? 1 : 0);
  return (isNegative ? "-" : "") + std::string(static_cast<std::size_t>(std::max(0, zeros)), '0') + digits;
}

}  // namespace

std::string expandFrame(std::string_view name, std::optional<int> frame) {
  const std::optional<Pattern> pattern = findPattern(name);
  if (!frame) {
    if (!pattern) return std::string(name);
    throw std::invalid_argument("\"" + std::string(name) + "\" has the frame pattern \"" +
                                std::string(name.substr(pattern->begin, pattern->size)) +
                                "\", but no frame is given; give one, or a name without the pattern");
  }
  if (pattern) {
    return std::string(name.substr(0, pattern->begin)) + padded(*frame, pattern->width, pattern->countsTheSign) +
           std::string(name.substr(pattern->begin + pattern->size));
  }
  const std::string_view fileName = name.substr(fileNameBegin(name));
  if (fileName.empty() || fileName == "." || fileName == "..") {
    throw std::invalid_argument("\"" + std::string(name) + "\" has no file name that could hold frame " +
                                std::to_string(*frame) + " into");
  }
  const std::size_t extension = extensionBegin(name);
  return std::string(name.substr(0, extension)) + "." + padded(*frame, kDefaultWidth, false) +
         std::string(name.substr(extension));
}

bool hasFramePattern(std::string_view name) { return findPattern(name).has_value(); }

std::string stemWithoutFrame(std::string_view name) {
  std::string whole(name);
  if (const std::optional<Pattern> pattern = findPattern(name)) whole.erase(pattern->begin, pattern->size);
  const std::size_t begin = fileNameBegin(whole);
  const std::string stem = whole.substr(begin, extensionBegin(whole) - begin);
  constexpr const char* kLeft = "._- ";
  const std::size_t first = stem.find_first_not_of(kLeft);
  return first == std::string::npos ? "" : stem.substr(first, stem.find_last_not_of(kLeft) + 1 - first);
}

void FrameInputs::add(const std::filesystem::path& file, int frame) {
  if (!mKnown.insert(file).second) return;
  mFiles.add(file);
  std::error_code error;
  if (std::filesystem::exists(pathToOpen(file), error)) return;
  constexpr std::size_t kMostNamed = 3;
  if (++mMissing <= kMostNamed)
    mNames += (mNames.empty() ? "'" : ", '") + file.string() + "' (frame " + std::to_string(frame) + ")";
}

void FrameInputs::requireNoneMissing() const {
  if (mMissing == 0) return;
  throw MissingInputError(mMissing == 1 ? "an input of the sequence is missing: " + mNames
                                        : std::to_string(mMissing) +
                                              " inputs of the sequence are missing, the first of them " + mNames);
}

}  // namespace vdbtools
