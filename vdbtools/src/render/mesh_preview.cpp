// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/render/preview.h"

#include "base/srgb.h"
#include "render/preview_renderer.h"
#include "render/ray_tree.h"

#include "vdbtools/base/errors.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

namespace vdbtools {
namespace {

using openvdb::Vec3d;
using openvdb::Vec3I;
using openvdb::Vec3s;

/// Normals are averaged over triangles whose angle has at least this cosine: 60 degrees.
constexpr double kSmooth = 0.5;
/// At points with more triangles, such as the centre of a large fan, normals are not averaged.
constexpr std::uint64_t kMostAveraged = 256;
/// The offset of secondary rays from the surface that they leave, in radii of the mesh.
constexpr double kLeave = 1e-5;
/// The albedo of a full colour channel; a larger one would leave no range for the lights.
constexpr double kBrightest = 0.85;

/// The mesh scaled to the unit ball about the origin, and the triangles at each of its points.
class MeshStage {
 public:
  MeshStage(Mesh mesh, bool colours, Monitor& monitor) : mMesh(std::move(mesh)) {
    frame();
    listTriangles();
    if (colours) findColours();
    mTree.emplace(mPoints, mMesh.triangles, monitor);
  }

  FramedBall ball() const { return {mCentre, mRadius}; }
  Vec3d place(const Vec3d& world) const { return (world - mCentre) / mRadius; }
  const RayTree& tree() const { return *mTree; }
  /// The minimum dot product of a direction with the mesh's points.
  double lowestAlong(const Vec3d& direction) const {
    double least = std::numeric_limits<double>::infinity();
    for (const Vec3I& triangle : mMesh.triangles)
      for (int i = 0; i < 3; ++i) least = std::min(least, placed(triangle[i]).dot(direction));
    return least;
  }

  /// @param direction  the direction of the ray
  HitPoint pointOf(const RayTree::Hit& hit, const Vec3d& eye, const Vec3d& direction) const {
    const Vec3I& corners = mMesh.triangles[hit.triangle];
    const std::array<double, 3> weights{1 - hit.u - hit.v, hit.u, hit.v};
    const Vec3d position = eye + hit.distance * direction;
    Vec3d flat = crossOf(hit.triangle);
    if (!flat.normalize()) flat = -direction;
    if (flat.dot(direction) > 0) flat = -flat;

    Vec3d normal(0), bulge(0);
    for (int i = 0; i < 3; ++i) {
      const double weight = weights[static_cast<std::size_t>(i)];
      const Vec3d atCorner = averaged(corners[i], flat);
      normal += weight * atCorner;
      // The shadows of a coarse mesh end where those of its smooth surface would (J. Hanika, "Hacking the shadow
      // terminator", 2021): rays leave from the planes perpendicular to the normals at the corners.
      bulge += weight * std::min(0.0, (position - placed(corners[i])).dot(atCorner)) * -atCorner;
    }
    if (!normal.normalize()) normal = flat;
    // The normal must face the eye even near an outline, where the average may face away.
    constexpr double kGrazing = 1e-3;
    if (const double away = normal.dot(direction); away > -kGrazing)
      normal = (normal - (away + kGrazing) * direction).unit();
    return {hit.distance, position + bulge + kLeave * flat, normal, albedo(corners, weights)};
  }

 private:
  Vec3d placed(std::uint32_t point) const { return Vec3d(mPoints[point]); }

  void frame() {
    openvdb::BBoxd box;
    for (const Vec3I& triangle : mMesh.triangles) {
      for (int i = 0; i < 3; ++i) {
        if (triangle[i] >= mMesh.points.size())
          throw DataError("the mesh has a triangle with the point " + std::to_string(triangle[i]) + " of " +
                          std::to_string(mMesh.points.size()));
        const Vec3d& point = mMesh.points[triangle[i]];
        if (!point.isFinite()) throw DataError("the mesh has a coordinate that is not finite");
        box.expand(point);
      }
    }
    if (mMesh.triangles.empty()) throw DataError("the mesh has no triangle to show");
    mCentre = box.getCenter();
    // Scaled by the longest side first, so that no square overflows or underflows.
    const double side = box.extents()[box.maxExtent()];
    if (!(side > 0) || !std::isfinite(side)) throw DataError("the mesh has no extent to show: all its points are one");
    double largest = 0;
    for (const Vec3I& triangle : mMesh.triangles)
      for (int i = 0; i < 3; ++i)
        largest = std::max(largest, ((mMesh.points[triangle[i]] - mCentre) / side).lengthSqr());
    mRadius = side * std::sqrt(largest);
    mPoints.resize(mMesh.points.size());
    tbb::parallel_for(std::size_t(0), mPoints.size(),
                      [&](std::size_t i) { mPoints[i] = Vec3s((mMesh.points[i] - mCentre) / mRadius); });
    mMesh.points = {};
  }

  /// Lists the triangles at each point, point by point.
  void listTriangles() {
    mFirst.assign(mPoints.size() + 1, 0);
    for (const Vec3I& triangle : mMesh.triangles)
      for (int i = 0; i < 3; ++i) ++mFirst[triangle[i] + 1];
    for (std::size_t i = 1; i < mFirst.size(); ++i) mFirst[i] += mFirst[i - 1];
    mAt.resize(mFirst.back());
    std::vector<std::uint64_t> next(mFirst.begin(), mFirst.end() - 1);
    for (std::uint32_t t = 0; t < mMesh.triangles.size(); ++t)
      for (int i = 0; i < 3; ++i) mAt[next[mMesh.triangles[t][i]]++] = t;
  }

  void findColours() {
    std::array<const VertexAttribute*, 3> found{};
    for (const VertexAttribute& attribute : mMesh.attributes) {
      constexpr const char* kChannels[] = {"red", "green", "blue"};
      for (std::size_t i = 0; i < 3; ++i)
        if (attribute.name == kChannels[i] && attribute.values.size() == mPoints.size()) found[i] = &attribute;
    }
    if (found[0] && found[1] && found[2]) mChannels = found;
  }

  Vec3d crossOf(std::uint32_t triangle) const {
    const Vec3I& t = mMesh.triangles[triangle];
    const Vec3d a = placed(t[0]);
    return (placed(t[1]) - a).cross(placed(t[2]) - a);
  }

  /// The area-weighted normal at a point over those triangles that differ little from one with a given normal, turned
  /// to its side, of length 1.
  Vec3d averaged(std::uint32_t point, const Vec3d& flat) const {
    if (mFirst[point + 1] - mFirst[point] > kMostAveraged) return flat;
    Vec3d sum(0);
    for (std::uint64_t i = mFirst[point]; i < mFirst[point + 1]; ++i) {
      const Vec3d cross = crossOf(mAt[i]);
      const double along = cross.dot(flat), least = kSmooth * cross.length();
      if (along > least) sum += cross;
      if (-along > least) sum -= cross;
    }
    return sum.normalize() ? sum : flat;
  }

  std::optional<Vec3d> albedo(const Vec3I& corners, const std::array<double, 3>& weights) const {
    if (!mChannels[0]) return std::nullopt;
    Vec3d colour(0);
    for (int i = 0; i < 3; ++i) {
      Vec3d linear;
      for (int channel = 0; channel < 3; ++channel) {
        const auto value = static_cast<double>(mChannels[static_cast<std::size_t>(channel)]->values[corners[i]]);
        if (!std::isfinite(value)) return std::nullopt;
        linear[channel] = linearFromSrgb(std::clamp(value, 0.0, 1.0));
      }
      colour += weights[static_cast<std::size_t>(i)] * linear;
    }
    return kBrightest * colour;
  }

  Mesh mMesh;  ///< without its points
  Vec3d mCentre;
  double mRadius = 1;
  std::vector<Vec3s> mPoints;
  std::vector<std::uint64_t> mFirst;  ///< first entry in mAt for each point
  std::vector<std::uint32_t> mAt;
  std::array<const VertexAttribute*, 3> mChannels{};
  std::optional<RayTree> mTree;
};

class MeshSurface {
 public:
  explicit MeshSurface(const MeshStage& stage) : mStage(stage) {}

  std::optional<HitPoint> firstHit(const Vec3d& eye, const Vec3d& direction) const {
    const std::optional<RayTree::Hit> hit = mStage.tree().firstHit(eye, direction);
    return hit ? std::optional(mStage.pointOf(*hit, eye, direction)) : std::nullopt;
  }
  bool blocked(const Vec3d& origin, const Vec3d& direction) const { return mStage.tree().blocked(origin, direction); }

 private:
  const MeshStage& mStage;
};

/// Whether the triangles share so few points that they must be welded before normals can be averaged.
bool isSoup(const Mesh& mesh) { return mesh.points.size() > mesh.triangles.size() + mesh.triangles.size() / 2; }

}  // namespace

ShadedImage renderMeshPreview(Mesh mesh, const MeshPreviewOptions& options, Monitor& monitor) {
  const PreviewOptions& picture = options.picture;
  const PixelSamples samples(picture.width, picture.height, picture.samples);
  requireAngles(picture.view);
  monitor.throwIfCancelled();
  if (isSoup(mesh)) {
    Mesh welded = weldMesh(mesh);
    if (!welded.triangles.empty()) mesh = std::move(welded);
  }
  const MeshStage surface(std::move(mesh), options.colours, monitor);
  monitor.throwIfCancelled();

  std::vector<PreviewBall> balls = picture.balls;
  for (PreviewBall& ball : balls) {
    requireOption(ball.radius > 0, "the radius of a ball", ball.radius, "above 0");
    ball.centre = surface.place(ball.centre);
    ball.radius /= surface.ball().radius;
  }
  const auto [camera, sky] = cameraAndSky(picture, surface.ball(), samples.aspect());
  PreviewStage stage = previewStage(
      camera, picture.look, sky, samples.aspect(), surface.ball(),
      [&](const Vec3d& point) { return surface.place(point); },
      [](const Vec3d& direction) { return direction.unit(); });
  if (picture.look.ground) stage.floor = surface.lowestAlong(stage.sky);
  return renderStage(
      stage, picture, samples, balls, [&] { return MeshSurface(surface); }, monitor);
}

}  // namespace vdbtools
