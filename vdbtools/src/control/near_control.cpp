// SPDX-License-Identifier: Apache-2.0
// The distance to another mesh, so that an object placed in the scene acts as a brush.
#include "base/smooth_step.h"
#include "control/control_kinds.h"
#include "control/control_lattice.h"
#include "vdbtools/base/fractal_space.h"
#include "vdbtools/mesh_files/mesh_reader.h"

#include <algorithm>
#include <cmath>

namespace vdbtools {
namespace {

using openvdb::Vec3d;

constexpr const char* kNearForm =
    "near:FILE:DISTANCE:NEAR:FAR, with a mesh whose path has no ':' in it, a distance above 0 as a share of the "
    "target's longest side, and two finite numbers, such as near:brush.obj:0.2:20:300";

/// Changes smoothly from @a near to @a far while the distance grows from 0 to @a reach; constant on either side.
struct Falloff {
  double reach = 1;  ///< world units
  double near = 0, far = 0;

  double operator()(double distance) const {
    const double t = std::clamp(distance / reach, 0.0, 1.0);
    return std::lerp(near, far, smoothStep(t));
  }
  std::pair<double, double> over(std::pair<double, double> distances) const {  // the function is monotonic
    return std::minmax({(*this)(distances.first), (*this)(distances.second)});
  }
};

class NearField final : public ControlField {
 public:
  NearField(std::shared_ptr<const ControlField> distance, const Falloff& falloff)
      : mDistance(std::move(distance)), mFalloff(falloff) {}

  void sample(std::span<const Vec3d> points, std::span<double> values) const override {
    mDistance->sample(points, values);
    for (double& value : values) value = mFalloff(value);
  }
  std::pair<double, double> range() const override { return mFalloff.over(mDistance->range()); }

 private:
  std::shared_ptr<const ControlField> mDistance;
  Falloff mFalloff;
};

/// The points where the rows of a lattice's nodes pass through a surface.
class RowCrossings {
 public:
  /// @param points  in the lattice's index space
  RowCrossings(const ControlLattice& lattice, const std::vector<Vec3d>& points,
               const std::vector<openvdb::Vec3I>& triangles)
      : mLattice(lattice),
        mRows(static_cast<std::size_t>(lattice.size[0]) * static_cast<std::size_t>(lattice.size[1])) {
    for (const openvdb::Vec3I& t : triangles) add(points[t[0]], points[t[1]], points[t[2]]);
    for (std::vector<Crossing>& row : mRows) std::sort(row.begin(), row.end());
  }

  /// Calls inside(node) for the nodes with a non-zero winding number.
  template <class Inside>
  void forEachInside(const Inside& inside) const {
    mLattice.forEachRow([&](int x, int y) {
      const std::vector<Crossing>& row = mRows[rowOf(x, y)];
      std::size_t passed = 0;
      int winding = 0;
      for (int z = 0; z < mLattice.size[2]; ++z) {
        for (; passed < row.size() && row[passed].first <= z; ++passed) winding += row[passed].second;
        if (winding != 0) inside(mLattice.index(x, y, z));
      }
    });
  }

 private:
  using Crossing = std::pair<double, int>;  ///< z, and the direction in which the surface faces there

  std::size_t rowOf(int x, int y) const {
    return static_cast<std::size_t>(x) * static_cast<std::size_t>(mLattice.size[1]) + static_cast<std::size_t>(y);
  }

  /// Whether p lies to the left of the line from a to b, seen along z. For two triangles that share an edge, exactly
  /// one has the point on its side, because the sum is the same for both.
  static bool isLeft(const Vec3d& a, const Vec3d& b, double px, double py) {
    const bool isSorted = std::pair(a[0], a[1]) < std::pair(b[0], b[1]);
    const Vec3d &from = isSorted ? a : b, &to = isSorted ? b : a;
    const double side = (to[0] - from[0]) * (py - from[1]) - (to[1] - from[1]) * (px - from[0]);
    return (side > 0) == isSorted;
  }

  void add(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
    // Rows are shifted slightly from the nodes' rows, because meshes often have their points exactly there.
    constexpr double kBesideX = 1.234e-4, kBesideY = 2.345e-4;
    const auto firstOf = [](double low, double beside) {
      return static_cast<int>(std::ceil(std::clamp(low, 0., 1e6) - beside));  // no lattice is as wide
    };
    const double lowX = std::min({a[0], b[0], c[0]}), highX = std::max({a[0], b[0], c[0]});
    const double lowY = std::min({a[1], b[1], c[1]}), highY = std::max({a[1], b[1], c[1]});
    const double lastX = std::min<double>(highX, mLattice.size[0] - 1),
                 lastY = std::min<double>(highY, mLattice.size[1] - 1);
    const Vec3d normal = (b - a).cross(c - a);
    for (int x = firstOf(lowX, kBesideX); x <= lastX; ++x)
      for (int y = firstOf(lowY, kBesideY); y <= lastY; ++y) {
        const double px = x + kBesideX, py = y + kBesideY;
        const bool left = isLeft(a, b, px, py);
        if (isLeft(b, c, px, py) != left || isLeft(c, a, px, py) != left || normal[2] == 0) continue;
        const double z = a[2] - (normal[0] * (px - a[0]) + normal[1] * (py - a[1])) / normal[2];
        const auto [low, high] = std::minmax({a[2], b[2], c[2]});
        mRows[rowOf(x, y)].emplace_back(std::clamp(z, low, high), left ? 1 : -1);
      }
  }

  const ControlLattice& mLattice;
  std::vector<std::vector<Crossing>> mRows;
};

class NearSource final : public ControlSource {
 public:
  NearSource(NamedFile file, double distance, double near, double far, std::string text)
      : mFile(std::move(file)), mDistance(distance), mNear(near), mFar(far), mText(std::move(text)) {}
  std::string text() const override { return mText; }
  std::vector<NamedFile> files() const override { return {mFile}; }

  Control bind(const ControlContext& context) const override {
    const Mesh brush = readMesh(mFile.path);
    const double reach = mDistance * longestSide(context.targetBox);
    const ControlLattice lattice = controlLattice(context);
    std::vector<Vec3d> points;
    points.reserve(brush.points.size());
    for (const Vec3d& point : brush.points) points.push_back(lattice.toIndex(point));
    std::vector<float> distances = fromSurface(lattice, brush, 0, [](const SurfacePoint&, double*) {}).distance;
    if (reportMesh(weldMesh(brush)).closed())
      RowCrossings(lattice, points, brush.triangles).forEachInside([&](std::size_t node) { distances[node] = 0; });
    return Control(std::make_shared<NearField>(latticeField(lattice, std::move(distances)),
                                               Falloff{.reach = reach, .near = mNear, .far = mFar}));
  }

 private:
  NamedFile mFile;
  double mDistance;  ///< share of the target's longest side
  double mNear, mFar;
  std::string mText;
};

}  // namespace

ControlSourcePtr parseNearControl(const RecipeReader& reader, const std::string& option) {
  const std::string text = reader.text(option);
  const std::optional<std::string> rest = afterPrefix(text, "near:");
  if (!rest) return nullptr;
  const std::vector<std::string> parts = split(*rest, ':');
  if (parts.size() != 4 || parts[0].empty()) reader.refuse(option, kNearForm);
  const std::optional<double> distance = finiteNumber(parts[1]), near = finiteNumber(parts[2]),
                              far = finiteNumber(parts[3]);
  if (!distance || !(*distance > 0) || !near || !far) reader.refuse(option, kNearForm);
  return std::make_shared<NearSource>(reader.file(option, parts[0]), *distance, *near, *far, text);
}

}  // namespace vdbtools
