// SPDX-License-Identifier: Apache-2.0
#include "formats/nvdb_layout.h"
#include "formats/vdb_cursor.h"

#include "vdbtools/base/memory.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/formats/nvdb_file.h"

#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>
#include <limits>

namespace vdbtools {
namespace {

template <class Record>
Record recordAt(std::string_view bytes, std::size_t offset) {
  static_assert(std::is_trivially_copyable_v<Record>);
  Record record;
  std::memcpy(&record, bytes.substr(offset, sizeof record).data(), sizeof record);
  return record;
}

template <class Record>
Record nextRecord(VdbCursor& cursor) {
  return recordAt<Record>(cursor.bytes(sizeof(Record)), 0);
}

std::string versionText(std::uint32_t version) {
  return std::to_string(nvdb::majorOf(version)) + '.' + std::to_string(nvdb::minorOf(version)) + '.' +
         std::to_string(nvdb::patchOf(version));
}

std::uint32_t crcOf(std::string_view bytes) {
  uLong crc = crc32(0, nullptr, 0);
  while (!bytes.empty()) {
    const std::string_view some = bytes.substr(0, std::numeric_limits<uInt>::max());
    crc = crc32(crc, reinterpret_cast<const Bytef*>(some.data()), static_cast<uInt>(some.size()));
    bytes.remove_prefix(some.size());
  }
  return static_cast<std::uint32_t>(crc);
}

bool isBitOn(std::string_view mask, std::size_t bit) {
  return ((static_cast<unsigned char>(mask[bit / 8]) >> (bit % 8)) & 1) != 0;
}

/// One grid in memory, as NanoVDB would use it.
class NvdbGridCheck {
 public:
  /// @param name  for messages
  NvdbGridCheck(std::string_view bytes, const std::string& name) : mBytes(bytes), mName(name) {}

  /// @throw DataError  a number in it does not fit the others or the size, or a checksum does not fit the content
  NvdbGrid::Checksum check(const nvdb::GridHead& head) {
    if (mBytes.size() < sizeof(nvdb::GridData) + sizeof(nvdb::TreeData)) refuse("is too short for a grid");
    const auto data = recordAt<nvdb::GridData>(mBytes, 0);
    const auto tree = recordAt<nvdb::TreeData>(mBytes, kTree);
    if (data.magic != nvdb::kMagic && data.magic != nvdb::kMagicGrid)
      refuse("does not begin with the number that marks NanoVDB");
    if (nvdb::majorOf(data.version) != nvdb::kMajorVersion)
      refuse("is of version " + versionText(data.version) + " of NanoVDB; only 32 can be read");
    if (data.size != mBytes.size())
      refuse("says that it has " + std::to_string(data.size) + " bytes, and has " + std::to_string(mBytes.size()));
    requireSame(head, data, tree);
    mType = std::find_if(std::begin(nvdb::kTypes), std::end(nvdb::kTypes),
                         [&](const nvdb::Type& type) { return type.number == data.gridType; });
    if (mType == std::end(nvdb::kTypes))
      refuse("holds values of a type that is not known, number " + std::to_string(data.gridType));
    if (data.gridClass >= std::size(nvdb::kClasses))
      refuse("is of a class that is not known, number " + std::to_string(data.gridClass));
    checkBlindData(data);
    walk(tree);
    return checksum(data);
  }

  const nvdb::Type& type() const { return *mType; }

 private:
  static constexpr std::size_t kTree = sizeof(nvdb::GridData);

  [[noreturn]] void refuse(const std::string& what) const { throw DataError("its grid '" + mName + "' " + what); }

  /// The head of the file repeats what the grid says, and no checksum covers the head.
  void requireSame(const nvdb::GridHead& head, const nvdb::GridData& data, const nvdb::TreeData& tree) const {
    const bool same = head.gridType == data.gridType && head.gridClass == data.gridClass &&
                      head.voxelCount == tree.voxelCount &&
                      std::equal(tree.nodeCount, tree.nodeCount + 3, head.nodeCount) &&
                      std::memcmp(head.worldBox, data.worldBox, sizeof data.worldBox) == 0 &&
                      std::memcmp(head.voxelSize, data.voxelSize, sizeof data.voxelSize) == 0;
    if (!same) refuse("is not as the head of the file describes it");
    for (const double size : data.voxelSize)
      if (!(size > 0 && std::isfinite(size))) refuse("has voxels of no size");
  }

  void checkBlindData(const nvdb::GridData& data) const {
    if (data.blindCount == 0) return;
    const auto offset = static_cast<std::uint64_t>(data.blindOffset);
    if (data.blindOffset < 0 || offset > mBytes.size() ||
        data.blindCount > (mBytes.size() - offset) / sizeof(nvdb::BlindData))
      refuse("has blind data outside of itself");
    for (std::uint32_t i = 0; i < data.blindCount; ++i) {
      const std::uint64_t at = offset + i * sizeof(nvdb::BlindData);
      const auto blind = recordAt<nvdb::BlindData>(mBytes, at);
      if (!isWithin(at, blind.offset, 0)) refuse("has blind data outside of itself");
    }
  }

  /// Whether @a size bytes at an offset from a place are in the grid.
  bool isWithin(std::uint64_t place, std::int64_t offset, std::uint64_t size) const {
    const auto from = static_cast<std::int64_t>(place), end = static_cast<std::int64_t>(mBytes.size());
    if (offset < -from || offset > end - from) return false;
    return static_cast<std::uint64_t>(end - from - offset) >= size;
  }

  /// The place of a node. @throw DataError  it is not in the grid, or not at a multiple of 32
  std::size_t nodeAt(std::uint64_t place, std::int64_t offset, std::uint64_t size) const {
    if (!isWithin(place, offset, size)) refuse("has a node outside of itself");
    const auto at = static_cast<std::size_t>(static_cast<std::int64_t>(place) + offset);
    if (at % nvdb::kAlignment != 0) refuse("has a node at no multiple of 32 bytes");
    return at;
  }

  /// Finds all nodes, level by level.
  void walk(const nvdb::TreeData& tree) {
    const std::size_t sizes[3] = {mType->leaf, mType->lower, mType->upper};
    for (int level = 0; level < 3; ++level)
      if (tree.nodeCount[level] > mBytes.size() / sizes[level]) refuse("counts more nodes than it has bytes for");
    if (tree.nodeOffset[3] > mBytes.size()) refuse("has its root outside of itself");
    mRoot = nodeAt(kTree, static_cast<std::int64_t>(tree.nodeOffset[3]), mType->root);
    const auto entries = recordAt<std::uint32_t>(mBytes, mRoot + nvdb::kRootCount);
    if (entries > (mBytes.size() - mRoot - mType->root) / mType->tile) refuse("has a table outside of itself");
    mRootSize = mType->root + std::size_t{entries} * mType->tile;
    for (std::uint32_t i = 0; i < entries; ++i) {
      const std::size_t tile = mRoot + mType->root + std::size_t{i} * mType->tile;
      if (const auto child = recordAt<std::int64_t>(mBytes, tile + nvdb::kTileChild); child != 0)
        add(mUpper, nodeAt(mRoot, child, mType->upper), tree.nodeCount[2]);
    }
    for (const std::size_t node : mUpper)
      addChildren(node, nvdb::kUpperMask, mType->upperTable, mType->lower, mLower, tree.nodeCount[1]);
    for (const std::size_t node : mLower)
      addChildren(node, nvdb::kLowerMask, mType->lowerTable, mType->leaf, mLeaves, tree.nodeCount[0]);
    if (mType->variableLeaf)
      for (const std::size_t leaf : mLeaves) {
        const unsigned log = static_cast<unsigned char>(mBytes[leaf + nvdb::kLeafFlags]) >> 5;
        if (log > nvdb::kLargestLogOfBits) refuse("has a leaf of a number of bits that is not known");
        nodeAt(leaf, 0, mType->leaf + (nvdb::kLeafBytesOfABit << log));
      }
    const std::size_t found[3] = {mLeaves.size(), mLower.size(), mUpper.size()};
    for (int level = 0; level < 3; ++level) {
      if (found[level] != tree.nodeCount[level]) refuse("has fewer nodes than it counts");
      // Readers go along the nodes from the first.
      if (found[level] != 0 && tree.nodeOffset[level] > mBytes.size()) refuse("has a node outside of itself");
      if (found[level] != 0 && !mType->variableLeaf)
        nodeAt(kTree, static_cast<std::int64_t>(tree.nodeOffset[level]), found[level] * sizes[level]);
    }
  }

  void add(std::vector<std::size_t>& nodes, std::size_t node, std::uint32_t most) const {
    if (nodes.size() == most) refuse("has more nodes than it counts");
    nodes.push_back(node);
  }

  void addChildren(std::size_t node, std::size_t maskSize, std::size_t table, std::size_t childSize,
                   std::vector<std::size_t>& children, std::uint32_t most) const {
    const std::string_view mask = mBytes.substr(node + nvdb::kMasks + maskSize, maskSize);
    for (std::size_t i = 0; i < 8 * maskSize; ++i) {
      if (i % 8 == 0 && mask[i / 8] == 0) {
        i += 7;
        continue;
      }
      if (isBitOn(mask, i))
        add(children, nodeAt(node, recordAt<std::int64_t>(mBytes, node + table + i * mType->entry), childSize), most);
    }
  }

  NvdbGrid::Checksum checksum(const nvdb::GridData& data) const {
    if (data.headChecksum == nvdb::kNoChecksum) return NvdbGrid::Checksum::None;
    std::size_t headSize = kTree + sizeof(nvdb::TreeData);
    if (!isAfter32_6(data)) headSize += mRootSize;
    if (headSize > mBytes.size()) refuse("has its root outside of itself");
    if (crcOf(mBytes.substr(nvdb::kChecksummedFrom, headSize - nvdb::kChecksummedFrom)) != data.headChecksum)
      refuse("is damaged: the checksum of its head is wrong");
    if (data.nodeChecksum == nvdb::kNoChecksum) return NvdbGrid::Checksum::Head;
    const bool isByNodes = nvdb::minorOf(data.version) < 6;
    if ((isByNodes ? crcOfNodes() : crcOfBlocks(mBytes.substr(headSize))) != data.nodeChecksum)
      refuse("is damaged: the checksum of its nodes is wrong");
    return NvdbGrid::Checksum::Full;
  }

  static bool isAfter32_6(const nvdb::GridData& data) {
    return nvdb::minorOf(data.version) > 6 || (nvdb::minorOf(data.version) == 6 && nvdb::patchOf(data.version) > 0);
  }

  std::uint32_t crcOfNodes() const {
    std::vector<std::uint64_t> crcs;
    crcs.reserve(mUpper.size() + mLower.size() + mLeaves.size());
    for (const std::size_t node : mUpper) crcs.push_back(crcOf(mBytes.substr(node, mType->upper)));
    for (const std::size_t node : mLower) crcs.push_back(crcOf(mBytes.substr(node, mType->lower)));
    for (const std::size_t node : mLeaves) crcs.push_back(crcOf(mBytes.substr(node, mType->leaf)));
    return crcOf({reinterpret_cast<const char*>(crcs.data()), crcs.size() * sizeof crcs[0]});
  }

  static std::uint32_t crcOfBlocks(std::string_view bytes) {
    std::vector<std::uint32_t> crcs(bytes.size() / nvdb::kChecksumBlock);
    for (std::size_t i = 0; i < crcs.size(); ++i)
      crcs[i] = crcOf(
          bytes.substr(i * nvdb::kChecksumBlock, i + 1 == crcs.size() ? std::string_view::npos : nvdb::kChecksumBlock));
    return crcOf({reinterpret_cast<const char*>(crcs.data()), crcs.size() * sizeof crcs[0]});
  }

  std::string_view mBytes;
  const std::string& mName;
  const nvdb::Type* mType = nullptr;
  std::size_t mRoot = 0, mRootSize = 0;
  std::vector<std::size_t> mUpper, mLower, mLeaves;
};

/// The bytes of a grid as in memory; @a buffer holds them if they are compressed.
std::string_view unpacked(std::string_view packed, const nvdb::GridHead& head, std::uint16_t codec,
                          std::string& buffer) {
  if (codec == nvdb::kUncompressed) {
    if (packed.size() != head.gridSize) throw DataError("it holds a grid of another size than its head says");
    return packed;
  }
  VdbCursor cursor(packed);
  cursor.enter("a compressed grid");
  const std::string_view stream = cursor.bytes(cursor.number<std::uint64_t>());
  // Deflate shrinks by no more than this factor.
  constexpr std::uint64_t kMostOfAByte = 1040;
  if (head.gridSize / kMostOfAByte > stream.size())
    throw DataError("it holds a grid of another size than its head says");
  requireMemory(static_cast<double>(head.gridSize), MemoryUse::File, "a grid");
  buffer.resize(head.gridSize);
  uLongf size = head.gridSize;
  const int state = uncompress(reinterpret_cast<Bytef*>(buffer.data()), &size,
                               reinterpret_cast<const Bytef*>(stream.data()), stream.size());
  if (state != Z_OK || size != head.gridSize) throw DataError("it holds a compressed grid that is damaged");
  return buffer;
}

NvdbGrid gridOf(const nvdb::GridHead& head, std::string name, std::string_view bytes) {
  NvdbGrid grid;
  grid.name = std::move(name);
  NvdbGridCheck check(bytes, grid.name);
  grid.checksum = check.check(head);
  grid.type = check.type().name;
  grid.gridClass = nvdb::kClasses[head.gridClass];
  grid.activeVoxels = head.voxelCount;
  grid.bytes = head.gridSize;
  std::copy(head.nodeCount, head.nodeCount + 3, grid.nodes.begin());
  grid.voxelSize = openvdb::Vec3d(head.voxelSize);
  if (head.voxelCount > 0) grid.box = {openvdb::Vec3d(head.worldBox), openvdb::Vec3d(head.worldBox + 3)};
  return grid;
}

void readSegment(VdbCursor& cursor, NvdbFile& file) {
  cursor.enter("its head");
  const auto head = nextRecord<nvdb::FileHead>(cursor);
  if (head.magic == nvdb::kMagicGrid)
    throw DataError(
        "it is the memory of a grid, without the head of a file; write it again by nanovdb::io::writeGrid()");
  if (head.magic != nvdb::kMagic && head.magic != nvdb::kMagicFile)
    throw DataError("it does not begin with the number that marks NanoVDB");
  if (nvdb::majorOf(head.version) != nvdb::kMajorVersion)
    throw DataError("it is of version " + versionText(head.version) + " of NanoVDB; only 32 can be read");
  if (head.codec == nvdb::kBlosc)
    throw DataError("it is compressed by Blosc, which is not read; write it again without compression");
  if (head.codec > nvdb::kBlosc) throw DataError("it is compressed in a way that is not known");
  file.version = versionText(head.version);
  if (file.compression != "zip") file.compression = head.codec == nvdb::kZip ? "zip" : "none";
  struct Entry {
    nvdb::GridHead head;
    std::string name;
  };
  std::vector<Entry> entries;
  for (std::uint16_t i = 0; i < head.gridCount; ++i) {
    Entry entry{nextRecord<nvdb::GridHead>(cursor), {}};
    const std::string_view name = cursor.bytes(entry.head.nameSize);
    if (name.empty() || name.back() != '\0') throw DataError("it holds a grid whose name does not end");
    entry.name = inOneLine(name.substr(0, name.find('\0')));
    entries.push_back(std::move(entry));
  }
  for (const Entry& entry : entries) {
    cursor.enter("its grid '" + entry.name + "'");
    std::string buffer;
    const std::string_view grid = unpacked(cursor.bytes(entry.head.fileSize), entry.head, head.codec, buffer);
    file.grids.push_back(gridOf(entry.head, entry.name, grid));
  }
}

}  // namespace

NvdbFile decodeNvdb(std::string_view bytes) {
  VdbCursor cursor(bytes);
  NvdbFile file;
  do readSegment(cursor, file);
  while (cursor.left() > 0);
  if (file.grids.empty()) throw DataError("it holds no grid");
  return file;
}

NvdbFile readNvdb(const std::filesystem::path& path) {
  const std::string bytes = readWholeFile(path);
  try {
    return decodeNvdb(bytes);
  } catch (const DataError& error) {
    throw DataError("'" + inOneLine(path.string()) + "' cannot be read as a NanoVDB file: " + error.what());
  }
}

}  // namespace vdbtools
