// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/extract_mesh.h"

#include "edge_search.h"
#include "leaf_signs.h"
#include "marching_cubes_table.h"

#include <openvdb/tree/ValueAccessor.h>

#include <tbb/parallel_for.h>

#include <array>
#include <bit>
#include <limits>
#include <memory>
#include <stdexcept>
#include <unordered_map>
#include <vector>

namespace vdbtools {
namespace {

using openvdb::Coord;
using openvdb::FloatTree;
using openvdb::Index;
using openvdb::Vec3d;
using Leaf = FloatTree::LeafNodeType;
using Accessor = openvdb::tree::ValueAccessor<const FloatTree>;

constexpr std::uint16_t kNoVertex = 0xffff;

/// The vertices on the edges that begin at a leaf's nodes.
struct LeafVertices {
  std::array<std::uint16_t, 3 * Leaf::SIZE> onEdge;  // by 3 offset + axis: which of positions
  std::vector<Vec3d> positions;                      // world units
  std::size_t first = 0;                             // of all vertices

  LeafVertices() { onEdge.fill(kNoVertex); }
};

/// Phase 1: the crossing edges that begin in a leaf, and their vertices.
std::unique_ptr<LeafVertices> findVertices(const Leaf& leaf, const Accessor& accessor, const FractalField& field,
                                           const FieldSource& source, const ExtractMeshOptions& options) {
  const LeafSigns signs(leaf, accessor);
  std::unique_ptr<LeafVertices> vertices;
  std::vector<LatticeEdge> edges;
  for (unsigned x = 0; x < LeafSigns::kSide; ++x)
    for (unsigned y = 0; y < LeafSigns::kSide; ++y) {
      const std::array<unsigned, 3> crossings = {signs.crossings(x, y, 0), signs.crossings(x, y, 1),
                                                 signs.crossings(x, y, 2)};
      for (unsigned rest = crossings[0] | crossings[1] | crossings[2]; rest != 0; rest &= rest - 1) {
        const auto z = static_cast<unsigned>(std::countr_zero(rest));
        const Index offset = (x * LeafSigns::kSide + y) * LeafSigns::kSide + z;
        const Coord node = leaf.offsetToGlobalCoord(offset);
        for (int axis = 0; axis < 3; ++axis) {
          if (!(crossings[static_cast<std::size_t>(axis)] >> z & 1)) continue;
          Coord end = node;
          ++end[axis];
          const bool cut = !field.domain.isInside(node) || !field.domain.isInside(end);
          if (cut && options.border == Border::Open) continue;
          if (!vertices) vertices = std::make_unique<LeafVertices>();
          vertices->onEdge[3 * offset + static_cast<Index>(axis)] = static_cast<std::uint16_t>(edges.size());
          edges.push_back({node, axis, leaf.getValue(offset), accessor.getValue(end), cut});
        }
      }
    }
  if (edges.empty()) return nullptr;
  vertices->positions = searchEdges(edges, field.field->voxelSize()[0], source, options.tolerance);
  return vertices;
}

/// Phase 2: the triangles of the cells that begin at a leaf's nodes.
class CellWalker {
 public:
  CellWalker(const FractalField& field, const std::vector<std::unique_ptr<LeafVertices>>& vertices,
             const std::unordered_map<Coord, std::size_t>& leafIndex, Border border)
      : mField(field), mVertices(vertices), mLeafIndex(leafIndex), mBorder(border) {}

  void walk(const Leaf& leaf, const Accessor& accessor, std::vector<openvdb::Vec3I>& triangles) const {
    const std::array<const LeafVertices*, 8> neighbours = around(leaf.origin());
    bool any = false;
    for (const LeafVertices* neighbour : neighbours) any = any || neighbour;
    if (!any) return;
    const LeafSigns signs(leaf, accessor);
    const bool nearBorder = !mField.domain.isInside(
        openvdb::CoordBBox(leaf.origin(), leaf.origin().offsetBy(static_cast<int>(LeafSigns::kSide))));
    for (unsigned x = 0; x < LeafSigns::kSide; ++x)
      for (unsigned y = 0; y < LeafSigns::kSide; ++y)
        for (unsigned rest = signs.mixedCells(x, y); rest != 0; rest &= rest - 1) {
          const auto z = static_cast<unsigned>(std::countr_zero(rest));
          const Coord node = leaf.offsetToGlobalCoord((x * LeafSigns::kSide + y) * LeafSigns::kSide + z);
          if (nearBorder && mBorder == Border::Open &&
              !mField.domain.isInside(openvdb::CoordBBox(node, node.offsetBy(1))))
            continue;
          for (const CellTriangle& triangle : cellTriangles(signs.cell(x, y, z))) {
            openvdb::Vec3I indices;
            for (int k = 0; k < 3; ++k)
              indices[k] = vertex(neighbours, leaf.origin(), node, triangle[static_cast<std::size_t>(k)]);
            triangles.push_back(indices);
          }
        }
  }

 private:
  static Coord cornerOf(const Coord& node, unsigned corner) {
    return node.offsetBy(corner & 1, corner >> 1 & 1, corner >> 2 & 1);
  }

  std::array<const LeafVertices*, 8> around(const Coord& origin) const {
    std::array<const LeafVertices*, 8> result{};
    for (unsigned k = 0; k < 8; ++k) {
      const int size = Leaf::DIM;
      const auto found = mLeafIndex.find(origin.offsetBy(k & 1 ? size : 0, k & 2 ? size : 0, k & 4 ? size : 0));
      if (found != mLeafIndex.end()) result[k] = mVertices[found->second].get();
    }
    return result;
  }

  Index vertex(const std::array<const LeafVertices*, 8>& neighbours, const Coord& origin, const Coord& node,
               std::size_t cellEdge) const {
    const CellEdge& edge = cellEdges()[cellEdge];
    const Coord begin = cornerOf(node, static_cast<unsigned>(edge.corner));
    unsigned neighbour = 0;
    for (unsigned axis = 0; axis < 3; ++axis)
      if (begin[static_cast<int>(axis)] >= origin[static_cast<int>(axis)] + static_cast<int>(Leaf::DIM))
        neighbour |= 1u << axis;
    const LeafVertices* vertices = neighbours[neighbour];
    const std::uint16_t local =
        vertices ? vertices->onEdge[3 * Leaf::coordToOffset(begin) + static_cast<Index>(edge.axis)] : kNoVertex;
    if (local == kNoVertex)
      throw std::logic_error("F changes sign on an edge at " + std::to_string(begin[0]) + ", " +
                             std::to_string(begin[1]) + ", " + std::to_string(begin[2]) + " that no block owns");
    return static_cast<Index>(vertices->first + local);
  }

  const FractalField& mField;
  const std::vector<std::unique_ptr<LeafVertices>>& mVertices;
  const std::unordered_map<Coord, std::size_t>& mLeafIndex;
  Border mBorder;
};

/// Runs body(i, accessor) over all leaves in threads; a cancelled run ends early and throws.
template <class Body>
void forEachLeaf(const FloatTree& tree, std::size_t count, Monitor& monitor, const Body& body) {
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, 8), [&](const auto& range) {
    const Accessor accessor(tree);
    for (std::size_t i = range.begin(); i != range.end(); ++i) {
      if (monitor.cancelled()) return;
      body(i, accessor);
      monitor.advance(1);
    }
  });
  monitor.throwIfCancelled();
}

}  // namespace

Mesh extractMesh(const FractalField& field, const FieldSource& source, const ExtractMeshOptions& options,
                 Monitor& monitor) {
  if (!(options.tolerance >= 0x1p-40 && options.tolerance <= 0.5))
    throw std::invalid_argument("the tolerance of edge searches is " + std::to_string(options.tolerance) +
                                " voxels; it must be at most 0.5 and at least 1e-12");
  const FloatTree& tree = field.field->tree();
  std::vector<const Leaf*> leaves;
  leaves.reserve(tree.leafCount());
  std::unordered_map<Coord, std::size_t> leafIndex;
  leafIndex.reserve(tree.leafCount());
  for (auto leaf = tree.cbeginLeaf(); leaf; ++leaf) {
    leafIndex.emplace(leaf->origin(), leaves.size());
    leaves.push_back(leaf.getLeaf());
  }

  std::vector<std::unique_ptr<LeafVertices>> vertices(leaves.size());
  monitor.begin("edges", leaves.size());
  forEachLeaf(tree, leaves.size(), monitor, [&](std::size_t i, const Accessor& accessor) {
    vertices[i] = findVertices(*leaves[i], accessor, field, source, options);
  });

  std::size_t count = 0;
  for (const auto& part : vertices)
    if (part) {
      part->first = count;
      count += part->positions.size();
    }
  if (count > std::numeric_limits<Index>::max())
    throw DataError("the mesh has " + std::to_string(count) +
                    " vertices, more than 32-bit indices count; use larger voxels, or several boxes");

  const CellWalker walker(field, vertices, leafIndex, options.border);
  std::vector<std::vector<openvdb::Vec3I>> triangles(leaves.size());
  monitor.begin("triangles", leaves.size());
  forEachLeaf(tree, leaves.size(), monitor,
              [&](std::size_t i, const Accessor& accessor) { walker.walk(*leaves[i], accessor, triangles[i]); });

  Mesh mesh;
  mesh.points.reserve(count);
  for (const auto& part : vertices)
    if (part) mesh.points.insert(mesh.points.end(), part->positions.begin(), part->positions.end());
  for (const auto& part : triangles) mesh.triangles.insert(mesh.triangles.end(), part.begin(), part.end());
  return mesh;
}

void computeNormals(Mesh& mesh) {
  std::vector<Vec3d> sums(mesh.points.size(), Vec3d(0));
  for (const openvdb::Vec3I& triangle : mesh.triangles) {
    const Vec3d& a = mesh.points[triangle[0]];
    const Vec3d normal = (mesh.points[triangle[1]] - a).cross(mesh.points[triangle[2]] - a);
    for (int k = 0; k < 3; ++k) sums[triangle[k]] += normal;
  }
  mesh.normals.resize(sums.size());
  for (std::size_t i = 0; i < sums.size(); ++i) {
    const double length = sums[i].length();
    // A point whose triangles cancel out has no normal of its own; up is as good as any.
    mesh.normals[i] = length > 0 ? openvdb::Vec3s(sums[i] / length) : openvdb::Vec3s(0, 1, 0);
  }
}

}  // namespace vdbtools
