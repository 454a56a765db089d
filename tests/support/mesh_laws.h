// SPDX-License-Identifier: Apache-2.0
/// @file mesh_laws.h
/// What must hold for every mesh that leaves the project, in words when it does not.
#pragma once

#include "vdbtools/mesh/mesh.h"

#include <cmath>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <tuple>
#include <vector>

namespace mesh_laws {

using Edge = std::pair<openvdb::Index, openvdb::Index>;

inline std::map<Edge, int> directedEdges(const vdbtools::Mesh& mesh) {
  std::map<Edge, int> edges;
  for (const openvdb::Vec3I& t : mesh.triangles)
    for (int k = 0; k < 3; ++k) ++edges[{t[k], t[(k + 1) % 3]}];
  return edges;
}

/// "" if every edge is used twice, in opposite directions, every point has one fan of triangles around it, and no two
/// points coincide.
inline std::string notClosedManifold(const vdbtools::Mesh& mesh) {
  std::ostringstream text;
  const auto edges = directedEdges(mesh);
  for (const auto& [edge, count] : edges) {
    const auto back = edges.find({edge.second, edge.first});
    if (count == 1 && back != edges.end() && back->second == 1) continue;
    text << "edge " << edge.first << "-" << edge.second << " is used " << count << " times forwards and "
         << (back == edges.end() ? 0 : back->second) << " backwards";
    return text.str();
  }
  // Around a point, the edges opposite to it form one cycle.
  std::vector<std::map<openvdb::Index, openvdb::Index>> around(mesh.points.size());
  for (const openvdb::Vec3I& t : mesh.triangles)
    for (int k = 0; k < 3; ++k) around[t[k]][t[(k + 1) % 3]] = t[(k + 2) % 3];
  for (std::size_t i = 0; i < around.size(); ++i) {
    if (around[i].empty()) {
      text << "point " << i << " belongs to no triangle";
      return text.str();
    }
    std::size_t steps = 0;
    openvdb::Index at = around[i].begin()->first;
    do {
      at = around[i][at];
      ++steps;
    } while (at != around[i].begin()->first && steps <= around[i].size());
    if (steps != around[i].size()) {
      text << "point " << i << " joins several fans";
      return text.str();
    }
  }
  std::set<std::tuple<double, double, double>> positions;
  for (const openvdb::Vec3d& p : mesh.points)
    if (!positions.insert({p[0], p[1], p[2]}).second) {
      text << "two points at " << p;
      return text.str();
    }
  return text.str();
}

inline double volume(const vdbtools::Mesh& mesh) {
  double sum = 0;
  for (const openvdb::Vec3I& t : mesh.triangles)
    sum += mesh.points[t[0]].dot(mesh.points[t[1]].cross(mesh.points[t[2]])) / 6;
  return sum;
}

inline double area(const vdbtools::Mesh& mesh) {
  double sum = 0;
  for (const openvdb::Vec3I& t : mesh.triangles)
    sum += (mesh.points[t[1]] - mesh.points[t[0]]).cross(mesh.points[t[2]] - mesh.points[t[0]]).length() / 2;
  return sum;
}

/// A vertex of marching cubes as the lattice edge it lies on: the node where that begins, and the axis.
struct OnEdge {
  openvdb::Coord node;
  int axis = -1;
  double t = 0;  ///< voxels from the node

  friend bool operator<(const OnEdge& a, const OnEdge& b) {
    return std::tie(a.node, a.axis) < std::tie(b.node, b.axis);
  }
};

/// axis stays -1 for a point that lies on no lattice edge.
inline OnEdge onEdge(const openvdb::Vec3d& world, double voxelSize) {
  OnEdge result;
  for (int axis = 0; axis < 3; ++axis) {
    const double index = world[axis] / voxelSize, nearest = std::round(index);
    if (std::abs(index - nearest) < 1e-7) {
      result.node[axis] = static_cast<int>(nearest);
    } else {
      if (result.axis != -1) return {};
      result.axis = axis;
      result.node[axis] = static_cast<int>(std::floor(index));
      result.t = index - std::floor(index);
    }
  }
  return result;
}

}  // namespace mesh_laws
