// SPDX-License-Identifier: Apache-2.0
/// @file mesh_writer.h
/// Writing meshes as binary little-endian PLY, OBJ, binary STL or GLB (glTF 2.0). Positions are 32-bit floats, except
/// in OBJ, whose digits hold doubles, and where floats would move vertices by more than 1/1000 of a voxel, or 1/10000
/// in an object farther from the origin than four of its longest sides: a PLY then has doubles, and a GLB floats about
/// the middle of the object, to where its node takes it. An STL has neither: where its floats would move vertices by
/// more than 1/1000 of a voxel, it is refused. The same mesh gives the same bytes, whole or in pieces, whatever the
/// stream.
#pragma once

#include "vdbtools/base/up_axis.h"
#include "vdbtools/mesh/mesh_sink.h"
#include "vdbtools/mesh/vertex_column.h"

#include <filesystem>
#include <iosfwd>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace vdbtools {

enum class MeshFormat { Ply, Obj, Stl, Glb };

/// The formats' extensions: for error messages and for lists of what may be written.
inline constexpr const char* kMeshExtensions = ".ply .obj .stl .glb";
/// The same as names of formats, for the help.
inline constexpr const char* kMeshFormatNames = "ply, obj, stl, glb";

/// By extension, in any case. @throw std::invalid_argument  it is none of kMeshExtensions
MeshFormat meshFormat(const std::filesystem::path& path);

/// A level of detail as it was written.
struct MeshLevel {
  std::uint64_t triangles = 0;
  double error = 0;  ///< an estimate of how far its surface is from that of the mesh, world units
};

struct MeshWriteOptions {
  MeshFormat format = MeshFormat::Ply;
  double voxelSize = 0;  ///< world units: tells how exact positions must be. 0: floats are exact enough
  /// A box around all points, world units, by which it is decided whether floats are exact enough. By default that is
  /// the mesh's own box, which is not known while the mesh comes in pieces.
  std::optional<openvdb::BBoxd> box;
  /// What each point has besides its position and its normal. A PLY has colours as red, green, blue (bytes of sRGB),
  /// texture coordinates as s and t, vectors as NAME_x, NAME_y, NAME_z, and numbers by their names. An OBJ has a colour
  /// behind each position (sRGB, 0 to 1) and texture coordinates as vt; it drops the other columns, STL all of them. A
  /// GLB has colours as COLOR_0 (linear, 0 to 1), texture coordinates as TEXCOORD_0, with v counted from the top of the
  /// picture, and vectors and numbers as _NAME.
  std::vector<VertexColumn> columns{};
  /// Comment lines, "juliavdb KEY VALUE", in PLY and OBJ, and the extras of the asset in GLB: the recipe.
  std::map<std::string, std::string> comments{};
  /// Brings points, normals and the box to the axes of the file; columns stay as they are.
  UpTurn turn{};
  /// Levels of detail that a GLB has besides the mesh, by their shares of its triangles. The whole mesh is then held in
  /// memory. Other formats have none.
  std::vector<double> levels{};
};

/// The names of those of the columns that a file of the format has no room for.
std::vector<std::string> columnsLeftOut(MeshFormat format, std::span<const VertexColumn> columns);

/// Whether a file of these options holds positions as doubles, or numbers that are computed from doubles.
/// @throw std::invalid_argument  a voxel size without a box, or an STL that cannot hold the mesh
bool needsDoublePositions(const MeshWriteOptions& options);

/// Normals are written if the mesh has them (STL has normals of its own, of the faces). Errors of the stream are left
/// to its owner.
/// @param values  of options.columns, row by row (PointBatch)
/// @throw std::invalid_argument  an STL of more triangles than it can count, or of an object too far from the origin
/// @throw std::logic_error       an index out of range, or another number of normals or of rows than of points
/// @return the levels of detail
std::vector<MeshLevel> writeMesh(std::ostream& stream, const Mesh& mesh, const MeshWriteOptions& options,
                                 std::span<const float> values = {});

/// Writes a mesh while it is made. What cannot be put in its place yet waits in nameless files: the triangles of a PLY
/// or GLB, the normals and triangles of an OBJ, and, if the stream cannot seek, all of a PLY, STL or GLB. Memory holds
/// a few buffers and, for STL, the points that triangles may still use: those from the last firstPoint on.
///
///   AtomicFile file(path);
///   MeshStreamWriter writer(file.stream(), file.temporaryPath().parent_path(), options);
///   makeMesh(writer);    // any number of addPoints() and addTriangles()
///   writer.finish();
///   file.commit();
///
/// If a call throws, the mesh is lost, and so is the stream's content.
/// @throw IoError  any call: the scratch folder's disk is full, or the stream has failed, whose owner knows why
class MeshStreamWriter final : public MeshSink {
 public:
  /// @param stream         used by nobody else until finish(). If it can tell its position, the header is filled in
  ///                       afterwards, so it must not be a stream that always appends
  /// @param scratchFolder  on a disk with room for the mesh, such as the folder of the file itself; empty: the working
  ///                       directory
  /// @throw std::invalid_argument  a voxel size without a box, or an STL that cannot hold the mesh
  /// @throw CreateError            no file can be made in the folder
  MeshStreamWriter(std::ostream& stream, const std::filesystem::path& scratchFolder, const MeshWriteOptions& options);
  ~MeshStreamWriter() override;
  MeshStreamWriter(const MeshStreamWriter&) = delete;
  MeshStreamWriter& operator=(const MeshStreamWriter&) = delete;

  /// @throw DataError         more points than triangles can refer to
  /// @throw std::logic_error  another number of normals or of rows than of points, or normals in some calls only
  void addPoints(const PointBatch& batch) override;

  /// @throw std::invalid_argument  an STL of more triangles than it can count
  /// @throw std::logic_error       a triangle uses a point that has not been added yet, or one before a firstPoint
  void addTriangles(std::span<const openvdb::Vec3I> triangles, std::uint64_t firstPoint) override;

  /// Completes the file, which cannot be read before. The stream then stands at its end, and the writer takes no more.
  void finish();

  /// Those of options.levels, once it is finished.
  const std::vector<MeshLevel>& levels() const;

 private:
  struct State;
  std::unique_ptr<State> mState;
};

/// The comments of a PLY, OBJ or GLB that this project wrote; nothing from any other file.
/// @throw MissingInputError, IoError
std::map<std::string, std::string> readMeshComments(const std::filesystem::path& path);

}  // namespace vdbtools
