// SPDX-License-Identifier: Apache-2.0
/// @file text_scan.h
/// Reading words and numbers from a text file that is held in memory, with errors that name the file and the line.
#pragma once

#include "vdbtools/base/text.h"

#include <openvdb/Types.h>

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace vdbtools {

/// Splits one line into words. Spaces, tabs and carriage returns separate words.
class WordScanner {
 public:
  explicit WordScanner(std::string_view line) : mRest(line) {}
  /// @return the next word; empty at the end of the line
  std::string_view next();

 private:
  std::string_view mRest;
};

/// A text, line by line.
class LineScanner {
 public:
  /// @param text  a whole text; a byte order mark at its beginning is skipped
  LineScanner(const std::filesystem::path& path, std::string_view text)
      : mPath(path), mRest(withoutByteOrderMark(text)) {}

  /// @return the next line without its end; empty at the end of the text
  std::optional<std::string_view> next();

  /// As next(), but skips empty lines and removes comments that begin with '#'.
  std::optional<std::string_view> nextMeaningful();

  std::size_t lineNumber() const { return mLineNumber; }
  std::string_view rest() const { return mRest; }

  /// @throw DataError  "FILE, line N: WHAT"
  [[noreturn]] void fail(const std::string& what) const;

  /// A number, finite in double precision. @throw DataError
  double number(std::string_view word) const;

  /// A whole number. @throw DataError
  long long integer(std::string_view word) const;

  /// The next three words as coordinates, which may be not finite (usable_points.h). @throw DataError
  openvdb::Vec3d point(WordScanner& words) const;

 private:
  /// A number, finite or not. @throw DataError
  double anyNumber(std::string_view word) const;

  const std::filesystem::path& mPath;
  std::string_view mRest;
  std::size_t mLineNumber = 0;
};

/// A short form of @a word for an error message: one line, printable.
std::string shown(std::string_view word);

}  // namespace vdbtools
