// SPDX-License-Identifier: Apache-2.0
/// @file control_lattice.h
/// Controls that are computed once, on a dense lattice over the target's box and a margin, and then read trilinearly.
/// Points outside the lattice get the value of its nearest point.
///
/// The lattice has 100 nodes along the target's longest side. It is centred on the middle of the target, so the values
/// do not depend on the target's position, nor on the number of threads.
#pragma once

#include "search/surface_search.h"
#include "vdbtools/control/control.h"

#include <tbb/parallel_for.h>

#include <array>
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
  /// Nodes are ordered by their indices, with z running fastest.
  std::size_t index(int x, int y, int z) const {
    return (static_cast<std::size_t>(x) * static_cast<std::size_t>(size[1]) + static_cast<std::size_t>(y)) *
               static_cast<std::size_t>(size[2]) +
           static_cast<std::size_t>(z);
  }
  openvdb::Vec3d world(const openvdb::Vec3d& index) const { return first + voxel * index; }
  openvdb::Vec3d toIndex(const openvdb::Vec3d& world) const { return (world - first) / voxel; }
  /// Reads values trilinearly at an index that is clamped to the lattice.
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

/// Replaces each value by half of it plus half the mean of the two adjacent nodes, along one axis after the other.
/// Linear functions stay unchanged.
void smooth(const ControlLattice& lattice, std::vector<float>& values);

/// @pre there is one finite value for each node
std::shared_ptr<const ControlField> latticeField(const ControlLattice& lattice, std::vector<float> values);

/// Values at the point of a surface that is nearest to each node.
struct SurfaceValues {
  std::vector<float> distance;               ///< distance of each node from the surface, world units
  std::vector<std::vector<float>> values{};  ///< for each kind, the value at each node
};

/// Reads the surface at a point: writes as many values as there are kinds.
using ReadSurface = std::function<void(const SurfacePoint& point, double* values)>;

/// Computes the values at the point of @a mesh that is nearest to each node. They are exact near the surface. Farther
/// away they are computed on increasingly coarse lattices, whose voxels double each time and are small compared with
/// the distance, and interpolated.
/// @param read  many threads call it at once
SurfaceValues fromSurface(const ControlLattice& lattice, const Mesh& mesh, std::size_t kinds, const ReadSurface& read);

/// Finds the attribute of a mesh by its name.
/// @param whose  names the mesh in the error message
/// @throw DataError  there is no such attribute, or it is not finite at a point that triangles use
const VertexAttribute& requireAttribute(const Mesh& mesh, const std::string& name, const std::string& whose);

/// The three attributes of a vector: NAME_x, NAME_y and NAME_z, or NAMEx, NAMEy and NAMEz.
/// @param option  what asks for them, for the error message
/// @throw DataError  they are not there, or not finite at a point that triangles use
std::array<const VertexAttribute*, 3> requireVector(const Mesh& mesh, const std::string& name,
                                                    const std::string& option);

/// @throw DataError  the target's mesh has no texture coordinates, or not at every corner
void requireUvs(const Mesh& mesh);

/// For each requested attribute, its value at the point of the mesh nearest to each node.
std::vector<std::vector<float>> extended(const ControlLattice& lattice, const Mesh& mesh,
                                         std::span<const VertexAttribute* const> attributes);

/// The rest of a text that begins with @a prefix; empty for any other text.
std::optional<std::string> afterPrefix(const std::string& text, const std::string& prefix);

/// Parses a finite number; empty for any other text.
std::optional<double> finiteNumber(const std::string& text);

/// The names of a mesh's attributes, for an error message: "red, green, blue", or "none".
std::string attributeNames(const Mesh& mesh);

}  // namespace vdbtools
