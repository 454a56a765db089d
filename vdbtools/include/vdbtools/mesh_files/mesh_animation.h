// SPDX-License-Identifier: Apache-2.0
/// @file mesh_animation.h
/// The animations of a glTF, and a moment of one at which its mesh is read.
#pragma once

#include "vdbtools/mesh/mesh.h"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace vdbtools {

/// A moment of an animation. Before its first key and after its last, an animation stands still.
struct MeshMoment {
  double seconds = 0;
  /// The animation, by its name or by its number from 0, or "all" for all of them at once; empty: the first.
  std::string animation{};
  bool operator==(const MeshMoment&) const = default;
};

/// Reads a mesh as readMesh() does (mesh_reader.h), at a moment if one is given.
/// @throw as readMesh()
/// @throw DataError  there is no such animation, or it cannot be played
Mesh readMesh(const std::filesystem::path& path, const std::optional<MeshMoment>& moment);
/// The same for readPoints() (point_cloud.h).
Mesh readPoints(const std::filesystem::path& path, const std::optional<MeshMoment>& moment);

/// Whether files of its format (formatOfMesh()) may have animations; those of glTF may.
bool mayBeAnimated(const std::filesystem::path& path);

struct MeshAnimation {
  std::string name;            ///< may be empty
  double first = 0, last = 0;  ///< the times of its first and its last key, seconds
};

/// The animations of a file, in its order; empty for formats other than glTF.
/// @throw DataError, MissingInputError, IoError
std::vector<MeshAnimation> readAnimations(const std::filesystem::path& path);

}  // namespace vdbtools
