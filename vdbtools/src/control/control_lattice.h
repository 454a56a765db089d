// SPDX-License-Identifier: Apache-2.0
/// @file control_lattice.h
/// Controls that are found once, on a dense lattice over the target's box and a margin, and read trilinearly from then
/// on. Beyond the lattice the value of its nearest point holds.
///
/// The lattice has 100 nodes along the target's longest side. It is centred on the middle of the target, so that a
/// target at another place has the same values. The same values are found with any number of threads.
#pragma once

#include "search/surface_search.h"
#include "vdbtools/control/control.h"

#include <tbb/parallel_for.h>

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace vdbtools {

struct ControlLattice {
  openvdb::Vec3d first;  ///< world position of the node 0, 0, 0
  double voxel = 0;      ///< world units
  openvdb::Coord size;   ///< nodes along each axis

  std::size_t count() const {
    return static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]) * static_cast<std::size_t>(size[2]);
  }
  /// Nodes are in the order of their indices, z first.
  std::size_t index(int x, int y, int z) const {
    return (static_cast<std::size_t>(x) * static_cast<std::size_t>(size[1]) + static_cast<std::size_t>(y)) *
               static_cast<std::size_t>(size[2]) +
           static_cast<std::size_t>(z);
  }
  openvdb::Vec3d world(const openvdb::Vec3d& index) const { return first + voxel * index; }
  openvdb::Vec3d toIndex(const openvdb::Vec3d& world) const { return (world - first) / voxel; }
  /// Clamped to the lattice.
  double read(std::span<const float> values, const openvdb::Vec3d& index) const;

  /// Runs body(x, y) for every row of nodes along z, in threads.
  template <class Body>
  void forEachRow(const Body& body) const {
    const std::size_t rows = static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]);
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, rows, 16), [&](const auto& range) {
      for (std::size_t row = range.begin(); row != range.end(); ++row)
        body(static_cast<int>(row / static_cast<std::size_t>(size[1])),
             static_cast<int>(row % static_cast<std::size_t>(size[1])));
    });
  }
};

ControlLattice controlLattice(const ControlContext& context);

/// Half the value of each node and half the mean of the nodes before and behind, along one axis after the other. Values
/// that change at an even rate stay what they are.
void smooth(const ControlLattice& lattice, std::vector<float>& values);

/// @pre as many values as nodes, all finite
std::shared_ptr<const ControlField> latticeField(const ControlLattice& lattice, std::vector<float> values);

/// What is found at the nearest point of a surface.
struct SurfaceValues {
  std::vector<float> distance;               ///< of each node from the surface, world units
  std::vector<std::vector<float>> values{};  ///< of each kind, at each node
};

/// What a surface has at a point of it: writes as many values as there are kinds.
using ReadSurface = std::function<void(const SurfacePoint& point, double* values)>;

/// The values at the point of @a mesh that is nearest to each node. They are exact near the surface; farther away they
/// are found on ever coarser lattices, voxels doubled each time, whose voxels are a small share of the distance, and
/// interpolated.
/// @param read  called in many threads at once
SurfaceValues fromSurface(const ControlLattice& lattice, const Mesh& mesh, std::size_t kinds, const ReadSurface& read);

/// The attribute of a mesh by its name.
/// @param whose  the mesh, for the error's text
/// @throw DataError  there is none, or it is not finite at a point that triangles use
const VertexAttribute& requireAttribute(const Mesh& mesh, const std::string& name, const std::string& whose);

/// @throw DataError  the target's mesh has no texture coordinates, or not at every corner
void requireUvs(const Mesh& mesh);

/// At each node the attribute's value at the nearest point of the mesh, for every attribute that is asked for.
std::vector<std::vector<float>> extended(const ControlLattice& lattice, const Mesh& mesh,
                                         std::span<const VertexAttribute* const> attributes);

/// What follows @a prefix in a text that begins with it.
std::optional<std::string> afterPrefix(const std::string& text, const std::string& prefix);

/// A number from text, unless it is none or not finite.
std::optional<double> finiteNumber(const std::string& text);

/// The names of a mesh's attributes, for an error's text: "red, green, blue", or "none".
std::string attributeNames(const Mesh& mesh);

}  // namespace vdbtools
