// SPDX-License-Identifier: Apache-2.0
#include "support/temporary_folder.h"

#include "vdbtools/files/named_file.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/files/file_bytes.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

namespace vdbtools {
namespace {

namespace fs = std::filesystem;

class FileHash : public ::testing::Test {
 protected:
  fs::path fileWith(const std::string& content) const {
    std::ofstream(mFolder / "file", std::ios::binary) << content;
    return mFolder / "file";
  }

  const TemporaryFolder mTemporary;
  const fs::path mFolder = mTemporary.path();
};

struct Vector {
  std::string message, digest;
};

// The examples published with FIPS 180 by NIST.
const Vector kVectors[] = {
    {"", "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855"},
    {"abc", "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"},
    {"abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq",
     "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1"},
    {"abcdefghbcdefghicdefghijdefghijkefghijklfghijklmghijklmnhijklmnoijklmnopjklmnopqklmnopqrlmnopqrsmnopqrstnopqrstu",
     "cf5b16a778af8380036ce59e7b0492370b249b11e8f07a51afac45037afee9d1"},
    {std::string(1000000, 'a'), "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0"},
    {std::string("\xbd"), "68325720aabd7c82f30f554b313d0570c95accbb7dc4b5aae11204c08ffe732b"},
    {std::string(55, '\0'), "02779466cdec163811d078815c633f21901413081449002f24aa3e80f0b88ef7"},
};

TEST_F(FileHash, MeetsThePublishedVectors) {
  for (const Vector& v : kVectors) {
    EXPECT_EQ(sha256Hex(v.message), v.digest) << v.message.size() << " bytes";
    EXPECT_EQ(sha256OfFile(fileWith(v.message)), v.digest) << v.message.size() << " bytes";
  }
}

TEST_F(FileHash, OfAFileIsThatOfItsBytes) {
  // Around the size of a piece.
  constexpr std::size_t kMebi = std::size_t{1} << 20;
  for (const std::size_t size : {kMebi - 1, kMebi, kMebi + 1, 3 * kMebi + 5}) {
    std::string content(size, '\0');
    for (std::size_t i = 0; i < size; ++i) content[i] = static_cast<char>(i * 2654435761U >> 13);
    EXPECT_EQ(sha256OfFile(fileWith(content)), sha256Hex(content)) << size;
    EXPECT_EQ(readWholeFile(mFolder / "file"), content) << size;
  }
}

TEST_F(FileHash, TellsMissingFilesFromBrokenReads) {
  for (const fs::path& path : {mFolder / "absent", mFolder, fileWith("x") / "below", fs::path()}) {
    EXPECT_THROW(sha256OfFile(path), MissingInputError) << path;
    EXPECT_THROW(readWholeFile(path), MissingInputError) << path;
  }
  // The first page of a process is never mapped, so that reading its memory from 0 on fails.
  EXPECT_THROW(sha256OfFile("/proc/self/mem"), IoError);
  EXPECT_THROW(readWholeFile("/proc/self/mem"), IoError);
}

TEST_F(FileHash, ReadsFilesThatDoNotTellTheirSize) {
  EXPECT_EQ(readWholeFile("/dev/null"), "");
  EXPECT_FALSE(readWholeFile("/proc/self/status").empty());
}

TEST(InOneLine, LeavesNoControlCharacters) {
  EXPECT_EQ(inOneLine("a\nb\tc\x1b[1m\x7f"), "a?b?c?[1m?");
  EXPECT_LT(inOneLine(std::string(100000, 'x')).size(), 1000U);
}

TEST(InOneLine, CutsNoCharacterInTwo) {
  std::string word;
  while (word.size() < 1000) word += "\u20ac";  // three bytes each
  for (const std::string before : {"", "a", "ab"}) {
    const std::string line = inOneLine(before + word);
    ASSERT_LT(line.size(), 1000U);
    EXPECT_EQ((line.size() - before.size() - 3) % 3, 0U) << line;
  }
}

}  // namespace
}  // namespace vdbtools
