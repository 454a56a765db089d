// SPDX-License-Identifier: Apache-2.0
/// @file file_formats.h
/// All formats of grids and meshes, and what follows from the name of a file. Whoever asks what a file of some
/// extension is or holds asks here.
#pragma once

#include "vdbtools/files/file_format.h"
#include "vdbtools/formats/nvdb_file.h"
#include "vdbtools/formats/vdb_file.h"

#include <filesystem>
#include <iosfwd>
#include <string>
#include <string_view>
#include <vector>

namespace vdbtools {

/// Those of grids, then those of meshes.
FormatList fileFormats();

/// The format by the extension of a file's name, or by the extension alone, as ".ply". Null: another one, or none.
const FileFormat* findFormat(std::string_view name);
/// The same of a file that is read, which may be a mesh in the standard input (formatOfMesh(), mesh_reader.h).
/// @throw as formatOfMesh()
const FileFormat* formatOfInput(const std::filesystem::path& path);

/// The extensions of the formats of which @a fact is true, in words: ".vdb or .nvdb".
std::string extensionsOf(bool FileFormat::*fact);
/// Their names: "VDB, PLY, OBJ or GLB".
std::string namesOf(bool FileFormat::*fact);
/// The formats in which this build writes a fractal, as extensions without dots: "vdb", "nvdb", "ply" and so on.
std::vector<std::string> writtenFormats();

/// The format that grids are to be written in, as meshFormat() for meshes (mesh_writer.h).
/// @throw std::invalid_argument  no grids are written so
const FileFormat& gridFormat(const std::filesystem::path& path);

/// @throw std::invalid_argument  this build cannot write the format; says why
void requireBuilt(const FileFormat& format);

/// The texts of a file that may hold them, such as its recipe; empty for any other.
/// @throw DataError, MissingInputError, IoError
FileTexts readFileTexts(const std::filesystem::path& path);
/// The same from the first bytes of a file that has this name. @throw DataError
FileTexts fileTexts(std::string_view name, std::string_view bytes);

/// Writes grids in any format of grids.
/// @param options  what a format has no room for is left out
/// @param values   how NanoVDB stores numbers
/// @return what became of the grids, where a format rounds their values
/// @throw std::invalid_argument  it is no format of grids, this build cannot write it, or two grids have the same name
/// @throw DataError              the format has no such type of grid, or no transform of this kind
std::vector<NvdbWritten> writeGrids(std::ostream& stream, const FileFormat& format,
                                    const std::vector<openvdb::GridBase::Ptr>& grids, const VdbWriteOptions& options,
                                    NvdbValues values = NvdbValues::Full);

}  // namespace vdbtools
