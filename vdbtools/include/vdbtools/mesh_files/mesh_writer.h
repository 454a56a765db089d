// SPDX-License-Identifier: Apache-2.0
/// @file mesh_writer.h
/// Writes meshes as binary little-endian PLY, OBJ, binary STL or GLB (glTF 2.0). Positions are 32-bit floats except in
/// two cases. An OBJ always holds the digits of doubles. And where floats would move vertices by more than 1/1000 of a
/// voxel, or 1/10000 in an object farther from the origin than four of its longest sides, a PLY has doubles, and a GLB
/// has floats relative to the middle of the object, with a node that moves them there. An STL can do neither: if its
/// floats would move vertices by more than 1/1000 of a voxel, it is refused. The same mesh gives the same bytes, whole
/// or in pieces, for any stream.
#pragma once

#include "vdbtools/base/units.h"
#include "vdbtools/files/file_format.h"
#include "vdbtools/mesh/mesh.h"
#include "vdbtools/mesh/mesh_sink.h"

#include <filesystem>
#include <iosfwd>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace vdbtools {

/// Returns the format that a file is to be written in, by its extension or that of a name such as "a.ply" or ".ply".
/// @throw std::invalid_argument  no mesh is written so
const FileFormat& meshFormat(const std::filesystem::path& path);

/// A written level of detail.
struct MeshLevel {
  std::uint64_t triangles = 0;
  double error = 0;  ///< an estimate of the distance between its surface and that of the mesh, world units
};

struct MeshWriteOptions {
  const FileFormat* format = &meshFormat(".ply");  ///< one that is written
  double voxelSize = 0;  ///< world units; sets the required precision of positions. 0: floats are precise enough
  /// A bounding box of all points, world units, which decides whether floats are precise enough. By default it is the
  /// mesh's own box, which is unknown while the mesh comes in pieces.
  std::optional<openvdb::BBoxd> box;
  /// The data of each point in addition to its position and its normal. A PLY has colours as red, green, blue (bytes of
  /// sRGB), texture coordinates as s and t, vectors as NAME_x, NAME_y, NAME_z, and numbers by their names. An OBJ has a
  /// colour after each position (sRGB, 0 to 1) and texture coordinates as vt; it drops the other columns, and STL drops
  /// all of them. A GLB has colours as COLOR_0 (linear, 0 to 1), texture coordinates as TEXCOORD_0, with v counted from
  /// the top of the picture, vectors and numbers as _name, and world vectors as _NAME in capitals.
  std::vector<VertexColumn> columns{};
  /// The recipe, as comment lines "juliavdb KEY VALUE" in PLY and OBJ, and as the extras of the asset in GLB. An STL
  /// has room for the unit alone (kLengthUnit), in its title.
  FileTexts comments{};
  /// Rotates points, normals, world vectors and the box to the axes of the file; other columns stay unchanged.
  UpTurn turn{};
  /// Multiplies positions, the box and world vectors for a file whose unit is another one; other columns stay
  /// unchanged.
  double scale = 1;
  /// Levels of detail that a GLB has in addition to the mesh, as fractions of its triangles. They require holding the
  /// whole mesh in memory. Other formats have none.
  std::vector<double> levels{};
};

/// Takes the world vectors among the values of columns to other axes and another unit.
/// @param values  row by row
void turnWorldVectors(std::span<float> values, std::span<const VertexColumn> columns, const UpTurn& turn,
                      double scale = 1);

/// The names of the columns that a file of the format cannot hold, also one of grids.
std::vector<std::string> columnsLeftOut(const FileFormat& format, std::span<const VertexColumn> columns);

/// Whether a file with these options holds positions as doubles, or numbers that are computed from doubles.
/// @throw std::invalid_argument  a voxel size without a box, or an STL that cannot hold the mesh
bool needsDoublePositions(const MeshWriteOptions& options);

/// Checks before a mesh is made that a file with these options can hold so many points and triangles.
/// @throw DataError              more points than triangles can refer to
/// @throw std::invalid_argument  more than the format can count, or a GLB of more than 4 GiB
void requireMeshCounts(const MeshWriteOptions& options, bool normals, std::uint64_t points, std::uint64_t triangles);

/// Writes normals if the mesh has them (STL has its own normals, those of the faces). The stream's owner must check it
/// for errors.
/// @param values  of options.columns, row by row (PointBatch)
/// @throw std::invalid_argument  an STL of more triangles than it can count, or of an object too far from the origin
/// @throw std::logic_error       an index out of range, or a number of normals or rows that differs from that of the
///                               points
/// @return the levels of detail
std::vector<MeshLevel> writeMesh(std::ostream& stream, const Mesh& mesh, const MeshWriteOptions& options,
                                 std::span<const float> values = {});

/// Writes a mesh while it is made. Data that cannot be put in its place yet waits in unnamed files: the triangles of a
/// PLY or GLB, the normals and triangles of an OBJ, and, if the stream cannot seek, all of a PLY, STL or GLB. Memory
/// holds a few buffers and, for STL, the points that triangles may still use: those from the last firstPoint on.
///
///   AtomicFile file(path);
///   MeshStreamWriter writer(file.stream(), file.temporaryPath().parent_path(), options);
///   makeMesh(writer);    // any number of addPoints() and addTriangles()
///   writer.finish();
///   file.commit();
///
/// If a call throws, the mesh and the stream's content are lost.
/// @throw IoError  any call: the scratch folder's disk is full, or the stream has failed, for a reason that its owner
///                 knows
class MeshStreamWriter final : public MeshSink {
 public:
  /// @param stream         used by nobody else until finish(). If it can tell its position, the header is filled in
  ///                       afterwards, so it must not be a stream that always appends
  /// @param scratchFolder  on a disk with room for the mesh, such as the folder of the file itself; empty: the working
  ///                       directory
  /// @throw std::invalid_argument  a voxel size without a box, or an STL that cannot hold the mesh
  /// @throw CreateError            no file can be created in the folder
  MeshStreamWriter(std::ostream& stream, const std::filesystem::path& scratchFolder, const MeshWriteOptions& options);
  ~MeshStreamWriter() override;
  MeshStreamWriter(const MeshStreamWriter&) = delete;
  MeshStreamWriter& operator=(const MeshStreamWriter&) = delete;

  /// @throw DataError         more points than triangles can refer to
  /// @throw std::logic_error  a number of normals or rows that differs from that of the points, or normals in some
  ///                          calls only
  void addPoints(const PointBatch& batch) override;

  /// @throw std::invalid_argument  an STL of more triangles than it can count
  /// @throw std::logic_error       a triangle uses a point that has not been added yet, or one before a firstPoint
  void addTriangles(std::span<const openvdb::Vec3I> triangles, std::uint64_t firstPoint) override;

  /// Completes the file, which cannot be read before. The stream is then positioned at its end, and the writer accepts
  /// no more.
  void finish();

  /// The written levels of options.levels, after finish().
  const std::vector<MeshLevel>& levels() const;

 private:
  struct State;
  std::unique_ptr<State> mState;
};

/// The comments of a PLY, OBJ or GLB written by this project, the unit in the title of its STL, and the unit of any
/// 3MF and of an FBX or DAE that is trusted; empty for any other file.
/// @throw MissingInputError, IoError
FileTexts readMeshTexts(const std::filesystem::path& path);
/// The same from the beginning of a file of a format of meshes. The state of the stream shows read errors.
FileTexts meshTexts(const FileFormat& format, std::istream& stream);

// Writes meshes as 3MF, a format for 3D printing: a zip with a model in XML (3MF Core Specification 1.3, ISO/IEC
// 25422). The unit is the millimetre.

/// Whether this build can write 3MF, which requires libzip.
bool canWrite3mf();
/// Whether this build can read 3MF (mesh_reader.h), which requires libexpat, too.
bool canRead3mf();

/// Returns the bytes of a file with one object, with positions as 32-bit floats. The same mesh gives the same bytes.
/// @param mesh      millimetres, closed and oriented outward
/// @param metadata  stored under the project's own names
/// @throw std::invalid_argument  this build has no libzip
std::string encode3mf(const Mesh& mesh, const std::map<std::string, std::string>& metadata = {});

}  // namespace vdbtools
