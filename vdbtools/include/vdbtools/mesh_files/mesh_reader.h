// SPDX-License-Identifier: Apache-2.0
/// @file mesh_reader.h
/// The room `mesh_files` reads and writes the files of meshes: OBJ, PLY, STL, OFF, glTF and 3MF. It uses the rooms up
/// to `decimation`, which makes the levels of detail in a GLB.
///
/// Here: reading a mesh, whatever its format.
#pragma once

#include "vdbtools/mesh/mesh.h"

#include <filesystem>

namespace vdbtools {

/// Reads OBJ, PLY, STL, OFF or glTF (.glb, .gltf), by the file's extension in any case. Polygons are split into
/// triangles: convex ones into fans, others by ear clipping. Normals are skipped; unused points are kept; STL and glTF
/// are welded. Coordinates are read in double precision, except those of STL and glTF, which are floats. In OBJ,
/// corners that a face repeats are dropped. Of glTF, all triangles of the default scene are joined, where their nodes
/// place them; skins, morph targets and materials are not looked at, and a .gltf may name buffers beside it only.
///
/// Attributes are, of PLY, all single numbers of the vertices but x, y, z, nx, ny, nz and texture coordinates; integers
/// that are channels of a colour (red, green, blue, alpha) are scaled to 0..1. Of OBJ, red, green and blue where they
/// follow the three coordinates (and 1 at points without, if others have them). Texture coordinates are those of OBJ's
/// corners, of PLY's vertices where they have s and t, u and v, or texture_u and texture_v, and the first ones of glTF,
/// turned so that v counts from the bottom. Of glTF, COLOR_0 gives red, green, blue and perhaps alpha as they are,
/// which is linear light, and _NAME the attribute NAME, or NAME_x, NAME_y and so on.
/// @throw MissingInputError  there is no such file, it is not an ordinary file, or it may not be opened
/// @throw IoError            reading broke off
/// @throw DataError          unknown format, empty, truncated, counts that do not fit the file, an index out of range,
///                           coordinates that are not finite, no triangle
Mesh readMesh(const std::filesystem::path& path);

}  // namespace vdbtools
