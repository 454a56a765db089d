// SPDX-License-Identifier: Apache-2.0
#include "decimation/decimate.h"

#include "base/elementary.h"
#include "decimation/halfedge_mesh.h"

#include <OpenMesh/Tools/Decimater/DecimaterT.hh>
#include <OpenMesh/Tools/Decimater/ModAspectRatioT.hh>
#include <OpenMesh/Tools/Decimater/ModEdgeLengthT.hh>
#include <OpenMesh/Tools/Decimater/ModNormalFlippingT.hh>
#include <OpenMesh/Tools/Decimater/ModQuadricT.hh>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace vdbtools {
namespace {

using Decimater = OpenMesh::Decimater::DecimaterT<HalfedgeMesh>;

/// The maximum ratio of longest edge to height that boundary elements and point spreading handle without problems.
constexpr float kAspectRatio = 5;

constexpr float kFoldOfCollapse = 60;  ///< maximum rotation of a triangle's normal in one collapse, degrees

void collapseShortEdges(HalfedgeMesh& mesh, double shortest) {
  Decimater decimater(mesh);
  OpenMesh::Decimater::ModEdgeLengthT<HalfedgeMesh>::Handle length;
  OpenMesh::Decimater::ModNormalFlippingT<HalfedgeMesh>::Handle normals;
  decimater.add(length);
  decimater.module(length).set_edge_length(static_cast<float>(shortest));
  decimater.module(length).set_binary(false);
  decimater.add(normals);
  decimater.module(normals).set_max_normal_deviation(kFoldOfCollapse);
  decimater.initialize();
  decimater.decimate();
  mesh.garbage_collection();
}

void collapseTo(HalfedgeMesh& mesh, std::size_t triangles, bool wellShaped) {
  Decimater decimater(mesh);
  OpenMesh::Decimater::ModQuadricT<HalfedgeMesh>::Handle quadric;
  OpenMesh::Decimater::ModNormalFlippingT<HalfedgeMesh>::Handle normals;
  OpenMesh::Decimater::ModAspectRatioT<HalfedgeMesh>::Handle aspect;
  decimater.add(quadric);
  decimater.module(quadric).unset_max_err();
  if (wellShaped) {
    decimater.add(normals);
    decimater.module(normals).set_max_normal_deviation(kFoldOfCollapse);
    decimater.add(aspect);
    decimater.module(aspect).set_aspect_ratio(kAspectRatio);
  }
  decimater.initialize();
  decimater.decimate_to_faces(0, triangles);
  mesh.garbage_collection();
}

/// Twice the area, as a vector along the normal.
OpenMesh::Vec3d areaVector(const HalfedgeMesh& mesh, const std::array<HalfedgeMesh::VertexHandle, 3>& t) {
  return (mesh.point(t[1]) - mesh.point(t[0])) % (mesh.point(t[2]) - mesh.point(t[0]));
}

/// The ratio of longest edge to height.
double aspectRatio(const HalfedgeMesh& mesh, const std::array<HalfedgeMesh::VertexHandle, 3>& t) {
  double longest = 0;
  for (std::size_t c = 0; c < 3; ++c)
    longest = std::max(longest, (mesh.point(t[(c + 1) % 3]) - mesh.point(t[c])).sqrnorm());
  return longest / areaVector(mesh, t).norm();
}

/// Flips the edge between two triangles if one of them is flat and the flip helps. Flat triangles have no short edge to
/// collapse.
void flipEdgesOfFlatTriangles(HalfedgeMesh& mesh) {
  constexpr int kRounds = 3;  // a flip may make room for the next
  const double leastCosine = elementary::cos(kFoldOfCollapse * std::numbers::pi / 180);
  for (int round = 0; round < kRounds; ++round)
    for (const auto edge : mesh.edges()) {
      if (edge.is_boundary() || !mesh.is_flip_ok(edge)) continue;
      const auto half = edge.h0();
      const auto a = half.from(), b = half.to(), c = half.next().to(), d = half.opp().next().to();
      using Triangle = std::array<HalfedgeMesh::VertexHandle, 3>;
      const Triangle before[] = {{a, b, c}, {b, a, d}}, after[] = {{a, d, c}, {d, b, c}};
      const auto worst = [&](const Triangle* pair) {
        return std::max(aspectRatio(mesh, pair[0]), aspectRatio(mesh, pair[1]));
      };
      const double now = worst(before);
      if (now <= kAspectRatio || !(worst(after) < now)) continue;
      const OpenMesh::Vec3d normal = areaVector(mesh, before[0]) + areaVector(mesh, before[1]);
      const auto turnsLittle = [&](const Triangle& t) {
        const OpenMesh::Vec3d turned = areaVector(mesh, t);
        return (turned | normal) > leastCosine * turned.norm() * normal.norm();
      };
      if (turnsLittle(after[0]) && turnsLittle(after[1])) mesh.flip(edge);
    }
}

}  // namespace

Mesh decimated(const Mesh& mesh, std::size_t triangles, double shortest) {
  HalfedgeMesh halfedges = toHalfedges(mesh);
  collapseShortEdges(halfedges, shortest);
  for (const bool wellShaped : {true, false})
    if (halfedges.n_faces() > triangles) collapseTo(halfedges, triangles, wellShaped);
  flipEdgesOfFlatTriangles(halfedges);
  halfedges.delete_isolated_vertices();
  halfedges.garbage_collection();

  Mesh result;
  for (const auto vertex : halfedges.vertices()) {
    const HalfedgeMesh::Point& p = halfedges.point(vertex);
    result.points.emplace_back(p[0], p[1], p[2]);
  }
  for (const auto face : halfedges.faces()) {
    openvdb::Vec3I corners;
    int c = 0;
    for (const auto vertex : face.vertices()) corners[c++] = static_cast<std::uint32_t>(vertex.idx());
    result.triangles.push_back(corners);
  }
  return result;
}

}  // namespace vdbtools
