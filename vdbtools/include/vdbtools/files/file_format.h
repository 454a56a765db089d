// SPDX-License-Identifier: Apache-2.0
/// @file file_format.h
/// What is known of a file format. Each format is one row of a table, beside the functions that read and write it:
/// those of meshes in mesh_files/mesh_formats.h, those of grids in formats/grid_formats.h.
/// vdbtools/formats/file_formats.h has all of them together.
#pragma once

#include "vdbtools/base/units.h"

#include <map>
#include <span>
#include <string>
#include <string_view>

namespace vdbtools {

/// The texts of a file besides its shape, by their keys: the recipe, the axis that points up, the unit.
using FileTexts = std::map<std::string, std::string>;

/// The data of points or voxels that a format has room for.
enum class FormatColumns {
  None,
  Colours,   ///< colours and texture coordinates
  OfVoxels,  ///< everything but texture coordinates
  All
};

struct FileFormat {
  std::string_view extension;  ///< in lower case, with the dot
  std::string_view name;       ///< in messages

  // What is done with it.
  bool readsGrids = false, writesGrids = false;  ///< by readVdb(), by writeGrids()
  // These follow from the functions of its row.
  bool readsMesh = false, writesMesh = false;  ///< by readMesh(), by MeshStreamWriter
  bool writesColours = false;                  ///< with a mesh
  bool printed = false;                        ///< 'print' writes it
  bool points = false;                         ///< 'points' writes it
  bool piped = false;  ///< "-" with the extension is the standard output; for the first such format "-" alone is
  /// Whether this build can write it; null: every build can.
  bool (*isBuilt)() = nullptr;

  // What a file carries.
  bool recipe = false;  ///< the recipe that it was made by, and which axis points up
  bool unit = false;
  FormatColumns columns = FormatColumns::None;
  bool animations = false;
  bool levels = false;    ///< levels of detail
  bool half = false;      ///< 16-bit floats, by --half
  bool nvdbBits = false;  ///< fewer bits, by --nvdb-bits

  // How it is read.
  UpAxis up = UpAxis::Y;      ///< the axis that most programs take for up
  bool metresYUp = false;     ///< by its specification, the unit is the metre and Y points up
  bool linearLight = false;   ///< its colours are linear; those of others are sRGB
  bool endsUnmarked = false;  ///< a file that is cut between two of its lines passes for a whole one

  /// Whether the recipe in a file makes the coordinates of the file again, and not those of a target in another unit.
  bool isMadeAgain() const { return recipe && !metresYUp; }
};

/// A list of formats.
using FormatList = std::span<const FileFormat* const>;

/// The format whose extension ends @a name, ignoring case; null: none of them.
const FileFormat* formatByName(FormatList formats, std::string_view name);

/// The extensions or the names of the formats of which @a fact is true, in their order: ".ply, .obj or .stl".
std::string formatTexts(FormatList formats, bool FileFormat::*fact, std::string_view FileFormat::*text,
                        std::string_view between = ", ", std::string_view beforeLast = " or ");

}  // namespace vdbtools
