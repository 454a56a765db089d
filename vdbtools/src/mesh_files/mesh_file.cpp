// SPDX-License-Identifier: Apache-2.0
#include "mesh_files/mesh_file.h"

#include "vdbtools/base/errors.h"

namespace vdbtools {
namespace {

/// The folder for scratch data of @a file: beside it, or, for a device, the folder for temporary files.
std::filesystem::path scratchFolder(const AtomicFile& file) {
  const std::filesystem::path temporary = file.temporaryPath();
  return temporary.empty() ? std::filesystem::temp_directory_path() : temporary.parent_path();
}

/// The writer only knows that its stream failed; the file knows its name and the reason.
template <class Work>
void guarded(AtomicFile& file, const Work& work) {
  try {
    work();
  } catch (const IoError&) {
    file.finish();
    throw;
  }
}

}  // namespace

MeshFile::MeshFile(AtomicFile& file, const MeshWriteOptions& options)
    : mFile(file), mWriter(file.stream(), scratchFolder(file), options) {}

void MeshFile::addPoints(const PointBatch& batch) {
  guarded(mFile, [&] { mWriter.addPoints(batch); });
}

void MeshFile::addTriangles(std::span<const openvdb::Vec3I> triangles, std::uint64_t firstPoint) {
  guarded(mFile, [&] { mWriter.addTriangles(triangles, firstPoint); });
}

void MeshFile::finish() {
  guarded(mFile, [&] { mWriter.finish(); });
}

}  // namespace vdbtools
