// SPDX-License-Identifier: Apache-2.0
#include "mesh_files/mesh_encoder.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/base/text.h"

#include <ostream>
#include <stdexcept>
#include <utility>

namespace vdbtools {
namespace {

/// Whether the box is small compared with its distance from the origin.
bool isFar(const openvdb::BBoxd& box) {
  constexpr double kFar = 4;  // longest sides
  double nearest = 0, longest = 0;
  for (int axis = 0; axis < 3; ++axis) {
    nearest = std::max({nearest, box.min()[axis], -box.max()[axis]});
    longest = std::max(longest, box.extents()[axis]);
  }
  return nearest > kFar * longest;
}

/// Far from the origin doubles cost little compared with what they preserve: otherwise vertices around one node of the
/// lattice would coincide there.
bool areDoublesNeeded(const openvdb::BBoxd& box, double voxelSize) {
  return roundingIn(box) > (isFar(box) ? kFarTolerance : kPositionTolerance) * voxelSize;
}

}  // namespace

double roundingIn(const openvdb::BBoxd& box) {
  double largest = 0;
  for (int axis = 0; axis < 3; ++axis) largest = std::max({largest, -box.min()[axis], box.max()[axis]});
  return largest * std::numeric_limits<float>::epsilon() / 2;
}

MeshPart::MeshPart(std::ostream& stream, std::unique_ptr<ScratchFile> aside)
    : mStream(stream),
      mAside(std::move(aside)),
      mBytes(std::make_unique_for_overwrite<char[]>(kChunkSize + kLongestRecord)) {}

void MeshPart::flush(const char* end) {
  const std::string_view bytes(mBytes.get(), static_cast<std::size_t>(end - mBytes.get()));
  if (mAside)
    mAside->append(bytes);
  else
    mStream.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

void MeshPart::finish() {
  flush(mBytes.get() + mSize);
  mSize = 0;
  if (mAside) mAside->moveTo(mStream);
}

MeshEncoder::MeshEncoder(const MeshWriteOptions& options)
    : mOptions(options), mRowLength(vdbtools::rowLength(options.columns)) {
  constexpr std::size_t kMostValues = 900;
  if (mRowLength > kMostValues)
    throw std::invalid_argument("a mesh file holds up to " + std::to_string(kMostValues) +
                                " numbers a point besides its position, not " + std::to_string(mRowLength));
  if (!(options.voxelSize > 0)) return;
  if (!options.box)
    throw std::invalid_argument("a mesh of voxels of " + shortText(options.voxelSize) +
                                " is to be written without a box; give the box that holds it");
  mDoubles = areDoublesNeeded(*options.box, options.voxelSize);
}

void MeshEncoder::requireCounts(std::uint64_t points, std::uint64_t) const {
  if (points > kMostUint32)
    throw DataError("the mesh has " + std::to_string(points) + " points or more, and triangles can refer to " +
                    std::to_string(kMostUint32) + " of them; use larger voxels, or several boxes");
}

std::uint64_t MeshEncoder::countOf(std::span<const openvdb::Vec3I> triangles, std::span<const openvdb::Vec3d>,
                                   std::uint64_t) const {
  return triangles.size();
}

std::optional<std::size_t> MeshEncoder::offsetOf(ColumnKind kind) const {
  std::size_t offset = 0;
  for (const VertexColumn& column : mOptions.columns) {
    if (column.kind == kind) return offset;
    offset += componentsOf(column.kind);
  }
  return std::nullopt;
}

}  // namespace vdbtools
