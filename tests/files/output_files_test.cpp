// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/files/output_files.h"

#include "support/temporary_folder.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace vdbtools {
namespace {

namespace fs = std::filesystem;

class OutputFilesTest : public ::testing::Test {
 protected:
  OutputFilesTest() {
    put("input", "precious");
    put("other", "another");
    fs::create_directory(mFolder / "folder");
    fs::create_directory_symlink(mFolder, mFolder / "around");
    fs::create_symlink("input", mFolder / "link");
    fs::create_symlink("link", mFolder / "far link");
    fs::create_hard_link(mFolder / "input", mFolder / "hard");
  }

  void put(const std::string& name, const std::string& content) const { std::ofstream(mFolder / name) << content; }

  std::string contentOf(const std::string& name) const {
    std::ifstream stream(mFolder / name);
    return {std::istreambuf_iterator<char>(stream), {}};
  }

  std::ptrdiff_t count() const { return std::distance(fs::directory_iterator(mFolder), {}); }

  /// All that lead to the input.
  std::vector<fs::path> ways() const {
    return {mFolder / "input", mFolder / "." / "input",         mFolder / "folder" / ".." / "input",
            mFolder / "link",  mFolder / "around" / "input",    mFolder / "far link",
            mFolder / "hard",  mFolder / "around" / "far link", fs::relative(mFolder / "input")};
  }

  const TemporaryFolder mTemporary;
  const fs::path mFolder = mTemporary.path();
};

// Promise: "No output replaces an input", through ...
TEST_F(OutputFilesTest, NoWayLeadsToAnInput) {
  const std::ptrdiff_t before = count();
  for (const fs::path& input : ways()) {
    InputFiles inputs;
    inputs.add(mFolder / "other");
    inputs.add(input);
    OutputFiles files(inputs);
    for (const fs::path& output : ways()) {
      try {
        files.add(output);
        ADD_FAILURE() << output << " replaces " << input;
      } catch (const std::invalid_argument& error) {
        EXPECT_NE(std::string(error.what()).find(output), std::string::npos) << error.what();
        EXPECT_NE(std::string(error.what()).find(input), std::string::npos) << error.what();
      }
    }
    files.add(mFolder / "new").stream() << "made";
    EXPECT_EQ(count(), before + 1) << "the temporary file of the new one alone";
  }
  EXPECT_EQ(contentOf("input"), "precious");
}

TEST_F(OutputFilesTest, AnInputThatIsNotThereYetHasItsName) {
  InputFiles inputs;
  inputs.add(mFolder / "later");
  OutputFiles files(inputs);
  EXPECT_THROW(files.add(mFolder / "around" / "later"), std::invalid_argument);
  EXPECT_THROW(files.add(mFolder / "folder" / ".." / "later"), std::invalid_argument);
  EXPECT_NO_THROW(files.add(mFolder / "folder" / "later"));
}

// Promise: "No output replaces an input", through ...
TEST_F(OutputFilesTest, AnInputThatWasReplacedMeanwhileKeepsItsPlace) {
  InputFiles inputs;
  inputs.add(mFolder / "input");
  put("newer", "newer");
  fs::rename(mFolder / "newer", mFolder / "input");
  OutputFiles files(inputs);
  EXPECT_THROW(files.add(mFolder / "link"), std::invalid_argument);
  EXPECT_THROW(files.add(mFolder / "hard"), std::invalid_argument) << "it is the file that was read";
}

TEST_F(OutputFilesTest, FoldersAreInputsWithAllThatIsBelow) {
  InputFiles inputs;
  inputs.addFolder(mFolder / "folder");
  inputs.addFolder(mFolder / "not there");
  fs::create_symlink("folder/new", mFolder / "into");
  put("folder/new", "");
  OutputFiles files(inputs);
  for (const char* name : {"folder/a", "folder/b/c", "around/folder/a", "not there/a", "into"})
    EXPECT_THROW(files.add(mFolder / name), std::invalid_argument) << name;
  EXPECT_NO_THROW(files.add(mFolder / "folderful"));
}

TEST_F(OutputFilesTest, AllOfSeveralLists) {
  InputFiles first, second;
  first.add(mFolder / "input");
  second.addFolder(mFolder / "folder");
  second.add(first);
  EXPECT_THROW(second.requireNot(mFolder / "hard"), std::invalid_argument);
  EXPECT_THROW(second.requireNot(mFolder / "folder" / "x"), std::invalid_argument);
  EXPECT_NO_THROW(first.requireNot(mFolder / "folder" / "x"));
}

// Promise: Two names of outputs that are one ...
TEST_F(OutputFilesTest, OutputsAreDifferentFiles) {
  OutputFiles files({});
  files.add(mFolder / "input").stream() << "made";
  for (const fs::path& way : ways()) {
    if (way.filename() == "hard") continue;
    EXPECT_THROW(files.add(way), std::invalid_argument) << way;
  }
  // Replacing one name of a file leaves the other.
  files.add(mFolder / "hard").stream() << "made too";
  files.commit();
  EXPECT_EQ(contentOf("link"), "made");
  EXPECT_EQ(contentOf("hard"), "made too");
}

// Promise: Two names of outputs that are one ...
TEST_F(OutputFilesTest, DevicesAreNeitherInputsNorReplaced) {
  InputFiles inputs;
  inputs.add("/dev/null");
  OutputFiles files(inputs);
  EXPECT_NO_THROW(files.add("/dev/null"));
  EXPECT_NO_THROW(files.add("/dev/null"));
  EXPECT_NO_THROW(files.commit());
}

}  // namespace
}  // namespace vdbtools
