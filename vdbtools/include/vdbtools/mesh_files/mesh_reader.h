// SPDX-License-Identifier: Apache-2.0
/// @file mesh_reader.h
/// The room `mesh_files` reads and writes the files of meshes: OBJ, PLY, STL, OFF, glTF and 3MF, and others by a
/// library that has to be trusted (trustImporter()). It uses the rooms up to `decimation`, which makes the levels of
/// detail in a GLB.
///
/// This header reads meshes in any of these formats.
#pragma once

#include "vdbtools/files/file_format.h"
#include "vdbtools/mesh/mesh.h"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace vdbtools {

/// The formats of meshes.
FormatList meshFormats();

/// The format of a mesh: by its name, or by the content of the standard input (standard_streams.h), which has no name.
/// What is not recognised there is an OBJ. Null: the name has the extension of no mesh.
/// @throw as openToRead()
const FileFormat* formatOfMesh(const std::filesystem::path& path);

/// Reads OBJ, PLY, STL, OFF, glTF (.glb, .gltf) or 3MF, according to formatOfMesh(), and FBX, DAE, 3DS or X3D
/// if trustImporter() allows it. Polygons are split into triangles:
/// convex ones into fans, others by ear clipping. Normals are skipped; unused points are kept, except those
/// whose coordinates are not finite (Mesh::pointsLeftOut); STL and glTF are welded. Coordinates are read in double
/// precision, except those of STL and glTF, which are floats. In OBJ, corners that a face repeats are dropped. A PLY
/// may have triangle strips in the place of faces. In glTF, all triangles of the default scene are joined, in the
/// positions given by their nodes, skins and morph targets as they stand in the file (a MeshMoment plays
/// animations); instances (EXT_mesh_gpu_instancing) as often as they occur. Materials are ignored, and a .gltf may only
/// name buffers in its own folder. In 3MF, the items of the build are joined, in the file's unit; supports are left
/// out.
///
/// The attributes of a PLY are all scalar properties of the vertices except x, y, z, nx, ny, nz and texture
/// coordinates; integers that are colour channels (red, green, blue, alpha) are scaled to 0..1. Those of an OBJ are
/// red, green and blue where they follow the three coordinates (and 1 at points without, if others have them), or else
/// the mean diffuse colour (Kd) of the faces at a point, if the file's material library lies in its folder; and
/// material_NAME and group_NAME, the share of the faces at a point that have this name, where faces differ in it. Of
/// each kind there are at most 32, and characters that are no letters, digits, dots or dashes are underscores there.
/// Texture coordinates are those of OBJ's corners, of PLY's vertices if they have s and t, u and v, or texture_u and
/// texture_v, and the first set of glTF, flipped so that v counts from the bottom. In glTF, COLOR_0 gives red, green,
/// blue and perhaps alpha unchanged, which is linear light, and _NAME gives the attribute NAME, or NAME_x, NAME_y and
/// so on.
/// @throw MissingInputError  the file does not exist, is not an ordinary file, or may not be opened
/// @throw IoError            reading failed midway
/// @throw DataError          unknown format, empty, truncated, counts that do not fit the file, an index out of range,
///                           coordinates that are not finite, no triangle
Mesh readMesh(const std::filesystem::path& path);

// The animations of a glTF, and a moment of one at which its mesh is read.

/// A moment of an animation. Before its first key and after its last, an animation stands still.
struct MeshMoment {
  double seconds = 0;
  /// The animation, by its name or by its number from 0, or "all" for all of them at once; empty: the first.
  std::string animation{};
  bool operator==(const MeshMoment&) const = default;
};

/// Reads a mesh as readMesh() does, at a moment if one is given.
/// @throw as readMesh()
/// @throw DataError  there is no such animation, or it cannot be played
Mesh readMesh(const std::filesystem::path& path, const std::optional<MeshMoment>& moment);
/// The same for readPoints().
Mesh readPoints(const std::filesystem::path& path, const std::optional<MeshMoment>& moment);

/// Whether files of its format (formatOfMesh()) may have animations; those of glTF may.
bool mayBeAnimated(const std::filesystem::path& path);

struct MeshAnimation {
  std::string name;            ///< may be empty
  double first = 0, last = 0;  ///< the times of its first and its last key, seconds
};

/// The animations of a file, in its order; empty for formats other than glTF.
/// @throw DataError, MissingInputError, IoError
std::vector<MeshAnimation> readAnimations(const std::filesystem::path& path);

// Points without a surface, such as those of a scanner.

/// Reads the points of a file as readMesh() does. The file may have no triangles; those that it has are left out, and
/// so are their texture coordinates. See asPoints().
/// @throw as readMesh()
/// @throw DataError  there is no point
Mesh readPoints(const std::filesystem::path& path);

/// The points of a mesh. Each becomes a triangle without area, with all three corners at the point, so that a search
/// for the nearest surface finds the nearest point.
Mesh asPoints(Mesh mesh);

/// The median distance of a point from its nearest neighbour, for a sample of points spread over the list, world units;
/// 0 for fewer than two points. It relates to the radius of points as the length of edges does to a surface.
double pointSpacing(const std::vector<openvdb::Vec3d>& points);

// FBX, DAE, 3DS and X3D, which the library Assimp imports. Its importers have had many memory-safety defects: a file
// can be made such that reading it does harm. They are therefore off until somebody says that the files can be
// trusted. That is said of a process, and never by a recipe or a file.

/// Whether this build has Assimp.
bool canImport();

/// Whether the process imports files from now on. At first it does not.
void trustImporter(bool isTrusted);
bool isImporterTrusted();

}  // namespace vdbtools
