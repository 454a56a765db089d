// SPDX-License-Identifier: Apache-2.0
/// @file vdb_file.h
/// The room `formats` reads and writes files of grids and maps: VDB, versors as JSON, and the binary formats of the
/// programs released with the papers. It uses the rooms `base` and `files`.
///
/// Here: VDB files. The same grids give the same bytes: OpenVDB stamps each file with a random identifier, which is
/// replaced by one that is made from the content.
#pragma once

#include "vdbtools/base/errors.h"
#include "vdbtools/base/grids.h"
#include "vdbtools/base/up_axis.h"

#include <filesystem>
#include <iosfwd>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace vdbtools {

struct VdbWriteOptions {
  bool half = false;  ///< 16-bit floats on disk: half the size, 3 digits
  /// String metadata of the file and of every grid.
  std::map<std::string, std::string> metadata{};
  /// The axis that points up in the file. It decides the text "creator" of the file's metadata: Blender takes a file
  /// for one with Y up if that begins with "Houdini". None: the file is for this program alone.
  std::optional<UpAxis> up{};
  /// Brings the grids to these axes, through their transforms alone: values, also those of vectors, stay as they are.
  UpTurn turn{};
};

/// To be called before grids for other programs are made, for encodeVdb() does not look: what this program keeps for
/// itself may have voxels of any size.
/// @param wayOut  what else the caller's options offer; by default the options of voxels
/// @throw std::invalid_argument  OpenVDB makes no transform for voxels as small as this, nor do programs that use it
void requireVdbVoxel(double voxelSize, std::string_view wayOut = {});

/// The bytes of a file with @a grids, Blosc-compressed. @a options.metadata is added to the grids' own in the file; the
/// grids themselves stay as they are.
/// @throw std::invalid_argument  two grids of one name
std::string encodeVdb(const std::vector<openvdb::GridBase::Ptr>& grids, const VdbWriteOptions& options);

struct VdbFile {
  openvdb::GridPtrVec grids;
  std::map<std::string, std::string> metadata;  ///< the file's, as text
  struct UnreadGrid {
    std::string name, type;
  };
  std::vector<UnreadGrid> unread{};  ///< grids of types that are not known, which are passed over
};

/// The grids of a file with these bytes. Of grids of points, the voxels that hold points, but not the points: this
/// program writes them and never needs them back. The structure of the whole is checked before OpenVDB reads it, which
/// trusts a file: what it could not read safely is refused, whatever the bytes are. Values may be any, also not finite.
/// @throw DataError  not a VDB, truncated, broken, without a grid that can be read, or with grids that would take more
///                   memory than this machine has
VdbFile decodeVdb(std::string bytes);

/// As decodeVdb(). The file is read once, as a whole, so it may be a pipe, and a file that changes meanwhile is refused
/// or read as it was.
/// @throw MissingInputError  no such file, or not readable
/// @throw IoError            reading broke off
VdbFile readVdb(const std::filesystem::path& path);

/// The metadata alone, without reading the grids.
/// @throw  as readVdb()
std::map<std::string, std::string> readVdbMetadata(const std::filesystem::path& path);

/// The FloatGrid called @a name. If the name is empty, the only FloatGrid, or among several the one called "surface" or
/// "phi".
/// @throw DataError  there is no such grid, it is of another type, or the choice is not clear; the text lists the grids
openvdb::FloatGrid::Ptr chooseFloatGrid(const VdbFile& file, const std::string& name,
                                        const std::filesystem::path& path);

/// True for an extension .vdb, in any case.
bool isVdbPath(const std::filesystem::path& path);

}  // namespace vdbtools
