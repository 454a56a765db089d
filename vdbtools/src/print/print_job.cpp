// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/print/print_job.h"

#include "print/shells.h"
#include "repair/solid_input.h"
#include "surface/part_shape.h"
#include "surface/part_thickness.h"
#include "vdbtools/base/text.h"
#include "vdbtools/decimation/adaptive_mesh.h"
#include "vdbtools/surface/extract_mesh.h"
#include "vdbtools/surface/level_set.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <numeric>
#include <stdexcept>
#include <string>
#include <vector>

namespace vdbtools {
namespace {

using openvdb::Vec3d;
using openvdb::Vec3I;

constexpr std::uint64_t kUsualResolution = 400;

void requireOptions(const PrintOptions& options) {
  const auto refuse = [](const char* what, double value, const char* wanted) {
    throw std::invalid_argument(std::string("a ") + what + " of " + shortText(value) +
                                " mm cannot be made; it must be " + wanted);
  };
  const auto positive = [](double value) { return value > 0 && std::isfinite(value); };
  if (!positive(options.size) || options.size > 1e5) refuse("size", options.size, "above 0 and at most 100000 mm");
  if (options.minThickness && !(positive(*options.minThickness) && *options.minThickness <= options.size / 4))
    refuse("least thickness", *options.minThickness, "above 0 and at most a quarter of the size");
  if (options.flatBase && !(positive(*options.flatBase) && *options.flatBase < options.size))
    refuse("flat base", *options.flatBase, "above 0 and less than the size");
  if (!(options.tolerance >= 0 && std::isfinite(options.tolerance)))
    refuse("tolerance", options.tolerance, "0 or above");
  if (options.islands == 0) throw std::invalid_argument("0 islands cannot be printed; keep 1 or more");
}

/// The triangles for which @a keep(triangle) holds, and their points.
template <class Keep>
Mesh partOf(const Mesh& mesh, const Keep& keep) {
  constexpr std::uint32_t kNone = ~std::uint32_t{0};
  std::vector<std::uint32_t> numbers(mesh.points.size(), kNone);
  Mesh part;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    if (!keep(i)) continue;
    Vec3I triangle = mesh.triangles[i];
    for (int c = 0; c < 3; ++c) {
      std::uint32_t& number = numbers[triangle[c]];
      if (number == kNone) {
        number = static_cast<std::uint32_t>(part.points.size());
        part.points.push_back(mesh.points[triangle[c]]);
      }
      triangle[c] = number;
    }
    part.triangles.push_back(triangle);
  }
  return part;
}

/// Keeps the largest islands and fills the cavities in them. @param report  receives what was dropped; may be null
Mesh keepIslands(const Mesh& mesh, std::uint64_t count, PrintedPart* report) {
  const Shells shells = shellsOf(mesh);
  std::vector<std::uint32_t> order;
  double all = 0, cavities = 0;
  std::uint64_t cavityCount = 0;
  for (std::size_t i = 0; i < shells.volumes.size(); ++i) {
    if (shells.volumes[i] > 0) {
      order.push_back(static_cast<std::uint32_t>(i));
      all += shells.volumes[i];
    } else {
      ++cavityCount;
      cavities -= shells.volumes[i];
    }
  }
  if (order.empty()) throw DataError("the mesh encloses no volume; are its triangles turned inside out?");
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return shells.volumes[a] != shells.volumes[b] ? shells.volumes[a] > shells.volumes[b] : a < b;
  });
  std::vector<char> kept(shells.volumes.size(), 0);
  double keptVolume = 0;
  for (std::size_t i = 0; i < std::min<std::size_t>(order.size(), count); ++i) {
    kept[order[i]] = 1;
    keptVolume += shells.volumes[order[i]];
  }
  if (report) {
    report->islands = order.size();
    report->droppedShare = 1 - keptVolume / all;
    report->cavities = cavityCount;
    report->cavityShare = cavities / all;
  }
  return partOf(mesh, [&](std::size_t i) { return kept[shells.ofTriangle[i]] != 0; });
}

/// @throw as openSolid()
MeshReport checkedReport(const Mesh& mesh) {
  return openSolid("the mesh", std::shared_ptr<const Mesh>(std::shared_ptr<const Mesh>(), &mesh), {}).report;
}

/// Puts the mesh on its feet: its up axis points along z, and the middle of its base is at 0.
void stand(Mesh& mesh) {
  const openvdb::BBoxd box = boundingBox(mesh);
  const Vec3d middle = box.getCenter(), base(middle[0], middle[1], box.min()[2]);
  for (Vec3d& point : mesh.points) point -= base;
}

void scaleTo(Mesh& mesh, double size) {
  const double scale = size / longestSide(boundingBox(mesh));
  for (Vec3d& point : mesh.points) point *= scale;
}

/// Thickens or removes the thin parts of the solid, and cuts its base. @param solid  with normals
Mesh shaped(const Mesh& solid, const PrintOptions& options, double voxel, double thickness, PrintedPart& part,
            Monitor& monitor) {
  openvdb::FloatGrid::Ptr grid = partLevelSet(solid, voxel, monitor);
  std::optional<double> floor;
  if (options.flatBase) {
    const openvdb::BBoxd box = boundingBox(solid);
    floor = box.min()[2] + *options.flatBase;
    if (*floor > box.max()[2] - voxel)
      throw std::invalid_argument("a flat base of " + shortText(*options.flatBase) +
                                  " mm cuts off all of the part, which is " + shortText(box.extents()[2]) +
                                  " mm high; cut off less, or make the part larger");
    cutBelow(*grid, *floor, monitor);
  }
  if (thickness > 0) {
    if (options.thin == ThinParts::Thicken) {
      part.thinPoints = thicken(*grid, solid, thickness, floor, monitor);
      // The added balls may leave thin places where they meet the solid at an angle.
      constexpr int kMostPasses = 3;
      bool changed = part.thinPoints > 0;
      for (int pass = 1; pass < kMostPasses && changed; ++pass) {
        Mesh now = meshOfLevelSet(*grid, monitor);
        computeNormals(now);
        changed = thicken(*grid, now, thickness, floor, monitor) > 0;
      }
    } else if (floor) {
      dropThin(*grid, meshOfLevelSet(*grid, monitor), thickness, monitor);
    } else {
      dropThin(*grid, solid, thickness, monitor);
    }
  }
  return keepIslands(meshOfLevelSet(*grid, monitor), options.islands, nullptr);
}

std::uint64_t resolutionOf(const PrintOptions& options) {
  if (options.resolution > 0) return options.resolution;
  constexpr double kVoxelsAcross = 5, kLeast = 250, kMost = 600;
  const double wanted = options.minThickness ? kVoxelsAcross * options.size / *options.minThickness : kLeast;
  return static_cast<std::uint64_t>(std::ceil(std::clamp(wanted, kLeast, kMost)));
}

/// The area of the triangles that face down at z = 0.
double baseAreaOf(const Mesh& mesh, double near) {
  double area = 0;
  for (const Vec3I& t : mesh.triangles) {
    const Vec3d &a = mesh.points[t[0]], &b = mesh.points[t[1]], &c = mesh.points[t[2]];
    if (std::max({a[2], b[2], c[2]}) <= near) area += std::abs((b - a).cross(c - a)[2]) / 2;
  }
  return area;
}

/// The area of the cross-section of a closed mesh at the height z: what lies above it casts the same shadow upwards and
/// downwards, and the section is a part of the latter.
double sectionArea(const Mesh& mesh, double z) {
  double twice = 0;
  for (const Vec3I& t : mesh.triangles) {
    std::array<Vec3d, 4> corners;  // of the part above z
    std::size_t count = 0;
    for (int k = 0; k < 3; ++k) {
      const Vec3d &from = mesh.points[t[k]], &to = mesh.points[t[(k + 1) % 3]];
      if (from[2] >= z) corners[count++] = from;
      if ((from[2] >= z) != (to[2] >= z)) corners[count++] = from + (z - from[2]) / (to[2] - from[2]) * (to - from);
    }
    for (std::size_t i = 2; i < count; ++i) twice += (corners[i - 1] - corners[0]).cross(corners[i] - corners[0])[2];
  }
  return twice / 2;
}

/// Looks for a larger base, where that of the part is small.
/// @param voxel  of the lattice by which a flat base is cut
void adviseBase(PrintedPart& part, const Mesh& solid, double flatBase, double voxel) {
  const double enough = enoughBase(part.extents);
  part.smallBase = part.baseArea < enough;
  if (!part.smallBase) return;
  constexpr int kSteps = 100;
  for (int step = 1; step <= kSteps; ++step) {
    const double z = part.extents[2] / 2 * step / kSteps;
    // The edge of a base is as round as the lattice makes it, and the part is made again with another base.
    const double radius = std::sqrt(sectionArea(solid, z) / std::numbers::pi) - voxel;
    if (radius <= 0 || std::numbers::pi * radius * radius < 1.1 * enough) continue;
    part.betterBase = flatBase + z;
    return;
  }
}

}  // namespace

double enoughBase(const openvdb::Vec3d& extents) {
  const double slender = extents[2] / 20;
  return std::max(extents[0] * extents[1] / 100, slender * slender);
}

Mesh closedMesh(const Mesh& mesh, std::uint64_t resolution, bool repair, Monitor& monitor, std::size_t* united) {
  openvdb::initialize();
  if (united) *united = 0;
  const MeshReport report = checkedReport(mesh);
  const double voxel = longestSide(report.box) / static_cast<double>(resolution > 0 ? resolution : kUsualResolution);
  std::size_t meeting = 0;
  if (!repair && report.closed())
    if (std::optional<Mesh> oriented = withShellsOriented(mesh, voxel, meeting, monitor)) return *std::move(oriented);
  if (united) *united = meeting;
  const MeshSdf sdf = makeSdf(mesh, sdfBand(voxel, kPartBand, kPartBand), {.repair = repair}, monitor);
  return meshOfLevelSet(*sdf.grid, monitor);
}

PrintedPart printedPart(const Mesh& mesh, const PrintOptions& asked, Monitor& monitor) {
  PrintOptions options = asked;
  if (!options.scale) requireOptions(options);
  openvdb::initialize();
  const MeshReport report = checkedReport(mesh);
  if (!report.closed())
    throw DataError("the mesh is not closed: " +
                    std::to_string(report.openEdges + report.nonManifoldEdges + report.misorientedEdges) +
                    " of its edges are not shared by two triangles of one orientation");
  PrintedPart part;
  monitor.begin(PhaseKind::Islands, 0);
  Mesh upright = mesh;
  if (report.volume < 0)
    for (Vec3I& t : upright.triangles) std::swap(t[1], t[2]);
  const UpTurn turn(options.up, UpAxis::Z);
  for (Vec3d& point : upright.points) point = turn(point);
  Mesh solid = keepIslands(upright, options.islands, &part);
  stand(solid);
  const double given = longestSide(boundingBox(solid));
  if (!(given > 0)) throw DataError("the mesh has no extent");
  if (options.scale) {
    options.size = *options.scale * given;
    requireOptions(options);
  }
  scaleTo(solid, options.size);
  computeNormals(solid);

  double scale = options.size / given;
  // Nested surfaces of several islands may lie in filled cavities of each other; the lattice merges them.
  const bool nested = options.islands > 1 && part.cavities > 0;
  if (options.minThickness || options.flatBase || nested) {
    part.voxelSize = options.size / static_cast<double>(resolutionOf(options));
    // Adding and cutting change the size, so the part is made again until it has the requested one.
    constexpr int kMostTries = 4;
    constexpr double kNearEnough = 0.002;
    // Leaves room for the last, small change of the size, for the lattice, and for larger triangles on both sides.
    const double thickness =
        options.minThickness ? *options.minThickness * (1 + 2 * kNearEnough) + 2 * options.tolerance : 0;
    Mesh made;
    double change = 1;
    for (int attempt = 0; attempt < kMostTries; ++attempt) {
      Mesh next = shaped(solid, options, part.voxelSize, thickness, part, monitor);
      const double needed = options.size / longestSide(boundingBox(next));
      if (change > 1 + kNearEnough && needed < 1 - kNearEnough) {
        // The part was too small at one size and is too large at the next, because thin places appear and vanish, so
        // no size is exact. The smaller part is enlarged, which makes nothing thinner.
        scale /= change;
        break;
      }
      made = std::move(next);
      change = needed;
      if (std::abs(change - 1) < kNearEnough || attempt + 1 == kMostTries) break;
      for (Vec3d& point : solid.points) point *= change;
      scale *= change;
    }
    scale *= options.size / longestSide(boundingBox(made));
    solid = std::move(made);
    stand(solid);
    scaleTo(solid, options.size);
  }
  part.scale = scale;
  if (options.tolerance > 0) {
    solid = meshOf(adaptedMesh(solid, options.tolerance, monitor), solid);
    stand(solid);
  }
  part.extents = boundingBox(solid).extents();
  const std::vector<double> volumes = shellsOf(solid).volumes;
  part.volume = std::accumulate(volumes.begin(), volumes.end(), 0.);
  part.keptIslands = volumes.size();
  const double voxel = part.voxelSize > 0 ? part.voxelSize : options.size / 1000;
  part.baseArea = baseAreaOf(solid, voxel / 100);
  adviseBase(part, solid, options.flatBase.value_or(0), options.size / static_cast<double>(resolutionOf(options)));

  monitor.begin(PhaseKind::Thickness, 0);
  computeNormals(solid);
  constexpr std::size_t kMostPlaces = 20000;
  const double thickness = options.minThickness.value_or(1.0);
  const ThinPlaces found = findThinPlaces(solid, thickness, kThicknessRounding, kMostPlaces, monitor);
  part.places = found.places;
  part.thinPlaces = found.thin;
  part.thinnest = found.thinnest;
  solid.normals.clear();
  part.mesh = std::move(solid);
  return part;
}

}  // namespace vdbtools
