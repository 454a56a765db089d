// SPDX-License-Identifier: Apache-2.0
/// @file vdb_file.h
/// The room `formats` reads and writes files of grids and maps: VDB, versors as JSON, and the binary formats of the
/// programs released with the papers. It uses the rooms `base` and `files`.
///
/// This header declares VDB files. The same grids give the same bytes: OpenVDB stamps each file with a random
/// identifier, which is replaced by one derived from the content.
#pragma once

#include "vdbtools/base/errors.h"
#include "vdbtools/base/grids.h"
#include "vdbtools/base/units.h"
#include "vdbtools/mesh/mesh_sink.h"

#include <cstdint>
#include <filesystem>
#include <iosfwd>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace vdbtools {

/// The metadata entry with the name of the grid of distances in a file of this program, if it differs from the usual
/// one.
inline constexpr const char* kDistanceGrid = "julia_distance_grid";

/// A grid with values too large for 16 bits.
struct ClampedGrid {
  std::string name;          ///< in the file
  std::uint64_t values = 0;  ///< how many active values were too large
};

/// One line for each: "12 values of the grid trap are beyond what 16 bits hold, and stored as ..."
std::vector<std::string> textsOf(const std::vector<ClampedGrid>& grids);

struct VdbWriteOptions {
  /// 16-bit floats on disk: half the size, 3 digits. Finite values beyond 65504 would become infinite, and are stored
  /// as 65504 or -65504.
  bool half = false;
  /// String metadata of the file and of every grid.
  std::map<std::string, std::string> metadata{};
  /// The axis that points up in the file; none if the file is for this program alone. It decides the text "creator" of
  /// the file's metadata: Blender assumes Y up if that begins with "Houdini".
  std::optional<UpAxis> up{};
  /// Rotates the grids to these axes through their transforms alone. Values stay unchanged, except vectors of the type
  /// VEC_CONTRAVARIANT_RELATIVE, which are turned too.
  UpTurn turn{};
  /// The names that grids have in the file, by their own names; grids that are not listed keep theirs.
  std::map<std::string, std::string> names{};
  /// Takes the grids with active values that were too large for 16 bits, if there are any.
  std::vector<ClampedGrid>* clamped = nullptr;
};

/// Returns the grids with their names replaced as @a names says; grids that are not listed keep theirs. Values are
/// shared.
std::vector<openvdb::GridBase::Ptr> renamed(const std::vector<openvdb::GridBase::Ptr>& grids,
                                            const std::map<std::string, std::string>& names);

/// Checks the voxel size before grids for other programs are made. encodeVdb() does not check it, because files that
/// only this program reads may have voxels of any size.
/// @param wayOut  the remedy that the caller's options offer; by default the options of voxels
/// @throw std::invalid_argument  OpenVDB, and programs that use it, cannot represent voxels this small
void requireVdbVoxel(double voxelSize, std::string_view wayOut = {});

/// Returns the bytes of a file with @a grids, Blosc-compressed. In the file, @a options.metadata is added to the grids'
/// own metadata; the grids themselves are not changed.
/// @throw std::invalid_argument  two grids have the same name
std::string encodeVdb(const std::vector<openvdb::GridBase::Ptr>& grids, const VdbWriteOptions& options);

struct VdbFile {
  openvdb::GridPtrVec grids;
  std::map<std::string, std::string> metadata;  ///< the file's metadata, as text
  struct UnreadGrid {
    std::string name, type;
  };
  std::vector<UnreadGrid> unread{};  ///< grids of unknown types, which are skipped
};

/// Reads the grids of a file with these bytes. Of grids of points, it reads the voxels that hold points, but not the
/// points, which this program only writes. It checks the structure of the whole file before OpenVDB, which trusts
/// files, reads it, and refuses anything that OpenVDB could not read safely. Values may be anything, even not finite.
/// @throw DataError  not a VDB, truncated, broken, without a readable grid, or with grids that would take more memory
///                   than this machine has
VdbFile decodeVdb(std::string bytes);

/// As decodeVdb(), for a file. The file is read once, as a whole, so it may be a pipe; if the file changes meanwhile,
/// it is refused or read in its old state.
/// @throw MissingInputError  the file does not exist or is not readable
/// @throw IoError            reading failed midway
VdbFile readVdb(const std::filesystem::path& path);

/// Reads the metadata alone, without the grids.
/// @throw  as readVdb()
std::map<std::string, std::string> readVdbMetadata(const std::filesystem::path& path);

/// The names that the grid of distances may have according to the file's metadata, the likeliest first.
std::vector<std::string> distanceGrids(const std::map<std::string, std::string>& metadata);

/// A name for each grid that no other grid has: where several have the same one, it is followed by [0], [1] and so on
/// in the order of the file, as OpenVDB's own tools number them.
std::vector<std::string> gridLabels(const VdbFile& file);

/// Returns the FloatGrid called @a name, which may be its label. If the name is empty, it is the only FloatGrid, or
/// among several the one that the file's metadata name (kDistanceGrid), or else the one called "surface" or "phi".
/// Where there is no FloatGrid, it is a copy of the only DoubleGrid.
/// @throw DataError  there is no such grid, it is of another type, or the choice is ambiguous; the message lists the
///                   grids
openvdb::FloatGrid::Ptr chooseFloatGrid(const VdbFile& file, const std::string& name,
                                        const std::filesystem::path& path);

/// Whether the extension is .vdb, ignoring case.
bool isVdbPath(const std::filesystem::path& path);

// Points in VDB files: OpenVDB's point grids, which Houdini reads as packed points.

/// Returns a grid named "points" of class unknown. Positions are the attribute P, in 32-bit floats relative to the
/// voxels that hold the points; normals, if there are any, are N. Columns keep their names, and texture coordinates get
/// a third component, 0. Points in a voxel keep their order.
/// @param spacing  approximate distance between neighbours, world units, > 0; a voxel is twice as wide
/// @throw std::invalid_argument  no points, or a spacing that is not positive
/// @throw std::logic_error       the number of normals or values does not match the points
openvdb::GridBase::Ptr pointGrid(const PointBatch& points, const std::vector<VertexColumn>& columns, double spacing);

}  // namespace vdbtools
