// SPDX-License-Identifier: Apache-2.0
#include "surface/marching_cubes_table.h"

#include <stdexcept>

namespace vdbtools {
namespace {

constexpr int kNone = -1;

struct Topology {
  std::array<CellEdge, 12> edges;
  int edgeOf[8][8];                         // the edge between two neighbouring corners
  std::array<std::array<int, 4>, 6> faces;  // corners, counter-clockwise seen from outside the cell
  bool shareFace[12][12] = {};
};

Topology makeTopology() {
  Topology cube;
  int count = 0;
  for (int axis = 0; axis < 3; ++axis)
    for (int corner = 0; corner < 8; ++corner)
      if (!(corner >> axis & 1)) {
        const int end = corner | 1 << axis;
        cube.edgeOf[corner][end] = cube.edgeOf[end][corner] = count;
        cube.edges[count++] = {corner, axis};
      }
  for (int axis = 0; axis < 3; ++axis)
    for (int side = 0; side < 2; ++side) {
      const int base = side << axis, u = 1 << (axis + 1) % 3, v = 1 << (axis + 2) % 3;
      cube.faces[2 * axis + side] = side ? std::array{base, base | u, base | u | v, base | v}
                                         : std::array{base | v, base | u | v, base | u, base};
    }
  for (const auto& face : cube.faces)
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j)
        cube.shareFace[cube.edgeOf[face[i]][face[(i + 1) % 4]]][cube.edgeOf[face[j]][face[(j + 1) % 4]]] = true;
  return cube;
}

/// next[e]: the crossing that follows that of edge e in its loop.
std::array<int, 12> linkCrossings(const Topology& cube, unsigned inside) {
  std::array<int, 12> next;
  next.fill(kNone);
  for (const auto& face : cube.faces) {
    const auto isInside = [&](int i) { return (inside >> face[static_cast<std::size_t>((i + 4) % 4)] & 1) != 0; };
    const auto edge = [&](int i) {
      return cube.edgeOf[face[static_cast<std::size_t>((i + 4) % 4)]][face[static_cast<std::size_t>((i + 5) % 4)]];
    };
    for (int last = 0; last < 4; ++last) {
      if (!isInside(last) || isInside(last + 1)) continue;
      int first = last;  // the first of the run of inside corners that ends here
      while (isInside(first - 1)) --first;
      next[static_cast<std::size_t>(edge(first - 1))] = edge(last);
    }
  }
  return next;
}

/// Splits loop[from..to] into triangles without a diagonal in a face.
bool triangulate(const Topology& cube, const std::vector<int>& loop, int from, int to, std::vector<CellTriangle>& out) {
  if (to - from < 2) return true;
  const int size = static_cast<int>(loop.size());
  const auto at = [&](int i) { return loop[static_cast<std::size_t>(i)]; };
  const auto mayJoin = [&](int i, int j) {
    return j - i == 1 || (i == 0 && j == size - 1) || !cube.shareFace[at(i)][at(j)];
  };
  for (int middle = from + 1; middle < to; ++middle) {
    if (!mayJoin(from, middle) || !mayJoin(middle, to)) continue;
    const std::size_t before = out.size();
    out.push_back({static_cast<std::uint8_t>(at(from)), static_cast<std::uint8_t>(at(middle)),
                   static_cast<std::uint8_t>(at(to))});
    if (triangulate(cube, loop, from, middle, out) && triangulate(cube, loop, middle, to, out)) return true;
    out.resize(before);
  }
  return false;
}

struct Table {
  Topology cube = makeTopology();
  std::array<std::vector<CellTriangle>, 256> triangles;

  Table() {
    for (unsigned inside = 0; inside < 256; ++inside) {
      std::array<int, 12> next = linkCrossings(cube, inside);
      for (int start = 0; start < 12; ++start) {
        std::vector<int> loop;
        for (int edge = start; next[static_cast<std::size_t>(edge)] != kNone;) {
          loop.push_back(edge);
          const int following = next[static_cast<std::size_t>(edge)];
          next[static_cast<std::size_t>(edge)] = kNone;
          edge = following;
        }
        if (!triangulate(cube, loop, 0, static_cast<int>(loop.size()) - 1, triangles[inside]))
          throw std::logic_error("marching cubes: corner signs " + std::to_string(inside) + " have no triangulation");
      }
    }
  }
};

const Table& table() {
  static const Table theTable;
  return theTable;
}

}  // namespace

const std::array<CellEdge, 12>& cellEdges() { return table().cube.edges; }

const std::vector<CellTriangle>& cellTriangles(unsigned insideCorners) { return table().triangles.at(insideCorners); }

}  // namespace vdbtools
