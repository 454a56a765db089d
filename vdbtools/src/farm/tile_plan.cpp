// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/farm/plans.h"

#include "farm/tile_task.h"
#include "farm/variant_plan.h"
#include "field/block_layers.h"

#include "julia/evaluator.h"
#include "scene/prepared_scene.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/farm/manifest.h"
#include "vdbtools/files/atomic_file.h"
#include "vdbtools/files/named_file.h"
#include "vdbtools/job/fractal_job.h"
#include "vdbtools/mesh_files/mesh_writer.h"
#include "vdbtools/scene/voxel_advice.h"
#include "vdbtools/surface/extract_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <stdexcept>
#include <utility>

namespace vdbtools::farm {
namespace {

using openvdb::Coord;
using openvdb::CoordBBox;

/// The parts of the boxes that lie within another box.
std::vector<CoordBBox> clipped(std::span<const CoordBBox> boxes, const CoordBBox& within) {
  std::vector<CoordBBox> result;
  for (CoordBBox box : boxes) {
    box.intersect(within);
    if (!box.empty()) result.push_back(box);
  }
  return result;
}

/// The interval of @a side nodes to which a node belongs.
int intervalOf(int node, int side) { return node >= 0 ? node / side : -((-node + side - 1) / side); }
int blockOf(int node) { return intervalOf(node, kBlock); }

/// The cut along an axis that puts about @a share of the work before it: the first node after the cut, a multiple of 8;
/// empty if all work is in one block.
std::optional<int> whereToCut(const std::vector<CoordBBox>& work, const CoordBBox& around, int axis, double share) {
  const int first = blockOf(around.min()[axis]), last = blockOf(around.max()[axis]);
  if (first == last) return std::nullopt;
  // For each block along the axis: the change of the work per node there.
  std::vector<double> begins(static_cast<std::size_t>(last - first) + 2, 0.0);
  double all = 0;
  for (const CoordBBox& box : work) {
    // The work is spread evenly over the blocks that the box touches.
    const int low = blockOf(box.min()[axis]), high = blockOf(box.max()[axis]);
    const double each = volumeOf(box) / (high - low + 1);
    begins[static_cast<std::size_t>(low - first)] += each;
    begins[static_cast<std::size_t>(high - first) + 1] -= each;
    all += volumeOf(box);
  }
  int best = first + 1;
  double before = 0, rate = 0, bestMiss = INFINITY;
  for (int block = first; block < last; ++block) {
    rate += begins[static_cast<std::size_t>(block - first)];
    before += rate;
    if (const double miss = std::abs(before - share * all); miss < bestMiss) {
      bestMiss = miss;
      best = block + 1;
    }
  }
  return best * kBlock;
}

void cut(const CoordBBox& box, std::vector<CoordBBox> work, int count, std::vector<TileBox>& tiles) {
  if (work.empty()) return;
  CoordBBox around;
  for (const CoordBBox& one : work) around.expand(one);
  const std::array<int, 3> byLength = [&] {
    std::array<int, 3> axes = {0, 1, 2};
    std::stable_sort(axes.begin(), axes.end(), [&](int a, int b) { return around.dim()[a] > around.dim()[b]; });
    return axes;
  }();
  const int firstCount = count / 2;
  for (const int axis : byLength) {
    if (count == 1) break;
    const std::optional<int> at = whereToCut(work, around, axis, double(firstCount) / count);
    if (!at) continue;
    CoordBBox low = box, high = box;
    low.max()[axis] = *at - 1;
    high.min()[axis] = *at;
    std::vector<CoordBBox> lowWork = clipped(work, low);
    work = clipped(work, high);
    cut(low, std::move(lowWork), firstCount, tiles);
    cut(high, std::move(work), count - firstCount, tiles);
    return;
  }
  TileBox tile{box};
  for (const CoordBBox& one : work) tile.work += volumeOf(one);
  tiles.push_back(tile);
}

/// Checks that the merged products can hold the fractal; its tiles always can.
void requireFormats(const std::vector<std::string>& makes, double voxelSize, const FieldPlan& whole) {
  for (const FileFormat* format : formatsOf(makes))
    if (format->writesGrids)
      requireVdbVoxel(voxelSize);
    else
      needsDoublePositions({.format = format, .voxelSize = voxelSize, .box = meshBox(whole)});
}

/// Boxes of nodes that the tiles must cover.
std::vector<CoordBBox> workOf(const Scene& scene, const FieldPlan& whole) {
  const bool everywhere = !scene.exponent() || scene.options.lattice.exhaustive;
  std::vector<CoordBBox> work = undecidedBoxes(everywhere ? nullptr : &*scene.exponent(), whole);
  if (everywhere || !whole.bounded) return work;
  // There are caps where the box cuts the set.
  for (int axis = 0; axis < 3; ++axis)
    for (const bool far : {false, true}) {
      CoordBBox face = whole.domain;
      (far ? face.min() : face.max())[axis] = (far ? face.max() : face.min())[axis];
      work.push_back(face);
    }
  return work;
}

/// Adds the cubes without work that lie inside the set. F has one sign in each, and in all adjacent ones.
void addInsideCubes(const Scene& scene, const FieldPlan& whole, int side, std::vector<TileBox>& tiles) {
  std::set<Coord> present;
  for (const TileBox& tile : tiles)
    present.insert(Coord(intervalOf(tile.nodes.min()[0], side), intervalOf(tile.nodes.min()[1], side),
                         intervalOf(tile.nodes.min()[2], side)));
  std::vector<CoordBBox> rows;  // of cubes along z
  std::vector<julia::Point> points;
  Coord low, high;
  for (int axis = 0; axis < 3; ++axis) {
    low[axis] = intervalOf(whole.domain.min()[axis], side);
    high[axis] = intervalOf(whole.domain.max()[axis], side);
  }
  for (auto cube = CoordBBox(low, high).begin(); cube; ++cube) {
    if (present.contains(*cube)) continue;
    if (!rows.empty() && rows.back().max() == (*cube).offsetBy(0, 0, -1)) {
      rows.back().max() = *cube;
      continue;
    }
    rows.emplace_back(*cube, *cube);
    const Coord first =
        Coord::maxComponent(whole.domain.min(), Coord((*cube)[0] * side, (*cube)[1] * side, (*cube)[2] * side));
    points.push_back(scene.source().space.toFractal(first.asVec3d() * whole.voxelSize));
  }
  std::vector<double> values(points.size());
  if (!points.empty()) scene.source().evaluator.evaluate(points, values, {});
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (julia::storedField(values[i]) >= 0) continue;
    for (auto cube = rows[i].begin(); cube; ++cube) {
      TileBox tile{CoordBBox::createCube(Coord((*cube)[0] * side, (*cube)[1] * side, (*cube)[2] * side), side), 0};
      tile.nodes.intersect(whole.domain);
      tiles.push_back(tile);
    }
  }
  std::sort(tiles.begin(), tiles.end(),
            [](const TileBox& a, const TileBox& b) { return a.nodes.min() < b.nodes.min(); });
}

}  // namespace

std::vector<TileBox> cutEvenly(const CoordBBox& domain, std::span<const CoordBBox> work, int count) {
  std::vector<TileBox> tiles;
  cut(domain, clipped(work, domain), count, tiles);
  return tiles;
}

std::vector<TileBox> cutIntoCubes(const CoordBBox& domain, std::span<const CoordBBox> work, int side, int margin) {
  std::map<Coord, double> cubes;
  for (CoordBBox box : work) {
    box.intersect(domain);
    if (box.empty()) continue;
    CoordBBox wide = box;
    wide.expand(margin);
    wide.intersect(domain);
    Coord low, high;
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = intervalOf(wide.min()[axis], side);
      high[axis] = intervalOf(wide.max()[axis], side);
    }
    for (auto cube = CoordBBox(low, high).begin(); cube; ++cube) {
      CoordBBox in = CoordBBox::createCube(Coord((*cube)[0] * side, (*cube)[1] * side, (*cube)[2] * side), side);
      in.intersect(box);
      cubes[*cube] += volumeOf(in);
    }
  }
  std::vector<TileBox> tiles;
  for (const auto& [cube, nodes] : cubes) {
    TileBox tile{CoordBBox::createCube(Coord(cube[0] * side, cube[1] * side, cube[2] * side), side), nodes};
    tile.nodes.intersect(domain);
    tiles.push_back(tile);
  }
  return tiles;
}

namespace {

/// Measures how much of the surface lies in each tile: its points on a lattice of at most kSurveyVoxels along the
/// domain's longest side.
void surveySurface(Scene& scene, const TileLattice& lattice, const std::vector<TileBox>& tiles, TilePlan& plan,
                   Monitor& monitor) {
  constexpr double kSurveyVoxels = 400;
  const Coord sides = lattice.domain.dim();
  const double ratio = std::max(1.0, std::max({sides[0], sides[1], sides[2]}) / kSurveyVoxels);
  const double voxelSize = lattice.voxelSize * ratio;
  const auto coarse = [&](int node) { return static_cast<int>(std::floor(node / ratio)); };
  openvdb::Int32Tree owners(-1);
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    CoordBBox box;
    for (int axis = 0; axis < 3; ++axis) {
      box.min()[axis] = coarse(tiles[i].nodes.min()[axis]);
      box.max()[axis] = coarse(tiles[i].nodes.max()[axis]);
    }
    owners.fill(box, static_cast<std::int32_t>(i));
  }
  // The plan alone has other voxels: the scene is written for the tasks afterwards.
  const double planned = std::exchange(scene.voxelSize, voxelSize);
  const FieldPlan whole = planScene(scene);
  scene.voxelSize = planned;
  const FractalField field = evaluateField(whole, scene.source(), {}, monitor);
  constexpr double kRough = 0.5;  // voxels; only the tile of a point matters
  const Mesh mesh = extractMesh(field, scene.source(), {.tolerance = kRough, .border = Border::Cap}, monitor);
  for (const openvdb::Vec3d& point : mesh.points)
    if (const std::int32_t owner = owners.getValue(Coord::floor(point / voxelSize)); owner >= 0)
      ++plan.work[static_cast<std::size_t>(owner)].surface;
}

}  // namespace

TilePlan planTiles(const FractalOptions& wanted, const Recipe& asked, const TilePlanOptions& tiles,
                   const std::filesystem::path& folder, Monitor& monitor) {
  FractalOptions options = wanted;
  // Tiles serve fractals that do not fit in memory.
  options.lattice.withinMemory = false;
  requireMakes(PlanKind::Tiles, tiles.makes);
  requireCuttable(options, tiles.makes);
  if (tiles.tiles.has_value() == tiles.tileNodes.has_value())
    throw std::invalid_argument("give either the number of tiles or the nodes along the side of one, and not both");
  if (tiles.tiles && (*tiles.tiles < 1 || *tiles.tiles > kMostTiles))
    throw std::invalid_argument("the number of tiles is " + std::to_string(*tiles.tiles) + "; it must be from 1 to " +
                                std::to_string(kMostTiles));
  if (tiles.tileNodes && *tiles.tileNodes < 2)
    throw std::invalid_argument("a tile has " + std::to_string(*tiles.tileNodes) +
                                " nodes along its side; it must have 2 or more");
  Scene scene = makeScene(options, monitor);
  options = scene.options;
  const Recipe recipe = resolvedRecipe(scene, asked);
  // A window without nodes: a large lattice would have too many blocks.
  FieldPlan whole = planScene(scene, CoordBBox());
  whole.window = whole.domain;
  if (whole.origin != openvdb::Vec3d(0))
    throw std::invalid_argument("at voxel size " + shortText(whole.voxelSize) +
                                " the nodes of the box cannot be numbered from 0, as tiles need it; use larger voxels, "
                                "or make the box by one run of juliavdb fractal");
  requireFormats(tiles.makes, scene.voxelSize, whole);
  std::vector<CoordBBox> work = workOf(scene, whole);
  if (work.empty()) throw DataError("the fractal is empty: no cell of the lattice is undecided", Remedy::LargerBeta);

  TilePlan plan;
  plan.chosenResolution = chosenResolutionText(scene);
  plan.finerThanVoxels = finerThanVoxelsText(scene);
  Manifest& manifest = plan.manifest;
  manifest.makes = tiles.makes;
  const TileFiles files = tileFiles(manifest, options);
  // A tile without a triangle may still have a part of the level set.
  std::vector<TileBox> boxes = tiles.tiles ? cutEvenly(whole.domain, work, *tiles.tiles)
                                           : cutIntoCubes(whole.domain, work, *tiles.tileNodes, kTileHalo);
  // Islands are joined through cubes without work, and such cubes count for their size.
  if (files.islands && tiles.tileNodes) addInsideCubes(scene, whole, *tiles.tileNodes, boxes);
  if (boxes.size() > kMostTiles)
    throw std::invalid_argument("there would be " + std::to_string(boxes.size()) + " tiles, and " +
                                std::to_string(kMostTiles) + " is the most; make them larger");

  manifest.kind = PlanKind::Tiles;
  // A task runs in any folder, and can check whether the map's files are those of the plan.
  manifest.recipe = withAbsoluteNames(recipe, std::filesystem::current_path());
  for (const auto& [name, hash] : verifiedHashes(filesOf(options))) manifest.recipe[name] = hash;
  manifest.metadata = sceneMetadata(scene, recipe);
  manifest.lattice = TileLattice{whole.domain, whole.bounded, whole.voxelSize};
  for (const TileBox& box : boxes) {
    manifest.tasks.push_back({.box = box.nodes, .writes = tileNames(files, manifest.tasks.size() + 1)});
    plan.work.push_back({.shell = box.work});
  }
  if (tiles.survey) surveySurface(scene, *manifest.lattice, boxes, plan, monitor);

  // This comes last, so that a failure or an interruption leaves no part of a plan behind; the check is repeated,
  // because another plan may have been written there meanwhile.
  requireNewPlanFolder(folder);
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw CreateError("cannot make the folder '" + folder.string() + "': " + error.message());
  const std::string bytes = encodePreparedScene(scene);
  AtomicFile file(folder / kPreparedName);
  file.stream().write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  file.commit();
  manifest.inputs.push_back({kPreparedName, sha256Hex(bytes)});
  return plan;
}

}  // namespace vdbtools::farm
