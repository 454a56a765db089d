// SPDX-License-Identifier: Apache-2.0
/// @file mesh_file.h
/// A mesh that is written to an output while it is made.
#pragma once

#include "output.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/mesh/mesh_writer.h"

namespace cli {

class MeshFile final : public vdbtools::MeshSink {
 public:
  MeshFile(vdbtools::AtomicFile& file, const vdbtools::MeshWriteOptions& options)
      : mFile(file), mWriter(file.stream(), scratchFolder(file), options) {}

  void addPoints(std::span<const openvdb::Vec3d> points, std::span<const openvdb::Vec3s> normals) override {
    guarded([&] { mWriter.addPoints(points, normals); });
  }
  void addTriangles(std::span<const openvdb::Vec3I> triangles, std::uint64_t firstPoint) override {
    guarded([&] { mWriter.addTriangles(triangles, firstPoint); });
  }
  /// @throw vdbtools::IoError naming the file
  void finish() {
    guarded([&] { mWriter.finish(); });
  }

 private:
  /// The writer knows only that its stream failed; the file knows its name and why.
  template <class Work>
  void guarded(const Work& work) {
    try {
      work();
    } catch (const vdbtools::IoError&) {
      mFile.finish();
      throw;
    }
  }

  vdbtools::AtomicFile& mFile;
  vdbtools::MeshStreamWriter mWriter;
};

}  // namespace cli
