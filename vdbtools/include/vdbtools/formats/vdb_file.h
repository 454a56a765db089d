// SPDX-License-Identifier: Apache-2.0
/// @file vdb_file.h
/// VDB files in and out. What is written is the same bytes for the same grids: OpenVDB stamps each file with a random
/// identifier, which is replaced by one made from the content.
#pragma once

#include "vdbtools/base/errors.h"
#include "vdbtools/base/grids.h"

#include <filesystem>
#include <iosfwd>
#include <map>
#include <string>
#include <vector>

namespace vdbtools {

struct VdbWriteOptions {
  bool half = false;  ///< 16-bit floats on disk: half the size, 3 digits
  /// String metadata of the file and of every grid.
  std::map<std::string, std::string> metadata;
};

/// The bytes of a file with @a grids, Blosc-compressed. The grids' metadata is added to.
/// @throw std::invalid_argument  two grids of one name
std::string encodeVdb(const std::vector<openvdb::GridBase::Ptr>& grids, const VdbWriteOptions& options);

struct VdbFile {
  openvdb::GridPtrVec grids;
  std::map<std::string, std::string> metadata;  ///< the file's, as text
};

/// @throw MissingInputError  no such file, or not readable
/// @throw DataError          not a VDB, truncated, or without a grid
VdbFile readVdb(const std::filesystem::path& path);

/// The metadata alone, without reading the grids.
std::map<std::string, std::string> readVdbMetadata(const std::filesystem::path& path);

/// The FloatGrid called @a name, or the only one (the one called "surface" or "phi" among several) if the name is
/// empty.
/// @throw DataError  no such grid, of another type, or no single choice; the text lists what there is
openvdb::FloatGrid::Ptr chooseFloatGrid(const VdbFile& file, const std::string& name,
                                        const std::filesystem::path& path);

/// True for an extension .vdb, in any case.
bool isVdbPath(const std::filesystem::path& path);

}  // namespace vdbtools
