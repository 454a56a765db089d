// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/recipe.h"

#include "recipe_reader.h"

#include "vdbtools/errors.h"
#include "vdbtools/mesh_writer.h"
#include "vdbtools/vdb_file.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <sstream>
#include <stdexcept>
#include <type_traits>

namespace vdbtools {
namespace {

constexpr const char* kPrefix = "julia_";
constexpr const char* kCommandName = "julia_command";
constexpr const char* kVersionName = "julia_version";

constexpr OptionSpec kSdfSpecs[] = {
    {"input", "MESH", nullptr, "the mesh: .obj, .ply, .stl or .off"},
    {"resolution", "N", "200", "voxels along the mesh's longest side"},
    {"voxel-size", "H", nullptr, "the size of a voxel, in the mesh's units"},
    {"band", "N", "3", "half width of the narrow band, voxels"},
    {"repair", nullptr, nullptr, "close holes and gaps of an open mesh or a triangle soup"},
    {"repair-gap", "W", "0", "close gaps up to this width, in the mesh's units; 0 finds the smallest that serves"},
    {"half", nullptr, nullptr, "write 16-bit floats"},
};

constexpr OptionSpec kFractalSpecs[] = {
    {"input", "MESH|SDF.vdb", nullptr, "the target: a mesh, or a VDB that holds its signed distance"},
    {"grid", "NAME", "", "which grid of a VDB input"},
    {"resolution", "N", "200", "voxels of the result along the target's longest side"},
    {"voxel-size", "H", nullptr, "the size of a voxel of the result, in the target's units"},
    {"sdf-resolution", "N", "200",
     "voxels of the target's distance field along its longest side; the fractal is a function of it"},
    {"sdf-voxel-size", "H", nullptr, "the same as a size, in the target's units"},
    {"repair", nullptr, nullptr, "close holes and gaps of an open mesh or a triangle soup"},
    {"repair-gap", "W", "0", "close gaps up to this width, in the mesh's units; 0 finds the smallest that serves"},
    {"map", "shape-modulus|rational|quadratic", "shape-modulus", "the map that is iterated"},
    {"alpha", "A", "40",
     "thinness of the shell of detail: 6 eats deep, 40 decorates, 300 is nearly smooth. A number, a ramp such as "
     "x:10:300:smooth, or FILE.vdb[:GRID]"},
    {"beta", "B", "0", "offset of the shell, as a share of the target's longest side; positive is outward. As alpha"},
    {"versor", "random|FILE", "random", "the texture: random roots, or .json, .p4d, .poly4d, .o3d"},
    {"rational", "FILE", "", "the rational map: .json of 'juliavdb fit', or .o3d"},
    {"versor-seed", "S", "1", "another number, another texture"},
    {"versor-roots", "N", "10", "how many roots"},
    {"versor-powers", "MIN:MAX", "2:11", "their powers: higher is finer"},
    {"versor-integer", nullptr, nullptr, "whole powers only"},
    {"versor-placement", "box|inside|surface|cluster", "box", "where the roots are strewn"},
    {"versor-distance", "D", "0.05", "surface: at most this far from it, as a share of the longest side"},
    {"versor-centre", "X,Y,Z", "0,0,0", "cluster: its middle, in fractal space"},
    {"versor-radius", "R", "0.1", "cluster: its radius, in fractal space"},
    {"versor-scale", "F", "1", "scales the roots about the origin"},
    {"versor-translate", "X,Y,Z", "0,0,0", "moves the roots alone, also a rational map's, in fractal space"},
    {"c", "A,B,C,D", "0,0,0,0", "quadratic: the constant of q^2 + c"},
    {"iterations", "N", "3", "steps of the map"},
    {"escape", "R", "20", "radius beyond which an orbit has escaped"},
    {"slice", "S", "0", "the fourth coordinate of the slice through the quaternions"},
    {"origin", "X,Y,Z", "0,0,0", "moves the dynamics' origin, in fractal space: erodes the set"},
    {"drop-axis", "i|j|k", "k", "the quaternion axis along which the target is extruded"},
    {"space", "fit|world", "fit",
     "fit: the target's longest side is 1 and its centre 0; world: coordinates as they are"},
    {"box", "X0,Y0,Z0,X1,Y1,Z1", nullptr, "only this region, in the target's units"},
    {"tolerance", "T", "0.001", "how near a vertex lies to the true surface, voxels"},
    {"largest", "N", "0", "keep only the N largest islands, by volume; 0 keeps all. A box's islands are what it holds"},
    {"min-size", "W", "0", "drop islands whose longest side is below this, in the target's units"},
    {"cap", nullptr, nullptr, "close the mesh where the box cuts the set; the VDB always is"},
    {"precision", "auto|float|double", "auto",
     "the arithmetic of the iteration; auto takes float where it is as good as double"},
    {"sampling", "trilinear|quadratic", "trilinear",
     "how the target's distances are read between their nodes; quadratic has no creases in deep zooms"},
    {"exhaustive", nullptr, nullptr, "evaluate every node, also where the result is known; for checking"},
    {"follow", nullptr, nullptr,
     "follow the surface from seeds instead of going through the whole shell: for huge runs. What is found is exact, "
     "islands that no seed meets are missed; says how much that is likely to be"},
    {"seed-stride", "N", "8", "follow: voxels between seeds, a power of 2 up to 64; fewer find more"},
    {"grids", "LIST", "surface", "what the VDB holds: surface, density, logmodulus, iterations, versor"},
    {"half", nullptr, nullptr, "write 16-bit floats"},
};

julia::RandomRootsOptions parseRandomRoots(const RecipeReader& reader) {
  julia::RandomRootsOptions options;
  options.seed = reader.integer<std::uint64_t>("versor-seed", 0, std::numeric_limits<std::uint64_t>::max());
  options.count = reader.integer("versor-roots", 1, 1'000'000);
  const std::string powers = reader.text("versor-powers");
  const std::vector<std::string> ends = split(powers, ':');
  if (ends.size() > 2) refuse("versor-powers", powers, "MIN:MAX");
  options.minPower = parseNumber("versor-powers", ends.front());
  options.maxPower = parseNumber("versor-powers", ends.back());
  if (options.minPower > options.maxPower) refuse("versor-powers", powers, "MIN:MAX with the smaller first");
  options.integerPowers = reader.flag("versor-integer");
  using julia::RootPlacement;
  options.placement = reader.choice<RootPlacement>("versor-placement", {{"box", RootPlacement::Box},
                                                                        {"inside", RootPlacement::Inside},
                                                                        {"surface", RootPlacement::Surface},
                                                                        {"cluster", RootPlacement::Cluster}});
  options.surfaceDistance = reader.positive("versor-distance");
  const openvdb::Vec3d centre = reader.vector("versor-centre");
  options.clusterCentre = {centre[0], centre[1], centre[2]};
  options.clusterRadius = reader.positive("versor-radius");
  return options;
}

std::vector<std::string> parseGrids(const std::string& text) {
  constexpr const char* kKnown[] = {"surface", "density", "logmodulus", "iterations", "versor"};
  std::vector<std::string> grids = split(text, ',');
  for (std::size_t i = 0; i < grids.size(); ++i) {
    if (std::find(std::begin(kKnown), std::end(kKnown), grids[i]) == std::end(kKnown))
      refuse("grids", text, "a list of surface, density, logmodulus, iterations, versor");
    if (std::find(grids.begin(), grids.begin() + static_cast<std::ptrdiff_t>(i), grids[i]) !=
        grids.begin() + static_cast<std::ptrdiff_t>(i))
      refuse("grids", text, "a list without repetition");
  }
  return grids;
}

}  // namespace

std::span<const OptionSpec> sdfOptionSpecs() { return kSdfSpecs; }
std::span<const OptionSpec> fractalOptionSpecs() { return kFractalSpecs; }

std::string metadataName(const std::string& option) {
  std::string name = kPrefix + option;
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}

std::map<std::string, std::string> recipeToMetadata(const Recipe& recipe, const std::string& command) {
  std::map<std::string, std::string> metadata;
  for (const auto& [option, value] : recipe) metadata[metadataName(option)] = value;
  metadata[kCommandName] = command;
  metadata[kVersionName] = JULIAVDB_VERSION;
  return metadata;
}

std::pair<Recipe, std::string> recipeFromMetadata(const std::map<std::string, std::string>& metadata) {
  const auto command = metadata.find(kCommandName);
  if (command == metadata.end()) return {};
  Recipe recipe;
  const auto take = [&](const std::string& option) {
    const auto found = metadata.find(metadataName(option));
    if (found != metadata.end()) recipe[option] = found->second;
  };
  for (const OptionSpec& spec : command->second == "sdf" ? sdfOptionSpecs() : fractalOptionSpecs()) take(spec.name);
  for (const char* hash : kHashOptions) take(hash);
  return {recipe, command->second};
}

std::string alternativeOption(const std::string& option) {
  constexpr std::pair<const char*, const char*> kPairs[] = {
      {"resolution", "voxel-size"}, {"sdf-resolution", "sdf-voxel-size"}, {"versor", "rational"}};
  for (const auto& [one, other] : kPairs) {
    if (option == one) return other;
    if (option == other) return one;
  }
  return {};
}

Recipe completeRecipe(Recipe recipe, std::span<const OptionSpec> specs) {
  for (const OptionSpec& spec : specs)
    if (spec.defaultValue && !recipe.contains(alternativeOption(spec.name)))
      recipe.emplace(spec.name, spec.defaultValue);
  return recipe;
}

std::pair<Recipe, std::string> readRecipe(const std::filesystem::path& path) {
  auto result = recipeFromMetadata(isVdbPath(path) ? readVdbMetadata(path) : readMeshComments(path));
  if (result.second.empty())
    throw DataError("'" + path.string() + "' holds no recipe of juliavdb; only a VDB, PLY or OBJ that it made does");
  return result;
}

double VoxelChoice::sizeFor(double longestSide) const {
  const double size = voxelSize ? *voxelSize : longestSide / resolution.value();
  // OpenVDB takes transforms from about 1.5e-5 on, whose volume is not yet 0 to it.
  constexpr double kSmallest = 2e-5, kLargest = 1e30;
  if (!(size >= kSmallest && size <= kLargest)) {
    std::ostringstream text;
    text << "the voxel size comes to " << size << "; it must be 2e-5 to 1e30: choose another --resolution or "
         << "--voxel-size, or give the target in other units";
    throw std::invalid_argument(text.str());
  }
  return size;
}

double parseNumber(const std::string& option, const std::string& text) { return parseNumbers(option, text, 1).front(); }

std::vector<double> parseNumbers(const std::string& option, const std::string& text, std::size_t count) {
  const std::string wanted =
      count == 1 ? "a finite number" : std::to_string(count) + " finite numbers with commas between them";
  std::vector<double> values;
  for (const std::string& part : split(text, ',')) {
    double value = 0;
    const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), value);
    if (error != std::errc{} || end != part.data() + part.size() || !std::isfinite(value)) refuse(option, text, wanted);
    values.push_back(value);
  }
  if (values.size() != count) refuse(option, text, wanted);
  return values;
}

SdfOptions parseSdfOptions(const Recipe& recipe) {
  const RecipeReader reader(recipe, sdfOptionSpecs());
  SdfOptions options;
  options.input = reader.text("input");
  if (options.input.empty()) throw std::invalid_argument("no mesh was given");
  options.voxels = reader.voxels("resolution", "voxel-size");
  options.repair = reader.flag("repair");
  options.gap = reader.notNegative("repair-gap");
  options.band = reader.number("band");
  if (!(options.band >= 1 && options.band <= 1e6)) refuse("band", reader.text("band"), "1 to 1e6");
  options.half = reader.flag("half");
  return options;
}

FractalOptions parseFractalOptions(const Recipe& recipe) {
  const RecipeReader reader(recipe, fractalOptionSpecs());
  FractalOptions options;
  options.input = reader.text("input");
  options.grid = reader.text("grid");
  options.voxels = reader.voxels("resolution", "voxel-size");
  options.sdfVoxels = reader.voxels("sdf-resolution", "sdf-voxel-size");
  options.repair = reader.flag("repair");
  options.gap = reader.notNegative("repair-gap");
  options.map = reader.choice<MapKind>(
      "map",
      {{"shape-modulus", MapKind::ShapeModulus}, {"rational", MapKind::Rational}, {"quadratic", MapKind::Quadratic}});
  options.alpha = reader.text("alpha");
  options.beta = reader.text("beta");
  options.versor = reader.text("versor");
  if (const std::string rational = reader.text("rational"); !rational.empty()) {
    if (options.map != MapKind::Rational)
      throw std::invalid_argument("--rational gives the map's roots; it goes with --map rational");
    if (options.versor != "random")
      throw std::invalid_argument("--rational and --versor both give the map's roots; give one of them");
    if (rational == "random") reader.refuse("rational", "a file; --versor random draws roots");
    options.versor = rational;
  }
  options.randomRoots = parseRandomRoots(reader);
  options.versorScale = reader.number("versor-scale");
  if (options.versorScale == 0) refuse("versor-scale", reader.text("versor-scale"), "other than 0");
  options.versorTranslate = reader.vector("versor-translate");
  const std::vector<double> c = parseNumbers("c", reader.text("c"), 4);
  options.c = {c[0], c[1], c[2], c[3]};
  options.iterations = reader.integer("iterations", 1, julia::kMaxIterations);
  options.escape = reader.number("escape");
  if (!(options.escape > 1 && options.escape <= julia::kMaxEscapeRadius))
    refuse("escape", reader.text("escape"), "above 1 and at most 1e9");
  options.slice = reader.number("slice");
  options.origin = reader.vector("origin");
  options.dropAxis = reader.choice<julia::DropAxis>(
      "drop-axis", {{"i", julia::DropAxis::I}, {"j", julia::DropAxis::J}, {"k", julia::DropAxis::K}});
  options.randomRoots.embedding = {options.slice, options.dropAxis};
  options.space = reader.choice<SpaceKind>("space", {{"fit", SpaceKind::Fit}, {"world", SpaceKind::World}});
  if (reader.has("box")) {
    const std::vector<double> b = parseNumbers("box", reader.text("box"), 6);
    options.box.emplace(openvdb::Vec3d(b[0], b[1], b[2]), openvdb::Vec3d(b[3], b[4], b[5]));
    for (int axis = 0; axis < 3; ++axis)
      if (!(b[static_cast<std::size_t>(axis)] < b[static_cast<std::size_t>(axis) + 3]))
        refuse("box", reader.text("box"), "x0,y0,z0,x1,y1,z1 with the smaller corner first");
  }
  options.tolerance = reader.number("tolerance");
  if (!(options.tolerance >= 0x1p-40 && options.tolerance <= 0.5))
    refuse("tolerance", reader.text("tolerance"), "at least 1e-12 and at most 0.5");
  options.islands.largest = reader.integer<std::uint64_t>("largest", 0, std::numeric_limits<std::uint64_t>::max());
  options.islands.minSize = reader.notNegative("min-size");
  options.cap = reader.flag("cap");
  options.precision = reader.choice<Precision>(
      "precision", {{"auto", Precision::Auto}, {"float", Precision::Float}, {"double", Precision::Double}});
  options.interpolation = reader.choice<julia::Interpolation>(
      "sampling", {{"trilinear", julia::Interpolation::Trilinear}, {"quadratic", julia::Interpolation::Quadratic}});
  options.exhaustive = reader.flag("exhaustive");
  const int stride = reader.integer<int>("seed-stride", 1, 64);
  if (!isSeedStride(stride)) refuse("seed-stride", reader.text("seed-stride"), "a power of 2, at most 64");
  if (reader.flag("follow")) {
    if (options.exhaustive)
      throw std::invalid_argument("--follow and --exhaustive contradict each other; give one of them");
    options.follow = FollowOptions{.seedStride = stride};
  }
  options.grids = parseGrids(reader.text("grids"));
  options.half = reader.flag("half");
  options.sourceHash = reader.text(kHashOptions[0]);
  options.versorHash = reader.text(kHashOptions[1]);
  return options;
}

}  // namespace vdbtools
