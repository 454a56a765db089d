// SPDX-License-Identifier: Apache-2.0
#include "formats/vdb_head.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/base/grids.h"
#include "vdbtools/formats/vdb_file.h"

#include <gtest/gtest.h>

#include <map>
#include <random>
#include <string>

namespace {

std::string someVdb(const std::map<std::string, std::string>& metadata) {
  openvdb::initialize();
  const openvdb::FloatGrid::Ptr grid = openvdb::FloatGrid::create(1.0f);
  grid->setName("surface");
  grid->tree().setValue({1, 2, 3}, 0.5f);
  return vdbtools::encodeVdb({grid}, {.metadata = metadata});
}

TEST(VdbHead, ItReadsWhatOpenVdbWrites) {
  const std::map<std::string, std::string> metadata = {
      {"julia_command", "fractal"}, {"empty", ""}, {"long", std::string(70000, 'x')}};
  const std::string bytes = someVdb(metadata);
  const auto read = vdbtools::vdbHeadMetadata(bytes);
  for (const auto& [key, value] : metadata) EXPECT_EQ(read.at(key), value);
  // Of the grids it needs nothing.
  EXPECT_EQ(vdbtools::vdbHeadMetadata(bytes.substr(0, 71000)), read);
}

TEST(VdbHead, NoBytesAreTrusted) {
  const std::string bytes = someVdb({{"julia_command", "fractal"}, {"julia_detail", "0.3"}});
  const std::size_t head = bytes.find("surface");
  for (std::size_t length = 0; length < head; ++length) {
    try {
      vdbtools::vdbHeadMetadata(bytes.substr(0, length));
    } catch (const vdbtools::DataError&) {
    }
  }
  std::mt19937 random(5);
  for (int i = 0; i < 20000; ++i) {
    std::string changed = bytes.substr(0, head);
    for (int k = 0; k < 3; ++k) changed[8 + random() % (head - 8)] = static_cast<char>(random() % 4 ? 0xff : random());
    try {
      // What comes out can only be what is in the bytes.
      std::size_t size = 0;
      for (const auto& [key, value] : vdbtools::vdbHeadMetadata(changed)) size += key.size() + value.size();
      EXPECT_LE(size, changed.size());
    } catch (const vdbtools::DataError&) {
    }
  }
  EXPECT_THROW(vdbtools::vdbHeadMetadata("ply\n"), vdbtools::DataError);
}

}  // namespace
