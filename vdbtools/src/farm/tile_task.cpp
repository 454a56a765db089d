// SPDX-License-Identifier: Apache-2.0
#include "farm/tile_task.h"

#include "farm/tile_count.h"
#include "farm/tile_layers.h"
#include "field/block_layers.h"

#include "scene/prepared_scene.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/files/output_files.h"
#include "vdbtools/job/fractal_job.h"
#include "vdbtools/mesh_files/mesh_writer.h"

#include <openvdb/tree/ValueAccessor.h>

#include <algorithm>
#include <span>
#include <utility>

namespace vdbtools::farm {
namespace {

using openvdb::Coord;
using openvdb::CoordBBox;
using openvdb::FloatGrid;
using Leaf = openvdb::FloatTree::LeafNodeType;

std::string numbered(std::uint64_t index, const char* extension) { return "tiles/" + taskName(index) + extension; }

/// @throw DataError  the plan was not made from the prepared scene in its folder
void requireLattice(const TileLattice& lattice, const FieldPlan& plan) {
  if (lattice.domain == plan.domain && lattice.bounded == plan.bounded && lattice.voxelSize == plan.voxelSize) return;
  throw DataError(std::string("the lattice of the plan is not that of '") + kPreparedName + "'; plan again");
}

/// The mesh without its caps, and the places of the rest.
PlacedMesh withoutCaps(PlacedMesh placed) {
  CappedMesh capped{.mesh = std::move(placed.mesh)};
  PlacedMesh result;
  for (const EdgePlace& edge : placed.places.points) {
    capped.onCap.push_back(edge.cut);
    if (!edge.cut) result.places.points.push_back(edge);
  }
  for (std::size_t i = 0; i < capped.mesh.triangles.size(); ++i) {
    const openvdb::Vec3I& t = capped.mesh.triangles[i];
    if (!capped.onCap[t[0]] && !capped.onCap[t[1]] && !capped.onCap[t[2]])
      result.places.triangles.push_back(placed.places.triangles[i]);
  }
  capped.mesh.normals.clear();
  result.mesh = withoutCaps(std::move(capped));
  computeNormals(result.mesh);
  return result;
}

/// Gives the points that are not on caps the normals of the mesh without caps.
void setOpenNormals(PlacedMesh& placed) {
  const PlacedMesh open = withoutCaps(placed);
  std::size_t next = 0;
  for (std::size_t i = 0; i < placed.places.points.size(); ++i)
    if (!placed.places.points[i].cut) placed.mesh.normals[i] = open.mesh.normals[next++];
}

/// Passes on a mesh whose points and triangles are ordered by blocks.
void passOn(const PlacedMesh& placed, PlacedMeshSink& sink) {
  sink.addPoints({placed.mesh.points, placed.mesh.normals}, placed.places.points);
  const std::span<const openvdb::Vec3I> triangles = placed.mesh.triangles;
  const std::vector<Coord>& cells = placed.places.triangles;
  std::vector<std::uint16_t> offsets;
  for (std::size_t begin = 0; begin < cells.size(); begin += offsets.size()) {
    const Coord block = cells[begin] & ~(kBlock - 1);
    offsets.clear();
    for (std::size_t i = begin; i < cells.size() && (cells[i] & ~(kBlock - 1)) == block; ++i)
      offsets.push_back(static_cast<std::uint16_t>(Leaf::coordToOffset(cells[i])));
    sink.addTriangles(triangles.subspan(begin, offsets.size()), block, offsets);
  }
}

/// The evaluated nodes of a grid within a box; its leaves stay, even those without an evaluated node.
FloatGrid::Ptr ownPart(const FloatGrid& whole, const CoordBBox& own) {
  FloatGrid::Ptr part = FloatGrid::create(whole.background());
  part->setTransform(whole.transform().copy());
  part->setName(whole.getName());
  for (auto leaf = whole.tree().cbeginLeaf(); leaf; ++leaf) {
    if (!own.hasOverlap(leaf->getNodeBoundingBox())) continue;
    Leaf* const copy = part->tree().touchLeaf(leaf->origin());
    for (openvdb::Index i = 0; i < Leaf::SIZE; ++i) {
      if (!own.isInside(leaf->offsetToGlobalCoord(i))) continue;
      if (leaf->isValueOn(i))
        copy->setValueOn(i, leaf->getValue(i));
      else
        copy->setValueOff(i, leaf->getValue(i));
    }
  }
  return part;
}

bool capsMesh(const Scene& scene, const FieldPlan& plan) { return scene.options.surface.cap || !plan.bounded; }

/// A tile with grids, or with islands: its window's field and mesh are held as a whole.
Tile makeHeldTile(const Scene& scene, const FieldPlan& plan, const CoordBBox& box, const FractalProducts& wanted,
                  const TileLayerSink& layers, Monitor& monitor) {
  const GridPlan grids = wanted.grids ? planGrids(scene.options.output) : GridPlan{};
  const CoordBBox own = ownNodes(box, plan.domain);
  const FractalField field = evaluateField(plan, scene.source(), grids.evaluation(), monitor);
  Tile tile{.evaluatedNodes = field.evaluatedNodes, .crumbs = field.crumbs};
  const bool dropped = dropsIslands(scene.options);
  if (dropped) tile.islands.emplace(field, scene.source(), box, monitor);
  const bool wantsSurface = grids.needsLevelSet();
  const bool capMesh = capsMesh(scene, plan);
  PlacedMesh placed = extractPlacedMesh(
      field, scene.source(),
      {.tolerance = scene.options.surface.tolerance, .border = capMesh || wantsSurface ? Border::Cap : Border::Open},
      monitor);
  if (wantsSurface && !dropped) {
    const FloatGrid::Ptr surface = levelSetPart(field, scene.source(), placed.mesh, own, monitor);
    surface->setName("surface");
    tile.grids.push_back(surface);
  }
  if (grids.has(OutputGrid::LogModulus)) tile.grids.push_back(ownPart(*field.field, own));
  if (grids.has(OutputGrid::Iterations)) tile.grids.push_back(ownPart(*field.iterations, own));
  if (!wanted.mesh && !(wantsSurface && dropped)) return tile;
  if (wantsSurface && !capMesh) {
    if (dropped)
      setOpenNormals(placed);
    else
      placed = withoutCaps(std::move(placed));
  }
  TileLayers ownLayers(own, tile.islands ? &*tile.islands : nullptr, layers);
  passOn(placed, ownLayers);
  ownLayers.finish();
  return tile;
}

}  // namespace

std::string tileMeshName(std::uint64_t index) { return numbered(index, ".tile"); }
std::string tileGridsName(std::uint64_t index) { return numbered(index, ".vdb"); }
std::string tileIslandsName(std::uint64_t index) { return numbered(index, ".islands"); }
std::string tileCountName(std::uint64_t index) { return numbered(index, ".json"); }

TileFiles tileFiles(const Manifest& manifest, const FractalOptions& options) {
  if (makes(manifest, kMakeCount)) return {.count = true};
  TileFiles files{.mesh = makesMesh(manifest), .grids = makesGrids(manifest), .islands = dropsIslands(options)};
  if (!files.islands || !files.grids) return files;
  const GridPlan grids = planGrids(options.output);
  files.cappedMesh = grids.needsLevelSet();
  files.mesh = files.mesh || files.cappedMesh;
  files.grids = grids.has(OutputGrid::LogModulus) || grids.has(OutputGrid::Iterations);
  return files;
}

TileJob tileJob(const Manifest& manifest) {
  TileJob job{.manifest = manifest, .options = parseFractalOptions(manifest.recipe), .grids = {}, .files = {}};
  if (makesGrids(manifest)) job.grids = planGrids(job.options.output);
  job.files = tileFiles(manifest, job.options);
  return job;
}

std::vector<std::string> tileNames(const TileFiles& files, std::uint64_t index) {
  std::vector<std::string> names;
  if (files.mesh) names.push_back(tileMeshName(index));
  if (files.grids) names.push_back(tileGridsName(index));
  if (files.islands) names.push_back(tileIslandsName(index));
  if (files.count) names.push_back(tileCountName(index));
  return names;
}

void requireCuttable(const FractalOptions& options, const std::vector<std::string>& makes) {
  if (options.lattice.follow)
    throw std::invalid_argument(
        "a fractal that is made by following its surface cannot be cut into tiles, as the way leads through all of "
        "them; leave out the option to follow it");
  if (options.surface.adaptivity > 0)
    throw std::invalid_argument(
        "--adaptivity needs the whole mesh at once, and tiles are merged without holding it; leave it out, or make the "
        "fractal in one run");
  if (options.output.attributes.has(PointAttribute::Mask))
    throw std::invalid_argument(
        "--attributes is to have 'mask', but the tasks of a plan and its merging know the mask only as a part of the "
        "exponent; leave it out, or make the fractal in one run");
  if (makes != std::vector<std::string>{kMakeCount}) return;
  if (dropsIslands(options))
    throw std::invalid_argument(
        "--make count keeps no tiles, and islands are joined through all of them; leave out --largest and --min-size, "
        "or give --make ply");
  if (!options.output.attributes.empty())
    throw std::invalid_argument(
        "--make count writes no points, which could have attributes; leave out --attributes, --colour and --transfer, "
        "or give --make ply");
}

CoordBBox ownNodes(const CoordBBox& box, const CoordBBox& domain) {
  CoordBBox own = box;
  for (int axis = 0; axis < 3; ++axis) {
    if (box.min()[axis] == domain.min()[axis]) own.min()[axis] -= 2 * kBlock;
    if (box.max()[axis] == domain.max()[axis]) own.max()[axis] += 2 * kBlock;
  }
  return own;
}

Tile makeTile(const Scene& scene, const CoordBBox& box, const FractalProducts& wanted, const TileLayerSink& layers,
              Monitor& monitor) {
  const bool held = wanted.grids || dropsIslands(scene.options);
  CoordBBox window = box;
  window.expand(held ? kTileHalo : kMeshHalo);
  FieldPlan plan = planScene(scene, window);
  if (plan.crumbs) plan.crumbs->counted = box;
  if (held) return makeHeldTile(scene, plan, box, wanted, layers, monitor);
  TileLayers own(ownNodes(box, plan.domain), nullptr, layers);
  const MeshCounts made = streamPlacedMesh(
      plan, scene.source(),
      {.tolerance = scene.options.surface.tolerance, .border = capsMesh(scene, plan) ? Border::Cap : Border::Open}, own,
      monitor);
  own.finish();
  return {.evaluatedNodes = made.evaluatedNodes, .crumbs = made.crumbs};
}

bool tilesNeedDoubles(const TileJob& job) {
  // Attributes are computed at the merged vertices, which must equal those of a single run bit for bit.
  if (!job.options.output.attributes.empty()) return true;
  const TileLattice& lattice = job.lattice();
  // They are rounded once, after they are moved.
  if (latticeOffset(job.options, lattice.voxelSize) != openvdb::Vec3d(0)) return true;
  const openvdb::BBoxd box = meshBox({.domain = lattice.domain, .voxelSize = lattice.voxelSize});
  return std::ranges::any_of(formatsOf(job.manifest.makes), [&](const FileFormat* format) {
    return format->writesMesh && needsDoublePositions({.format = format, .voxelSize = lattice.voxelSize, .box = box});
  });
}

TileMaker::TileMaker(std::filesystem::path folder, const Manifest& manifest)
    : mFolder(std::move(folder)), mManifest(manifest), mJob(tileJob(mManifest)) {}

const Scene& TileMaker::scene() {
  if (mScene) return *mScene;
  // The files of controls have been used for the exponent, and need not be available.
  std::vector<NamedFile> present = mJob.options.map->files();
  std::erase_if(present, [](const NamedFile& file) { return !std::filesystem::exists(file.path); });
  verifiedHashes(present);
  Scene scene = readPreparedScene(mJob.options, mFolder / kPreparedName);
  requireLattice(mJob.lattice(), planScene(scene, CoordBBox()));
  return mScene.emplace(std::move(scene));
}

TaskCounts TileMaker::make(std::uint64_t index, Monitor& monitor) {
  const bool onlyCounts = makes(mManifest, kMakeCount);
  const FractalProducts wanted{.grids = makesGrids(mManifest), .mesh = makesMesh(mManifest) || onlyCounts};
  const TileFiles& written = mJob.files;
  OutputFiles files(inputsOf(mJob.options));
  AtomicFile* const mesh = written.mesh ? &files.add(mFolder / tileMeshName(index)) : nullptr;
  AtomicFile* const grids = written.grids ? &files.add(mFolder / tileGridsName(index)) : nullptr;
  AtomicFile* const islands = written.islands ? &files.add(mFolder / tileIslandsName(index)) : nullptr;
  AtomicFile* const count = written.count ? &files.add(mFolder / tileCountName(index)) : nullptr;
  TileEncoder encoder(written.cappedMesh || tilesNeedDoubles(mJob));
  TileCounter counter;
  const Tile tile = makeTile(
      scene(), mManifest.tasks.at(index - 1).box.value(), wanted,
      [&](const TileLayer& layer) {
        if (mesh) encoder.add(layer);
        if (count) counter.add(layer);
      },
      monitor);
  monitor.begin(PhaseKind::Writing, 0);
  TaskCounts counts;
  counts.counts["evaluatedNodes"] = tile.evaluatedNodes;
  if (tile.crumbs) {
    counts.counts[kCrumbsCount] = tile.crumbs->crumbs;
    counts.counts[kCrumbNodesCount] = tile.crumbs->nodes;
  }
  if (count) {
    const TileCount of = counter.count();
    count->stream() << encodeTileCount(of);
    counts.counts["points"] = of.points;
    counts.counts["triangles"] = of.triangles;
  }
  if (mesh) {
    encoder.write(mesh->stream());
    const TileCounts& of = encoder.counts();
    counts.counts["points"] = of.points;
    counts.counts["triangles"] = of.triangles;
  }
  // Not in half floats like the result: merging needs all digits.
  if (grids) grids->stream() << encodeVdb(tile.grids, {});
  if (islands) tile.islands->write(islands->stream());
  monitor.throwIfCancelled();
  files.commit();
  return counts;
}

}  // namespace vdbtools::farm
