// SPDX-License-Identifier: Apache-2.0
#include "mesh_files/mesh_encoder.h"
#include "mesh_files/mesh_formats.h"
#include "vdbtools/base/units.h"

#include <istream>
#include <sstream>
#include <stdexcept>

namespace vdbtools {
namespace {

using openvdb::Vec3d;
using openvdb::Vec3I;
using openvdb::Vec3s;

constexpr std::size_t kStlTitle = 80;
/// What precedes the unit in the title.
constexpr std::string_view kStlUnit = "JuliaVDB, unit ";

void requireFloatsServe(const openvdb::BBoxd& box, double voxelSize) {
  const double moved = roundingIn(box) / voxelSize;
  if (moved <= kPositionTolerance) return;
  std::ostringstream text;
  text.precision(2);
  text << "STL holds positions as 32-bit floats, which would move vertices of this mesh by up to " << moved
       << " voxels, because its coordinates are so large against the voxels; write .ply, .obj or .glb, or move the "
          "shape nearer to the origin";
  throw std::invalid_argument(text.str());
}

struct StlCorners {
  StlCorners(const Vec3I& triangle, std::span<const Vec3d> points, std::uint64_t firstPoint)
      : a(points[triangle[0] - firstPoint]), b(points[triangle[1] - firstPoint]), c(points[triangle[2] - firstPoint]) {}

  bool collapse() const {
    const Vec3s p(a), q(b), r(c);
    return p == q || q == r || r == p;
  }

  const Vec3d &a, &b, &c;
};

class StlEncoder final : public MeshEncoder {
 public:
  explicit StlEncoder(const MeshWriteOptions& options) : MeshEncoder(options) {
    if (options.voxelSize > 0) requireFloatsServe(*options.box, options.voxelSize);
  }

  MeshParts parts() const override { return {}; }

  /// Triangles with two corners that coincide in 32-bit floats are left out, so the surface stays closed.
  std::uint64_t countOf(std::span<const Vec3I> triangles, std::span<const Vec3d> points,
                        std::uint64_t firstPoint) const override {
    return static_cast<std::uint64_t>(std::count_if(triangles.begin(), triangles.end(), [=](const Vec3I& triangle) {
      return !StlCorners(triangle, points, firstPoint).collapse();
    }));
  }

  void requireCounts(std::uint64_t points, std::uint64_t triangles) const override {
    MeshEncoder::requireCounts(points, triangles);
    if (triangles > kMostUint32)
      throw std::invalid_argument("STL cannot count " + std::to_string(triangles) + " triangles; write a PLY");
  }

  std::string header(std::uint64_t, std::uint64_t triangles) const override {
    std::string header = "JuliaVDB";
    if (const auto unit = options().comments.find(kLengthUnit); unit != options().comments.end())
      header = std::string(kStlUnit) + unit->second;
    header.resize(kStlTitle + sizeof(std::uint32_t), '\0');
    put(header.data() + kStlTitle, static_cast<std::uint32_t>(triangles));
    return header;
  }

  void encodeTriangles(std::span<const Vec3I> triangles, std::span<const Vec3d> points, std::uint64_t firstPoint,
                       MeshPart& part) const override {
    part.add(triangles.size(), [=](char* to, std::size_t i) {
      const StlCorners corners(triangles[i], points, firstPoint);
      if (corners.collapse()) return to;
      const auto& [a, b, c] = corners;
      Vec3d normal = (b - a).cross(c - a);
      const double length = normal.length();
      if (length > 0) normal /= length;
      for (const Vec3d& vector : {normal, a, b, c}) to = putVector<float>(to, vector);
      return put(to, std::uint16_t{0});
    });
  }
};

}  // namespace

std::unique_ptr<MeshEncoder> stlEncoder(const MeshWriteOptions& options) {
  return std::make_unique<StlEncoder>(options);
}

FileTexts stlTexts(std::istream& stream) {
  std::string title(kStlTitle, '\0');
  stream.read(title.data(), kStlTitle);
  if (!title.starts_with(kStlUnit)) return {};
  // The title ends with the first zero.
  return {{kLengthUnit, title.substr(kStlUnit.size(), title.find('\0') - kStlUnit.size())}};
}

}  // namespace vdbtools
