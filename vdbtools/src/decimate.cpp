// SPDX-License-Identifier: Apache-2.0
#include "decimate.h"

#include "vdbtools/errors.h"

#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <OpenMesh/Core/System/omstream.hh>
#include <OpenMesh/Tools/Decimater/DecimaterT.hh>
#include <OpenMesh/Tools/Decimater/ModAspectRatioT.hh>
#include <OpenMesh/Tools/Decimater/ModEdgeLengthT.hh>
#include <OpenMesh/Tools/Decimater/ModNormalFlippingT.hh>
#include <OpenMesh/Tools/Decimater/ModQuadricT.hh>

#include <string>

namespace vdbtools {
namespace {

struct Traits : OpenMesh::DefaultTraits {
  using Point = OpenMesh::Vec3d;
  using Normal = OpenMesh::Vec3d;
};
using HalfedgeMesh = OpenMesh::TriMesh_ArrayKernelT<Traits>;
using Decimater = OpenMesh::Decimater::DecimaterT<HalfedgeMesh>;

/// Longest edge over height; what boundary elements and the spreading of points take without complaint.
constexpr float kAspectRatio = 5;

constexpr float kFold = 60;  ///< degrees that a triangle's normal may turn by in one collapse

HalfedgeMesh toHalfedges(const Mesh& mesh) {
  omerr().disable();  // what it would print is thrown below
  HalfedgeMesh result;
  for (const openvdb::Vec3d& p : mesh.points) result.add_vertex({p[0], p[1], p[2]});
  for (const openvdb::Vec3I& t : mesh.triangles) {
    const auto corner = [&](int c) { return HalfedgeMesh::VertexHandle(static_cast<int>(t[c])); };
    if (!result.add_face(corner(0), corner(1), corner(2)).is_valid())
      throw DataError("the surface is not a 2-manifold at the triangle of points " + std::to_string(t[0]) + ", " +
                      std::to_string(t[1]) + ", " + std::to_string(t[2]));
  }
  result.request_vertex_status();
  result.request_edge_status();
  result.request_halfedge_status();
  result.request_face_status();
  result.request_face_normals();
  result.update_face_normals();
  return result;
}

void collapseShortEdges(HalfedgeMesh& mesh, double shortest) {
  Decimater decimater(mesh);
  OpenMesh::Decimater::ModEdgeLengthT<HalfedgeMesh>::Handle length;
  OpenMesh::Decimater::ModNormalFlippingT<HalfedgeMesh>::Handle normals;
  decimater.add(length);
  decimater.module(length).set_edge_length(static_cast<float>(shortest));
  decimater.module(length).set_binary(false);
  decimater.add(normals);
  decimater.module(normals).set_max_normal_deviation(kFold);
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
    decimater.module(normals).set_max_normal_deviation(kFold);
    decimater.add(aspect);
    decimater.module(aspect).set_aspect_ratio(kAspectRatio);
  }
  decimater.initialize();
  decimater.decimate_to_faces(0, triangles);
  mesh.garbage_collection();
}

}  // namespace

Mesh decimated(const Mesh& mesh, std::size_t triangles, double shortest) {
  HalfedgeMesh halfedges = toHalfedges(mesh);
  collapseShortEdges(halfedges, shortest);
  for (const bool wellShaped : {true, false})
    if (halfedges.n_faces() > triangles) collapseTo(halfedges, triangles, wellShaped);
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
