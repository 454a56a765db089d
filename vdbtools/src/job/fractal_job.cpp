// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/job/fractal_job.h"

#include "base/elementary.h"
#include "job/point_attributes.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/base/memory.h"
#include "vdbtools/decimation/adaptive_mesh.h"
#include "vdbtools/mesh/mesh_sink.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>

namespace vdbtools {

using openvdb::BBoxd;
using openvdb::FloatGrid;

namespace {

/// What to try where the set is empty.
std::string wayOut(const Scene& scene) {
  if (scene.options.lattice.box)
    return scene.exponent ? "another box, or less detail" : "another box, or other constants";
  if (!scene.exponent) return "other constants, or another box";
  return scene.exponentOf->detail ? "less detail, a larger outward reach, or smaller voxels"
                                  : "a larger beta, a larger alpha, or smaller voxels";
}

}  // namespace

void requireMoreThanCrumbs(const CrumbReport& dropped) {
  if (dropped.crumbs == 0) return;
  throw DataError("the fractal has nothing but crumbs here: " + std::to_string(dropped.crumbs) +
                      (dropped.crumbs == 1 ? " piece" : " pieces") + " of at most " + std::to_string(kCrumb) +
                      " voxels along each axis; use smaller voxels, or keep them",
                  Remedy::KeepCrumbs);
}

FractalResult runFractal(const Scene& scene, const FieldPlan& plan, bool wantGrids, MeshSink* sink, Monitor& monitor) {
  const SurfaceOptions& surfaceOptions = scene.options.surface;
  const std::optional<FollowOptions>& follow = scene.options.lattice.follow;
  const std::vector<std::string>& names = scene.options.output.grids;
  const auto wants = [&](const char* name) {
    return wantGrids && std::find(names.begin(), names.end(), name) != names.end();
  };
  FractalResult result;
  const auto requireSurface = [&](std::uint64_t triangles) {
    if (triangles == 0 && result.crumbs) requireMoreThanCrumbs(*result.crumbs);
    if (triangles == 0)
      throw DataError("the fractal is empty here: the field changes sign nowhere in the region; try " + wayOut(scene),
                      scene.exponent ? Remedy::LargerBeta : Remedy::None);
  };
  const bool capMesh = surfaceOptions.cap || !plan.bounded;
  const ExtractMeshOptions asked{.tolerance = surfaceOptions.tolerance, .border = capMesh ? Border::Cap : Border::Open};
  std::optional<PointAttributes> attributes;
  if (!scene.options.output.attributes.empty()) attributes.emplace(scene);
  std::optional<AttributedSink> attributed;
  if (attributes && sink) sink = &attributed.emplace(*attributes, *sink, monitor);
  std::optional<AdaptiveMeshSink> adaptive;
  if (sink && surfaceOptions.adaptivity > 0)
    sink = &adaptive.emplace(*sink, surfaceOptions.adaptivity * scene.voxelSize);
  const bool dropsIslands = surfaceOptions.islands.largest > 0 || surfaceOptions.islands.minSize > 0;
  const auto finishAdaptive = [&] {
    if (!adaptive) return;
    adaptive->finish(monitor);
    result.mesh.points = adaptive->pointsAfter();
    result.mesh.triangles = adaptive->trianglesAfter();
  };
  if (!wantGrids && !dropsIslands && !follow) {
    if (!sink) return result;
    SolidMeter meter(sink);
    result.mesh = streamMesh(plan, scene.source(), asked, meter, monitor);
    if (capMesh || !scene.options.lattice.box) result.solid = meter.measure();
    result.evaluatedNodes = result.mesh.evaluatedNodes;
    result.crumbs = result.mesh.crumbs;
    requireSurface(result.mesh.triangles);
    finishAdaptive();
    return result;
  }

  const EvaluateFieldOptions evaluate{.keepIterations = wants("iterations"),
                                      .everyNode = wants("iterations") || wants("logmodulus")};
  FractalField field = follow ? followSurface(plan, scene.source(), evaluate, *follow, result.follow.emplace(), monitor)
                              : evaluateField(plan, scene.source(), evaluate, monitor);
  result.evaluatedNodes = field.evaluatedNodes;
  result.crumbs = field.crumbs;
  if (dropsIslands) result.islands = dropIslands(field, surfaceOptions.islands, monitor);
  FloatGrid::Ptr surface;
  const bool wantsAttributes = wantGrids && attributes;
  if (wants("surface") || wants("density") || wants("versor") || wantsAttributes) {
    CappedMesh capped = extractCappedMesh(field, scene.source(), surfaceOptions.tolerance, monitor);
    requireSurface(capped.mesh.triangles.size());
    surface = levelSet(field, capped.mesh, monitor);
    result.solid = measureSolid(capped.mesh);
    result.check = checkSurface(*surface);
    if (sink) {
      Mesh mesh = capMesh ? std::move(capped.mesh) : withoutCaps(std::move(capped));
      requireSurface(mesh.triangles.size());
      computeNormals(mesh);
      sink->addPoints({mesh.points, mesh.normals});
      sink->addTriangles(mesh.triangles, 0);
      result.mesh = {mesh.points.size(), mesh.triangles.size()};
    }
  }
  if (sink && result.mesh.triangles == 0) {
    SolidMeter meter(sink);
    result.mesh = extractMesh(field, scene.source(), asked, meter, monitor);
    if (capMesh || !scene.options.lattice.box) result.solid = meter.measure();
  }
  if (sink) requireSurface(result.mesh.triangles);
  finishAdaptive();
  for (const std::string& name : names) {
    if (!wantGrids) break;
    if (name == "surface") result.grids.push_back(surface);
    if (name == "density") result.grids.push_back(densityGrid(*surface));
    if (name == "logmodulus") result.grids.push_back(logModulusGrid(field));
    if (name == "iterations") result.grids.push_back(field.iterations);
    if (name == "versor") result.grids.push_back(versorGrid(*surface, scene.source(), monitor));
  }
  if (wantsAttributes)
    for (const openvdb::GridBase::Ptr& grid : attributeGrids(*attributes, *surface, monitor))
      result.grids.push_back(grid);
  return result;
}

void requireMemoryForMesh(const Scene& scene) {
  // A box may cut the surface off, and flat places may need few triangles.
  if (!scene.exponent || scene.options.lattice.box || scene.options.surface.adaptivity > 0) return;
  double nodes = 0;
  const FloatGrid& exponent = *scene.exponent->grid;
  for (auto value = exponent.cbeginValueAll(); value; ++value)
    if (*value <= scene.exponent->shell.lower) nodes += static_cast<double>(value.getVoxelCount());
  const double volume = nodes * std::abs(exponent.transform().voxelSize().product());
  // Each line of the lattice through that volume V crosses the surface twice, and V^2 is at most the product of its
  // three shadows (Loomis and Whitney), whose sum is therefore at least 3 V^(2/3). A point lies at each crossing. V is
  // counted in nodes, of which those at its surface have a part outside.
  constexpr double kSure = 0.8;
  const double points = kSure * 2 * 3 * elementary::cbrt(volume * volume) / (scene.voxelSize * scene.voxelSize);
  // A closed surface has two triangles for each point.
  constexpr double kBytes = sizeof(openvdb::Vec3d) + sizeof(openvdb::Vec3s) + 2 * sizeof(openvdb::Vec3I);
  requireMemory(points * kBytes, MemoryUse::Field,
                "a mesh of more than " + std::to_string(static_cast<std::uint64_t>(points)) + " points");
}

Mesh fractalMesh(const Scene& scene, Monitor& monitor) {
  requireMemoryForMesh(scene);
  Mesh mesh;
  MeshCollector collector(mesh);
  runFractal(scene, planScene(scene), false, &collector, monitor);
  return mesh;
}

}  // namespace vdbtools
