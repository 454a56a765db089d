// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/maps/map_options.h"

#include "recipe/option_rows.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/base/fractal_space.h"
#include "vdbtools/base/text.h"
#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/maps/versor_options.h"

#include <openvdb/tools/Interpolation.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace vdbtools {
namespace {

using openvdb::FloatGrid;
using openvdb::Vec3d;

constexpr const char* kVersorJson = "julia_versor_json";
constexpr const char* kRandom = "random";

OptionSpec kept(OptionSpec spec) {
  spec.kept = true;
  return spec;
}

/// The options that say something of random roots alone, and nothing of a texture or a file.
constexpr const char* kRandomOnly[] = {"texture-roots",    "texture-powers", "texture-integer", "texture-placement",
                                       "texture-distance", "texture-centre", "texture-radius"};

bool isRandomOnly(const std::string& option) {
  return std::find(std::begin(kRandomOnly), std::end(kRandomOnly), option) != std::end(kRandomOnly);
}

/// The target's longest side in fractal space; 1 without a target.
double sideOf(const MapContext& context) {
  return context.target ? longestSide(context.target->box) / context.unmovedSpace.scale : 1;
}

/// Placed in the target's box, or in the usual one without a target. Roots lie in the target's space, and moving the
/// dynamics' origin does not place them anew.
julia::Rational randomRoots(julia::RandomRootsOptions random, const MapContext& context) {
  if (context.target) {
    const FractalSpace space = context.unmovedSpace;
    random.boxMin = space.toFractal(context.target->box.min());
    random.boxMax = space.toFractal(context.target->box.max());
    random.surfaceDistance *= sideOf(context);
    random.distance = [phi = FloatGrid::ConstPtr(context.target->phi), space](const julia::Point& x) {
      return openvdb::tools::BoxSampler::sample(phi->tree(), phi->worldToIndex(space.toWorld(x))) / space.scale;
    };
  }
  return {0, julia::randomPolynomial(random), {}};
}

/// The usual versor. Whoever says something of random roots, their seed included, means those; and a rational map,
/// whose shape is that of its roots, has them too.
std::string usualVersor(const Recipe& recipe) {
  const auto map = recipe.find("map");
  const bool isRational = map != recipe.end() && map->second == "rational";
  const bool saysRandom = std::any_of(recipe.begin(), recipe.end(), [](const auto& entry) {
    return isRandomOnly(entry.first) || entry.first == "texture-seed";
  });
  return isRational || saysRandom ? kRandom : defaultTexture().name;
}

/// Why roots are not drawn at random; "" if they are.
std::string notRandom(const OptionRun& run) {
  const std::string rational = run.text("map") == "rational" ? run.text("rational") : "";
  const std::string name = rational.empty() ? run.text("texture") : rational;
  if (name.empty() || name == kRandom) return {};
  if (isDirections(name)) return "--texture " + name + " has no roots";
  return findTexture(name) ? "--texture " + name + " has roots of its own" : "the roots are those of '" + name + "'";
}

/// Of an option of random roots.
std::string idleRandomOnly(const OptionRun& run) {
  const std::string why = notRandom(run);
  return why.empty() ? "" : why + "; leave it out, or give --texture random";
}

/// Whether all layers of the texture follow a grain.
bool isAllGrain(const OptionRun& run) {
  const auto given = [&](const char* option) {
    const auto found = run.recipe.find(option);
    return found == run.recipe.end() ? std::string("none") : found->second;
  };
  const std::string over = given("texture-over");
  return hasGrain(run.recipe) && followsGrain(given("texture")) && (over == "none" || followsGrain(over));
}

/// Of --texture-translate.
std::string idleTranslate(const OptionRun& run) {
  return isAllGrain(run)
             ? "a texture that follows a grain lies where the target does; leave it out, or leave --grain out"
             : "";
}

/// Of --slice.
std::string idleSlice(const OptionRun& run) {
  return isAllGrain(run)
             ? "a texture that follows a grain is the same in all slices; leave it out, or leave --grain out"
             : "";
}

std::string idleSeed(const OptionRun& run) {
  const Texture* texture = findTexture(run.text("texture"));
  if (!texture || notRandom(run).empty()) return idleRandomOnly(run);
  return texture->varies()
             ? ""
             : "--texture " + texture->name + " has nothing random; leave it out, or give --texture random";
}

/// Of an option of one way to place random roots.
IdleRule idleUnlessPlaced(const char* placement) {
  return idleByAny({idleRandomOnly, [placement](const OptionRun& run) -> std::string {
                      const std::string given = run.text("texture-placement");
                      return given == placement ? ""
                                                : std::string("it is for roots that are placed by '") + placement +
                                                      "', and they are placed by '" + given + "'; leave it out";
                    }});
}

std::uint64_t parseSeed(const RecipeReader& reader, const std::string& option) {
  return reader.integer<std::uint64_t>(option, 0, std::numeric_limits<std::uint64_t>::max());
}

/// Of --frequency.
std::string idleFrequency(const OptionRun& run) {
  const bool withGrain = hasGrain(run.recipe) && followsGrain(run.text("texture"));
  if (run.text("map") == "rational" || (!followsThickness(run.text("texture")) && !withGrain))
    return "it is for textures of waves, and roots are as large as they are; leave it out, or give a texture that "
           "follows the thickness";
  return {};
}

/// The words for it, by the number of features across the local thickness.
constexpr std::pair<const char*, double> kFrequencyWords[] = {{"coarse", 1}, {"medium", 2}, {"fine", 4}};

std::string knownVersors() {
  std::string names;
  for (const Texture& texture : textureShelf()) names += texture.name + ", ";
  return names +
         "random, a file: .json, .p4d, .poly4d or .o3d, waves:FILE.json, expr:A,B,C or "
         "field:FILE.vdb:GRID";
}

julia::Rational moved(julia::Rational rational, const RootsSettings& settings, const julia::Embedding& embedding) {
  if (settings.scale != 1) rational = scaled(std::move(rational), settings.scale);
  const Vec3d& by = settings.translate;
  const julia::Embedding unsliced{0, embedding.dropped};
  return translated(std::move(rational), unsliced.quaternion<double>({by[0], by[1], by[2]}));
}

}  // namespace

ControlSetting parseFrequency(const RecipeReader& reader, const std::string& option) {
  const std::string text = reader.text(option);
  for (const auto& [word, value] : kFrequencyWords)
    if (text == word) return numberSource(value, text);
  if (const std::optional<double> value = numberFromText(text); value && !(*value > 0 && std::isfinite(*value)))
    reader.refuse(option, "above 0, or coarse, medium or fine");
  return parseControl(reader, option);
}

std::vector<std::string> textureNames() {
  std::vector<std::string> names{kRandom};
  for (const Texture& texture : textureShelf()) names.push_back(texture.name);
  return names;
}

OptionType frequencyType() {
  OptionType type{.kind = OptionType::Kind::Control, .low = 0, .excludesLow = true};
  for (const auto& [word, value] : kFrequencyWords) type.words.emplace_back(word);
  return type;
}

OptionSpec frequencyOption() {
  return {.name = "frequency",
          .argument = "F",
          .help =
              "how many features of the texture lie across the local thickness: coarse (1), medium (2), fine (4) "
              "or a number above 0; takes the same values as --detail. For the textures that follow the thickness",
          .defaultFor = [](const Recipe& recipe) -> std::optional<std::string> {
            const auto versor = recipe.find("texture");
            const std::string texture = versor == recipe.end() ? usualVersor(recipe) : versor->second;
            return followsThickness(texture) || (hasGrain(recipe) && followsGrain(texture))
                       ? std::optional<std::string>("medium")
                       : std::nullopt;
          },
          .defaultNote = "medium",
          .hash = "frequency-sha256",
          .type = frequencyType(),
          .idle = idleFrequency};
}

OptionSpec iterationsOption(const std::string& usual) {
  return {.name = "iterations",
          .argument = "N",
          .defaultValue = usual,
          .help = "how often the map is applied at most",
          .type = {.kind = OptionType::Kind::Whole, .low = 1, .high = julia::kMaxIterations},
          .followsSelector = true};
}

OptionSpec escapeOption() {
  return {.name = "escape",
          .argument = "R",
          .defaultValue = "20",
          .help = "the radius beyond which an orbit has escaped",
          .alternative = "radius",
          .type = above(1, julia::kMaxEscapeRadius)};
}

OptionSpec radiusOption() {
  return {.name = "radius",
          .argument = "R",
          .defaultValue = "2",
          .help = "the radius beyond which an orbit has escaped, and of the ball in which the set is searched",
          .alternative = "escape",
          .type = above(1, julia::kMaxEscapeRadius)};
}

julia::OrbitOptions parseOrbit(const RecipeReader& reader, const std::string& escape) {
  return {.maxIterations = reader.integer("iterations", 1, julia::kMaxIterations),
          .escapeRadius = readNumber(reader, escape, above(1, julia::kMaxEscapeRadius))};
}

OptionSpec mandelbrotOption(bool usual) {
  OptionSpec option{.name = "mandelbrot",
                    .help = "take the point itself as the constant",
                    .alternative = "c",
                    .type = {.kind = OptionType::Kind::Flag}};
  if (usual) {
    option.defaultValue = "true";
    option.defaultNote = "on without --c";
  }
  return option;
}

bool parseMandelbrot(const RecipeReader& reader) {
  const bool mandelbrot = reader.flag("mandelbrot");
  if (mandelbrot && reader.has("c"))
    throw std::invalid_argument(
        "--c and --mandelbrot contradict each other, because --mandelbrot takes the point itself as the constant; give "
        "only one of them");
  return mandelbrot;
}

namespace {

const OptionRows<julia::Embedding>& embeddingRows() {
  using julia::DropAxis;
  static const OptionRows<julia::Embedding> rows{
      {kept({.name = "slice",
             .argument = "S",
             .help = "the fourth coordinate of the slice through the quaternions",
             .idle = idleSlice}),
       number(&julia::Embedding::slice)},
      {kept({.name = "drop-axis", .help = "the quaternion axis along which the target is extruded"}),
       choice<DropAxis>(&julia::Embedding::dropped, {{"i", DropAxis::I}, {"j", DropAxis::J}, {"k", DropAxis::K}})}};
  return rows;
}

}  // namespace

std::vector<OptionSpec> embeddingOptions() { return embeddingRows().specs(); }

julia::Embedding parseEmbedding(const RecipeReader& reader) { return embeddingRows().read(reader); }

julia::Embedding parseSpatialEmbedding(const RecipeReader& reader) {
  // Recipes hold the two options for every map, at their defaults.
  const julia::Embedding embedding = parseEmbedding(reader);
  if (embedding.slice != 0 || embedding.dropped != julia::DropAxis::K)
    throw std::invalid_argument("--map " + reader.text("map") +
                                " has three dimensions, so --slice and --drop-axis do not apply; leave them out");
  return embedding;
}

namespace {

void parsePowers(const RecipeReader& reader, const std::string& name, julia::RandomRootsOptions& options) {
  const std::vector<std::string> ends = split(reader.text(name), ':');
  if (ends.size() > 2) reader.refuse(name, "MIN:MAX");
  options.minPower = parseNumber(name, ends.front());
  options.maxPower = parseNumber(name, ends.back());
  if (options.minPower > options.maxPower) reader.refuse(name, "MIN:MAX with the smaller first");
}

const OptionRows<julia::RandomRootsOptions>& randomRootsRows() {
  using Random = julia::RandomRootsOptions;
  using julia::RootPlacement;
  static const OptionRows<Random> rows{
      {kept({.name = "texture-seed",
             .argument = "S",
             .help = "the seed of random roots: every number is another texture; it also varies a texture that has "
                     "something random",
             .idle = idleSeed}),
       whole(&Random::seed, std::uint64_t{0}, std::numeric_limits<std::uint64_t>::max())},
      {kept({.name = "texture-roots", .argument = "N", .help = "the number of roots", .idle = idleRandomOnly}),
       whole(&Random::count, 1, 1'000'000)},
      {kept({.name = "texture-powers",
             .argument = "MIN:MAX",
             .defaultValue = numberText(Random{}.minPower) + ':' + numberText(Random{}.maxPower),
             .help = "the range of their powers: higher powers make finer detail",
             .idle = idleRandomOnly}),
       parsedBy(parsePowers)},
      {kept({.name = "texture-integer", .help = "use whole powers only", .idle = idleRandomOnly}),
       flag(&Random::integerPowers)},
      {kept({.name = "texture-placement", .help = "where the roots are placed", .idle = idleRandomOnly}),
       choice<RootPlacement>(&Random::placement, {{"box", RootPlacement::Box},
                                                  {"inside", RootPlacement::Inside},
                                                  {"surface", RootPlacement::Surface},
                                                  {"cluster", RootPlacement::Cluster}})},
      {kept({.name = "texture-distance",
             .argument = "D",
             .help =
                 "for --texture-placement surface: the largest distance of roots from it, as a share of the longest "
                 "side",
             .idle = idleUnlessPlaced("surface")}),
       number(&Random::surfaceDistance, above(0))},
      {kept({.name = "texture-centre",
             .argument = "X,Y,Z",
             .help = "for --texture-placement cluster: its centre, in fractal space",
             .idle = idleUnlessPlaced("cluster")}),
       vector(&Random::clusterCentre)},
      {kept({.name = "texture-radius",
             .argument = "R",
             .help = "for --texture-placement cluster: its radius, in fractal space",
             .idle = idleUnlessPlaced("cluster")}),
       number(&Random::clusterRadius, above(0))}};
  return rows;
}

}  // namespace

std::vector<OptionSpec> randomRootsOptions() { return randomRootsRows().specs(); }

std::vector<OptionSpec> rootsOptions() {
  std::vector<OptionSpec> options{kept(
      {.name = "texture",
       .argument = "NAME|random|FILE|expr:...",
       .help =
           "the texture (versor): one of those that 'juliavdb versor list' shows, random roots, a .json, .p4d, .poly4d "
           "or .o3d file, waves of 'juliavdb versor new' (waves:FILE.json), a formula (expr:A,B,C) or a field "
           "(field:FILE.vdb:GRID)",
       .defaultFor = [](const Recipe& recipe) { return usualVersor(recipe); },
       .defaultNote = defaultTexture().name + "; random with any option of random roots",
       .alternative = "rational",
       .displaces = {std::begin(kRandomOnly), std::end(kRandomOnly)},
       .hash = "texture-sha256"})};
  for (OptionSpec& option : randomRootsOptions()) {
    if (isRandomOnly(option.name)) {
      option.displaces = {"texture"};
      // Not recorded with a texture, where they mean nothing.
      option.defaultFor = [usual = option.defaultValue](const Recipe& recipe) {
        const auto versor = recipe.find("texture");
        return versor != recipe.end() && (findTexture(versor->second) || isDirections(versor->second)) ? std::nullopt
                                                                                                       : usual;
      };
    }
    options.push_back(std::move(option));
  }
  options.push_back(kept(
      {.name = "texture-scale", .argument = "F", .defaultValue = "1", .help = "scale the texture about the origin"}));
  options.push_back(kept({.name = "texture-translate",
                          .argument = "X,Y,Z",
                          .defaultValue = "0,0,0",
                          .help = "move the texture alone, or the roots of a rational map, in fractal space",
                          .idle = idleTranslate}));
  return options;
}

julia::RandomRootsOptions parseRandomRoots(const RecipeReader& reader) { return randomRootsRows().read(reader); }

namespace {

/// What all roots take.
void parsePlacement(const RecipeReader& reader, RootsSettings& settings) {
  settings.random.embedding = parseEmbedding(reader);
  settings.scale = reader.number("texture-scale");
  if (settings.scale == 0) reader.refuse("texture-scale", "other than 0");
  settings.translate = reader.vector("texture-translate");
}

/// @throw std::invalid_argument  it is no name that a file may have
NamedFile parseRootsFile(const RecipeReader& reader, const std::string& option) {
  NamedFile file = reader.file(option);
  if (file.path.extension().empty())
    reader.refuse(option, "one of " + knownVersors() + didYouMean(reader.text(option), textureNames()));
  return file;
}

}  // namespace

void refuseRandomOnly(const RecipeReader& reader) {
  for (const char* option : kRandomOnly)
    if (reader.has(option))
      throw std::invalid_argument("--" + std::string(option) + " belongs to random roots, and --texture " +
                                  reader.text("texture") + " has its own; leave one of them out");
}

RootsSettings parseRoots(const RecipeReader& reader, const std::string& fileOption) {
  RootsSettings settings;
  const std::string name = reader.text(fileOption);
  if (fileOption == "texture") settings.texture = findTexture(name);
  if (settings.texture) {
    refuseRandomOnly(reader);
    settings.random.seed = parseSeed(reader, "texture-seed");
  } else {
    if (fileOption == "texture" && isDirections(name))
      reader.refuse(fileOption, "roots, of which a rational map is made: random, or a file");
    if (!name.empty() && name != kRandom)
      settings.file = fileOption == "texture" ? parseRootsFile(reader, fileOption) : reader.file(fileOption);
    settings.random = parseRandomRoots(reader);
  }
  if (settings.texture && (settings.texture->followsThickness() || hasGrain(reader))) {
    if (!reader.has("frequency"))
      throw std::invalid_argument("--texture " + name +
                                  " follows the local thickness of a target, which only --map shape-modulus has; give "
                                  "that, or --texture random, rings or shells");
    settings.frequency = parseFrequency(reader, "frequency");
  }
  parsePlacement(reader, settings);
  return settings;
}

RootsSettings parseOverRoots(const RecipeReader& reader) {
  RootsSettings settings;
  const std::string name = reader.text("texture-over");
  settings.texture = findTexture(name);
  if (!settings.texture && name != kRandom) settings.file = parseRootsFile(reader, "texture-over");
  settings.random.seed = parseSeed(reader, "texture-over-seed");
  if (settings.texture && (settings.texture->followsThickness() || hasGrain(reader)))
    settings.frequency = parseFrequency(reader, "texture-over-frequency");
  parsePlacement(reader, settings);
  return settings;
}

std::optional<RationalFile> readRoots(const RootsSettings& settings) {
  if (!settings.file) return std::nullopt;
  const std::filesystem::path& path = settings.file->path;
  if (!isVdbPath(path)) return readRationalFile(path);
  const auto metadata = readVdbMetadata(path);
  const auto json = metadata.find(kVersorJson);
  if (json == metadata.end())
    throw DataError("'" + path.string() +
                    "' holds no roots; only a VDB that 'juliavdb fractal' made with a versor of roots does");
  return rationalFileFromJson(json->second, path.string());
}

double interiorReachOf(const RootsSettings& settings) {
  const bool onSurface =
      !settings.texture && !settings.file && settings.random.placement == julia::RootPlacement::Surface;
  return onSurface ? settings.random.surfaceDistance : 0;
}

std::map<std::string, std::string> PlacedRoots::metadata() const {
  return {{kVersorJson, rationalToJson(drawn, {}, fitted)}};
}

julia::WaveTexture placeWaves(const RootsSettings& settings, const std::optional<WaveFile>& file,
                              const julia::Embedding& embedding) {
  julia::WaveTexture waves =
      placedWaves(file ? file->waves : wavesOf(*settings.texture, settings.random.seed), settings.scale, embedding);
  const Vec3d& by = settings.translate;
  waves.origin = julia::Embedding{0, embedding.dropped}.quaternion<double>({by[0], by[1], by[2]});
  return waves;
}

julia::WaveTexture grainWaves(const RootsSettings& settings, const std::optional<WaveFile>& file, int octave) {
  return file ? alongGrain(file->waves, octave) : grainWavesOf(*settings.texture, settings.random.seed, octave);
}

std::optional<std::uint64_t> seedOf(const RootsSettings& settings) {
  const bool varies = settings.texture ? settings.texture->varies() : !settings.file;
  return varies ? std::optional(settings.random.seed) : std::nullopt;
}

PlacedRoots placeRoots(const RootsSettings& settings, const std::optional<RationalFile>& file,
                       const julia::Embedding& embedding, const MapContext& context) {
  PlacedRoots roots;
  if (file) {
    roots.drawn = file->rational;
    roots.fitted = file->target;
  } else if (settings.texture && settings.texture->followsThickness()) {
    return roots;
  } else if (settings.texture) {
    roots.drawn = placeTexture(*settings.texture, sideOf(context), embedding);
  } else {
    roots.drawn = randomRoots(settings.random, context);
  }
  roots.placed = moved(roots.drawn, settings, embedding);
  return roots;
}

namespace {

constexpr double kMostSummedPowers = 250;

}  // namespace

bool floatsServeWaves(const julia::OrbitOptions& orbit) {
  constexpr int kMostIterations = 10;
  return orbit.maxIterations <= kMostIterations;
}

bool floatsServeVersor(const julia::OrbitOptions& orbit, const julia::Rational& roots) {
  if (!floatsServeWaves(orbit)) return false;
  // Seen from afar, a pair turns the less, the nearer its two are to each other: at the distance r, by their distance
  // as a share of r. Fractals lie about this far from most of their roots.
  constexpr double kFar = 0.5;
  constexpr std::size_t kMostRoots = 4000;  // the search for pairs takes the product of their numbers
  const std::vector<julia::Root>&top = roots.top.roots, &bottom = roots.bottom.roots;
  const auto powerOf = [](const julia::Root& root, const julia::Polynomial& in) {
    return std::abs(root.power * in.powerScale);
  };
  double powers = 0;
  std::vector<char> paired(top.size(), 0);
  for (const julia::Root& pole : bottom) {
    double nearest = kFar;
    std::size_t with = top.size();
    for (std::size_t i = 0; i < top.size() && std::max(top.size(), bottom.size()) <= kMostRoots; ++i) {
      if (paired[i]) continue;
      const double distance = std::sqrt(julia::normSquared(top[i].position - pole.position));
      if (distance < nearest) {
        nearest = distance;
        with = i;
      }
    }
    const double below = powerOf(pole, roots.bottom);
    if (with == top.size()) {
      powers += below;
      continue;
    }
    paired[with] = 1;
    const double above = powerOf(top[with], roots.top), both = std::min(above, below);
    powers += 2 * both * nearest / kFar + (std::max(above, below) - both);
  }
  for (std::size_t i = 0; i < top.size(); ++i)
    if (!paired[i]) powers += powerOf(top[i], roots.top);
  return powers <= kMostSummedPowers;
}

bool floatsServe(const julia::OrbitOptions& orbit, const julia::Rational& roots) {
  constexpr int kMostIterations = 5;
  if (orbit.maxIterations > kMostIterations) return false;
  double powers = 0;
  for (const julia::Polynomial* polynomial : {&roots.top, &roots.bottom})
    for (const julia::Root& root : polynomial->roots) powers += std::abs(root.power * polynomial->powerScale);
  return powers <= kMostSummedPowers;
}

}  // namespace vdbtools
