// SPDX-License-Identifier: Apache-2.0
#include "mesh_files/mesh_formats.h"
#include "support/temporary_folder.h"
#include "support/test_fields.h"
#include "support/test_meshes.h"

#include "vdbtools/files/file_bytes.h"
#include "vdbtools/formats/file_formats.h"
#include "vdbtools/mesh_files/mesh_reader.h"
#include "vdbtools/mesh_files/mesh_writer.h"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

namespace {

using namespace vdbtools;

const FileTexts kTexts = {{"julia_alpha", "40"}, {"julia_up_axis", "z"}};

bool isHere(const FileFormat& format) { return !format.isBuilt || format.isBuilt(); }

/// The bytes of a small file in a format that is written.
std::string bytesOf(const FileFormat& format) {
  std::ostringstream stream;
  if (format.writesGrids) {
    const auto grid = test_fields::bandGrid([](const openvdb::Vec3d& x) { return x.length() - 0.4; }, 0.1, 0.3, 0.3);
    grid->setName("surface");
    writeGrids(stream, format, {grid}, {.metadata = kTexts});
  } else {
    writeMesh(stream, test_meshes::makeSphere(1, 2), {.format = &format, .comments = kTexts});
  }
  return stream.str();
}

TEST(FileFormats, AFileNameHasOneFormat) {
  openvdb::initialize();
  for (const FileFormat* format : fileFormats()) {
    const std::string extension(format->extension);
    EXPECT_EQ(extension, lowerExtension("a" + extension));
    for (const std::string& name : {extension, "a" + extension, "b/c.ply" + extension, "A" + lowerCase(extension)})
      EXPECT_EQ(findFormat(name), format) << name;
    EXPECT_EQ(findFormat(extension + "x"), nullptr);
    EXPECT_EQ(findFormat(extension.substr(1)), nullptr);
  }
  EXPECT_EQ(findFormat(""), nullptr);
  EXPECT_EQ(findFormat("A.PLY"), findFormat("a.ply"));
}

TEST(FileFormats, WhatIsWrittenIsRecognisedAndRead) {
  openvdb::initialize();
  const TemporaryFolder folder;
  for (const FileFormat* format : fileFormats()) {
    SCOPED_TRACE(format->name);
    if (!(format->writesGrids || format->writesMesh || format->printed) || !isHere(*format)) continue;
    const std::string bytes = bytesOf(*format);
    EXPECT_EQ(bytesOf(*format), bytes);
    const std::filesystem::path path = folder.path() / ("a" + std::string(format->extension));
    std::ofstream(path, std::ios::binary) << bytes;
    for (const MeshFormat& other : meshRows())
      if (other.begins) {
        EXPECT_EQ(other.begins(bytes, bytes.size()), other.facts.extension == format->extension) << other.facts.name;
      }
    if (format->readsGrids) {
      EXPECT_EQ(readVdb(path).grids.size(), 1u);
    }
    if (format->readsMesh && (format->writesMesh || canRead3mf())) {
      EXPECT_EQ(readMesh(path).triangles.size(), test_meshes::makeSphere(1, 2).triangles.size());
    }
  }
}

TEST(FileFormats, RecipesComeBackFromTheFormatsThatHoldThem) {
  openvdb::initialize();
  const TemporaryFolder folder;
  const auto common = [](const FileTexts& texts) {
    FileTexts found;
    for (const auto& [key, value] : kTexts)
      if (texts.contains(key) && texts.at(key) == value) found[key] = value;
    return found;
  };
  for (const FileFormat* format : fileFormats()) {
    SCOPED_TRACE(format->name);
    if (!(format->writesGrids || format->writesMesh) || !isHere(*format)) continue;
    const std::string bytes = bytesOf(*format), name = "a" + std::string(format->extension);
    std::ofstream(folder.path() / name, std::ios::binary) << bytes;
    const FileTexts expected = format->recipe ? kTexts : FileTexts();
    EXPECT_EQ(common(readFileTexts(folder.path() / name)), expected);
    EXPECT_EQ(common(fileTexts(name, bytes)), expected);
    EXPECT_THROW(readFileTexts(folder.path() / ("none" + name)), MissingInputError);
  }
}

TEST(FileFormats, NothingElseIsWritten) {
  std::ostringstream stream;
  for (const FileFormat* format : fileFormats()) {
    SCOPED_TRACE(format->name);
    const std::string name = "a" + std::string(format->extension);
    if (!format->writesMesh) {
      EXPECT_THROW(meshFormat(name), std::invalid_argument);
    }
    if (!format->writesGrids) {
      EXPECT_THROW(gridFormat(name), std::invalid_argument);
      EXPECT_THROW(writeGrids(stream, *format, {}, {}), std::invalid_argument);
    }
    if (isHere(*format))
      EXPECT_NO_THROW(requireBuilt(*format));
    else
      EXPECT_THROW(requireBuilt(*format), std::invalid_argument);
  }
  EXPECT_TRUE(stream.str().empty());
}

TEST(FileFormats, ListsInWords) {
  EXPECT_EQ(formatTexts({}, &FileFormat::recipe, &FileFormat::name), "");
  std::size_t written = 0;
  for (const std::string& name : writtenFormats()) {
    const FileFormat* const format = findFormat('.' + name);
    ASSERT_TRUE(format) << name;
    EXPECT_TRUE(format->writesGrids || format->writesMesh) << name;
    EXPECT_NE((extensionsOf(&FileFormat::writesGrids) + ' ' + extensionsOf(&FileFormat::writesMesh)).find('.' + name),
              std::string::npos);
    ++written;
  }
  EXPECT_GE(written, 5u);
}

}  // namespace
