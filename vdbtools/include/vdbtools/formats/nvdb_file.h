// SPDX-License-Identifier: Apache-2.0
/// @file nvdb_file.h
/// Files of NanoVDB, the read-only form of VDB trees that renderers and graphics processors use as they lie in memory
/// [Museth, NanoVDB: A GPU-Friendly and Portable VDB Data Structure For Real-Time Rendering And Simulation, 2021].
///
/// The format has no text metadata, so a file holds no recipe. Values are stored as they are, or quantized: each block
/// of 8 x 8 x 8 voxels then has a least value and a step of its own. The same grids give the same bytes, uncompressed.
#pragma once

#include "vdbtools/base/grids.h"
#include "vdbtools/base/units.h"

#include <array>
#include <cstdint>
#include <filesystem>
#include <iosfwd>
#include <string>
#include <vector>

namespace vdbtools {

/// How the values of float grids are stored. Grids of other types are always stored as they are.
enum class NvdbValues {
  Full,      ///< 32-bit floats
  Fp16,      ///< 16 bits
  Fp8,       ///< 8 bits
  Variable,  ///< FpN: as few bits for each block as keep the error below a tenth of a voxel in a level set, or below
             ///< 0.01 in a fog volume. Other grids have no such bound, and get 16 bits wherever fewer would lose
             ///< anything
};

struct NvdbWriteOptions {
  NvdbValues values = NvdbValues::Full;
  UpTurn turn{};  ///< rotates the grids through their transforms alone, as in VdbWriteOptions
};

/// How a grid was written.
struct NvdbWritten {
  std::string name;
  std::string type;          ///< the type's name in NanoVDB, such as "Fp8"
  bool quantized = false;    ///< whether values were rounded
  double greatestError = 0;  ///< of the active voxels, in the units of the values
  bool levelSet = false;     ///< whether the grid is a level set, so that its values are distances
  double voxelSize = 0;      ///< world units
};

/// Whether this build can write NanoVDB.
bool canWriteNvdb();

/// Writes the grids, uncompressed.
/// @throw std::invalid_argument  this build cannot write NanoVDB, or two grids have the same name
/// NanoVDB does not support the type or the transform of a grid
std::vector<NvdbWritten> writeNvdb(std::ostream& stream, const std::vector<openvdb::GridBase::Ptr>& grids,
                                   const NvdbWriteOptions& options);

/// A grid as its file describes it.
struct NvdbGrid {
  std::string name;
  std::string type;       ///< "float", "Fp8", ...
  std::string gridClass;  ///< as OpenVDB's: "level set", "fog volume", "unknown", ...
  std::uint64_t activeVoxels = 0;
  std::uint64_t bytes = 0;               ///< in memory
  std::array<std::uint32_t, 3> nodes{};  ///< leaves, lower and upper nodes
  openvdb::Vec3d voxelSize;
  openvdb::BBoxd box;  ///< of the active voxels with their extent, world units; empty if there is none
  enum class Checksum { None, Head, Full } checksum = Checksum::None;  ///< what the file's checksum covers
};

struct NvdbFile {
  std::string version;      ///< of NanoVDB, as "32.4.2"
  std::string compression;  ///< "none" or "zip"
  std::vector<NvdbGrid> grids;
};

/// Reads the descriptions of the grids in a file, and checks every size and count, the place of every node, and the
/// checksums. Readers of NanoVDB trust all of these. This works in every build.
/// @throw DataError  not a NanoVDB file of a known version, truncated or damaged, or compressed by Blosc
NvdbFile decodeNvdb(std::string_view bytes);

/// As decodeNvdb(), for a file.
/// @throw MissingInputError, IoError
NvdbFile readNvdb(const std::filesystem::path& path);

/// Whether the extension is .nvdb, ignoring case.
bool isNvdbPath(const std::filesystem::path& path);

}  // namespace vdbtools
