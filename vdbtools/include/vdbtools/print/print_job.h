// SPDX-License-Identifier: Apache-2.0
/// @file print_job.h
/// The room `print` makes parts for 3D printing. It uses the rooms up to `surface`.
///
/// From a closed mesh to a part that can be printed, as `juliavdb print` makes it: closed, of one or a few pieces,
/// without cavities, with a minimum wall thickness, in millimetres, with z up, standing on z = 0 and centred in x and
/// y.
#pragma once

#include "vdbtools/base/monitor.h"
#include "vdbtools/base/up_axis.h"
#include "vdbtools/mesh/mesh.h"

#include <cstdint>
#include <optional>

namespace vdbtools {

enum class ThinParts { Thicken, Drop };

struct PrintOptions {
  double size = 0;                     ///< the longest side of the part, millimetres, > 0
  std::optional<double> scale;         ///< millimetres a unit of the mesh, for its true size in the place of size
  std::optional<double> minThickness;  ///< millimetres, > 0: nowhere thinner, in the sense of ThinParts
  ThinParts thin = ThinParts::Thicken;
  std::optional<double> flatBase;  ///< millimetres that are cut off below, of the shape as large as the part
  UpAxis up = UpAxis::Y;           ///< which axis of the mesh points up
  std::uint64_t islands = 1;       ///< how many pieces to keep, the largest by volume
  /// Voxels along the longest side, for what is done on a lattice; 0: five to the least thickness, 250 to 600.
  std::uint64_t resolution = 0;
  double tolerance = 0;  ///< millimetres by which larger triangles may move the surface; 0: none are made larger
};

struct PrintedPart {
  Mesh mesh;                        ///< millimetres, without normals
  openvdb::Vec3d extents{0, 0, 0};  ///< millimetres
  double volume = 0;                ///< millimetres cubed
  double scale = 1;                 ///< millimetres a unit of the mesh that was given
  std::uint64_t islands = 0;        ///< that the mesh had
  std::uint64_t kept = 0;
  double droppedShare = 0;       ///< of their volume
  std::uint64_t cavities = 0;    ///< that were filled
  double cavityShare = 0;        ///< their share in the volume of the islands
  std::uint64_t thinPoints = 0;  ///< points of the mesh where it was too thin, before
  double voxelSize = 0;          ///< millimetres; 0: no lattice was used
  double baseArea = 0;           ///< of what stands on z = 0, millimetres squared
  /// What was measured on the finished mesh, with the thickness that was asked for, or 1 mm.
  double thinnest = 0;           ///< the least thickness found, up to twice that, millimetres
  std::uint64_t places = 0;      ///< where it was measured
  std::uint64_t thinPlaces = 0;  ///< of these: where it is less than that, by more than kThicknessRounding
};

/// How exactly a thickness is measured, as a share of it.
inline constexpr double kThicknessRounding = 0.02;

/// The mesh itself if it is closed and @a repair is not asked for; otherwise the surface of its distance field.
/// @param resolution  voxels of that along the longest side; 0: 400
/// @throw DataError, Interrupted  as meshToSdf() and repairedMeshToSdf()
Mesh closedMesh(const Mesh& mesh, std::uint64_t resolution, bool repair, Monitor& monitor);

/// The thickness at a place is the diameter of the largest ball within the part whose centre is no farther from the
/// place than that diameter. Edges and tips of 60 degrees or more, and roughness up to half of it, do not count as
/// thin. ThinParts::Thicken adds balls of the least diameter along what is thinner, so hairs become round wires of that
/// diameter; ThinParts::Drop takes it off. Without a least thickness and a flat base the surface stays that of the
/// mesh.
/// @param mesh  closed, every edge used by two triangles; see reportMesh()
/// @throw std::invalid_argument  options out of their domain
/// @throw DataError              the mesh is not closed, or holds no volume; nothing is left of it
/// @throw Interrupted
PrintedPart printedPart(const Mesh& mesh, const PrintOptions& options, Monitor& monitor);

}  // namespace vdbtools
