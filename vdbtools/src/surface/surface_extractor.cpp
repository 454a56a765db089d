// SPDX-License-Identifier: Apache-2.0
#include "surface/surface_extractor.h"

#include "base/in_parallel.h"
#include "field/block_layers.h"
#include "surface/marching_cubes_table.h"

#include <algorithm>
#include <array>
#include <bit>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

namespace vdbtools {

using openvdb::Coord;
using openvdb::CoordBBox;
using openvdb::Index;
using openvdb::Vec3d;

namespace {

constexpr std::uint16_t kNoVertex = 0xffff;

constexpr unsigned kSide = LeafSigns::kSide;

// The typical number of edges of a leaf that the surface crosses; memory for these is allocated at once.
constexpr std::size_t kUsualEdges = 64;

Coord cornerOf(const Coord& node, unsigned corner) {
  return node.offsetBy(corner & 1, corner >> 1 & 1, corner >> 2 & 1);
}

}  // namespace

/// The vertices on the edges that begin at a leaf's nodes.
struct SurfaceExtractor::LeafVertices {
  std::array<std::uint16_t, 3 * Leaf::SIZE> onEdge;  // index among the leaf's vertices, by 3 offset + axis
  std::size_t first = 0;                             // index among the layer's vertices
  std::vector<LatticeEdge> edges;                    // until they have been searched

  LeafVertices() { onEdge.fill(kNoVertex); }
};

struct SurfaceExtractor::Layer {
  enum class Stage { Added, HasVertices, HasTriangles };
  enum class Sides : std::uint8_t { Inside, Outside, Both };
  static constexpr std::uint32_t kNone = 0xffffffff;

  int x = 0;  // x of the blocks' first nodes
  std::vector<const Leaf*> leaves;
  std::vector<Coord> origins;      // of each leaf; if places are requested or a band is made
  std::vector<InsideBits> inside;  // of each leaf
  std::vector<Sides> sides;        // of each leaf's nodes
  std::shared_ptr<void> owner;
  std::vector<std::array<std::uint32_t, 8>> around;  // for each leaf: the numbers of its neighbours, or kNone
  Stage stage = Stage::Added;
  std::vector<std::unique_ptr<LeafVertices>> vertices;  // for each leaf; null: no edge crosses
  std::vector<Vec3d> positions;                         // world units
  std::vector<Vec3d> normals;                           // sums of the triangles' normals, weighted by area
  std::uint64_t first = 0;                              // index among all vertices
  std::vector<std::vector<openvdb::Vec3I>> triangles;   // of each leaf
  std::vector<EdgePlace> places;                        // of the vertices, if requested
  std::vector<std::vector<std::uint16_t>> cells;        // of each triangle, for each leaf; if requested

  /// Finds the neighbours of all leaves, in the order of LeafSigns.
  void findNeighbours(const Layer* next) {
    around.resize(leaves.size());
    for (unsigned k = 0; k < 8; ++k) {
      const Layer* const of = k & 1 ? next : this;
      const int dy = k & 2 ? kBlock : 0, dz = k & 4 ? kBlock : 0;
      // Both traverse the leaves in the same order.
      std::size_t other = 0;
      for (std::size_t i = 0; i < leaves.size(); ++i) {
        const std::pair wanted(leaves[i]->origin()[1] + dy, leaves[i]->origin()[2] + dz);
        const auto place = [&] { return std::pair(of->leaves[other]->origin()[1], of->leaves[other]->origin()[2]); };
        while (of && other < of->leaves.size() && place() < wanted) ++other;
        const bool found = of && other < of->leaves.size() && place() == wanted;
        around[i][k] = found ? static_cast<std::uint32_t>(other) : kNone;
      }
    }
  }
};

SurfaceExtractor::SurfaceExtractor(const FieldSource& source, const Options& options, Sink sink, Monitor& monitor)
    : mSource(source), mOptions(options), mMonitor(monitor) {
  MeshSink* const* const plain = std::get_if<MeshSink*>(&sink);
  PlacedMeshSink* const* const placed = std::get_if<PlacedMeshSink*>(&sink);
  mSink = plain ? *plain : nullptr;
  mPlaced = placed ? *placed : nullptr;
  mNodes = options.window;
  for (int axis = 0; axis < 3; ++axis) {
    // The window ends there with the domain, and a cap lies beyond.
    if (mNodes.min()[axis] <= options.domain.min()[axis]) --mNodes.min()[axis];
    if (mNodes.max()[axis] >= options.domain.max()[axis]) ++mNodes.max()[axis];
  }
  const double tolerance = options.extract.tolerance;
  if (!(tolerance >= 0x1p-40 && tolerance <= 0.5))
    throw std::invalid_argument("the tolerance of edge searches is " + std::to_string(tolerance) +
                                " voxels; it must be at most 0.5 and at least 1e-12");
}

SurfaceExtractor::~SurfaceExtractor() = default;

void SurfaceExtractor::add(std::vector<Leaves> layers) {
  std::size_t held = 0;
  for (Leaves& layer : layers) {
    if (layer.leaves.empty()) continue;
    hold(std::move(layer.leaves), std::move(layer.owner));
    ++held;
  }
  if (held == 0) return;
  findVertices(mLayers.size() - 1);
  // The mesh is passed on in the order in which layers that arrive one by one would make it.
  for (; held > 0; --held) advance(mLayers.size() - held, false);
}

void SurfaceExtractor::hold(std::vector<const Leaf*> leaves, std::shared_ptr<void> owner) {
  auto layer = std::make_unique<Layer>();
  layer->x = leaves.front()->origin()[0];
  layer->inside.resize(leaves.size());
  layer->sides.resize(leaves.size());
  inParallel(leaves.size(), 64, mMonitor, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const InsideBits bits = insideBits(*leaves[i]);
      layer->inside[i] = bits;
      const bool same = std::all_of(bits.begin(), bits.end(), [&](std::uint64_t word) { return word == bits[0]; });
      layer->sides[i] = same && bits[0] == 0                   ? Layer::Sides::Outside
                        : same && bits[0] == ~std::uint64_t{0} ? Layer::Sides::Inside
                                                               : Layer::Sides::Both;
    }
  });
  // The leaves will be gone when the triangles are passed on.
  if (mPlaced || mOptions.band) {
    layer->origins.reserve(leaves.size());
    for (const Leaf* const leaf : leaves) layer->origins.push_back(leaf->origin());
  }
  layer->leaves = std::move(leaves);
  layer->owner = std::move(owner);
  mLayers.push_back(std::move(layer));
}

void SurfaceExtractor::finish() {
  findVertices(mLayers.size());
  advance(mLayers.size(), true);
}

/// The next layer after number @a i, if it is adjacent.
SurfaceExtractor::Layer* SurfaceExtractor::behind(std::size_t i) const {
  return i + 1 < mLayers.size() && mLayers[i + 1]->x == mLayers[i]->x + kBlock ? mLayers[i + 1].get() : nullptr;
}

/// Finds the vertices of the first @a known layers, whose next layers are known.
void SurfaceExtractor::findVertices(std::size_t known) {
  std::vector<Layer*> added;
  for (std::size_t i = 0; i < known; ++i) {
    if (mLayers[i]->stage != Layer::Stage::Added) continue;
    findEdges(*mLayers[i], behind(i));
    added.push_back(mLayers[i].get());
  }
  placeVertices(added);
}

/// Advances every layer as far as possible from the vertices of the first @a known layers.
/// @param finished  whether no layer comes after these
void SurfaceExtractor::advance(std::size_t known, bool finished) {
  using Stage = Layer::Stage;
  for (std::size_t i = 0; i < known; ++i) {
    Layer* next = behind(i);
    if (mLayers[i]->stage != Stage::HasVertices || (next && i + 1 >= known)) continue;
    findTriangles(*mLayers[i], next);
    emitPoints(*mLayers[i]);
    mLayers[i]->owner.reset();
  }
  for (; !mLayers.empty() && mLayers[0]->stage == Stage::HasTriangles; --known) {
    const Layer* next = behind(0);
    // Triangles use the next layer's points, which must be passed on first.
    if (!finished && known == 0) return;
    if (next && next->stage != Stage::HasTriangles) return;
    emitTriangles(*mLayers[0]);
    if (mOptions.band) addToBand(*mLayers[0], next);
    mLayers.pop_front();
  }
}

/// Whether the nodes of a leaf and of its neighbours are on one side, so that nothing begins in it.
bool SurfaceExtractor::isOneSided(std::size_t leaf, const Layer& layer, const Layer* next) {
  const Layer::Sides own = layer.sides[leaf];
  if (own == Layer::Sides::Both) return false;
  for (unsigned k = 1; k < 8; ++k) {
    const std::uint32_t found = layer.around[leaf][k];
    if (found != Layer::kNone && (k & 1 ? next : &layer)->sides[found] != own) return false;
  }
  return true;
}

SurfaceExtractor::Neighbours SurfaceExtractor::neighbours(std::size_t leaf, const Layer& layer, const Layer* next) {
  Neighbours result;
  for (unsigned k = 0; k < 8; ++k) {
    const std::uint32_t found = layer.around[leaf][k];
    if (found == Layer::kNone) continue;
    const Layer* const of = k & 1 ? next : &layer;
    result.layers[k] = of;
    result.numbers[k] = found;
    result.leaves[k] = of->leaves[found];
    result.inside[k] = &of->inside[found];
  }
  return result;
}

/// The crossing edges that begin in a layer, with a vertex on each.
void SurfaceExtractor::findEdges(Layer& layer, const Layer* next) {
  layer.vertices.resize(layer.leaves.size());
  layer.findNeighbours(next);
  inParallel(layer.leaves.size(), 16, mMonitor, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      if (!isOneSided(i, layer, next)) layer.vertices[i] = crossingEdges(*layer.leaves[i], neighbours(i, layer, next));
  });
  countVertices(layer);
}

/// Where an edge that leaves the domain is cut, voxels from its first node.
double SurfaceExtractor::capPlace(const Coord& node, int axis) const {
  if (!mOptions.capFaces) return 0.5;
  const bool enters = node[axis] < mOptions.domain.min()[axis];
  return (enters ? mOptions.capFaces->min() : mOptions.capFaces->max())[axis] - node[axis];
}

/// The crossing edges that begin at a leaf's nodes, in their order; null if there are none.
std::unique_ptr<SurfaceExtractor::LeafVertices> SurfaceExtractor::crossingEdges(const Leaf& leaf,
                                                                                const Neighbours& around) const {
  const LeafSigns signs(around.inside);
  std::unique_ptr<LeafVertices> vertices;
  for (unsigned x = 0; x < kSide; ++x)
    for (unsigned y = 0; y < kSide; ++y) {
      const std::array<unsigned, 3> crossings = {signs.crossings(x, y, 0), signs.crossings(x, y, 1),
                                                 signs.crossings(x, y, 2)};
      for (unsigned rest = crossings[0] | crossings[1] | crossings[2]; rest != 0; rest &= rest - 1) {
        const auto z = static_cast<unsigned>(std::countr_zero(rest));
        const Index offset = (x * kSide + y) * kSide + z;
        const Coord node = leaf.offsetToGlobalCoord(offset);
        const unsigned at[3] = {x, y, z};
        for (unsigned axis = 0; axis < 3; ++axis) {
          if (!(crossings[axis] >> z & 1)) continue;
          Coord ahead = node;
          ++ahead[static_cast<int>(axis)];
          if (!mNodes.isInside(node) || !mNodes.isInside(ahead)) continue;
          const bool cut = !mOptions.domain.isInside(node) || !mOptions.domain.isInside(ahead);
          if (cut && mOptions.extract.border == Border::Open) continue;
          const Leaf* of = at[axis] + 1 < kSide ? &leaf : around.leaves[std::size_t{1} << axis];
          if (!vertices) {
            vertices = std::make_unique<LeafVertices>();
            vertices->edges.reserve(kUsualEdges);
          }
          vertices->onEdge[3 * offset + axis] = static_cast<std::uint16_t>(vertices->edges.size());
          LatticeEdge& edge = vertices->edges.emplace_back(
              LatticeEdge{node, static_cast<int>(axis), leaf.getValue(offset), of->getValue(ahead)});
          if (cut) edge.cut = capPlace(node, static_cast<int>(axis));
        }
      }
    }
  return vertices;
}

/// Numbers a layer's vertices, continuing after the layers before it.
void SurfaceExtractor::countVertices(Layer& layer) {
  std::size_t count = 0;
  for (const auto& part : layer.vertices)
    if (part) {
      part->first = count;
      count += part->edges.size();
    }
  layer.first = mPoints;
  mPoints += count;
  if (mPoints > std::numeric_limits<Index>::max())
    throw DataError("the mesh has more than " + std::to_string(std::numeric_limits<Index>::max()) +
                    " vertices, the most that 32-bit indices can count; use larger voxels, or cut the lattice into "
                    "tiles that are meshed one by one");
  layer.positions.resize(count);
  if (mPlaced) layer.places.resize(count);
  if (mOptions.normals) layer.normals.assign(count, Vec3d(0));
}

/// Searches the edges of layers for their vertices, and discards the edges.
void SurfaceExtractor::placeVertices(std::span<Layer* const> layers) const {
  /// The leaves of a layer whose edges are searched together.
  struct Part {
    Layer* layer;
    std::size_t begin, end;
  };
  const auto take = [this](const Part& part, std::vector<LatticeEdge>& edges) {
    const std::size_t before = edges.size();
    std::size_t first = 0;
    for (std::size_t i = part.begin; i < part.end; ++i) {
      LeafVertices* const vertices = part.layer->vertices[i].get();
      if (!vertices) continue;
      if (edges.size() == before) first = vertices->first;
      edges.insert(edges.end(), vertices->edges.begin(), vertices->edges.end());
      vertices->edges = {};
    }
    if (mPlaced)
      std::transform(edges.begin() + static_cast<std::ptrdiff_t>(before), edges.end(),
                     part.layer->places.begin() + static_cast<std::ptrdiff_t>(first), [](const LatticeEdge& edge) {
                       return EdgePlace{edge.begin, static_cast<std::uint8_t>(edge.axis), edge.cut.has_value()};
                     });
    return first;
  };
  const auto search = [this](const std::vector<LatticeEdge>& edges) {
    return searchEdges(edges, mOptions.voxelSize, mSource, mOptions.extract.tolerance);
  };
  if (mSource.evaluator.preferredNodes() > 0) {
    // A device gets them all at once.
    std::vector<LatticeEdge> edges;
    for (Layer* const layer : layers) take({layer, 0, layer->leaves.size()}, edges);
    const std::vector<Vec3d> found = edges.empty() ? std::vector<Vec3d>() : search(edges);
    auto first = found.begin();
    for (Layer* const layer : layers) {
      std::copy_n(first, layer->positions.size(), layer->positions.begin());
      first += static_cast<std::ptrdiff_t>(layer->positions.size());
    }
  } else {
    // A leaf that the surface crosses completely has at least this many edges.
    constexpr std::size_t kEdgesOfLeaf = kBlock * kBlock;
    const std::size_t together = std::max<std::size_t>(1, mSource.evaluator.preferredBatch() / kEdgesOfLeaf);
    for (Layer* const layer : layers)
      inParallel(layer->leaves.size(), together, mMonitor, [&](std::size_t begin, std::size_t end) {
        std::vector<LatticeEdge> edges;
        const std::size_t first = take({layer, begin, end}, edges);
        const std::vector<Vec3d> found = search(edges);
        std::copy(found.begin(), found.end(), layer->positions.begin() + static_cast<std::ptrdiff_t>(first));
      });
  }
  for (Layer* const layer : layers) {
    mMonitor.advance(layer->leaves.size());
    layer->stage = Layer::Stage::HasVertices;
  }
}

/// The triangles of the cells that begin at a leaf's nodes.
void SurfaceExtractor::walk(std::size_t leafIndex, Layer& layer, const Layer* next) const {
  const Leaf& leaf = *layer.leaves[leafIndex];
  const Coord origin = leaf.origin();
  const Neighbours around = neighbours(leafIndex, layer, next);
  std::array<const LeafVertices*, 8> vertices{};
  std::array<std::uint64_t, 8> firsts{};
  bool any = false;
  for (unsigned k = 0; k < 8; ++k) {
    if (!around.layers[k] || !around.layers[k]->vertices[around.numbers[k]]) continue;
    vertices[k] = around.layers[k]->vertices[around.numbers[k]].get();
    firsts[k] = around.layers[k]->first + vertices[k]->first;
    any = true;
  }
  if (!any) return;
  const auto vertex = [&](const Coord& node, std::size_t cellEdge) {
    const CellEdge& edge = cellEdges()[cellEdge];
    const Coord begin = cornerOf(node, static_cast<unsigned>(edge.corner));
    unsigned neighbour = 0;
    for (unsigned axis = 0; axis < 3; ++axis)
      if (begin[static_cast<int>(axis)] >= origin[static_cast<int>(axis)] + kBlock) neighbour |= 1u << axis;
    const std::uint16_t local =
        vertices[neighbour]
            ? vertices[neighbour]->onEdge[3 * Leaf::coordToOffset(begin) + static_cast<Index>(edge.axis)]
            : kNoVertex;
    if (local == kNoVertex)
      throw std::logic_error("F changes sign on an edge at " + std::to_string(begin[0]) + ", " +
                             std::to_string(begin[1]) + ", " + std::to_string(begin[2]) + " that no block owns");
    return static_cast<Index>(firsts[neighbour] + local);
  };
  const LeafSigns signs(around.inside);
  const CoordBBox reached(origin, origin.offsetBy(kBlock));
  const bool nearBorder = !mOptions.domain.isInside(reached), nearEnd = !mNodes.isInside(reached);
  std::vector<openvdb::Vec3I>& triangles = layer.triangles[leafIndex];
  triangles.reserve(2 * kUsualEdges);
  if (mPlaced) layer.cells[leafIndex].reserve(2 * kUsualEdges);
  for (unsigned x = 0; x < kSide; ++x)
    for (unsigned y = 0; y < kSide; ++y)
      for (unsigned rest = signs.mixedCells(x, y); rest != 0; rest &= rest - 1) {
        const auto z = static_cast<unsigned>(std::countr_zero(rest));
        const Index offset = (x * kSide + y) * kSide + z;
        const Coord node = leaf.offsetToGlobalCoord(offset);
        if (nearBorder && mOptions.extract.border == Border::Open &&
            !mOptions.domain.isInside(CoordBBox(node, node.offsetBy(1))))
          continue;
        if (nearEnd && !mNodes.isInside(CoordBBox(node, node.offsetBy(1)))) continue;
        for (const CellTriangle& triangle : cellTriangles(signs.cell(x, y, z))) {
          if (mPlaced) layer.cells[leafIndex].push_back(static_cast<std::uint16_t>(offset));
          triangles.emplace_back(vertex(node, triangle[0]), vertex(node, triangle[1]), vertex(node, triangle[2]));
        }
      }
}

void SurfaceExtractor::findTriangles(Layer& layer, Layer* next) {
  layer.triangles.resize(layer.leaves.size());
  if (mPlaced) layer.cells.resize(layer.leaves.size());
  inParallel(layer.leaves.size(), 16, mMonitor, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      if (!isOneSided(i, layer, next)) walk(i, layer, next);
  });
  if (mOptions.normals) addNormals(layer, next);
  layer.stage = Layer::Stage::HasTriangles;
}

/// Adds to the sums in the order of the triangles, which does not depend on the threads.
void SurfaceExtractor::addNormals(Layer& layer, Layer* next) const {
  const std::uint64_t behind = layer.first + layer.positions.size();
  const auto at = [&](Index i) -> const Vec3d& {
    return i < behind ? layer.positions[i - layer.first] : next->positions[i - next->first];
  };
  for (const auto& part : layer.triangles)
    for (const openvdb::Vec3I& triangle : part) {
      const Vec3d& a = at(triangle[0]);
      const Vec3d normal = (at(triangle[1]) - a).cross(at(triangle[2]) - a);
      for (int k = 0; k < 3; ++k) {
        const Index i = triangle[k];
        (i < behind ? layer.normals[i - layer.first] : next->normals[i - next->first]) += normal;
      }
    }
}

void SurfaceExtractor::emitPoints(Layer& layer) {
  std::vector<openvdb::Vec3s> units(layer.normals.size());
  inParallel(units.size(), 4096, mMonitor, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) units[i] = unitNormal(layer.normals[i]);
  });
  layer.normals = {};
  const PointBatch batch{layer.positions, units};
  if (layer.positions.empty()) return;
  if (mPlaced)
    mPlaced->addPoints(batch, layer.places);
  else
    mSink->addPoints(batch);
}

void SurfaceExtractor::addToBand(const Layer& layer, const Layer* next) {
  mOptions.band->add({.x = layer.x,
                      .blocks = layer.origins,
                      .inside = layer.inside,
                      .triangles = layer.triangles,
                      .first = layer.first,
                      .positions = layer.positions,
                      .positionsBehind = next ? std::span<const Vec3d>(next->positions) : std::span<const Vec3d>()});
}

void SurfaceExtractor::emitTriangles(Layer& layer) {
  for (std::size_t i = 0; i < layer.triangles.size(); ++i) {
    const std::vector<openvdb::Vec3I>& part = layer.triangles[i];
    if (part.empty()) continue;
    if (mPlaced)
      mPlaced->addTriangles(part, layer.origins[i], layer.cells[i]);
    else
      mSink->addTriangles(part, layer.first);
    mTriangles += part.size();
  }
}

}  // namespace vdbtools
