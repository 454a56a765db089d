// SPDX-License-Identifier: Apache-2.0
/// @file vdb_cursor.h
/// A position in the bytes of a VDB, which never reads past their end.
#pragma once

#include "vdbtools/base/errors.h"

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>

namespace vdbtools {

static_assert(std::endian::native == std::endian::little, "the numbers are read as they lie in the file");

/// The bytes end too early.
class VdbEnds : public DataError {
  using DataError::DataError;
};

class VdbCursor {
 public:
  /// @param all  must outlive the cursor
  explicit VdbCursor(std::string_view all, std::size_t at = 0) : mAll(all), mAt(at) {}

  /// Names the part of the file that is read from here on, for error messages.
  void enter(std::string part) { mPart = std::move(part); }
  const std::string& part() const { return mPart; }

  std::size_t position() const { return mAt; }
  std::size_t left() const { return mAll.size() - mAt; }

  /// Reads the next bytes. @throw VdbEnds  there are fewer
  std::string_view bytes(std::uint64_t count) {
    if (count > left()) throw VdbEnds("it ends within " + mPart);
    const std::string_view some = mAll.substr(mAt, static_cast<std::size_t>(count));
    mAt += some.size();
    return some;
  }

  template <class T>
  T number() {
    static_assert(std::is_arithmetic_v<T>);
    T value;
    std::memcpy(&value, bytes(sizeof value).data(), sizeof value);
    return value;
  }

  /// Reads a length of 32 bits and that many bytes.
  std::string_view text() { return bytes(number<std::uint32_t>()); }

  /// @throw DataError  with @a what as a statement about the current part
  [[noreturn]] void refuse(const std::string& what) const { throw DataError(mPart + ' ' + what); }

 private:
  std::string_view mAll;
  std::size_t mAt;
  std::string mPart = "its head";
};

}  // namespace vdbtools
