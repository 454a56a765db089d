// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/control/control.h"

#include "base/lattice_field.h"
#include "control/control_lattice.h"

#include <vector>

namespace vdbtools {

using openvdb::Coord;
using openvdb::FloatGrid;
using openvdb::Vec3d;

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
