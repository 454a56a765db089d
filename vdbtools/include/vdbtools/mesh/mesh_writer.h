// SPDX-License-Identifier: Apache-2.0
/// @file mesh_writer.h
/// Meshes out: binary little-endian PLY, OBJ, binary STL. Positions are 32-bit floats, but as exact as doubles in OBJ,
/// and doubles in a PLY whose vertices floats would move by more than 1/1000 of a voxel (a small object far from the
/// origin). The same mesh gives the same bytes, whole or in pieces, whatever the stream.
#pragma once

#include "vdbtools/mesh/mesh_sink.h"

#include <filesystem>
#include <iosfwd>
#include <map>
#include <memory>
#include <optional>
#include <string>

namespace vdbtools {

enum class MeshFormat { Ply, Obj, Stl };

/// By extension, in any case. @throw std::invalid_argument for any but .ply, .obj, .stl
MeshFormat meshFormat(const std::filesystem::path& path);

struct MeshWriteOptions {
  MeshFormat format = MeshFormat::Ply;
  double voxelSize = 0;  ///< world units; how exact positions must be. 0: floats will do
  /// Holds all points, world units: with it, the voxel size alone says whether floats will do. Without it, the mesh's
  /// own box is taken, which is not known while the mesh comes in pieces.
  std::optional<openvdb::BBoxd> box;
  /// Comment lines, "juliavdb KEY VALUE", in PLY and OBJ: the recipe.
  std::map<std::string, std::string> comments;
};

/// Normals are written where the mesh has them (STL has its own, of the faces). Errors of the stream are left to its
/// owner.
/// @throw std::invalid_argument  an STL of more triangles than it can count
/// @throw std::logic_error       an index out of range, or normals that are not one a point
void writeMesh(std::ostream& stream, const Mesh& mesh, const MeshWriteOptions& options);

/// Writes a mesh while it is made. What cannot be put in its place yet waits in nameless files: triangles in PLY,
/// normals and triangles in OBJ, and in a stream that cannot seek all of PLY and STL. In memory are a few buffers and,
/// for STL, the points that triangles may still use: from the last firstPoint on.
///
///   AtomicFile file(path);
///   MeshStreamWriter writer(file.stream(), file.temporaryPath().parent_path(), options);
///   makeMesh(writer);    // any number of addPoints() and addTriangles()
///   writer.finish();
///   file.commit();
///
/// Where a call throws, the mesh is lost, and so is the stream's content.
/// @throw IoError  from any call: the scratch folder's disk is full, or the stream has failed; its owner knows why
class MeshStreamWriter final : public MeshSink {
 public:
  /// @param stream         is the writer's alone until finish(). Where it can tell its position it is written back at,
  ///                       so it must not be one that always appends
  /// @param scratchFolder  on a disk with room for the mesh, such as the folder that it is written to; empty: the
  ///                       working directory
  /// @throw std::invalid_argument  a voxel size without a box
  /// @throw CreateError            no file can be made in the folder
  MeshStreamWriter(std::ostream& stream, const std::filesystem::path& scratchFolder, const MeshWriteOptions& options);
  ~MeshStreamWriter() override;
  MeshStreamWriter(const MeshStreamWriter&) = delete;
  MeshStreamWriter& operator=(const MeshStreamWriter&) = delete;

  /// @throw DataError         more points than triangles can refer to
  /// @throw std::logic_error  normals that are not one a point, or not in every call
  void addPoints(std::span<const openvdb::Vec3d> points, std::span<const openvdb::Vec3s> normals) override;

  /// @throw std::invalid_argument  an STL of more triangles than it can count
  /// @throw std::logic_error       a triangle uses a point that was not added yet, or one before a firstPoint
  void addTriangles(std::span<const openvdb::Vec3I> triangles, std::uint64_t firstPoint) override;

  /// Completes the file, which is none before. Afterwards the stream stands at its end, and the writer takes no more.
  void finish();

 private:
  struct State;
  std::unique_ptr<State> mState;
};

/// The comments of a PLY or OBJ that was written here; none from any other file.
/// @throw MissingInputError, IoError
std::map<std::string, std::string> readMeshComments(const std::filesystem::path& path);

}  // namespace vdbtools
