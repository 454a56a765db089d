// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/distance/mesh_to_sdf.h"

#include "distance/hole_caps.h"
#include "distance/mesh_conversion.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/base/text.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace vdbtools {
namespace {

/// Enough to measure a fraction to half a per cent.
constexpr std::size_t kSamples = 20000;

/// This fraction of an open mesh may bound nothing, e.g. an eyelash on a head. More is a leak.
constexpr double kMostLostOpen = 0.05;

/// A closed mesh cannot leak, but it may be thinner than a voxel in places, because the grid is coarse. It must not be
/// so in most places.
constexpr double kMostLostClosed = 0.5;

/// A part that several closed surfaces cover counts several times in the mesh's own volume, but only once in the grid.
constexpr double kMostCover = 4;

/// A sheet on the lattice's own nodes is inside by rounding. A real inside is at least this deep somewhere, in voxels.
constexpr double kLeastDepth = 0.01;

double deepest(const openvdb::FloatGrid& grid) {
  float least = 0;
  for (auto value = grid.cbeginValueAll(); value; ++value) least = std::min(least, *value);
  return -least;
}

std::string percent(double share) {
  char text[16];
  std::snprintf(text, sizeof(text), "%.3g %%", 100 * share);
  return text;
}

/// Throws if @a grid is not the mesh's distance field.
///
/// Volumes: each node stands for h^3. A cell of that volume can be counted wrongly only if the surface crosses it, so
/// all its points lie within sqrt(3) h of the surface, half of them on the wrong side. Hence the volume of the nodes
/// inside differs from the mesh's by at most sqrt(3) h times the area (and the h^2, h^3 terms of Steiner's formula,
/// which matter where the curvature exceeds 1/h: there the feature is thinner than a voxel and may vanish altogether).
void requireDistances(const openvdb::FloatGrid& grid, const Mesh& mesh, const std::vector<openvdb::Vec3d>& indexPoints,
                      const MeshReport& report) {
  const double h = grid.voxelSize()[0];
  const double inside = insideNodes(grid) * h * h * h;
  const double lost = lostShare(grid, sampleSurface(indexPoints, mesh.triangles, kSamples));
  const bool closed = report.closed();
  const bool tooSmall = inside < (std::abs(report.volume) - std::sqrt(3.0) * h * report.area) / kMostCover;
  const bool sheet = !(deepest(grid) > kLeastDepth * h);
  if (inside > 0 && !sheet && lost <= (closed ? kMostLostClosed : kMostLostOpen) && !(closed && tooSmall)) return;
  const std::string numbers = "(" + std::to_string(report.openEdges) + " open edges, " +
                              std::to_string(report.nonManifoldEdges) + " non-manifold edges, inside volume " +
                              shortText(inside) + " against the mesh's " + shortText(std::abs(report.volume)) + ", " +
                              percent(lost) + " of the surface bounds nothing)";
  if (closed) {
    throw DataError("the mesh has no inside, or only a part of it, at the voxel size " + shortText(h) + " " + numbers +
                    ": its features are thinner than a voxel; use finer voxels");
  }
  if (isOneSheet(weldMesh(mesh)))
    throw DataError("the mesh is an open sheet, and bounds nothing at the voxel size " + shortText(h) + " " + numbers +
                        ": it has to be given a thickness",
                    Remedy::SolidifySheet);
  throw DataError("the mesh leaks at the voxel size " + shortText(h) + " " + numbers +
                      ": its holes must be closed, or spanned by coarser voxels",
                  Remedy::RepairMesh);
}

}  // namespace

openvdb::FloatGrid::Ptr meshToSdf(const Mesh& mesh, const MeshToSdfOptions& options, Monitor& monitor,
                                  PartCounts* counts) {
  MeshReport report = reportMesh(mesh);
  checkOptions(report, options);
  const std::vector<openvdb::Vec3d> points = toIndexSpace(mesh.points, options.voxelSize);
  PartCounts found;
  openvdb::FloatGrid::Ptr grid = convert(points, mesh.triangles, options, monitor, &found);
  if (counts) *counts = found;
  // Points that are duplicated along seams of texture or normals, or in a soup, do not open a hole.
  if (!report.closed()) report = reportMesh(weldMesh(mesh));
  requireDistances(*grid, mesh, points, report);
  monitor.throwIfCancelled();
  return grid;
}

}  // namespace vdbtools
