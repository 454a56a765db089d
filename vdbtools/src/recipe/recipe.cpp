// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/recipe/recipe.h"

#include "recipe/recipe_reader.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/mesh/mesh_writer.h"

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

constexpr unsigned kCross = mapBit(MapKind::Cross), kMandelbulb = mapBit(MapKind::Mandelbulb);
constexpr unsigned kSpatial = kCross | kMandelbulb;  // on R^3; their sets have no target

constexpr OptionSpec kFractalSpecs[] = {
    {"input", "MESH|SDF.vdb", nullptr, "the target: a mesh, or a VDB that holds its signed distance", ~kSpatial},
    {"grid", "NAME", "", "which grid of a VDB input"},
    {"resolution", "N", "200",
     "voxels of the result along the longest side of the target, or of the region without one"},
    {"voxel-size", "H", nullptr, "the size of a voxel of the result, in the target's units"},
    {"sdf-resolution", "N", "200",
     "voxels of the target's distance field along its longest side; the fractal is a function of it"},
    {"sdf-voxel-size", "H", nullptr, "the same as a size, in the target's units"},
    {"repair", nullptr, nullptr, "close holes and gaps of an open mesh or a triangle soup"},
    {"repair-gap", "W", "0", "close gaps up to this width, in the mesh's units; 0 finds the smallest that serves"},
    {"map", "shape-modulus|rational|quadratic|cross|mandelbulb", "shape-modulus", "the map that is iterated"},
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
    {"scheme", "3|4|5", "4",
     "cross: the equation of Zimmermann and Bruckner 2025; 3: p x g(c), 4: f(p) x g(p) + c, 5: the same with c fixed",
     kCross},
    {"pair", "A|A'|B|C|D|E|user", nullptr, "cross: f and g, the paper's or your own (default A; user with --f)",
     kCross},
    {"f", "X,Y,Z", nullptr, "cross: the first function of your own pair, such as \"x*x, y*y, z*z\"", kCross},
    {"g", "X,Y,Z", nullptr, "cross: the second one, such as \"cos(x), cos(y), cos(z)\"", kCross},
    {"power", "P", "8", "mandelbulb: the power of triplex numbers, any real number from -100 to 100", kMandelbulb},
    {"theta", "plane|pole", "plane",
     "mandelbulb: where its second angle is 0, as in the paper, or as in the well-known set of power 8", kMandelbulb},
    {"c", "A,B,C[,D]", nullptr,
     "the constant of a Julia set: four numbers for quadratic (default 0,0,0,0), three for mandelbulb and for cross in "
     "scheme 5 (default -1,0,0)"},
    {"mandelbrot", nullptr, nullptr,
     "quadratic, mandelbulb: the constant is the point itself (default for mandelbulb without --c)",
     kMandelbulb | mapBit(MapKind::Quadratic)},
    {"iterations", "N", nullptr, "steps of the map (default 3; 10 for cross, mandelbulb and --mandelbrot)"},
    {"escape", "R", "20", "radius beyond which an orbit has escaped", ~kSpatial},
    {"radius", "R", "2", "cross, mandelbulb: the same, and of the ball in which the set is looked for", kSpatial},
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

constexpr std::pair<const char*, MapKind> kMaps[] = {{"shape-modulus", MapKind::ShapeModulus},
                                                     {"rational", MapKind::Rational},
                                                     {"quadratic", MapKind::Quadratic},
                                                     {"cross", MapKind::Cross},
                                                     {"mandelbulb", MapKind::Mandelbulb}};

}  // namespace

MapKind mapOf(const Recipe& recipe) {
  const std::string text = given(recipe, "map").value_or(kMaps[0].first);
  for (const auto& [name, map] : kMaps)
    if (text == name) return map;
  return kMaps[0].second;
}

namespace {

bool isMandelbrot(const Recipe& recipe) { return given(recipe, "mandelbrot").value_or("false") != "false"; }

/// What an option that is not given has for its value, if it has one: with this map and what else is given.
std::optional<std::string> defaultOf(const OptionSpec& spec, const Recipe& recipe) {
  const MapKind map = mapOf(recipe);
  const std::string_view name = spec.name;
  if (!(spec.maps & mapBit(map)) || recipe.contains(alternativeOption(spec.name))) return std::nullopt;
  if (name == "iterations") return (mapBit(map) & kSpatial) || isMandelbrot(recipe) ? "10" : "3";
  if (name == "pair") return recipe.contains("f") || recipe.contains("g") ? "user" : "A";
  if (name == "mandelbrot" && map == MapKind::Mandelbulb) return "true";
  if (name == "c" && map == MapKind::Cross)
    return given(recipe, "scheme") == "5" ? std::optional("-1,0,0") : std::nullopt;
  if (name == "c" && map != MapKind::Mandelbulb) return "0,0,0,0";
  return spec.defaultValue ? std::optional(spec.defaultValue) : std::nullopt;
}

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

julia::Point parsePoint(const std::string& option, const std::string& text) {
  const std::vector<double> values = parseNumbers(option, text, 3);
  return {values[0], values[1], values[2]};
}

/// Three numbers, and a fourth if it is 0: a quaternion that lies in space.
julia::Point parseSpatialConstant(const std::string& option, const std::string& text) {
  const bool padded = std::count(text.begin(), text.end(), ',') == 3 && parseNumbers(option, text, 4)[3] == 0;
  return parsePoint(option, padded ? text.substr(0, text.rfind(',')) : text);
}

julia::CrossOptions parseCross(const RecipeReader& reader) {
  using julia::CrossPair, julia::CrossScheme;
  julia::CrossOptions options;
  options.scheme = reader.choice<CrossScheme>(
      "scheme", {{"3", CrossScheme::FixedFactor}, {"4", CrossScheme::Mandelbrot}, {"5", CrossScheme::Julia}});
  options.pair = reader.choice<CrossPair>("pair", {{"A", CrossPair::A},
                                                   {"A'", CrossPair::APrime},
                                                   {"B", CrossPair::B},
                                                   {"C", CrossPair::C},
                                                   {"D", CrossPair::D},
                                                   {"E", CrossPair::E},
                                                   {"user", CrossPair::User}});
  for (const char* function : {"f", "g"}) {
    if (options.pair == CrossPair::User && !reader.has(function))
      throw std::invalid_argument(std::string("the pair user needs --") + function +
                                  ", three expressions with commas between them, such as \"x*x, y*y, z*z\"");
    if (options.pair != CrossPair::User && reader.has(function))
      throw std::invalid_argument(std::string("--") + function + " is for --pair user, and the pair is " +
                                  reader.text("pair") + "; give one of the two");
  }
  options.f = reader.text("f");
  options.g = reader.text("g");
  if (options.scheme == CrossScheme::Julia)
    options.constant = parsePoint("c", reader.text("c"));
  else if (reader.has("c"))
    throw std::invalid_argument("--c is for scheme 5; in scheme " + reader.text("scheme") + " c is the point");
  return options;
}

julia::MandelbulbOptions parseMandelbulb(const RecipeReader& reader, bool mandelbrot) {
  using julia::TriplexAngle;
  julia::MandelbulbOptions options;
  options.power = reader.number("power");
  if (!(std::abs(options.power) <= 100)) refuse("power", reader.text("power"), "between -100 and 100");
  options.angle =
      reader.choice<TriplexAngle>("theta", {{"plane", TriplexAngle::AbovePlane}, {"pole", TriplexAngle::FromPole}});
  if (!mandelbrot) options.constant = reader.has("c") ? parseSpatialConstant("c", reader.text("c")) : julia::Point{};
  return options;
}

/// The map and what belongs to it alone.
void parseMap(const RecipeReader& reader, FractalOptions& options) {
  options.mandelbrot = reader.flag("mandelbrot");
  if (options.mandelbrot && reader.has("c"))
    throw std::invalid_argument("--c and --mandelbrot contradict each other: there c is the point; give one of them");
  if (options.map == MapKind::Cross) options.cross = parseCross(reader);
  if (options.map == MapKind::Mandelbulb) options.mandelbulb = parseMandelbulb(reader, options.mandelbrot);
  const bool spatial = mapBit(options.map) & kSpatial;
  if (!spatial && reader.has("c")) {
    const std::vector<double> c = parseNumbers("c", reader.text("c"), 4);
    options.c = {c[0], c[1], c[2], c[3]};
  }
  options.iterations = reader.integer("iterations", 1, julia::kMaxIterations);
  const char* escape = spatial ? "radius" : "escape";
  options.escape = reader.number(escape);
  if (!(options.escape > 1 && options.escape <= julia::kMaxEscapeRadius))
    refuse(escape, reader.text(escape), "above 1 and at most 1e9");
  options.slice = reader.number("slice");
  options.dropAxis = reader.choice<julia::DropAxis>(
      "drop-axis", {{"i", julia::DropAxis::I}, {"j", julia::DropAxis::J}, {"k", julia::DropAxis::K}});
  if (spatial && (options.slice != 0 || options.dropAxis != julia::DropAxis::K))
    throw std::invalid_argument("the map " + reader.text("map") +
                                " has three dimensions; leave --slice and --drop-axis out");
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
      {"resolution", "voxel-size"}, {"sdf-resolution", "sdf-voxel-size"}, {"versor", "rational"}, {"c", "mandelbrot"}};
  for (const auto& [one, other] : kPairs) {
    if (option == one) return other;
    if (option == other) return one;
  }
  return {};
}

std::vector<std::string> displacedOptions(const Recipe& base, const std::string& option, const std::string& value) {
  const std::optional<std::string> before = given(base, option);
  if (before == value) return {};
  std::vector<std::string> displaced{alternativeOption(option)};
  if (option == "f" || option == "g") displaced.emplace_back("pair");
  if (option == "pair") displaced.insert(displaced.end(), {"f", "g"});
  if (option == "scheme" && before) displaced.emplace_back("c");
  if (option == "map" && before) {
    displaced.insert(displaced.end(), {"c", "iterations"});
    if (mapBit(mapOf({{"map", value}})) & kSpatial) displaced.emplace_back(kHashOptions[0]);
    for (const OptionSpec& spec : kFractalSpecs)
      if (!(spec.maps & mapBit(mapOf({{"map", value}})))) displaced.emplace_back(spec.name);
  }
  return displaced;
}

Recipe completeRecipe(Recipe recipe, std::span<const OptionSpec> specs) {
  for (const OptionSpec& spec : specs) {
    if (recipe.contains(spec.name)) continue;
    if (const std::optional<std::string> value = defaultOf(spec, recipe)) recipe.emplace(spec.name, *value);
  }
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
  options.map = reader.choice<MapKind>("map", kMaps);
  options.alpha = reader.text("alpha");
  options.beta = reader.text("beta");
  options.versor = reader.text("versor");
  if (const std::string rational = reader.text("rational"); !rational.empty()) {
    if (options.map != MapKind::Rational)
      throw std::invalid_argument("--rational gives the map's roots; it goes with --map rational");
    if (reader.has("versor") && options.versor != "random")
      throw std::invalid_argument("--rational and --versor both give the map's roots; give one of them");
    if (rational == "random") reader.refuse("rational", "a file; --versor random draws roots");
    options.versor = rational;
  }
  options.randomRoots = parseRandomRoots(reader);
  options.versorScale = reader.number("versor-scale");
  if (options.versorScale == 0) refuse("versor-scale", reader.text("versor-scale"), "other than 0");
  options.versorTranslate = reader.vector("versor-translate");
  parseMap(reader, options);
  options.origin = reader.vector("origin");
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
