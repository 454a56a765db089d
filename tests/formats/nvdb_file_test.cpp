// SPDX-License-Identifier: Apache-2.0
// What other programs find in these files is tested by tests/cli/test_nvdb.py.
#include "support/test_fields.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/formats/nvdb_file.h"

#include <tbb/global_control.h>
#include <zlib.h>

#include <gtest/gtest.h>

#include <cstring>
#include <random>
#include <sstream>

namespace {

using namespace vdbtools;
using openvdb::Coord;

// Of the format: the head of a file, that of a grid without its name, and where a grid has its checksums.
constexpr std::size_t kNvdbFileHead = 16, kNvdbGridHead = 176, kNvdbChecksums = 8;

openvdb::FloatGrid::Ptr nvdbBand() {
  const auto grid = test_fields::bandGrid(test_fields::lumpy, 0.1, 0.3, 0.3);
  grid->setName("surface");
  return grid;
}

std::string encodedNvdb(const std::vector<openvdb::GridBase::Ptr>& grids, NvdbValues values = NvdbValues::Full) {
  std::ostringstream stream;
  writeNvdb(stream, grids, {.values = values});
  return std::move(stream).str();
}

class NvdbFileTest : public testing::Test {
 protected:
  NvdbFileTest() { openvdb::initialize(); }
  void SetUp() override {
    if (!canWriteNvdb()) GTEST_SKIP() << "NanoVDB is not built in";
  }
};

// Promise: The grids of a NanoVDB file ...
TEST_F(NvdbFileTest, SaysWhatTheGridsAre) {
  const auto surface = nvdbBand();
  const auto vectors = openvdb::Vec3SGrid::create();
  vectors->setName("versor");
  vectors->tree().setValue(Coord(-1, 200, 3), openvdb::Vec3s(1, 2, 3));
  const NvdbFile file = decodeNvdb(encodedNvdb({surface, vectors}));
  ASSERT_EQ(file.grids.size(), 2u);
  const NvdbGrid& level = file.grids[0];
  EXPECT_EQ(level.name, "surface");
  EXPECT_EQ(level.type, "float");
  EXPECT_EQ(level.gridClass, "level set");
  EXPECT_EQ(level.activeVoxels, surface->activeVoxelCount());
  EXPECT_EQ(level.nodes[0], surface->tree().leafCount());
  EXPECT_EQ(level.voxelSize, surface->voxelSize());
  EXPECT_EQ(level.checksum, NvdbGrid::Checksum::Full);
  // Its box takes a voxel to have an extent from its node on.
  const openvdb::CoordBBox box = surface->evalActiveVoxelBoundingBox();
  EXPECT_TRUE(level.box.min().eq(surface->indexToWorld(box.min()), 1e-9));
  EXPECT_TRUE(level.box.max().eq(surface->indexToWorld(box.max().offsetBy(1)), 1e-9));
  EXPECT_EQ(file.grids[1].type, "vec3s");
  EXPECT_EQ(file.grids[1].activeVoxels, 1u);
}

// Promise: The grids of a NanoVDB file ...
TEST_F(NvdbFileTest, TheTreesStayAsTheyAre) {
  const auto surface = nvdbBand();
  const openvdb::FloatGrid::Ptr before = surface->deepCopy();
  encodedNvdb({surface}, NvdbValues::Fp8);
  ASSERT_TRUE(surface->tree().hasSameTopology(before->tree()));
  for (auto leaf = before->tree().cbeginLeaf(); leaf; ++leaf)
    ASSERT_EQ(surface->tree().probeConstLeaf(leaf->origin())->origin(), leaf->origin());
  EXPECT_EQ(surface->getGridClass(), before->getGridClass());
}

TEST_F(NvdbFileTest, SameGridsSameBytesForAnyNumberOfThreads) {
  for (const NvdbValues values : {NvdbValues::Full, NvdbValues::Fp16, NvdbValues::Fp8, NvdbValues::Variable}) {
    const std::string once = encodedNvdb({nvdbBand()}, values);
    // Memory that was in use before must leave no trace.
    { const std::vector<char> used(once.size(), 'x'); }
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    EXPECT_EQ(encodedNvdb({nvdbBand()}, values), once);
  }
}

// Promise: Of a NanoVDB file of fewer ...
TEST_F(NvdbFileTest, FewerBitsTakeLessAndLoseMore) {
  std::vector<std::size_t> sizes;
  std::vector<double> errors;
  for (const NvdbValues values : {NvdbValues::Full, NvdbValues::Fp16, NvdbValues::Fp8}) {
    std::ostringstream stream;
    const std::vector<NvdbWritten> written = writeNvdb(stream, {nvdbBand()}, {.values = values});
    sizes.push_back(stream.str().size());
    errors.push_back(written.at(0).greatestError);
  }
  EXPECT_GT(sizes[0], sizes[1]);
  EXPECT_GT(sizes[1], sizes[2]);
  EXPECT_EQ(errors[0], 0);
  // Half a step of a band of 6 voxels, of 0.1 each.
  EXPECT_GT(errors[1], 0);
  EXPECT_LE(errors[1], 0.6 / 65535 / 2 * 1.01);
  EXPECT_GT(errors[2], errors[1]);
  EXPECT_LE(errors[2], 0.6 / 255 / 2 * 1.01);
}

// Promise: Of a NanoVDB file of fewer ...
TEST_F(NvdbFileTest, VariableBitsKeepTheirBound) {
  std::ostringstream stream;
  const NvdbWritten written = writeNvdb(stream, {nvdbBand()}, {.values = NvdbValues::Variable}).at(0);
  EXPECT_LE(written.greatestError, 0.1 * 0.1);
  const NvdbFile file = decodeNvdb(stream.str());
  EXPECT_EQ(file.grids.at(0).type, "FpN");
}

TEST_F(NvdbFileTest, GridsWithoutLeavesOrVoxels) {
  const auto tile = openvdb::FloatGrid::create(0), empty = openvdb::FloatGrid::create(1),
             off = openvdb::FloatGrid::create(2);
  tile->setName("tile");
  tile->tree().addTile(2, Coord(0), 0.5f, true);
  empty->setName("empty");
  off->setName("off");
  off->tree().addTile(3, Coord(4096, 0, 0), 0.5f, false);
  for (const NvdbValues values : {NvdbValues::Full, NvdbValues::Variable}) {
    testing::internal::CaptureStderr();
    const NvdbFile file = decodeNvdb(encodedNvdb({tile, empty, off}, values));
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
    EXPECT_EQ(file.grids.at(0).activeVoxels, 128u * 128 * 128);
    EXPECT_EQ(file.grids.at(1).activeVoxels, 0u);
    EXPECT_EQ(file.grids.at(2).activeVoxels, 0u);
  }
}

TEST_F(NvdbFileTest, RefusesWhatNanoVdbDoesNotHave) {
  const auto texts = openvdb::Vec3IGrid::create();
  texts->setName("integers");
  texts->tree().setValue(Coord(0), openvdb::Vec3i(1, 2, 3));
  EXPECT_THROW(encodedNvdb({texts}), DataError);
  const auto wide = nvdbBand();
  wide->setTransform(openvdb::math::Transform::createFrustumTransform(
      openvdb::BBoxd(openvdb::Vec3d(0), openvdb::Vec3d(10)), 0.5, 2, 0.1));
  EXPECT_THROW(encodedNvdb({wide}), DataError);
  EXPECT_THROW(encodedNvdb({nvdbBand(), nvdbBand()}), std::invalid_argument);
}

// Promise: `info` of a NanoVDB file ...
TEST_F(NvdbFileTest, EveryDamageOfAGridIsNoticed) {
  for (const NvdbValues values : {NvdbValues::Full, NvdbValues::Fp8}) {
    const std::string whole = encodedNvdb({nvdbBand()}, values);
    const std::size_t grid = kNvdbFileHead + kNvdbGridHead + sizeof "surface";
    std::minstd_rand random(7);
    const auto refused = [&](std::size_t at) {
      std::string bytes = whole;
      bytes[at] = static_cast<char>(bytes[at] ^ (1 << random() % 8));
      try {
        decodeNvdb(bytes);
        return false;
      } catch (const DataError&) {
        return true;
      }
    };
    for (std::size_t at = grid; at < grid + 2000; at += 7) ASSERT_TRUE(refused(at)) << "byte " << at - grid;
    for (int i = 0; i < 300; ++i) {
      const std::size_t at = grid + random() % (whole.size() - grid);
      ASSERT_TRUE(refused(at)) << "byte " << at - grid;
    }
  }
}

/// The same grid, as NanoVDB 32.4.2, 32.6.0 and 32.9.0 wrote it: only marks, versions, checksums and the place of blind
/// data, of which there is none, are different.
TEST_F(NvdbFileTest, TheChecksumsOfAllVersionsFit) {
  struct Writer {
    const char* name;
    std::uint32_t version;
    const char *file, *grid;  ///< how these begin
    std::uint32_t checksums[2];
    std::int64_t blindData;
  };
  constexpr Writer kWriters[] = {{"32.4.2", 0x04001002, "NanoVDB0", "NanoVDB0", {0x64944497, 0x74edb619}, 0},
                                 {"32.6.0", 0x04001800, "NanoVDB0", "NanoVDB0", {0x1cd2ae96, 0x54e4eefe}, 307232},
                                 {"32.9.0", 0x04002400, "NanoVDB2", "NanoVDB1", {0x1095ea9b, 0x156e1388}, 307232}};
  const auto one = openvdb::FloatGrid::create(1);
  one->setName("one");
  one->tree().setValue(Coord(1, 2, 3), 0.5f);
  const std::string ours = encodedNvdb({one});
  const std::size_t grid = kNvdbFileHead + kNvdbGridHead + sizeof "one";
  for (const Writer& writer : kWriters) {
    SCOPED_TRACE(writer.name);
    std::string bytes = ours;
    const auto put = [&](std::size_t at, const auto* values, std::size_t size) {
      std::memcpy(bytes.data() + at, values, size);
    };
    put(0, writer.file, 8);
    put(8, &writer.version, 4);
    put(kNvdbFileHead + kNvdbGridHead - 4, &writer.version, 4);
    put(grid, writer.grid, 8);
    put(grid + kNvdbChecksums, writer.checksums, 8);
    put(grid + 16, &writer.version, 4);
    put(grid + 640, &writer.blindData, 8);
    const NvdbFile file = decodeNvdb(bytes);
    EXPECT_EQ(file.version, writer.name);
    EXPECT_EQ(file.grids.at(0).checksum, NvdbGrid::Checksum::Full);
    bytes.back() = static_cast<char>(bytes.back() ^ 1);
    EXPECT_THROW(decodeNvdb(bytes), DataError);
  }
}

// Promise: `info` of a NanoVDB file ...
TEST_F(NvdbFileTest, WrongSizesAndTruncatedFilesAreRefused) {
  const std::string whole = encodedNvdb({nvdbBand()});
  std::minstd_rand random(5);
  for (int i = 0; i < 100; ++i) {
    const std::size_t length = i < 50 ? static_cast<std::size_t>(i) * 5 : random() % whole.size();
    EXPECT_THROW(decodeNvdb(std::string_view(whole).substr(0, length)), DataError) << length;
  }
  EXPECT_THROW(decodeNvdb(whole + "more"), DataError);
}

/// Without checksums the places of nodes alone stand between a damage and memory that is not ours.
// Promise: `info` of a NanoVDB file ...
TEST_F(NvdbFileTest, PlacesOfNodesAreChecked) {
  std::string whole = encodedNvdb({nvdbBand()});
  const std::size_t grid = kNvdbFileHead + kNvdbGridHead + sizeof "surface";
  std::memset(whole.data() + grid + kNvdbChecksums, 0xff, 8);
  ASSERT_EQ(decodeNvdb(whole).grids.at(0).checksum, NvdbGrid::Checksum::None);
  std::minstd_rand random(11);
  int refused = 0;
  for (std::size_t at = grid + 640; at < grid + 900; at += 4)
    for (const std::int64_t wrong :
         {std::int64_t{-1}, std::int64_t{1} << 62, std::int64_t{1} << 40, std::int64_t{4096}}) {
      std::string bytes = whole;
      std::memcpy(bytes.data() + at, &wrong, sizeof wrong);
      try {
        decodeNvdb(bytes);
      } catch (const DataError&) {
        ++refused;
      }
    }
  EXPECT_GT(refused, 50);
}

TEST_F(NvdbFileTest, AFileOfZipIsReadToo) {
  const std::string whole = encodedNvdb({nvdbBand()});
  const std::size_t grid = kNvdbFileHead + kNvdbGridHead + sizeof "surface";
  const std::string_view content = std::string_view(whole).substr(grid);
  uLongf size = compressBound(content.size());
  std::string packed(size, '\0');
  ASSERT_EQ(compress(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(content.data()),
                     content.size()),
            Z_OK);
  packed.resize(size);
  std::string bytes = whole.substr(0, grid);
  const std::uint16_t zip = 1;
  const std::uint64_t packedSize = size, fileSize = size + 8;
  std::memcpy(bytes.data() + 14, &zip, 2);
  std::memcpy(bytes.data() + kNvdbFileHead + 8, &fileSize, 8);
  bytes.append(reinterpret_cast<const char*>(&packedSize), 8);
  bytes += packed;
  const NvdbFile file = decodeNvdb(bytes);
  EXPECT_EQ(file.compression, "zip");
  EXPECT_EQ(file.grids.at(0).checksum, NvdbGrid::Checksum::Full);
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 1);
  EXPECT_THROW(decodeNvdb(bytes), DataError);
}

}  // namespace
