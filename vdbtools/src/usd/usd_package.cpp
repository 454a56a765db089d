// SPDX-License-Identifier: Apache-2.0
#include "usd/usd_package.h"

#include "vdbtools/base/errors.h"

#include <zlib.h>

#include <cstddef>
#include <cstdint>
#include <limits>
#include <ostream>
#include <sstream>
#include <streambuf>

namespace vdbtools {
namespace {

constexpr std::size_t kAlignment = 64;
constexpr std::size_t kLocalHeader = 30;  ///< bytes before the name
constexpr std::size_t kExtraHeader = 4;   ///< of a field of padding

/// Passes bytes on, counts them and computes their checksum.
class CheckedBytes final : public std::streambuf {
 public:
  explicit CheckedBytes(std::ostream& target) : mTarget(target) {}
  std::uint64_t size() const { return mSize; }
  std::uint32_t checksum() const { return static_cast<std::uint32_t>(mChecksum); }

 protected:
  int_type overflow(int_type c) override {
    if (traits_type::eq_int_type(c, traits_type::eof())) return traits_type::not_eof(c);
    const char byte = traits_type::to_char_type(c);
    return xsputn(&byte, 1) == 1 ? c : traits_type::eof();
  }
  std::streamsize xsputn(const char* from, std::streamsize count) override {
    mTarget.write(from, count);
    mChecksum = crc32_z(mChecksum, reinterpret_cast<const Bytef*>(from), static_cast<z_size_t>(count));
    mSize += static_cast<std::uint64_t>(count);
    return mTarget ? count : 0;
  }

 private:
  std::ostream& mTarget;
  uLong mChecksum = crc32(0, nullptr, 0);
  std::uint64_t mSize = 0;
};

/// Writes numbers in little-endian order, as archives have them, on any machine.
class Record {
 public:
  Record& two(std::uint64_t value) { return bytes(value, 2); }
  Record& four(std::uint64_t value) { return bytes(value, 4); }
  Record& text(const std::string& value) {
    mBytes += value;
    return *this;
  }
  const std::string& all() const { return mBytes; }

 private:
  Record& bytes(std::uint64_t value, int count) {
    for (int i = 0; i < count; ++i) mBytes += static_cast<char>(value >> (8 * i) & 0xFF);
    return *this;
  }
  std::string mBytes;
};

/// The common part of a file's header and of its entry in the central directory.
std::string describedFile(const std::string& name, const CheckedBytes& bytes, std::size_t padding) {
  constexpr std::uint64_t kVersion = 10, kStored = 0, kUtf8 = 1 << 11;
  constexpr std::uint64_t kTime = 0, kDate = 1 << 5 | 1;  // the first day of 1980: the same scene gives the same bytes
  return Record()
      .two(kVersion)
      .two(kUtf8)
      .two(kStored)
      .two(kTime)
      .two(kDate)
      .four(bytes.checksum())
      .four(bytes.size())
      .four(bytes.size())
      .two(name.size())
      .two(padding)
      .all();
}

std::string localHeader(const std::string& name, const CheckedBytes& bytes, std::size_t padding) {
  constexpr std::uint64_t kMark = 0x04034b50, kPaddingField = 0x1986;
  return Record()
      .four(kMark)
      .text(describedFile(name, bytes, padding))
      .text(name)
      .two(kPaddingField)
      .two(padding - kExtraHeader)
      .text(std::string(padding - kExtraHeader, '\0'))
      .all();
}

std::string listOfFiles(const std::string& name, const CheckedBytes& bytes, std::uint64_t begin) {
  constexpr std::uint64_t kMark = 0x02014b50, kEndMark = 0x06054b50, kVersion = 10;
  const std::string entry = Record()
                                .four(kMark)
                                .two(kVersion)
                                .text(describedFile(name, bytes, 0))
                                .two(0)   // comment
                                .two(0)   // disk
                                .two(0)   // internal attributes
                                .four(0)  // external attributes
                                .four(0)  // offset of its header
                                .text(name)
                                .all();
  return Record().text(entry).four(kEndMark).two(0).two(0).two(1).two(1).four(entry.size()).four(begin).two(0).all();
}

}  // namespace

void writeUsdPackage(std::ostream& stream, const std::string& name,
                     const std::function<void(std::ostream&)>& writeScene) {
  const std::ostream::pos_type begin = stream.tellp();
  if (begin == std::ostream::pos_type(-1)) {
    // The stream is a device or a pipe, in which the header cannot be filled in later.
    std::ostringstream whole;
    writeUsdPackage(whole, name, writeScene);
    stream << whole.view();
    return;
  }
  std::size_t padding = kAlignment - (kLocalHeader + name.size()) % kAlignment;
  if (padding < kExtraHeader) padding += kAlignment;
  CheckedBytes bytes(stream);
  stream << localHeader(name, bytes, padding);
  std::ostream scene(&bytes);
  writeScene(scene);
  scene.flush();
  if (bytes.size() >= std::numeric_limits<std::uint32_t>::max() - (std::uint64_t{1} << 20))
    throw DataError("a package (.usdz) has no room for 4 GiB or more; write a .usda with -o, or fewer frames");
  const std::string header = localHeader(name, bytes, padding);
  stream << listOfFiles(name, bytes, header.size() + bytes.size());
  const std::ostream::pos_type end = stream.tellp();
  stream.seekp(begin);
  stream << header;
  stream.seekp(end);
}

}  // namespace vdbtools
