// SPDX-License-Identifier: Apache-2.0
/// @file usd_file.h
/// The room `usd` writes USD scenes. It uses the rooms up to `job`.
///
/// This header writes scenes in the text form of USD (.usda, OpenUSD), as a side-car to the program's outputs: a Volume
/// whose fields are the grids of VDB files, frame by frame, and a mesh, which may be another one in each frame. The
/// scene refers to the VDB files. It contains the meshes themselves, because USD cannot refer to mesh files other than
/// its own.
#pragma once

#include "vdbtools/base/units.h"
#include "vdbtools/mesh/mesh.h"

#include <filesystem>
#include <functional>
#include <iosfwd>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace vdbtools {

/// A grid, in the terms of UsdVolOpenVDBAsset.
struct UsdField {
  std::string grid;        ///< its name in the VDB
  std::string dataType;    ///< "float", "int", "float3" and so on; empty: USD has no token for it
  std::string fieldClass;  ///< "levelSet", "fogVolume", "staggered" or "unknown"

  bool operator==(const UsdField&) const = default;
};

struct UsdFrame {
  std::optional<int> number;  ///< empty: the volume does not change
  std::filesystem::path vdb;  ///< relative to the scene's folder
  openvdb::BBoxd box;         ///< bounds of the grids, world units
};

/// Numbers at the points of a mesh, of one or three components.
struct UsdPrimvar {
  std::string name;                ///< an identifier of USD
  std::vector<std::string> parts;  ///< the attributes of the mesh that are its components

  bool operator==(const UsdPrimvar&) const = default;
};

/// A mesh, or one for each frame, whose points and triangles may all differ.
struct UsdMeshes {
  std::vector<std::optional<int>> frames;  ///< one without a number, or any number of them in ascending order
  std::vector<openvdb::BBoxd> boxes;       ///< of each, in the axes of the scene
  bool hasNormals = false;
  bool hasColours = false;     ///< the attributes red, green and blue, as linear light
  bool hasVelocities = false;  ///< the attributes velocity_x, velocity_y and velocity_z, in the axes of the scene
  bool hasUvs = false;         ///< Mesh::cornerUvs
  std::vector<UsdPrimvar> primvars{};  ///< of all meshes, each by a name of its own
  /// The mesh at a place of the list, in the axes of the scene. The scene asks for each of them several times, one
  /// after the other, and the result is valid until the next call.
  std::function<const Mesh&(std::size_t)> at;
};

struct UsdScene {
  UpAxis up = UpAxis::Y;
  double metersPerUnit = 1;
  double framesPerSecond = 24;
  std::vector<UsdField> fields{};
  std::vector<UsdFrame> frames{};  ///< one without a number, or any number of them in ascending order
  std::optional<UsdMeshes> mesh{};
  std::optional<std::pair<int, int>> range{};  ///< the first and the last frame, if there are frames
};

/// The name as an identifier of USD.
std::string usdIdentifier(const std::string& name);

/// Writes a scene. The same scene gives the same bytes.
/// @throw std::invalid_argument  neither a frame nor a mesh; two fields whose names become the same identifier
void writeUsda(std::ostream& stream, const UsdScene& scene);

}  // namespace vdbtools
