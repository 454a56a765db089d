// SPDX-License-Identifier: Apache-2.0
#include "base/openvdb/mesh_to_volume.h"

#include <openvdb/tools/MeshToVolume.h>

namespace vdbtools {
namespace {

int flagsOf(DistanceField kind) {
  switch (kind) {
    case DistanceField::SignedNotRenormalized: return openvdb::tools::DISABLE_RENORMALIZATION;
    case DistanceField::Unsigned: return openvdb::tools::UNSIGNED_DISTANCE_FIELD;
    case DistanceField::Signed: break;
  }
  return 0;
}

}  // namespace

openvdb::FloatGrid::Ptr meshToVolume(const std::vector<openvdb::Vec3d>& points,
                                     const std::vector<openvdb::Vec3I>& triangles, float exteriorBand,
                                     float interiorBand, DistanceField kind, openvdb::Int32Grid* closest,
                                     const Monitor& monitor) {
  // The library's own instantiations read points in single precision, which moves those far from the origin.
  const openvdb::tools::QuadAndTriangleDataAdapter<openvdb::Vec3d, openvdb::Vec3I> adapter(points, triangles);
  OpenVdbInterrupter interrupter(monitor);
  openvdb::FloatGrid::Ptr grid = openvdb::tools::meshToVolume<openvdb::FloatGrid>(
      interrupter, adapter, *openvdb::math::Transform::createLinearTransform(1.0), exteriorBand, interiorBand,
      flagsOf(kind), closest);
  monitor.throwIfCancelled();
  return grid;
}

}  // namespace vdbtools
