// SPDX-License-Identifier: Apache-2.0
#include "print/shells.h"

#include "base/disjoint_sets.h"
#include "distance/hole_caps.h"
#include "distance/mesh_conversion.h"
#include "distance/outer_surface.h"
#include "search/triangle_tree.h"
#include "vdbtools/base/fractal_space.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace vdbtools {
namespace {

using openvdb::Vec3d;
using openvdb::Vec3I;

constexpr std::uint32_t kNoShell = ~std::uint32_t{0};

/// The number of shells that meet, as withShellsOriented() counts them.
/// @param mesh     in voxels
/// @param outer    its outer surface
/// @param isOuter  the shells of which that has something
std::size_t shellsThatMeet(const TriangleTree& mesh, const Shells& shells, double voxel, const OuterSurface& outer,
                           const std::vector<char>& isOuter) {
  constexpr double kTiny = 1e-3, kHardly = 0.25;  // of the largest volume; of the shell's mean cross-section
  std::vector<double> within(isOuter.size(), 0);  // areas
  std::vector<openvdb::BBoxd> boxes(isOuter.size());
  for (std::size_t t = 0; t < shells.ofTriangle.size(); ++t) {
    const Vec3I& triangle = mesh.triangles()[t];
    within[shells.ofTriangle[t]] += areaOf({&triangle, 1}, mesh.points());
    for (int c = 0; c < 3; ++c) boxes[shells.ofTriangle[t]].expand(mesh.points()[triangle[c]]);
  }
  for (std::size_t t = 0; t < outer.triangles.size(); ++t)
    within[shells.ofTriangle[outer.source[t]]] -= areaOf({&outer.triangles[t], 1}, outer.points);
  std::vector<double> volumes;
  for (const double volume : shells.volumes) volumes.push_back(std::abs(volume) / (voxel * voxel * voxel));
  const auto largest = std::max_element(volumes.begin(), volumes.end());
  std::size_t meeting = 0;
  bool isMissed = false;
  for (std::size_t i = 0; i < volumes.size(); ++i) {
    if (!isOuter[i] || !(within[i] > 1)) continue;
    ++meeting;
    if (i == static_cast<std::size_t>(largest - volumes.begin())) continue;
    isMissed |= volumes[i] > kTiny * *largest || within[i] > kHardly * volumes[i] / longestSide(boxes[i]);
  }
  return isMissed ? meeting : 0;
}

}  // namespace

Shells shellsOf(const Mesh& mesh) {
  DisjointSets<std::uint32_t> sets(mesh.points.size());
  for (const Vec3I& t : mesh.triangles) {
    sets.join(t[0], t[1]);
    sets.join(t[1], t[2]);
  }
  Shells shells;
  std::vector<std::uint32_t> numbers(mesh.points.size(), kNoShell);
  const Vec3d origin = mesh.points.front();  // near the triangles, so that little precision is lost
  for (const Vec3I& t : mesh.triangles) {
    std::uint32_t& number = numbers[sets.find(t[0])];
    if (number == kNoShell) {
      number = static_cast<std::uint32_t>(shells.volumes.size());
      shells.volumes.push_back(0);
    }
    shells.ofTriangle.push_back(number);
    shells.volumes[number] +=
        (mesh.points[t[0]] - origin).dot((mesh.points[t[1]] - origin).cross(mesh.points[t[2]] - origin)) / 6;
  }
  return shells;
}

std::optional<Mesh> withShellsOriented(const Mesh& mesh, double voxel, std::size_t& meeting, Monitor& monitor) {
  meeting = 0;
  const Shells shells = shellsOf(mesh);
  if (shells.volumes.size() < 2) return mesh;
  const std::vector<Vec3d> points = toIndexSpace(mesh.points, voxel);
  const TriangleTree tree(points, mesh.triangles);
  const auto outer = outerSurface(tree, {}, monitor);
  std::vector<char> isOuter(shells.volumes.size(), outer ? 0 : 1);
  if (outer) {
    for (const std::uint32_t t : outer->source) isOuter[shells.ofTriangle[t]] = 1;
    if (outer->parts.intersecting > 0) meeting = shellsThatMeet(tree, shells, voxel, *outer, isOuter);
    if (meeting > 0) return std::nullopt;
  }
  Mesh oriented = mesh;
  for (std::size_t t = 0; t < oriented.triangles.size(); ++t) {
    const std::uint32_t shell = shells.ofTriangle[t];
    if (isOuter[shell] ? shells.volumes[shell] < 0 : shells.volumes[shell] > 0)
      std::swap(oriented.triangles[t][1], oriented.triangles[t][2]);
  }
  return oriented;
}

}  // namespace vdbtools
