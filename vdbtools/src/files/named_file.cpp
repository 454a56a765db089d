// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/files/named_file.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/base/memory.h"
#include "vdbtools/files/file_bytes.h"

#include <openssl/evp.h>

#include <array>
#include <cstdint>
#include <memory>
#include <stdexcept>
#include <streambuf>
#include <system_error>

namespace vdbtools {

std::map<std::string, std::string> verifiedHashes(std::span<const NamedFile> files) {
  std::map<std::string, std::string> found;
  for (const NamedFile& file : files) {
    // Files that a recipe names are read whole, and hashing a file that does not fit would take hours.
    std::error_code error;
    const std::uintmax_t size = std::filesystem::file_size(file.path, error);
    if (!error) requireMemory(static_cast<double>(size), MemoryUse::File, inOneLine(file.path.native()));
    std::string& hashes = found[file.recordedAs];
    hashes += (hashes.empty() ? "" : ",") + sha256OfFile(file.path);
  }
  for (const NamedFile& file : files) {
    const std::string& hash = found.at(file.recordedAs);
    if (!file.expectedHash.empty() && file.expectedHash != hash)
      throw DataError("'" + file.path.string() + "' has changed since the recipe was made: its SHA-256 is " + hash +
                      " and was " + file.expectedHash + "; to use it all the same, give the options anew");
  }
  return found;
}

namespace {

class Sha256 {
 public:
  Sha256() : mContext(EVP_MD_CTX_new(), &EVP_MD_CTX_free) {
    require(mContext && EVP_DigestInit_ex(mContext.get(), EVP_sha256(), nullptr) == 1);
  }

  void add(std::string_view bytes) { require(EVP_DigestUpdate(mContext.get(), bytes.data(), bytes.size()) == 1); }

  std::string hex() {
    std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
    unsigned int size = 0;
    require(EVP_DigestFinal_ex(mContext.get(), digest.data(), &size) == 1);
    constexpr std::string_view kDigits = "0123456789abcdef";
    std::string text;
    for (unsigned int i = 0; i < size; ++i) {
      text += kDigits[digest[i] >> 4];
      text += kDigits[digest[i] & 0xF];
    }
    return text;
  }

 private:
  static void require(bool succeeded) {
    if (!succeeded) throw std::runtime_error("OpenSSL cannot compute SHA-256; its configuration may forbid it");
  }

  std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> mContext;
};

}  // namespace

class HashStream::Buffer final : public std::streambuf {
 public:
  std::string hex() { return mHash.hex(); }

 private:
  int_type overflow(int_type c) override {
    const char byte = traits_type::to_char_type(c);
    if (!traits_type::eq_int_type(c, traits_type::eof())) mHash.add({&byte, 1});
    return traits_type::not_eof(c);
  }
  std::streamsize xsputn(const char* bytes, std::streamsize size) override {
    mHash.add({bytes, static_cast<std::size_t>(size)});
    return size;
  }

  Sha256 mHash;
};

HashStream::HashStream() : std::ostream(nullptr), mBuffer(std::make_unique<Buffer>()) { rdbuf(mBuffer.get()); }
HashStream::~HashStream() = default;
std::string HashStream::sha256Hex() { return mBuffer->hex(); }

std::string sha256Hex(std::string_view bytes) {
  Sha256 hash;
  hash.add(bytes);
  return hash.hex();
}

std::string sha256OfFile(const std::filesystem::path& path) {
  Sha256 hash;
  readPieces(path, [&hash](std::string_view piece) { hash.add(piece); });
  return hash.hex();
}

}  // namespace vdbtools
