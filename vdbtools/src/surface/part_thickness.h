// SPDX-License-Identifier: Apache-2.0
/// @file part_thickness.h
/// How thick a solid is, as far as a maker is concerned. At a place of its surface a solid is at least t thick if it
/// holds a ball of the diameter t whose centre is no farther than t from the place. Flat walls, hairs and necks have
/// the thickness that one expects. Roughness, and edges and tips of 60 degrees or more, do not count as thin, as they
/// stand out from such a ball by no more than t / 2.
///
/// Balls are found by a search from the surface inward, in exact distances to the triangles. Where that fails, as it
/// may at corners, the deepest node of a lattice nearby tells where to search, or that there is no such ball: a centre
/// has a node within half the diagonal of a voxel, and that node is less deep by no more than that. A ball that was
/// found is there; one that exists may seldom be missed, so thicknesses are never too large.
#pragma once

#include "search/surface_search.h"
#include "vdbtools/base/grids.h"
#include "vdbtools/base/monitor.h"
#include "vdbtools/mesh/mesh.h"

#include <optional>
#include <vector>

namespace vdbtools {

struct InnerBall {
  openvdb::Vec3d centre{0, 0, 0};
  double radius = 0;
};

/// May be used in many threads at once.
class PartThickness {
 public:
  /// @param mesh       closed, with normals, at most some thousand millimetres wide
  /// @param thickness  the one that isThick() is to be sure of
  /// @param floor      the solid ends there: nothing of it is below this z
  PartThickness(const Mesh& mesh, double thickness, std::optional<double> floor, Monitor& monitor);

  /// The largest ball that is found within the solid, with its centre no farther than @a reach from @a point. The
  /// search ends as soon as the radius is @a enough.
  /// @param point   on the surface
  /// @param normal  of unit length, outward
  InnerBall ballNear(const openvdb::Vec3d& point, const openvdb::Vec3d& normal, double reach, double enough) const;

  /// The same, where the deepest node of the lattice is tried as well.
  InnerBall deepestBall(const openvdb::Vec3d& point, const openvdb::Vec3d& normal, double reach, double enough) const;

  /// Whether the solid is at least this thick at a place.
  bool isThick(const openvdb::Vec3d& point, const openvdb::Vec3d& normal, double thickness) const;

 private:
  struct Depth {
    double distance;
    openvdb::Vec3d nearest;  ///< on the surface or on the floor
  };
  Depth depthAt(const openvdb::Vec3d& p) const;
  /// The largest ball that is found from a place inside on, by steps away from the surface.
  InnerBall climbed(InnerBall best, openvdb::Vec3d nearest, const openvdb::Vec3d& point, double reach,
                    double enough) const;
  /// The deepest node within @a reach of the point; its depth is that of the lattice, and bounded.
  InnerBall deepestNode(const openvdb::Vec3d& point, double reach) const;
  InnerBall climbedFrom(const InnerBall& node, const openvdb::Vec3d& point, double reach, double enough) const;

  const Mesh& mMesh;
  double mThickness;
  std::optional<double> mFloor;
  SurfaceSearch mSearch;
  openvdb::FloatGrid::ConstPtr mDistances;  ///< inside, to more than half the thickness
};

/// The thinnest places of a solid.
struct ThinPlaces {
  std::size_t places = 0;  ///< the points of the mesh that were looked at
  std::size_t thin = 0;    ///< of them: those less thick than was asked for, by more than the rounding
  /// The least thickness that was found, in steps of 5 % and of the rounding; no more than twice what was asked for.
  double thinnest = 0;
};

/// Looks at the points of a mesh, at all of them or at @a most that are spread over them.
/// @param mesh      closed, with normals
/// @param rounding  how exactly a thickness is measured, as a share of it
ThinPlaces findThinPlaces(const Mesh& mesh, double thickness, double rounding, std::size_t most, Monitor& monitor);

}  // namespace vdbtools
