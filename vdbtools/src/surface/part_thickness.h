// SPDX-License-Identifier: Apache-2.0
/// @file part_thickness.h
/// The thickness of a solid for manufacturing. At a point of its surface a solid is at least t thick if it contains a
/// ball of diameter t whose centre is at most t from the point. Flat walls, hairs and necks have the expected
/// thickness. Roughness, and edges and tips of 60 degrees or more, do not count as thin, because they protrude from
/// such a ball by at most t / 2.
///
/// A node of a lattice of distances that lies below the point, and is deep enough, is the centre of such a ball; that
/// decides most places. Otherwise a search from the surface inward finds balls, in exact distances to the triangles. If
/// it fails, as it may at corners, the deepest node of a nearby lattice tells where to search, or proves that there is
/// no such ball: a centre has a node within half the diagonal of a voxel, and that node is less deep by at most that
/// distance. Every ball that is found exists, but a ball may occasionally be missed, so thicknesses are never
/// overestimated.
#pragma once

#include "search/triangle_tree.h"
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

/// Many threads may use it at once.
class PartThickness {
 public:
  /// @param mesh       closed, with a triangle and normals, at most a few thousand millimetres wide
  /// @param thickness  the thickness for which isThick() must be reliable
  /// @param floor      the solid ends there: nothing is below this z
  /// Keeps a reference to the mesh's triangles.
  PartThickness(const Mesh& mesh, double thickness, std::optional<double> floor, Monitor& monitor);

  /// Finds the largest ball within the solid whose centre is at most @a reach from @a point. The search ends as soon as
  /// the radius is @a enough.
  /// @param point   on the surface
  /// @param normal  of unit length, outward
  InnerBall ballNear(const openvdb::Vec3d& point, const openvdb::Vec3d& normal, double reach, double enough) const;

  /// As ballNear(), but begins at the deepest node of the lattice, if one is inside.
  InnerBall deepestBall(const openvdb::Vec3d& point, const openvdb::Vec3d& normal, double reach, double enough) const;

  /// Whether the solid is at least this thick at a place.
  bool isThick(const openvdb::Vec3d& point, const openvdb::Vec3d& normal, double thickness) const;

 private:
  struct Depth {
    double distance;
    openvdb::Vec3d nearest;  ///< on the surface or on the floor
  };
  Depth depthAt(const openvdb::Vec3d& p) const;
  /// Whether a node below the point is the centre of a ball of this radius.
  bool hasDeepNode(const openvdb::Vec3d& point, const openvdb::Vec3d& normal, double radius) const;
  /// Finds the largest ball reachable from a position inside by steps away from the surface.
  InnerBall climbed(InnerBall best, openvdb::Vec3d nearest, const openvdb::Vec3d& point, double reach,
                    double enough) const;
  /// The deepest node within @a reach of the point; its depth is read from the lattice, and bounded.
  InnerBall deepestNode(const openvdb::Vec3d& point, double reach) const;
  InnerBall climbedFrom(const InnerBall& node, const openvdb::Vec3d& point, double reach, double enough) const;

  double mThickness;
  std::optional<double> mFloor;
  double mVoxel;                        ///< of the lattice
  std::vector<openvdb::Vec3d> mPoints;  ///< in voxels
  TriangleTree mTree;
  openvdb::FloatGrid::ConstPtr mDistances;  ///< inside, to more than half the thickness
};

/// The thinnest places of a solid.
struct ThinPlaces {
  std::size_t places = 0;  ///< number of points of the mesh that were examined
  std::size_t thin = 0;    ///< number of these that are thinner than requested, by more than the rounding
  /// The minimum thickness found, in steps of 5 % and of the rounding; at most twice the requested one.
  double thinnest = 0;
};

/// Examines the points of a mesh: all of them, or @a most that are spread over them.
/// @param mesh      closed, with normals
/// @param rounding  relative accuracy of the measured thickness
ThinPlaces findThinPlaces(const Mesh& mesh, double thickness, double rounding, std::size_t most, Monitor& monitor);

}  // namespace vdbtools
