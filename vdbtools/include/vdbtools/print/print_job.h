// SPDX-License-Identifier: Apache-2.0
/// @file print_job.h
/// The room `print` makes parts for 3D printing. It uses the rooms up to `surface`.
///
/// This header makes a part that can be printed from a closed mesh, as `juliavdb print` does: closed, of one or a few
/// pieces, without cavities, with a minimum wall thickness, in millimetres, with z up, standing on z = 0 and centred in
/// x and y.
#pragma once

#include "vdbtools/base/monitor.h"
#include "vdbtools/base/units.h"
#include "vdbtools/mesh/mesh.h"

#include <cstddef>
#include <cstdint>
#include <optional>

namespace vdbtools {

enum class ThinParts { Thicken, Drop };

struct PrintOptions {
  double size = 0;                     ///< the longest side of the part, millimetres, > 0
  std::optional<double> scale;         ///< millimetres per unit of the mesh, to print its true size; replaces size
  std::optional<double> minThickness;  ///< millimetres, > 0: nowhere thinner, in the sense of ThinParts
  ThinParts thin = ThinParts::Thicken;
  std::optional<double> flatBase;  ///< how much is cut off at the bottom, millimetres of the shape in the part's size
  UpAxis up = UpAxis::Y;           ///< which axis of the mesh points up
  std::uint64_t islands = 1;       ///< how many pieces to keep, the largest by volume
  /// Voxels along the longest side, for the steps that use a lattice; 0: five across the minimum thickness, but 250 to
  /// 600.
  std::uint64_t resolution = 0;
  double tolerance = 0;  ///< how far larger triangles may move the surface, millimetres; 0: no triangles are enlarged
};

struct PrintedPart {
  Mesh mesh;                        ///< millimetres, without normals
  openvdb::Vec3d extents{0, 0, 0};  ///< millimetres
  double volume = 0;                ///< millimetres cubed
  double scale = 1;                 ///< millimetres per unit of the given mesh
  std::uint64_t islands = 0;        ///< number of islands of the given mesh
  std::uint64_t keptIslands = 0;
  double droppedShare = 0;       ///< the dropped share of their volume
  std::uint64_t cavities = 0;    ///< number of cavities that were filled
  double cavityShare = 0;        ///< their share in the volume of the islands
  std::uint64_t thinPoints = 0;  ///< points of the given mesh where it was too thin
  double voxelSize = 0;          ///< millimetres; 0: no lattice was used
  double baseArea = 0;           ///< area that stands on z = 0, millimetres squared
  /// Set if the base is smaller than a part of this size should have (enoughBase()).
  bool smallBase = false;
  std::optional<double> betterBase;  ///< the flatBase that makes it large enough, if one up to half of the height does
  /// Measurements of the finished mesh, relative to the requested minimum thickness, or to 1 mm without one.
  double thinnest = 0;           ///< the smallest thickness found, up to twice that minimum, millimetres
  std::uint64_t places = 0;      ///< number of places where it was measured
  std::uint64_t thinPlaces = 0;  ///< number of places where it is below the minimum by more than kThicknessRounding
};

/// The least area on which a part should stand: a hundredth of the rectangle about it, and for a slender one the square
/// of a twentieth of its height. A rule of thumb.
double enoughBase(const openvdb::Vec3d& extents);

/// The relative error of a measured thickness.
inline constexpr double kThicknessRounding = 0.02;

/// Makes one closed surface of a mesh. A closed mesh, with @a repair false, keeps its points and triangles; parts of it
/// that are inside out are turned. A mesh that is not closed, or whose closed parts run into each other, becomes the
/// surface of its distance field, in which these are one.
/// @param resolution  voxels of that field along the longest side; 0: 400
/// @param united      if not null, receives the number of closed parts that were made one
/// @throw DataError, Interrupted  as meshToSdf() and repairedMeshToSdf()
Mesh closedMesh(const Mesh& mesh, std::uint64_t resolution, bool repair, Monitor& monitor,
                std::size_t* united = nullptr);

/// The thickness at a place is the diameter of the largest ball within the part whose centre is no farther from the
/// place than that diameter. Edges and tips of 60 degrees or more, and roughness up to half of the minimum thickness,
/// do not count as thin. ThinParts::Thicken adds balls of the minimum diameter along thinner parts, so hairs become
/// round wires of that diameter; ThinParts::Drop removes thinner parts. Without a minimum thickness and a flat base the
/// surface of the mesh does not change.
/// @param mesh  closed, every edge used by two triangles; see reportMesh()
/// @throw std::invalid_argument  options out of their domain
/// the mesh is not closed, or encloses no volume; or nothing is left of it
/// @throw Interrupted
PrintedPart printedPart(const Mesh& mesh, const PrintOptions& options, Monitor& monitor);

}  // namespace vdbtools
