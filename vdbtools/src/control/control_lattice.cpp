// SPDX-License-Identifier: Apache-2.0
#include "control/control_lattice.h"

#include "base/lattice_field.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/base/fractal_space.h"
#include "vdbtools/base/text.h"
#include "vdbtools/control/control.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace vdbtools {
namespace {

using openvdb::Coord;
using openvdb::Vec3d;

/// Nodes along the target's longest side. This is half the default resolution of the target's distances, and
/// independent of their actual resolution, so that a finer target is painted like a coarser one.
constexpr double kResolution = 100;

/// The margin beyond the target's box, as a fraction of its longest side: the shell of detail reaches that far.
constexpr double kMargin = 0.1;

/// The position of a point in the lattice: a cell, and a position in it.
struct Place {
  int before[3];    ///< node
  int behind[3];    ///< node; the same at the lattice's end
  double share[3];  ///< 0..1 between the two
};

Place placeOf(const ControlLattice& lattice, const Vec3d& index) {
  Place place;
  for (int axis = 0; axis < 3; ++axis) {
    const int last = lattice.size[axis] - 1;
    const double at = std::clamp(index[axis], 0.0, static_cast<double>(last));
    place.before[axis] = std::min(static_cast<int>(at), last);
    place.behind[axis] = std::min(place.before[axis] + 1, last);
    place.share[axis] = at - place.before[axis];
  }
  return place;
}

class LatticeField final : public ControlField {
 public:
  LatticeField(const ControlLattice& lattice, std::vector<float> values)
      : mLattice(lattice), mValues(std::move(values)) {
    const auto [low, high] = std::minmax_element(mValues.begin(), mValues.end());
    mRange = {*low, *high};
  }

  void sample(std::span<const Vec3d> points, std::span<double> values) const override {
    for (std::size_t i = 0; i < points.size(); ++i) values[i] = mLattice.read(mValues, mLattice.toIndex(points[i]));
  }
  std::pair<double, double> range() const override { return mRange; }

 private:
  ControlLattice mLattice;
  std::vector<float> mValues;
  std::pair<double, double> mRange;
};

}  // namespace

double ControlLattice::read(std::span<const float> values, const Vec3d& at) const {
  const Place p = placeOf(*this, at);
  const auto value = [&](int x, int y, int z) { return static_cast<double>(values[index(x, y, z)]); };
  // std::lerp stays between its ends, so the bounds of the nodes bound all values.
  const auto row = [&](int x, int y) {
    return std::lerp(value(x, y, p.before[2]), value(x, y, p.behind[2]), p.share[2]);
  };
  const auto plane = [&](int x) { return std::lerp(row(x, p.before[1]), row(x, p.behind[1]), p.share[1]); };
  return std::lerp(plane(p.before[0]), plane(p.behind[0]), p.share[0]);
}

ControlLattice controlLattice(const ControlContext& context) {
  const double longest = longestSide(context.targetBox);
  ControlLattice lattice;
  lattice.voxel = longest / kResolution;
  const Vec3d middle = context.targetBox.getCenter(), sides = context.targetBox.extents();
  for (int axis = 0; axis < 3; ++axis) {
    const int half = static_cast<int>(std::ceil((sides[axis] / 2 + kMargin * longest) / lattice.voxel));
    lattice.size[axis] = 2 * half + 1;
    lattice.first[axis] = middle[axis] - half * lattice.voxel;
  }
  return lattice;
}

void smooth(const ControlLattice& lattice, std::vector<float>& values) {
  const Coord& size = lattice.size;
  for (int axis = 0; axis < 3; ++axis) {
    const std::vector<float> from = values;
    const std::size_t step = axis == 0 ? lattice.index(1, 0, 0) : axis == 1 ? lattice.index(0, 1, 0) : 1;
    lattice.forEachRow([&](int x, int y) {
      for (int z = 0; z < size[2]; ++z) {
        const int along = axis == 0 ? x : axis == 1 ? y : z;
        if (along == 0 || along == size[axis] - 1) continue;
        const std::size_t here = lattice.index(x, y, z);
        values[here] = 0.5F * from[here] + 0.25F * (from[here - step] + from[here + step]);
      }
    });
  }
}

std::shared_ptr<const ControlField> latticeField(const ControlLattice& lattice, std::vector<float> values) {
  return std::make_shared<LatticeField>(lattice, std::move(values));
}

namespace {

/// A lattice with half the resolution, about the same centre, and covering at least the same box.
ControlLattice coarser(const ControlLattice& lattice) {
  ControlLattice result;
  result.voxel = 2 * lattice.voxel;
  for (int axis = 0; axis < 3; ++axis) {
    const int half = lattice.size[axis] / 2, coarseHalf = (half + 1) / 2;
    result.size[axis] = 2 * coarseHalf + 1;
    result.first[axis] = lattice.first[axis] + half * lattice.voxel - coarseHalf * result.voxel;
  }
  return result;
}

/// @param finest  the lattice in whose index space the search takes place
SurfaceValues valuesOn(const ControlLattice& lattice, const ControlLattice& finest, const SurfaceSearch& search,
                       std::size_t kinds, const ReadSurface& read) {
  // A lattice this small is searched as a whole.
  constexpr int kSmall = 12;
  // Values are exact up to this distance, in voxels of the lattice.
  constexpr double kBand = 6;
  const bool isSmall = std::max({lattice.size[0], lattice.size[1], lattice.size[2]}) <= kSmall;
  const ControlLattice coarse = coarser(lattice);
  const SurfaceValues far = isSmall ? SurfaceValues() : valuesOn(coarse, finest, search, kinds, read);
  SurfaceValues result{.distance = std::vector<float>(lattice.count()),
                       .values = std::vector(kinds, std::vector<float>(lattice.count()))};
  lattice.forEachRow([&](int x, int y) {
    std::vector<double> values(kinds);
    std::optional<std::uint32_t> hint;
    for (int z = 0; z < lattice.size[2]; ++z) {
      const std::size_t node = lattice.index(x, y, z);
      const Vec3d world = lattice.world(Vec3d(x, y, z));
      if (!isSmall) {
        const Vec3d at = coarse.toIndex(world);
        const double distance = coarse.read(far.distance, at);
        if (distance > kBand * lattice.voxel) {
          result.distance[node] = static_cast<float>(distance);
          for (std::size_t k = 0; k < kinds; ++k)
            result.values[k][node] = static_cast<float>(coarse.read(far.values[k], at));
          continue;
        }
      }
      const std::optional<SurfacePoint> point =
          search.nearest(finest.toIndex(world), std::numeric_limits<double>::infinity(), hint);
      if (!point) throw DataError("the mesh has no triangle with an area; check the file");
      hint = point->triangle;
      result.distance[node] = static_cast<float>(point->distance * finest.voxel);
      read(*point, values.data());
      for (std::size_t k = 0; k < kinds; ++k) result.values[k][node] = static_cast<float>(values[k]);
    }
  });
  return result;
}

}  // namespace

SurfaceValues fromSurface(const ControlLattice& lattice, const Mesh& mesh, std::size_t kinds, const ReadSurface& read) {
  std::vector<Vec3d> points;
  points.reserve(mesh.points.size());
  for (const Vec3d& point : mesh.points) points.push_back(lattice.toIndex(point));
  return valuesOn(lattice, lattice, SurfaceSearch(std::move(points), mesh.triangles), kinds, read);
}

std::string attributeNames(const Mesh& mesh) {
  return mesh.attributes.empty() ? "none" : joined(mesh.attributes, ", ", &VertexAttribute::name);
}

const VertexAttribute& requireAttribute(const Mesh& mesh, const std::string& name, const std::string& whose) {
  const auto found = std::find_if(mesh.attributes.begin(), mesh.attributes.end(),
                                  [&name](const VertexAttribute& attribute) { return attribute.name == name; });
  if (found == mesh.attributes.end()) {
    throw DataError(whose + " has no vertex attribute '" + name + "'; it has " + attributeNames(mesh) +
                    (mesh.attributes.empty() ? ": paint it, and export it as PLY, or as OBJ with colours" : ""));
  }
  for (const openvdb::Vec3I& triangle : mesh.triangles)
    for (int c = 0; c < 3; ++c)
      if (const float value = found->values[triangle[c]]; !std::isfinite(value)) {
        throw DataError("the vertex attribute '" + name + "' of " + whose + " is " + shortText(value) + " at point " +
                        std::to_string(triangle[c]) + "; every point needs a finite value");
      }
  return *found;
}

std::array<const VertexAttribute*, 3> requireVector(const Mesh& mesh, const std::string& name,
                                                    const std::string& option) {
  const auto isThere = [&](const std::string& wanted) {
    return std::any_of(mesh.attributes.begin(), mesh.attributes.end(),
                       [&](const VertexAttribute& attribute) { return attribute.name == wanted; });
  };
  const std::string stem = name + (isThere(name + "_x") ? "_" : "");
  if (!isThere(stem + 'x') || !isThere(stem + 'y') || !isThere(stem + 'z'))
    throw DataError(option + " needs a vector at each point of the target's mesh, which are the attributes " + name +
                    "_x, " + name + "_y and " + name + "_z; the mesh has " + attributeNames(mesh));
  std::array<const VertexAttribute*, 3> parts{};
  for (std::size_t axis = 0; axis < 3; ++axis)
    parts[axis] = &requireAttribute(mesh, stem + "xyz"[axis], "the target's mesh");
  return parts;
}

void requireUvs(const Mesh& mesh) {
  constexpr const char* kWayOut = "; unwrap it, and export it as OBJ or PLY with its texture coordinates";
  if (mesh.cornerUvs.empty()) throw DataError(std::string("the target's mesh has no texture coordinates") + kWayOut);
  const auto isMissing = [](const openvdb::Vec2s& uv) { return !std::isfinite(uv[0]) || !std::isfinite(uv[1]); };
  const auto missing = std::count_if(mesh.cornerUvs.begin(), mesh.cornerUvs.end(), isMissing);
  if (missing > 0)
    throw DataError("the target's mesh has no texture coordinates at " + std::to_string(missing) + " of the " +
                    std::to_string(mesh.cornerUvs.size()) + " corners of its triangles" + kWayOut);
}

std::vector<std::vector<float>> extended(const ControlLattice& lattice, const Mesh& mesh,
                                         std::span<const VertexAttribute* const> attributes) {
  return fromSurface(lattice, mesh, attributes.size(),
                     [&](const SurfacePoint& point, double* values) {
                       const openvdb::Vec3I& t = mesh.triangles[point.triangle];
                       for (std::size_t a = 0; a < attributes.size(); ++a) {
                         const std::vector<float>& of = attributes[a]->values;
                         // This form keeps a value that is equal at all corners unchanged.
                         values[a] = of[t[0]] + point.weights[1] * (double{of[t[1]]} - of[t[0]]) +
                                     point.weights[2] * (double{of[t[2]]} - of[t[0]]);
                       }
                     })
      .values;
}

std::optional<std::string> afterPrefix(const std::string& text, const std::string& prefix) {
  return text.starts_with(prefix) ? std::optional(text.substr(prefix.size())) : std::nullopt;
}

std::optional<double> finiteNumber(const std::string& text) {
  const std::optional<double> value = numberFromText(text);
  return value && std::isfinite(*value) ? value : std::nullopt;
}

using openvdb::FloatGrid;

ControlGrid controlGrid(const Control& control, const ControlContext& context, const FractalSpace& space) {
  const ControlLattice lattice = controlLattice(context);
  const Coord last = lattice.size - Coord(1);
  ControlGrid result{FloatGrid::create()};
  const openvdb::math::Transform::Ptr transform =
      openvdb::math::Transform::createLinearTransform(lattice.voxel / space.scale);
  transform->postTranslate(Vec3d(space.toFractal(lattice.first).data()));
  result.grid->setTransform(transform);
  if (const std::optional<double> value = control.constant()) {
    result.grid->tree().fill(openvdb::CoordBBox(Coord(0), last), static_cast<float>(*value), true);
    return result;
  }
  std::vector<float> values(lattice.count());
  lattice.forEachRow([&](int x, int y) {
    const auto count = static_cast<std::size_t>(lattice.size[2]);
    std::vector<Vec3d> points(count);
    std::vector<double> row(count);
    for (int z = 0; z < lattice.size[2]; ++z) points[static_cast<std::size_t>(z)] = lattice.world(Vec3d(x, y, z));
    control.sample(points, row);
    for (int z = 0; z < lattice.size[2]; ++z)
      values[lattice.index(x, y, z)] = static_cast<float>(row[static_cast<std::size_t>(z)]);
  });
  FloatGrid::Accessor accessor = result.grid->getAccessor();
  for (int x = 0; x < lattice.size[0]; ++x)
    for (int y = 0; y < lattice.size[1]; ++y)
      for (int z = 0; z < lattice.size[2]; ++z) accessor.setValueOn({x, y, z}, values[lattice.index(x, y, z)]);
  return result;
}

template <class Real>
std::shared_ptr<const julia::ScalarField<Real>> makeControlField(const ControlGrid& grid) {
  return makeLatticeField<Real>(*grid.grid, grid.grid->evalActiveVoxelBoundingBox(), grid.space,
                                julia::Interpolation::Trilinear);
}

template std::shared_ptr<const julia::ScalarField<float>> makeControlField(const ControlGrid&);
template std::shared_ptr<const julia::ScalarField<double>> makeControlField(const ControlGrid&);

}  // namespace vdbtools
