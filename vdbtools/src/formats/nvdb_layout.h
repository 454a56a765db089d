// SPDX-License-Identifier: Apache-2.0
/// @file nvdb_layout.h
/// The layout of NanoVDB files of version 32, as plain data: the reader checks files by it without NanoVDB's headers,
/// and the writer, which has them, asserts that they agree. Numbers are little-endian, all sizes in bytes.
///
/// A file is a sequence of segments: NvdbFileHead, for each grid an NvdbGridHead with its name, then the grids. A grid
/// is NvdbGridData, NvdbTreeData, the root with its table, upper, lower and leaf nodes. Offsets to children are
/// relative to the node that has them; nodes lie at multiples of 32.
#pragma once

#include <cstddef>
#include <cstdint>

namespace vdbtools::nvdb {

constexpr std::uint64_t kMagic = 0x304244566f6e614e;      // "NanoVDB0", of files and grids
constexpr std::uint64_t kMagicGrid = 0x314244566f6e614e;  // "NanoVDB1", of grids since version 32.8
constexpr std::uint64_t kMagicFile = 0x324244566f6e614e;  // "NanoVDB2", of files since version 32.8
constexpr std::uint32_t kMajorVersion = 32;
constexpr std::size_t kAlignment = 32;

/// The version is a number of 11, 11 and 10 bits.
constexpr std::uint32_t majorOf(std::uint32_t version) { return version >> 21; }
constexpr std::uint32_t minorOf(std::uint32_t version) { return (version >> 10) & 0x7ff; }
constexpr std::uint32_t patchOf(std::uint32_t version) { return version & 0x3ff; }

enum : std::uint16_t { kUncompressed = 0, kZip = 1, kBlosc = 2 };

struct FileHead {
  std::uint64_t magic;
  std::uint32_t version;
  std::uint16_t gridCount, codec;
};
static_assert(sizeof(FileHead) == 16);

struct GridHead {
  std::uint64_t gridSize, fileSize, nameKey, voxelCount;
  std::uint32_t gridType, gridClass;
  double worldBox[6];
  std::int32_t indexBox[6];
  double voxelSize[3];
  std::uint32_t nameSize;  ///< with the 0 at its end
  std::uint32_t nodeCount[4], tileCount[3];
  std::uint16_t codec, padding;
  std::uint32_t version;
};
static_assert(sizeof(GridHead) == 176);

struct GridData {
  std::uint64_t magic;
  std::uint32_t headChecksum, nodeChecksum;
  std::uint32_t version, flags, index, count;
  std::uint64_t size;
  char name[256];
  unsigned char map[264];
  double worldBox[6], voxelSize[3];
  std::uint32_t gridClass, gridType;
  std::int64_t blindOffset;
  std::uint32_t blindCount, reserved0;
  std::uint64_t reserved1, reserved2;
};
static_assert(sizeof(GridData) == 672);
constexpr std::size_t kChecksummedFrom = 16;  // the magic number and the checksums are left out
constexpr std::uint32_t kNoChecksum = 0xffffffff;
/// Version 32.6 summed up what follows in blocks of this size instead of nodes, 32.6.0 from the first upper node on,
/// and later ones from the root on. The last block is longer than the others.
constexpr std::size_t kChecksumBlock = 4096;

struct TreeData {
  std::uint64_t nodeOffset[4];  ///< from the tree to the first leaf, lower node, upper node and to the root
  std::uint32_t nodeCount[3], tileCount[3];
  std::uint64_t voxelCount;
};
static_assert(sizeof(TreeData) == 64);

/// The root begins with the box (24) and the number of entries in its table.
constexpr std::size_t kRootCount = 24;
/// An entry begins with its key, and the offset of its child: 0 if it has none.
constexpr std::size_t kTileChild = 8;
/// An inner node begins with its box and flags; then come the masks of its values and of its children.
constexpr std::size_t kMasks = 32;
constexpr std::size_t kUpperMask = 32 * 32 * 32 / 8, kLowerMask = 16 * 16 * 16 / 8;
/// A leaf of FpN has the logarithm of its bits in the upper three bits of this byte, and its values behind the leaf.
constexpr std::size_t kLeafFlags = 15;
constexpr std::size_t kLeafBytesOfABit = 64;
constexpr std::uint32_t kLargestLogOfBits = 4;

struct BlindData {
  std::int64_t offset;  ///< from here
  std::uint64_t count;
  std::uint32_t flags, semantic, dataClass, dataType;
  char name[256];
};
static_assert(sizeof(BlindData) == 288);

/// The sizes of a type's parts. A table of children has entries of 8 bytes or the size of a value.
struct Type {
  std::uint32_t number;
  const char* name;
  std::size_t root, tile, upper, lower, leaf;
  std::size_t upperTable, lowerTable, entry;  ///< the places of the tables, and the size of their entries
  bool variableLeaf = false;
};
constexpr Type kTypes[] = {
    {1, "float", 64, 32, 270400, 33856, 2144, 8256, 1088, 8},
    {2, "double", 96, 32, 270400, 33856, 4224, 8256, 1088, 8},
    {3, "int16", 64, 32, 270400, 33856, 1120, 8256, 1088, 8},
    {4, "int32", 64, 32, 270400, 33856, 2144, 8256, 1088, 8},
    {5, "int64", 96, 32, 270400, 33856, 4224, 8256, 1088, 8},
    {6, "vec3s", 96, 32, 532544, 66624, 6272, 8256, 1088, 16},
    {7, "vec3d", 128, 64, 794720, 99424, 12448, 8288, 1120, 24},
    {8, "mask", 64, 32, 270400, 33856, 96, 8256, 1088, 8},
    {10, "uint32", 64, 32, 270400, 33856, 2144, 8256, 1088, 8},
    {11, "bool", 64, 32, 270400, 33856, 160, 8256, 1088, 8},
    {12, "rgba8", 64, 32, 270400, 33856, 2144, 8256, 1088, 8},
    {13, "Fp4", 64, 32, 270400, 33856, 352, 8256, 1088, 8},
    {14, "Fp8", 64, 32, 270400, 33856, 608, 8256, 1088, 8},
    {15, "Fp16", 64, 32, 270400, 33856, 1120, 8256, 1088, 8},
    {16, "FpN", 64, 32, 270400, 33856, 96, 8256, 1088, 8, true},
    {17, "vec4s", 96, 64, 532576, 66656, 8320, 8288, 1120, 16},
    {18, "vec4d", 160, 64, 1056896, 132224, 16544, 8320, 1152, 32},
    {19, "index", 96, 32, 270400, 33856, 96, 8256, 1088, 8},
};

/// By their numbers, in the words of OpenVDB where it has the class.
constexpr const char* kClasses[] = {"unknown",    "level set", "fog volume", "staggered", "point index",
                                    "point data", "topology",  "voxels",     "index"};

}  // namespace vdbtools::nvdb
