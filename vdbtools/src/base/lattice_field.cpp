// SPDX-License-Identifier: Apache-2.0
#include "base/lattice_field.h"

#include "base/affine_columns.h"
#include "base/grid_sampler.h"

#include "julia/brick_field.h"

namespace vdbtools {

using openvdb::Vec3d;

template <class Real>
std::shared_ptr<const julia::ScalarField<Real>> makeLatticeField(const openvdb::FloatGrid& grid,
                                                                 const openvdb::CoordBBox& nodes,
                                                                 const FractalSpace& space,
                                                                 julia::Interpolation interpolation,
                                                                 const julia::Knee& knee) {
  const GridBricks made = makeBricks(grid, nodes, interpolation);
  const auto [zero, columns] = affineColumns([&](const Vec3d& x) {
    return grid.worldToIndex(space.toWorld({x[0], x[1], x[2]})) - made.origin.asVec3d();
  });
  julia::BrickPlacement placement{.knee = knee};
  for (int row = 0; row < 3; ++row) {
    const auto r = static_cast<std::size_t>(row);
    for (std::size_t column = 0; column < 3; ++column) placement.matrix[r][column] = columns[column][row];
    placement.offset[r] = zero[row];
    placement.low[r] = nodes.min()[row] - made.origin[row];
    placement.high[r] = nodes.max()[row] - made.origin[row];
  }
  return std::make_shared<julia::BrickField<Real>>(made.bricks, placement);
}

template std::shared_ptr<const julia::ScalarField<float>> makeLatticeField(const openvdb::FloatGrid&,
                                                                           const openvdb::CoordBBox&,
                                                                           const FractalSpace&, julia::Interpolation,
                                                                           const julia::Knee&);
template std::shared_ptr<const julia::ScalarField<double>> makeLatticeField(const openvdb::FloatGrid&,
                                                                            const openvdb::CoordBBox&,
                                                                            const FractalSpace&, julia::Interpolation,
                                                                            const julia::Knee&);

}  // namespace vdbtools
