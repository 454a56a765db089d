// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/surface/extract_mesh.h"

#include "distance/leaves.h"
#include "field/block_evaluator.h"
#include "field/block_layers.h"
#include "field/crumb_filter.h"
#include "field/evaluated_layers.h"
#include "field/undecided_blocks.h"
#include "surface/band_maker.h"
#include "surface/surface_extractor.h"

#include "vdbtools/surface/level_set.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

namespace vdbtools {
namespace {

using openvdb::Vec3d;
using Leaf = SurfaceExtractor::Leaf;

/// The leaves of a field, sorted by x, then y, then z.
std::vector<const Leaf*> sortedLeaves(const openvdb::FloatTree& tree) {
  std::vector<const Leaf*> leaves = leavesOf(tree);
  std::sort(leaves.begin(), leaves.end(), [](const Leaf* a, const Leaf* b) { return a->origin() < b->origin(); });
  return leaves;
}

/// Keeps the whole mesh and its places.
class PlacedCollector final : public PlacedMeshSink {
 public:
  explicit PlacedCollector(PlacedMesh& mesh) : mPlaces(mesh.places), mMesh(mesh.mesh) {}
  void addPoints(const PointBatch& batch, std::span<const EdgePlace> places) override {
    mMesh.addPoints(batch);
    mPlaces.points.insert(mPlaces.points.end(), places.begin(), places.end());
  }
  void addTriangles(std::span<const openvdb::Vec3I> triangles, const openvdb::Coord& block,
                    std::span<const std::uint16_t> cells) override {
    mMesh.addTriangles(triangles, 0);
    for (const std::uint16_t cell : cells) mPlaces.triangles.push_back(block + Leaf::offsetToLocalCoord(cell));
  }

 private:
  MeshPlaces& mPlaces;
  MeshCollector mMesh;
};

/// Keeps the whole mesh, and which of its points lie on caps.
class CappedCollector final : public PlacedMeshSink {
 public:
  explicit CappedCollector(CappedMesh& mesh) : mOnCap(mesh.onCap), mMesh(mesh.mesh) {}
  void addPoints(const PointBatch& batch, std::span<const EdgePlace> places) override {
    mMesh.addPoints(batch);
    for (const EdgePlace& edge : places) mOnCap.push_back(edge.cut);
  }
  void addTriangles(std::span<const openvdb::Vec3I> triangles, const openvdb::Coord&,
                    std::span<const std::uint16_t>) override {
    mMesh.addTriangles(triangles, 0);
  }

 private:
  std::vector<bool>& mOnCap;
  MeshCollector mMesh;
};

MeshCounts extract(const FractalField& field, const FieldSource& source, const ExtractMeshOptions& options,
                   bool normals, SurfaceExtractor::Sink sink, Monitor& monitor) {
  SurfaceExtractor extractor(source,
                             {.extract = options,
                              .domain = field.domain,
                              .window = field.window,
                              .voxelSize = field.field->voxelSize()[0],
                              .capFaces = field.capFaces,
                              .normals = normals},
                             sink, monitor);
  const std::vector<const Leaf*> leaves = sortedLeaves(field.field->tree());
  monitor.begin(PhaseKind::Surface, leaves.size());
  for (auto first = leaves.begin(); first != leaves.end();) {
    const auto last =
        std::find_if(first, leaves.end(), [&](const Leaf* l) { return l->origin()[0] != (*first)->origin()[0]; });
    extractor.add({{{first, last}, nullptr}});
    first = last;
  }
  extractor.finish();
  return {extractor.points(), extractor.triangles()};
}

/// @param band  receives all layers, too; may be null
MeshCounts streamLayers(const FieldPlan& plan, const FieldSource& source, const ExtractMeshOptions& options,
                        bool normals, BandMaker* band, SurfaceExtractor::Sink sink, Monitor& monitor) {
  SurfaceExtractor extractor(source,
                             {.extract = options,
                              .domain = plan.domain,
                              .window = plan.window,
                              .voxelSize = plan.voxelSize,
                              .capFaces = plan.capFaces,
                              .normals = normals,
                              .band = band},
                             sink, monitor);
  const BlockSet undecided = undecidedBlocks(plan, source, monitor);
  BlockLayers layers(undecided);
  BlockEvaluator evaluator(source, {.voxelSize = plan.voxelSize,
                                    .domain = plan.domain,
                                    .window = plan.window,
                                    .proofs = worthwhileProofs(undecided, plan, source)});
  std::optional<CrumbFilter> crumbs;
  if (plan.crumbs) crumbs.emplace(plan, source, monitor);
  std::vector<SurfaceExtractor::Leaves> ready;
  const auto take = [&](std::optional<CrumbFilter::Layer> layer) {
    if (layer) ready.push_back({{layer->leaves.begin(), layer->leaves.end()}, std::move(layer->owner)});
  };
  // Every block is evaluated first and searched later.
  monitor.begin(PhaseKind::Surface, 2 * layers.blockCount());
  EvaluatedLayers evaluated(layers, evaluator, monitor);
  for (auto some = evaluated.next(); !some.empty(); some = evaluated.next()) {
    for (EvaluatedLayers::Layer& each : some) {
      const auto blocks = std::make_shared<EvaluatedLayers::Layer>(std::move(each));
      CrumbFilter::Layer layer{.owner = blocks};
      layer.leaves.reserve(blocks->size());
      for (const EvaluatedBlock& block : *blocks)
        if (block.field) layer.leaves.push_back(block.field.get());
      // Blocks that are proved to have one sign need no search.
      monitor.advance(blocks->size() - layer.leaves.size());
      if (crumbs)
        take(crumbs->add(std::move(layer)));
      else
        take(std::move(layer));
    }
    extractor.add(std::exchange(ready, {}));
  }
  if (crumbs) take(crumbs->finish());
  extractor.add(std::exchange(ready, {}));
  extractor.finish();
  MeshCounts counts{extractor.points(), extractor.triangles(), evaluator.evaluatedNodes()};
  if (crumbs) counts.crumbs = crumbs->report();
  return counts;
}

}  // namespace

Mesh extractMesh(const FractalField& field, const FieldSource& source, const ExtractMeshOptions& options,
                 Monitor& monitor) {
  Mesh mesh;
  MeshCollector collector(mesh);
  extract(field, source, options, false, &collector, monitor);
  return mesh;
}

MeshCounts extractMesh(const FractalField& field, const FieldSource& source, const ExtractMeshOptions& options,
                       MeshSink& sink, Monitor& monitor) {
  return extract(field, source, options, true, &sink, monitor);
}

CappedMesh extractCappedMesh(const FractalField& field, const FieldSource& source, double tolerance, Monitor& monitor) {
  CappedMesh result;
  CappedCollector collector(result);
  extract(field, source, {.tolerance = tolerance, .border = Border::Cap}, false, &collector, monitor);
  return result;
}

PlacedMesh extractPlacedMesh(const FractalField& field, const FieldSource& source, const ExtractMeshOptions& options,
                             Monitor& monitor) {
  PlacedMesh result;
  PlacedCollector collector(result);
  extract(field, source, options, true, &collector, monitor);
  return result;
}

MeshCounts extractPlacedMesh(const FractalField& field, const FieldSource& source, const ExtractMeshOptions& options,
                             PlacedMeshSink& sink, Monitor& monitor) {
  return extract(field, source, options, true, &sink, monitor);
}

Mesh withoutCaps(CappedMesh capped) {
  // Every triangle of a cell that the border crosses has a corner on a cap: around the inside corners of such a cell, a
  // loop crosses at most two edges within the domain's face, and leaves the domain between them.
  constexpr openvdb::Index kDropped = std::numeric_limits<openvdb::Index>::max();
  Mesh& mesh = capped.mesh;
  std::vector<openvdb::Index> kept(mesh.points.size(), kDropped);
  openvdb::Index count = 0;
  for (std::size_t i = 0; i < kept.size(); ++i) {
    if (capped.onCap[i]) continue;
    mesh.points[count] = mesh.points[i];
    kept[i] = count++;
  }
  mesh.points.resize(count);
  std::erase_if(mesh.triangles, [&](const openvdb::Vec3I& triangle) {
    return kept[triangle[0]] == kDropped || kept[triangle[1]] == kDropped || kept[triangle[2]] == kDropped;
  });
  for (openvdb::Vec3I& triangle : mesh.triangles)
    for (int k = 0; k < 3; ++k) triangle[k] = kept[triangle[k]];
  return std::move(mesh);
}

MeshCounts streamMesh(const FieldPlan& plan, const FieldSource& source, const ExtractMeshOptions& options,
                      MeshSink& sink, Monitor& monitor) {
  return streamLayers(plan, source, options, true, nullptr, &sink, monitor);
}

MeshCounts streamPlacedMesh(const FieldPlan& plan, const FieldSource& source, const ExtractMeshOptions& options,
                            PlacedMeshSink& sink, Monitor& monitor) {
  return streamLayers(plan, source, options, true, nullptr, &sink, monitor);
}

StreamedSurface streamSurface(const FieldPlan& plan, const FieldSource& source, double tolerance, bool normals,
                              MeshSink& sink, Monitor& monitor) {
  BandMaker band(plan.voxelSize, plan.domain, monitor);
  StreamedSurface surface{.mesh = streamLayers(plan, source, {.tolerance = tolerance, .border = Border::Cap}, normals,
                                               &band, &sink, monitor),
                          .levelSet = nullptr};
  if (surface.mesh.triangles == 0) return surface;
  monitor.begin(PhaseKind::LevelSet, 0);
  surface.levelSet = band.finish();
  finishLevelSet(*surface.levelSet);
  return surface;
}

openvdb::Vec3s unitNormal(const Vec3d& sum) {
  const double length = sum.length();
  return length > 0 ? openvdb::Vec3s(sum / length) : openvdb::Vec3s(0, 1, 0);
}

void computeNormals(Mesh& mesh) {
  std::vector<Vec3d> sums(mesh.points.size(), Vec3d(0));
  for (const openvdb::Vec3I& triangle : mesh.triangles) {
    const Vec3d& a = mesh.points[triangle[0]];
    const Vec3d normal = (mesh.points[triangle[1]] - a).cross(mesh.points[triangle[2]] - a);
    for (int k = 0; k < 3; ++k) sums[triangle[k]] += normal;
  }
  mesh.normals.resize(sums.size());
  std::transform(sums.begin(), sums.end(), mesh.normals.begin(), unitNormal);
}

}  // namespace vdbtools
