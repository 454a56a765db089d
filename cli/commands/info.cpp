// SPDX-License-Identifier: Apache-2.0
#include "commands.h"

#include "exit_code.h"
#include "failure.h"
#include "options.h"
#include "report.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/formats/nvdb_file.h"
#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/formats/versor_file.h"
#include "vdbtools/mesh/mesh.h"
#include "vdbtools/mesh_files/mesh_reader.h"
#include "vdbtools/mesh_files/mesh_writer.h"
#include "vdbtools/records/recorded_recipe.h"
#include "vdbtools/scene/file_axes.h"
#include "vdbtools/search/solid_meter.h"
#include "vdbtools/surface/level_set.h"
#include "vdbtools/target/target_survey.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <charconv>
#include <iostream>
#include <iterator>
#include <string>

namespace po = boost::program_options;

namespace cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr Usage kInfoUsage = {
    "info", "FILE... [--json]",
    "Shows what is in a mesh of any format that is read, in a VDB, with the recipe it was made by, in a NanoVDB file "
    "(.nvdb), all of whose checksums and places of nodes are checked, in a versor (.json, .p4d, "
    ".poly4d, .o3d), or in a recipe (.json). A file that cannot be read does not keep the others from being shown. A "
    "mesh may come through a pipe, with - for its name.",
    "  juliavdb info bunny.obj\n"
    "  juliavdb info bunny.vdb --json\n"
    "  juliavdb info bunny.nvdb\n"};

Json vector(const openvdb::Vec3d& v) { return {v[0], v[1], v[2]}; }

Json recipeOf(const std::map<std::string, std::string>& metadata) {
  const auto [command, recipe] = vdbtools::recordedRecipe(metadata);
  if (command.empty()) return nullptr;
  Json result{{"command", command}};
  for (const auto& [name, value] : recipe) result[name] = value;
  return result;
}

/// Describes a closed mesh as a target: its parts and, if @a wantShape, its deepest point and its thickness.
void addSolidInfo(const vdbtools::Mesh& mesh, const vdbtools::MeshReport& report, bool wantShape, Json& info) {
  const vdbtools::SolidMeasure solid = vdbtools::measureSolid(mesh);
  constexpr std::size_t kMostShares = 8;
  Json shares = Json::array();
  for (std::size_t i = 0; i < std::min(kMostShares, solid.islands.size()); ++i)
    shares.push_back(solid.islands[i] / solid.volume);
  info["parts"] = solid.islands.size();
  info["largest parts, of the volume"] = shares;
  if (!wantShape) return;
  const std::optional<vdbtools::SolidShape> shape = vdbtools::shapeOfSolid(mesh, report);
  if (!shape) return;
  info["depth"] = shape->deepest.radius;
  info["deepest point"] = vector(shape->deepest.centre);
  info["local thickness"] = Json{shape->leastThickness, shape->greatestThickness};
}

/// Lists what a file contains besides its surface.
void addParts(const vdbtools::Mesh& mesh, const std::string& path, Json& info) {
  if (const auto unit = vdbtools::unitOfFile(path)) info["unit"] = nameOf(*unit);
  if (!mesh.attributes.empty()) {
    info["attributes"] = Json::array();
    for (const vdbtools::VertexAttribute& attribute : mesh.attributes) info["attributes"].push_back(attribute.name);
  }
  if (!mesh.cornerUvs.empty()) info["texture coordinates"] = true;
  if (mesh.pointsLeftOut > 0) info["points left out, not finite"] = mesh.pointsLeftOut;
  for (const vdbtools::MeshAnimation& animation : vdbtools::readAnimations(path))
    info["animations"].push_back({{"name", animation.name}, {"seconds", {animation.first, animation.last}}});
  if (!mesh.faceNames.materials.empty()) info["materials"] = mesh.faceNames.materials;
  if (!mesh.faceNames.groups.empty()) info["groups"] = mesh.faceNames.groups;
}

Json cloudInfo(const std::string& path) {
  const vdbtools::Mesh cloud = vdbtools::readPoints(path);
  openvdb::BBoxd box;
  for (const openvdb::Vec3d& p : cloud.points) box.expand(p);
  Json info{{"kind", "points"},
            {"points", cloud.points.size()},
            {"box min", vector(box.min())},
            {"box max", vector(box.max())},
            {"spacing", vdbtools::pointSpacing(cloud.points)}};
  addParts(cloud, path, info);
  return info;
}

Json surfaceInfo(const std::string& path) {
  const vdbtools::Mesh mesh = vdbtools::readMesh(path);
  const vdbtools::MeshReport report = vdbtools::reportMesh(mesh);
  Json info{{"kind", "mesh"},
            {"points", report.points},
            {"triangles", report.triangles},
            {"components", report.components},
            {"closed", report.closed()},
            {"open edges", report.openEdges},
            {"non-manifold edges", report.nonManifoldEdges},
            {"misoriented edges", report.misorientedEdges},
            {"degenerate faces", report.degenerateFaces},
            {"box min", vector(report.box.min())},
            {"box max", vector(report.box.max())},
            {"area", report.area},
            {"volume", report.volume}};
  addParts(mesh, path, info);
  const Json recipe = recipeOf(vdbtools::readMeshTexts(path));
  // A fractal of this program is seldom a target again, and finding its thickness would take long.
  if (report.closed()) addSolidInfo(mesh, report, recipe.is_null(), info);
  if (!recipe.is_null()) info["recipe"] = recipe;
  return info;
}

Json meshInfo(const std::string& path) {
  try {
    return surfaceInfo(path);
  } catch (const vdbtools::DataError& error) {
    if (error.remedy() != vdbtools::Remedy::GivePointsRadius) throw;
    return cloudInfo(path);
  }
}

Json gridInfo(const openvdb::GridBase& grid) {
  const openvdb::CoordBBox active = grid.evalActiveVoxelBoundingBox();
  Json info{{"name", grid.getName()},
            {"type", grid.valueType()},
            {"class", openvdb::GridBase::gridClassToString(grid.getGridClass())},
            {"active voxels", grid.activeVoxelCount()},
            {"voxel size", vector(grid.voxelSize())},
            {"memory (bytes)", grid.memUsage()}};
  if (!active.empty()) {
    const openvdb::BBoxd world =
        grid.transform().indexToWorld(openvdb::BBoxd(active.min().asVec3d(), active.max().asVec3d()));
    info["box min"] = vector(world.min());
    info["box max"] = vector(world.max());
  }
  if (const auto* floats = dynamic_cast<const openvdb::FloatGrid*>(&grid);
      floats && grid.getGridClass() == openvdb::GRID_LEVEL_SET) {
    const vdbtools::LevelSetCheck check = vdbtools::checkSurface(*floats);
    info["level set check"] = check.failure.empty() ? "passes" : check.failure;
    info["|grad| within 0.5 of 1"] = check.gradientFraction;
  }
  return info;
}

Json vdbInfo(const std::string& path) {
  const vdbtools::VdbFile file = vdbtools::readVdb(path);
  Json info{{"kind", "VDB"}, {"grids", Json::array()}};
  const std::vector<std::string> labels = vdbtools::gridLabels(file);
  for (std::size_t i = 0; i < labels.size(); ++i) {
    info["grids"].push_back(gridInfo(*file.grids[i]));
    info["grids"].back()["name"] = labels[i];
  }
  for (const auto& grid : file.unread)
    info["grids"].push_back({{"name", grid.name}, {"type", grid.type}, {"class", "not known, and not read"}});
  if (Json recipe = recipeOf(file.metadata); !recipe.is_null()) info["recipe"] = recipe;
  Json rest = Json::object();
  for (const auto& [name, value] : file.metadata)
    if (!info.contains("recipe") || !name.starts_with("julia_")) rest[name] = value;
  // Facts that the program found are not options, but worth showing. The roots themselves are left to 'versor inspect'.
  for (const char* fact :
       {"julia_version",         vdbtools::kUpAxis,      vdbtools::kLengthUnit,  "julia_target_box",
        "julia_space_centre",    "julia_space_scale",    "julia_shell",          "julia_repair_moved",
        "julia_united_parts",    "julia_hollows_filled", "julia_hollows_kept",   "julia_inner_parts",
        "julia_points_left_out", "julia_chosen_iso",     "julia_unequal_voxels", "julia_origin_at",
        "julia_thickness",       "julia_alpha_range",    "julia_beta_range",     "julia_detail_law",
        "julia_rest_jumps"})
    if (const auto found = file.metadata.find(fact); found != file.metadata.end()) rest[fact] = found->second;
  if (!rest.empty()) info["metadata"] = rest;
  return info;
}

Json nvdbInfo(const std::string& path) {
  const vdbtools::NvdbFile file = vdbtools::readNvdb(path);
  Json info{
      {"kind", "NanoVDB"}, {"version", file.version}, {"compression", file.compression}, {"grids", Json::array()}};
  for (const vdbtools::NvdbGrid& grid : file.grids) {
    Json one{{"name", grid.name},
             {"type", grid.type},
             {"class", grid.gridClass},
             {"active voxels", grid.activeVoxels},
             {"voxel size", vector(grid.voxelSize)},
             {"memory (bytes)", grid.bytes},
             {"leaves, lower and upper nodes", grid.nodes}};
    if (!grid.box.empty()) {
      one["box min"] = vector(grid.box.min());
      one["box max"] = vector(grid.box.max());
    }
    using Checksum = vdbtools::NvdbGrid::Checksum;
    one["checksum"] = grid.checksum == Checksum::Full   ? "fits"
                      : grid.checksum == Checksum::Head ? "fits; the nodes have none"
                                                        : "none";
    info["grids"].push_back(one);
  }
  return info;
}

Json polynomialInfo(const julia::Polynomial& polynomial) {
  Json info{{"roots", polynomial.roots.size()},
            {"power scale", polynomial.powerScale},
            {"summed powers", julia::summedPowers(polynomial)}};
  if (!polynomial.roots.empty()) {
    const auto [low, high] = std::minmax_element(polynomial.roots.begin(), polynomial.roots.end(),
                                                 [](const auto& a, const auto& b) { return a.power < b.power; });
    info["smallest power"] = low->power;
    info["largest power"] = high->power;
  }
  return info;
}

Json versorInfo(const std::string& path) {
  const vdbtools::RationalFile file = vdbtools::readRationalFile(path);
  Json info{{"kind", "versor"},
            {"C", file.rational.logScale},
            {"top", polynomialInfo(file.rational.top)},
            {"bottom", polynomialInfo(file.rational.bottom)}};
  if (!file.note.empty()) info["note"] = file.note;
  return info;
}

Json recipeInfo(const std::string& path) {
  const auto [command, recipe] = vdbtools::readRecordedRecipe(path);
  Json info{{"kind", "recipe"}, {"recipe", {{"command", command}}}};
  for (const auto& [name, value] : recipe) info["recipe"][name] = value;
  return info;
}

Json infoOf(const std::string& path) {
  const std::string extension = vdbtools::lowerExtension(path);
  if (vdbtools::isRecipeFile(path)) return recipeInfo(path);
  if (vdbtools::isVdbPath(path)) return vdbInfo(path);
  if (vdbtools::isNvdbPath(path)) return nvdbInfo(path);
  for (const char* versor : {".json", ".p4d", ".poly4d", ".o3d"})
    if (extension == versor) return versorInfo(path);
  return meshInfo(path);
}

/// A number for people. Positions have as many digits as it takes to tell points apart far from the origin; --json has
/// all digits.
std::string numberText(double value, bool isPlace) {
  constexpr int kDigits = 6, kDigitsOfPlaces = 12;
  char digits[32];
  return {digits, std::to_chars(digits, std::end(digits), value, std::chars_format::general,
                                isPlace ? kDigitsOfPlaces : kDigits)
                      .ptr};
}

std::string valueText(const Json& value, bool isPlace = false) {
  if (value.is_number_float()) return numberText(value.get<double>(), isPlace);
  if (!value.is_array()) return value.dump(-1, ' ', false, Json::error_handler_t::replace);
  constexpr std::size_t kAxes = 3;
  return '[' + vdbtools::joined(value, ", ", [&](const Json& each) { return valueText(each, value.size() == kAxes); }) +
         ']';
}

void print(const Json& info, int indent) {
  for (const auto& [key, value] : info.items()) {
    std::cout << std::string(static_cast<std::size_t>(indent), ' ') << vdbtools::withoutControls(key) << ':';
    if (value.is_object()) {
      std::cout << '\n';
      print(value, indent + 2);
    } else if (value.is_array() && !value.empty() && value.front().is_object()) {
      std::cout << '\n';
      for (const Json& element : value) {
        print(element, indent + 2);
        std::cout << '\n';
      }
    } else if (value.is_string()) {
      std::cout << ' ' << vdbtools::withoutControls(value.get<std::string>()) << '\n';
    } else {
      std::cout << ' ' << valueText(value) << '\n';
    }
  }
}

void show(const std::string& file, bool asJson) {
  Json info{{"file", file}};
  info.update(infoOf(file));
  if (asJson)
    std::cout << info.dump(-1, ' ', false, Json::error_handler_t::replace) << '\n';
  else
    print(info, 0);
}

}  // namespace

int runInfo(const Arguments& arguments) {
  CommandLine line(kInfoUsage, vdbtools::OptionTable());
  line.addPositional("input", -1, "the files to look at");
  line.addOptions()("json", "print JSON, one object per line");
  line.acceptStandardInput();
  if (!line.parse(arguments)) return kDone;
  const std::vector<std::string> files = line.texts("input");
  if (files.empty()) throw std::invalid_argument("no file was given");
  std::vector<Failure> failures;
  for (const std::string& file : files) {
    try {
      show(file, line.has("json"));
    } catch (const vdbtools::Interrupted&) {
      throw;
    } catch (...) {
      if (files.size() == 1) throw;
      failures.push_back(currentFailure());
      if (failures.size() > 1) report().text() << "warning: " << failures.back().text << '\n';
    }
  }
  if (failures.empty()) return kDone;
  const std::string others = failures.size() == 1 ? "" : "; " + std::to_string(failures.size() - 1) + " more failed";
  throw FailedWith({failures.front().code, failures.front().text + others});
}

}  // namespace cli
