// SPDX-License-Identifier: Apache-2.0
/// @file gltf_pose.h
/// Where the nodes of a glTF stand, as the file says or at a moment of an animation, and how skins and morph targets
/// move the points of a mesh. After the specification of glTF 2.0 (Khronos Group), sections 3.7 and 3.11.
#pragma once

#include "mesh_files/gltf_file.h"
#include "vdbtools/mesh/mesh.h"
#include "vdbtools/mesh_files/mesh_reader.h"

#include <nlohmann/json_fwd.hpp>

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>
#include <vector>

namespace vdbtools {

/// An affine map: p -> A p + t. Columns of A, then t.
struct Placement {
  using Vec3d = openvdb::Vec3d;
  std::array<Vec3d, 4> columns{Vec3d(1, 0, 0), Vec3d(0, 1, 0), Vec3d(0, 0, 1), Vec3d(0)};

  Vec3d direction(const Vec3d& v) const { return v[0] * columns[0] + v[1] * columns[1] + v[2] * columns[2]; }
  Vec3d point(const Vec3d& p) const { return direction(p) + columns[3]; }
  bool mirrors() const { return columns[0].cross(columns[1]).dot(columns[2]) < 0; }

  Placement after(const Placement& inner) const {
    Placement result;
    for (std::size_t k = 0; k < 3; ++k) result.columns[k] = direction(inner.columns[k]);
    result.columns[3] = point(inner.columns[3]);
    return result;
  }
};

/// A translation, a rotation (a unit quaternion x, y, z, w) and a scale; empty: none.
Placement placed(const std::vector<double>& translation, const std::vector<double>& rotation,
                 const std::vector<double>& scale);

class GltfPose {
 public:
  /// @param file    must outlive this
  /// @param moment  without one, the nodes stand as the file says
  /// @throw DataError  there is no such animation, or it cannot be played
  GltfPose(const GltfFile& file, const std::optional<MeshMoment>& moment);

  /// Where a node stands relative to its parent.
  Placement local(std::uint64_t node) const;

  /// The weights of the morph targets of a node's mesh; may be empty.
  std::vector<double> morphWeights(std::uint64_t node) const;

  /// Where each joint of a skin takes a point of the mesh, in the space of the scene.
  std::vector<Placement> jointsOf(std::uint64_t skin) const;

 private:
  /// What an animation says of a node; empty: nothing.
  struct Moved {
    std::vector<double> translation{}, rotation{}, scale{}, weights{};
  };
  void play(const nlohmann::json& animation, double seconds);
  std::vector<Placement> worldsOf(const std::vector<std::uint64_t>& nodes) const;

  const GltfFile& mFile;
  std::map<std::uint64_t, Moved> mMoved;
};

/// The points of a primitive, moved by its morph targets and by a skin.
class GltfShape {
 public:
  /// @param weights  of morph targets
  /// @param joints   from GltfPose::jointsOf(); empty: no skin, and @a placement is where the node stands
  /// @throw DataError
  GltfShape(const GltfFile& file, const nlohmann::json& primitive, const std::vector<double>& weights,
            const std::vector<Placement>& joints, const Placement& placement);

  std::uint64_t count() const { return mPositions.count(); }
  std::uint64_t morphs() const { return mMorphs.size(); }  ///< in use
  /// @throw DataError  a joint does not exist
  openvdb::Vec3d point(std::uint64_t i) const;
  bool mirrors() const { return mMirrors; }

 private:
  const GltfFile& mFile;
  const std::vector<Placement>& mJoints;
  Placement mPlacement;
  GltfArray mPositions;
  std::vector<std::pair<double, GltfArray>> mMorphs;
  std::vector<std::pair<GltfArray, GltfArray>> mSkin;  ///< joints and their weights
  bool mMirrors = false;
};

}  // namespace vdbtools
