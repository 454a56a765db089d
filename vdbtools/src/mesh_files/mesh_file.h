// SPDX-License-Identifier: Apache-2.0
/// @file mesh_file.h
/// Writes a mesh to a file while it is made.
#pragma once

#include "vdbtools/files/atomic_file.h"
#include "vdbtools/mesh_files/mesh_writer.h"

namespace vdbtools {

class MeshFile final : public MeshSink {
 public:
  /// @param file  must outlive this, and must not be committed before finish()
  /// @throw as MeshStreamWriter's constructor; every call throws what the writer throws, with the file's name in an
  ///           IoError
  MeshFile(AtomicFile& file, const MeshWriteOptions& options);

  void addPoints(const PointBatch& batch) override;
  void addTriangles(std::span<const openvdb::Vec3I> triangles, std::uint64_t firstPoint) override;
  void finish();
  /// As MeshStreamWriter::levels().
  const std::vector<MeshLevel>& levels() const { return mWriter.levels(); }

 private:
  AtomicFile& mFile;
  MeshStreamWriter mWriter;
};

}  // namespace vdbtools
