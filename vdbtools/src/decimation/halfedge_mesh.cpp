// SPDX-License-Identifier: Apache-2.0
#include "decimation/halfedge_mesh.h"

#include "vdbtools/base/errors.h"

#include <OpenMesh/Core/System/omstream.hh>

#include <mutex>
#include <string>

namespace vdbtools {
namespace {

/// Keeps OpenMesh from printing errors while this object exists. They go to one stream for the whole program, so only
/// one such object exists at a time.
class QuietOpenMesh {
 public:
  QuietOpenMesh() : mLock(mutex()), mWasEnabled(omerr().is_enabled()) { omerr().disable(); }
  ~QuietOpenMesh() {
    if (mWasEnabled) omerr().enable();
  }
  QuietOpenMesh(const QuietOpenMesh&) = delete;
  QuietOpenMesh& operator=(const QuietOpenMesh&) = delete;

 private:
  static std::mutex& mutex() {
    static std::mutex mutex;
    return mutex;
  }
  std::scoped_lock<std::mutex> mLock;
  bool mWasEnabled;
};

}  // namespace

HalfedgeMesh toHalfedges(const Mesh& mesh) {
  const QuietOpenMesh quiet;  // errors are thrown below instead
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

}  // namespace vdbtools
