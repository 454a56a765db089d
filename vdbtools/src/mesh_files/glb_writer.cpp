// SPDX-License-Identifier: Apache-2.0
#include "mesh_files/glb_layout.h"
#include "mesh_files/mesh_encoder.h"
#include "mesh_files/mesh_formats.h"

#include "decimation/simplify.h"

#include <utility>

namespace vdbtools {
namespace {

using openvdb::Vec3d;
using openvdb::Vec3I;
using openvdb::Vec3s;

/// The centre of the box, as floats if they are close enough to it, because readers of GLB store the position of a node
/// as floats.
Vec3d middleOf(const openvdb::BBoxd& box, double voxelSize) {
  const Vec3d middle = box.getCenter(), rounded{Vec3s(middle)};
  return roundingIn({box.min() - rounded, box.max() - rounded}) > kFarTolerance * voxelSize ? middle : rounded;
}

void encodeGlbTriangles(std::span<const Vec3I> triangles, MeshPart& part) {
  part.add(triangles.size(),
           [triangles](char* to, std::size_t i) { return putVector<std::uint32_t>(to, triangles[i]); });
}

class GlbEncoder final : public MeshEncoder {
 public:
  explicit GlbEncoder(const MeshWriteOptions& options) : MeshEncoder(options) {
    requireGlbColumns(options);
    if (!hasDoubles()) return;
    const openvdb::BBoxd box = options.turn(*options.box);
    mContent.centre =
        middleOf({box.min() * options.scale, box.max() * options.scale}, options.voxelSize * options.scale);
  }

  MeshParts parts() const override { return {.points = true}; }

  void survey(const PointBatch& batch) override {
    for (const Vec3d& point : batch.positions) {
      const Vec3s position(point - mContent.centre);
      if (!mSurveyed) mContent.low = mContent.high = position;
      mSurveyed = true;
      mContent.low = openvdb::math::minComponent(mContent.low, position);
      mContent.high = openvdb::math::maxComponent(mContent.high, position);
      if (!options().levels.empty())
        mPositions.insert(mPositions.end(), position.asPointer(), position.asPointer() + 3);
    }
  }

  void survey(std::span<const Vec3I> triangles) override {
    if (!options().levels.empty()) mTriangles.insert(mTriangles.end(), triangles.begin(), triangles.end());
  }

  void finishSurvey() override {
    for (const double share : options().levels) {
      SimplifiedTriangles level = simplified(mPositions, mTriangles, share);
      mContent.levels.push_back({level.triangles.size(), level.error});
      mLevels.push_back({level.triangles.size(), level.error / options().scale});
      mLevelTriangles.push_back(std::move(level.triangles));
    }
  }

  void requireCounts(std::uint64_t points, std::uint64_t triangles) const override {
    MeshEncoder::requireCounts(points, triangles);
    requireGlbSize(contentOf(points, triangles), options());
  }

  std::string header(std::uint64_t points, std::uint64_t triangles) const override {
    return glbHeader(contentOf(points, triangles), options());
  }

  void encodePoints(const PointBatch& batch, MeshPart& part) const override {
    part.add(batch.positions.size(), [&](char* to, std::size_t i) {
      to = putVector<float>(to, batch.positions[i] - mContent.centre);
      if (hasNormals()) to = putVector<float>(to, batch.normals[i]);
      return rowLength() == 0 ? to : putGlbRow(to, &batch.values[i * rowLength()], options());
    });
  }

  void encodeTriangles(std::span<const Vec3I> triangles, std::span<const Vec3d>, std::uint64_t,
                       MeshPart& part) const override {
    encodeGlbTriangles(triangles, part);
  }

  void encodeEnd(MeshPart& part) const override {
    for (const std::vector<Vec3I>& level : mLevelTriangles) encodeGlbTriangles(level, part);
  }

 private:
  GlbContent contentOf(std::uint64_t points, std::uint64_t triangles) const {
    GlbContent content = mContent;
    content.normals = hasNormals();
    content.points = points;
    content.triangles = triangles;
    return content;
  }

  GlbContent mContent;     ///< in the unit of the file
  bool mSurveyed = false;  ///< whether any point was surveyed
  // For levels of detail.
  std::vector<float> mPositions;
  std::vector<Vec3I> mTriangles;
  std::vector<std::vector<Vec3I>> mLevelTriangles;
};

}  // namespace

std::unique_ptr<MeshEncoder> glbEncoder(const MeshWriteOptions& options) {
  return std::make_unique<GlbEncoder>(options);
}

}  // namespace vdbtools
