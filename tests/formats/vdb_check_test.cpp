// SPDX-License-Identifier: Apache-2.0
#include "support/test_fields.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/formats/vdb_file.h"

#include <gtest/gtest.h>

#include <openvdb/io/Archive.h>
#include <openvdb/io/Stream.h>
#include <openvdb/points/PointDataGrid.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <random>
#include <sstream>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace {

using openvdb::Coord;
using openvdb::GridBase;
using vdbtools::DataError;
using vdbtools::decodeVdb;
using vdbtools::VdbFile;

/// Writes as OpenVDB can, and encodeVdb() does not.
class TestArchive final : public openvdb::io::Archive {
 public:
  std::string bytes(const openvdb::GridCPtrVec& grids, std::uint32_t flags, bool offsets) {
    setCompression(flags);
    std::ostringstream stream(std::ios::binary);
    openvdb::MetaMap metadata;
    metadata.insertMeta("text", openvdb::StringMetadata("some words"));
    metadata.insertMeta("number", openvdb::DoubleMetadata(0.5));
    metadata.insertMeta("matrix", openvdb::Mat4DMetadata(openvdb::Mat4d::identity()));
    write(stream, grids, offsets, metadata);
    return std::move(stream).str();
  }
};

struct Storage {
  std::uint32_t flags;
  bool half, offsets;
};

std::vector<Storage> storages() {
  using namespace openvdb::io;
  std::vector<Storage> all;
  for (const std::uint32_t packing : {COMPRESS_NONE, COMPRESS_ZIP, COMPRESS_BLOSC})
    for (const std::uint32_t mask : {0U, std::uint32_t{COMPRESS_ACTIVE_MASK}})
      for (const bool half : {false, true})
        for (const bool offsets : {false, true}) all.push_back({packing | mask, half, offsets});
  return all;
}

std::string encodedVdb(const std::vector<GridBase::Ptr>& grids, const Storage& storage) {
  openvdb::GridCPtrVec out;
  for (const GridBase::Ptr& grid : grids) {
    grid->setSaveFloatAsHalf(storage.half);
    out.push_back(grid);
  }
  return TestArchive().bytes(out, storage.flags, storage.offsets);
}

GridBase::Ptr named(const GridBase::Ptr& grid, const std::string& name) {
  grid->setName(name);
  return grid;
}

/// A few values and tiles on each level, with inactive values of many kinds.
template <class Grid>
GridBase::Ptr scattered(const char* name) {
  using Value = typename Grid::ValueType;
  const auto value = [](int i) {
    if constexpr (std::is_same_v<Value, bool>)
      return i % 2 != 0;
    else if constexpr (openvdb::VecTraits<Value>::IsVec)
      return Value(static_cast<typename Value::value_type>(i));
    else
      return static_cast<Value>(i);
  };
  const auto grid = Grid::create(value(3));
  std::mt19937 random(7);
  for (int leaf = 0; leaf < 4; ++leaf)
    for (int i = 0; i < 300; ++i) {
      const Coord at(8 * leaf + static_cast<int>(random() % 8), static_cast<int>(random() % 8),
                     static_cast<int>(random() % 8) - 8);
      if (random() % 4 != 0)
        grid->tree().setValueOn(at, value(static_cast<int>(random() % 100)));
      else
        grid->tree().setValueOff(at, value(static_cast<int>(random() % static_cast<unsigned>(leaf + 1)) - 3));
    }
  grid->tree().addTile(1, Coord(64, 0, 0), value(5), true);
  grid->tree().addTile(2, Coord(512, 0, 0), value(6), false);
  grid->tree().addTile(3, Coord(-8192, 4096, 0), value(7), true);
  grid->setTransform(openvdb::math::Transform::createLinearTransform(0.25));
  return named(grid, name);
}

GridBase::Ptr coarseBall() {
  return named(test_fields::bandGrid([](const openvdb::Vec3d& x) { return x.length() - 0.4; }, 0.2, 0.6, 0.6),
               "surface");
}

GridBase::Ptr fog() {
  const auto grid = openvdb::FloatGrid::create(0);
  grid->fill(openvdb::CoordBBox(Coord(0), Coord(20)), 1, true);
  grid->fill(openvdb::CoordBBox(Coord(2), Coord(3)), 0.5F, true);
  grid->setGridClass(openvdb::GRID_FOG_VOLUME);
  return named(grid, "density");
}

/// A grid whose file is small: nodes below the root have masks of 8 KB.
GridBase::Ptr rootTiles() {
  const auto grid = openvdb::FloatGrid::create(1);
  grid->tree().addTile(3, Coord(0), 2, true);
  grid->tree().addTile(3, Coord(4096, 0, -4096), -1, false);
  return named(grid, "tiles");
}

GridBase::Ptr turned() {
  const GridBase::Ptr grid = rootTiles();
  const auto transform = openvdb::math::Transform::createLinearTransform(2);
  transform->preRotate(0.3, openvdb::math::Y_AXIS);
  transform->postTranslate(openvdb::Vec3d(1, 2, 3));
  grid->setTransform(transform);
  grid->setName("turned");
  return grid;
}

GridBase::Ptr stretched() {
  const GridBase::Ptr grid = rootTiles();
  const auto transform = openvdb::math::Transform::createLinearTransform();
  transform->postScale(openvdb::Vec3d(1, -2, 3));
  grid->setTransform(transform);
  grid->setName("stretched");
  return grid;
}

GridBase::Ptr frustum() {
  const GridBase::Ptr grid = rootTiles();
  grid->setTransform(openvdb::math::Transform::createFrustumTransform(
      openvdb::BBoxd(openvdb::Vec3d(0), openvdb::Vec3d(100)), 0.5, 10, 0.1));
  grid->setName("frustum");
  return grid;
}

GridBase::Ptr points() {
  const std::vector<openvdb::Vec3d> positions = {{0, 0, 0}, {1, 2, 3}, {1, 2, 3.1}};
  return vdbtools::pointGrid({positions, {}, {}}, {}, 0.5);
}

/// Two grids of one tree.
std::vector<GridBase::Ptr> instances() {
  const auto parent = openvdb::gridPtrCast<openvdb::FloatGrid>(scattered<openvdb::FloatGrid>("parent"));
  const auto child = openvdb::FloatGrid::create(parent->treePtr());
  child->setName("child");
  child->setTransform(openvdb::math::Transform::createLinearTransform(3));
  return {parent, child};
}

/// Sets of grids that files are made of.
std::vector<std::vector<GridBase::Ptr>> samples() {
  openvdb::initialize();
  using namespace openvdb;
  const GridBase::Ptr unnamed = rootTiles();
  unnamed->setName("");
  return {{coarseBall()},
          {coarseBall(), fog(), scattered<Vec3SGrid>("colour")},
          {named(FloatGrid::create(1), "empty")},
          {rootTiles(), rootTiles(), unnamed},
          {turned(), stretched(), frustum()},
          instances(),
          {points(), rootTiles()},
          {scattered<BoolGrid>("bool"), scattered<MaskGrid>("mask")},
          {scattered<FloatGrid>("float"), scattered<Int32Grid>("int32")},
          {scattered<DoubleGrid>("double"), named(GridBase::createGrid(Vec3DGrid::gridType()), "vec3d")}};
}

bool holdsPoints(const std::vector<GridBase::Ptr>& grids) {
  return grids.front()->isType<openvdb::points::PointDataGrid>();
}

std::vector<GridBase::Ptr> readByOpenVdb(const std::string& bytes) {
  std::istringstream stream(bytes, std::ios::binary);
  return *openvdb::io::Stream(stream, /*delayLoad=*/false).getGrids();
}

/// The bytes of a file with the grids, without what is different in each file.
std::string content(const std::vector<GridBase::Ptr>& grids) {
  constexpr std::size_t kIdentifier = 21, kLength = 36;
  return TestArchive().bytes({grids.begin(), grids.end()}, 0, true).replace(kIdentifier, kLength, "");
}

/// Goes everywhere in a grid.
double touched(const GridBase& grid) {
  double sum = static_cast<double>(grid.activeVoxelCount()) + static_cast<double>(grid.memUsage());
  sum += grid.evalActiveVoxelBoundingBox().min()[0] + grid.transform().indexToWorld(Coord(1, 2, 3))[0];
  if (!grid.isType<openvdb::FloatGrid>()) return sum;
  const openvdb::FloatTree& tree = static_cast<const openvdb::FloatGrid&>(grid).tree();
  for (auto value = tree.cbeginValueOn(); value; ++value) sum += *value;
  for (auto leaf = tree.cbeginLeaf(); leaf; ++leaf) sum += leaf->getValue(0) + leaf->getValue(511);
  return sum + tree.getValue(Coord(7, -1, 3));
}

TEST(VdbCheck, WhatOpenVdbWritesIsReadAsOpenVdbReadsIt) {
  int files = 0;
  for (const std::vector<GridBase::Ptr>& grids : samples())
    for (const Storage& storage : storages()) {
      if (holdsPoints(grids) && !storage.offsets) continue;
      const std::string bytes = encodedVdb(grids, storage);
      SCOPED_TRACE(grids.front()->getName() + ", compression " + std::to_string(storage.flags) +
                   (storage.half ? ", half" : "") + (storage.offsets ? "" : ", a stream"));
      std::vector<GridBase::Ptr> ours = decodeVdb(bytes).grids, theirs = readByOpenVdb(bytes);
      ASSERT_EQ(ours.size(), theirs.size());
      if (holdsPoints(grids)) {
        EXPECT_EQ(ours[0]->activeVoxelCount(), 2u);
        EXPECT_EQ(ours[0]->evalActiveVoxelBoundingBox(), theirs[0]->evalActiveVoxelBoundingBox());
        ours.erase(ours.begin());
        theirs.erase(theirs.begin());
      }
      ASSERT_EQ(content(ours), content(theirs));
      ++files;
    }
  EXPECT_GT(files, 200);
}

/// The type in the descriptor of the first grid.
std::string retyped(std::string bytes, const std::string& from, const std::string& to) {
  const std::size_t at = bytes.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  const auto length = static_cast<std::uint32_t>(to.size());
  bytes.replace(at, from.size(), to);
  return bytes.replace(at - sizeof length, sizeof length, reinterpret_cast<const char*>(&length), sizeof length);
}

TEST(VdbCheck, TypesOfTheSameSizeAreReadAlike) {
  using namespace openvdb;
  const auto expectRead = [](const GridBase::Ptr& grid, const std::string& type) {
    for (const Storage& storage : storages()) {
      if (storage.half) continue;
      const std::string bytes = retyped(encodedVdb({grid}, storage), grid->type(), type);
      const std::vector<GridBase::Ptr> ours = decodeVdb(bytes).grids;
      EXPECT_EQ(ours.at(0)->type(), type);
      EXPECT_EQ(content(ours), content(readByOpenVdb(bytes)));
    }
  };
  expectRead(scattered<DoubleGrid>("int64"), "Tree_int64_5_4_3");
  expectRead(scattered<Vec3SGrid>("vec3i"), "Tree_vec3i_5_4_3");
}

TEST(VdbCheck, InstancesShareTheirTree) {
  const VdbFile file = decodeVdb(encodedVdb(instances(), {openvdb::io::COMPRESS_ZIP, false, true}));
  ASSERT_EQ(file.grids.size(), 2u);
  EXPECT_EQ(file.grids[0]->baseTreePtr(), file.grids[1]->baseTreePtr());
  EXPECT_EQ(file.grids[1]->voxelSize()[0], 3);
}

TEST(VdbCheck, GridsOfUnknownTypesArePassedOver) {
  const std::vector<GridBase::Ptr> grids = {coarseBall(), fog()};
  for (const bool offsets : {true, false}) {
    const std::string bytes = retyped(encodedVdb(grids, {0, false, offsets}), "Tree_float_5_4_3", "Tree_flaot_5_4_3");
    if (offsets) {
      const VdbFile file = decodeVdb(bytes);
      ASSERT_EQ(file.grids.size(), 1u);
      EXPECT_EQ(file.grids[0]->getName(), "density");
      ASSERT_EQ(file.unread.size(), 1u);
      EXPECT_EQ(file.unread[0].name, "surface");
      EXPECT_EQ(file.unread[0].type, "Tree_flaot_5_4_3");
    } else {
      EXPECT_THROW(decodeVdb(bytes), DataError);
    }
  }
  const std::string alone =
      retyped(encodedVdb({coarseBall()}, {0, false, true}), "Tree_float_5_4_3", "Tree_flaot_5_4_3");
  EXPECT_THROW(decodeVdb(alone), DataError);
}

// Promise: "A file that is broken, or made ..."
TEST(VdbCheck, EveryCutIsRefused) {
  const auto expectRefused = [](const std::vector<GridBase::Ptr>& grids, std::size_t step) {
    const std::string bytes = encodedVdb(grids, {openvdb::io::COMPRESS_BLOSC, false, true});
    for (std::size_t length = 0; length < bytes.size(); length += step)
      ASSERT_THROW(decodeVdb(bytes.substr(0, length)), DataError) << length << " of " << bytes.size() << " bytes";
  };
  expectRefused({rootTiles(), frustum()}, 1);
  expectRefused({coarseBall()}, 37);
}

/// A part of a file that OpenVDB reads at once: a number, a name, a mask, compressed values.
struct Field {
  std::size_t at, size;
};

/// Notes what is read.
class NotingBuffer final : public std::stringbuf {
 public:
  explicit NotingBuffer(const std::string& bytes) : std::stringbuf(bytes, std::ios::in | std::ios::binary) {}
  std::vector<Field> fields;

 private:
  std::streamsize xsgetn(char* to, std::streamsize size) override {
    fields.push_back({static_cast<std::size_t>(gptr() - eback()), static_cast<std::size_t>(size)});
    return std::stringbuf::xsgetn(to, size);
  }
};

std::vector<Field> fieldsOf(const std::string& bytes) {
  NotingBuffer buffer(bytes);
  std::istream stream(&buffer);
  openvdb::io::Stream(stream, /*delayLoad=*/false);
  std::erase_if(buffer.fields, [](const Field& field) { return field.size == 0; });
  return buffer.fields;
}

/// A number that breaks readers.
std::uint64_t bad(std::uint64_t was, std::mt19937& random) {
  const std::uint64_t numbers[] = {0,
                                   1,
                                   was + 1,
                                   was - 1,
                                   was * 2,
                                   ~was + 1,
                                   was ^ std::uint64_t{1} << random() % 64,
                                   static_cast<std::uint64_t>(-1),
                                   0x7fffffff,
                                   0x80000000,
                                   0xffff,
                                   std::uint64_t{1} << 62,
                                   std::uint64_t{1} << 63,
                                   random(),
                                   4096 * (random() % 64),
                                   0x7ff0000000000000};
  return numbers[random() % std::size(numbers)];
}

void breakField(std::string& bytes, const Field& field, std::mt19937& random) {
  constexpr std::size_t kLargest = 8, kHeader = 24;
  if (field.size <= kLargest) {
    std::uint64_t number = 0;
    std::memcpy(&number, bytes.data() + field.at, field.size);
    number = bad(number, random);
    std::memcpy(bytes.data() + field.at, &number, field.size);
    return;
  }
  // Of what is compressed, mostly the header.
  const std::size_t reach = random() % 2 ? field.size : std::min(field.size, kHeader);
  const std::size_t at = field.at + random() % reach;
  if (random() % 2)
    bytes[at] = static_cast<char>(bytes[at] ^ 1 << random() % 8);
  else
    breakField(bytes, {std::min(at & ~std::size_t{3}, bytes.size() - 4), 4}, random);
}

std::string mutant(const std::string& bytes, const std::vector<Field>& fields, std::mt19937& random) {
  std::string changed = bytes;
  const std::size_t count = 1 + random() % 8 / 6;
  for (std::size_t i = 0; i < count; ++i) {
    const Field& field = fields[random() % fields.size()];
    switch (random() % 16) {
      case 0:  // a part is missing
        changed.erase(field.at, 1 + random() % field.size);
        return changed;
      case 1:  // a part stands there twice
        changed.insert(field.at, bytes.substr(field.at, 1 + random() % 64));
        return changed;
      case 2:  // a part of elsewhere
        for (std::size_t k = 0, from = fields[random() % fields.size()].at; k < field.size && from + k < bytes.size();
             ++k)
          changed[field.at + k] = bytes[from + k];
        break;
      default: breakField(changed, field, random);
    }
  }
  return changed;
}

/// Mutants of each sample in each kind of file. JULIAVDB_MUTANTS asks for more in a long run.
int mutantsWanted() {
  constexpr int kFew = 25;
  const char* wanted = std::getenv("JULIAVDB_MUTANTS");
  return wanted ? std::atoi(wanted) : kFew;
}

/// Each mutant is refused with a DataError, or is a VDB that can be used like any other: nothing else is thrown, and
/// nothing is read or written that is not there, which a build with sanitizers sees.
// Promise: "A file that is broken, or made ..."
TEST(VdbCheck, NoMutantDoesHarm) {
  std::mt19937 random(17);
  const int mutants = mutantsWanted();
  int refused = 0, read = 0;
  double sum = 0;
  for (const std::vector<GridBase::Ptr>& grids : samples())
    for (const Storage& storage : storages()) {
      if (holdsPoints(grids) && !storage.offsets) continue;
      const std::string bytes = encodedVdb(grids, storage);
      const std::vector<Field> fields = fieldsOf(bytes);
      ASSERT_GT(fields.size(), 20u);
      for (int i = 0; i < mutants; ++i) {
        const std::string changed = mutant(bytes, fields, random);
        try {
          for (const GridBase::Ptr& grid : decodeVdb(changed).grids) sum += touched(*grid);
          ++read;
        } catch (const DataError& error) {
          ASSERT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
          ++refused;
        }
      }
    }
  RecordProperty("refused", refused);
  RecordProperty("read", read);
  // Both are common, or the mutants are not worth much.
  EXPECT_GT(refused, read / 10);
  EXPECT_GT(read, refused / 10);
  EXPECT_NE(sum, 0.125);  // so that it has to be computed
}

}  // namespace
