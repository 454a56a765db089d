// SPDX-License-Identifier: Apache-2.0
/// @file surface_extractor.h
/// Makes the mesh of F while its blocks arrive in the order of x. If they arrive layer by layer,
/// at most four layers of blocks are held at a time.
#pragma once

#include "field/leaf_signs.h"
#include "surface/band_maker.h"
#include "surface/edge_search.h"

#include "vdbtools/base/monitor.h"
#include "vdbtools/mesh/mesh_sink.h"
#include "vdbtools/surface/extract_mesh.h"

#include <array>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <variant>
#include <vector>

namespace vdbtools {

/// Points and triangles are ordered by the blocks in which they begin, by x, then y, then z; within a block, by its
/// nodes. The mesh therefore depends on the field alone.
class SurfaceExtractor {
 public:
  using Leaf = LeafSigns::Leaf;

  struct Options {
    ExtractMeshOptions extract;
    openvdb::CoordBBox domain;
    openvdb::CoordBBox window;                 ///< as FieldPlan::window
    double voxelSize = 0;                      ///< world units
    std::optional<openvdb::BBoxd> capFaces{};  ///< as FieldPlan::capFaces
    bool normals = false;
    BandMaker* band = nullptr;  ///< if not null, receives all layers in order; needs Border::Cap
  };

  /// The receiver of the mesh, with places or without.
  using Sink = std::variant<MeshSink*, PlacedMeshSink*>;

  SurfaceExtractor(const FieldSource& source, const Options& options, Sink sink, Monitor& monitor);
  ~SurfaceExtractor();
  SurfaceExtractor(const SurfaceExtractor&) = delete;
  SurfaceExtractor& operator=(const SurfaceExtractor&) = delete;

  /// The leaves of one x, ordered by y, then z.
  struct Leaves {
    std::vector<const Leaf*> leaves;
    std::shared_ptr<void> owner;  ///< keeps the leaves until they are no longer needed
  };
  /// Adds the next layers. Layers come in the order of x; those without leaves are left out. If several are added at
  /// once, as many are held, and their edges are searched together.
  void add(std::vector<Leaves> layers);

  /// Processes the rest; no layer may be added afterwards.
  void finish();

  std::uint64_t points() const { return mPoints; }
  std::uint64_t triangles() const { return mTriangles; }

 private:
  struct LeafVertices;
  struct Layer;

  /// In the order of LeafSigns; absent neighbours are null.
  struct Neighbours {
    std::array<const Layer*, 8> layers{};
    std::array<std::size_t, 8> numbers{};  ///< indices in their layers
    std::array<const Leaf*, 8> leaves{};
    LeafSigns::Neighbours inside{};
  };
  void hold(std::vector<const Leaf*> leaves, std::shared_ptr<void> owner);
  static bool isOneSided(std::size_t leaf, const Layer& layer, const Layer* next);
  static Neighbours neighbours(std::size_t leaf, const Layer& layer, const Layer* next);
  void findEdges(Layer& layer, const Layer* next);
  double capPlace(const openvdb::Coord& node, int axis) const;
  std::unique_ptr<LeafVertices> crossingEdges(const Leaf& leaf, const Neighbours& around) const;
  void countVertices(Layer& layer);
  void placeVertices(std::span<Layer* const> layers) const;
  void findTriangles(Layer& layer, Layer* next);
  void walk(std::size_t leaf, Layer& layer, const Layer* next) const;
  void addNormals(Layer& layer, Layer* next) const;
  void emitPoints(Layer& layer);
  void emitTriangles(Layer& layer);
  void addToBand(const Layer& layer, const Layer* next);
  Layer* behind(std::size_t i) const;
  void findVertices(std::size_t known);
  void advance(std::size_t known, bool finished);

  FieldSource mSource;
  Options mOptions;
  openvdb::CoordBBox mNodes;  ///< nodes that edges and cells may use: in the window, and beyond the domain
  MeshSink* mSink;            ///< null if the mesh is wanted with its places
  PlacedMeshSink* mPlaced;    ///< else null
  Monitor& mMonitor;
  std::deque<std::unique_ptr<Layer>> mLayers;
  std::uint64_t mPoints = 0, mTriangles = 0;
};

}  // namespace vdbtools
