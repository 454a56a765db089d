// SPDX-License-Identifier: Apache-2.0
#include "target/solid_input.h"

#include "vdbtools/files/file_bytes.h"
#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/recipe/option_value.h"

#include <algorithm>
#include <stdexcept>
#include <vector>

namespace vdbtools {

using openvdb::BBoxd;
using openvdb::FloatGrid;
using openvdb::Vec3d;

std::string boxText(const BBoxd& box) {
  const Vec3d &a = box.min(), &b = box.max();
  return numbersText({a[0], a[1], a[2], b[0], b[1], b[2]});
}

double longestSide(const BBoxd& box) {
  const Vec3d extents = box.extents();
  return std::max({extents[0], extents[1], extents[2]});
}

MeshReport reportOfSolid(const Mesh& mesh, const std::filesystem::path& path) {
  const MeshReport report = reportMesh(mesh);
  if (!(longestSide(report.box) > 0))
    throw DataError("'" + path.string() + "' has no extent: all its triangles lie in one point");
  return report;
}

void requireUsable(const Mesh& mesh) {
  if (mesh.triangles.empty()) throw DataError("the mesh has no triangle");
  for (std::size_t i = 0; i < mesh.points.size(); ++i)
    if (!mesh.points[i].isFinite())
      throw DataError("point " + std::to_string(i) + " of the mesh has a coordinate that is not finite");
}

MeshToSdfOptions sdfBand(double voxelSize, double exteriorWidth, double interiorWidth) {
  return {.voxelSize = voxelSize, .exteriorBandWidth = exteriorWidth, .interiorBandWidth = interiorWidth};
}

MeshSdf makeSdf(const Mesh& mesh, const MeshToSdfOptions& options, bool repair, double gap, Monitor& monitor) {
  if (!repair) return {meshToSdf(mesh, options, monitor), {}, {}};
  RepairedSdf repaired = repairedMeshToSdf(mesh, options, {.gap = gap}, monitor);
  return {repaired.grid, repaired.moved, repaired.closedGap};
}

MeshSdf makeSdfAbout(const Vec3d& middle, Mesh mesh, const MeshToSdfOptions& options, bool repair, double gap,
                     Monitor& monitor) {
  for (Vec3d& point : mesh.points) point -= middle;
  MeshSdf sdf = makeSdf(mesh, options, repair, gap, monitor);
  sdf.grid->transform().postTranslate(middle);
  return sdf;
}

namespace {

/// @throw DataError  @a text is not a box with an extent
BBoxd boxFromMetadata(const std::string& text, const std::filesystem::path& path) {
  try {
    const std::vector<double> b = parseNumbers(kTargetBox, text, 6);
    const BBoxd box(Vec3d(b[0], b[1], b[2]), Vec3d(b[3], b[4], b[5]));
    if (b[0] <= b[3] && b[1] <= b[4] && b[2] <= b[5] && longestSide(box) > 0) return box;
  } catch (const std::invalid_argument&) {
    // It is the file that is wrong, not what was asked for.
  }
  throw DataError("the metadata " + std::string(kTargetBox) + " of '" + path.string() + "' is '" + inOneLine(text) +
                  "'; it must be six finite numbers with commas between them, the smaller corner first");
}

}  // namespace

Target readVdbTarget(const std::filesystem::path& path, const std::string& grid) {
  const VdbFile file = readVdb(path);
  const FloatGrid::Ptr phi = chooseFloatGrid(file, grid, path);
  // An SDF of ours knows the box of its mesh; half a voxel more exactly than its nodes do.
  std::optional<BBoxd> box;
  if (const auto found = file.metadata.find(kTargetBox); found != file.metadata.end() && phi->getName() == "phi") {
    box = boxFromMetadata(found->second, path);
  }
  return makeTarget(phi, box);
}

}  // namespace vdbtools
