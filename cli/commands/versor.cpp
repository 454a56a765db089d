// SPDX-License-Identifier: Apache-2.0
#include "commands.h"

#include "exit_code.h"
#include "options.h"
#include "output.h"
#include "report.h"

#include "vdbtools/base/text.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/formats/peer_formats.h"
#include "vdbtools/formats/versor_file.h"
#include "vdbtools/maps/map_options.h"
#include "vdbtools/maps/texture_shelf.h"

#include "julia/elementary.h"
#include "julia/random_roots.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <iostream>
#include <limits>
#include <optional>
#include <sstream>
#include <variant>

namespace cli {
namespace {

constexpr Usage kVersorUsage = {
    "versor",
    "list|new|inspect|add|scale|translate [FILES] [-o F.json] [options]",
    "Makes, shows and changes versors, the texture of a fractal. A versor is a quaternion polynomial or rational, "
    "given by its roots and powers in fractal space, where the target's longest side is 1. Reads .json, .p4d, .poly4d "
    "and .o3d; writes .json and, for polynomials, .p4d. A texture of waves becomes a .json too, which fractal reads as "
    "--texture waves:FILE.json.\n\n"
    "  list                        show the textures that have a name\n"
    "  new -o F                    make random roots in a box or about a point, or a texture's roots or waves\n"
    "  inspect F                   show what is in a file\n"
    "  add A B -o F                make the ordered product of two versors\n"
    "  scale A FACTOR -o F         scale the roots about the origin\n"
    "  translate A X,Y,Z[,S] -o F  move the roots",
    "  juliavdb versor list\n"
    "  juliavdb versor new -o swirl.json --seed 3 --roots 12 --powers 2:9 --integer\n"
    "  juliavdb versor new -o shells.json --texture shells\n"
    "  juliavdb versor new -o scales.json --texture scales --seed 5\n"
    "  juliavdb versor inspect swirl.json\n"
    "  juliavdb versor scale swirl.json 0.5 -o fine.json\n"
    "  juliavdb versor translate swirl.json 0.1,0,0 -o moved.json\n"
    "  juliavdb versor add fine.json moved.json -o both.json\n",
    nullptr,
    "list new inspect add scale translate"};

constexpr std::string_view kPrefix = "texture-";

/// What 'new' takes for random roots: the options of 'fractal' without their prefix.
std::vector<vdbtools::OptionSpec> newRootsSpecs() {
  std::vector<vdbtools::OptionSpec> specs;
  for (vdbtools::OptionSpec& option : vdbtools::randomRootsOptions()) {
    if (option.name == "texture-distance") continue;  // from a target, of which there is none
    if (option.name == "texture-placement") option.argument = "box|cluster";
    option.name.erase(0, kPrefix.size());
    for (std::size_t at; (at = option.help.find("--texture-")) != std::string::npos;)
      option.help.replace(at, std::string_view("--texture-").size(), "--");
    option.help.insert(0, "new: ");
    specs.push_back(std::move(option));
  }
  return specs;
}

std::vector<vdbtools::OptionSpec> versorOptionSpecs() {
  std::vector<vdbtools::OptionSpec> specs = newRootsSpecs();
  specs.insert(specs.begin(), {.name = "output", .argument = "F.json", .help = "the file to write"});
  specs.push_back({.name = "box",
                   .argument = "X0,Y0,Z0,X1,Y1,Z1",
                   .help = "new: the box in which the roots are placed",
                   .defaultNote = "the unit cube about 0"});
  specs.push_back({.name = "texture",
                   .argument = "NAME",
                   .help = "new: a texture of 'versor list', over a cube about 0, instead of random roots"});
  specs.push_back({.name = "json", .help = "list: write names, descriptions and numbers of roots as JSON"});
  return specs;
}

const std::vector<std::string> kActions{"list", "new", "inspect", "add", "scale", "translate"};

void write(CommandLine& line, const julia::Rational& rational, const std::string& note,
           const std::optional<vdbtools::FittedTo>& target = {}) {
  if (!line.has("output")) throw std::invalid_argument("no output was given; use -o F.json");
  Outputs outputs(line, {});  // the files that are read are words of the command line
  const std::string name = line.text("output");
  std::ostream& file = outputs.add("output", name, ".json .p4d .poly4d").stream();
  const std::string extension = vdbtools::lowerExtension(name);
  if (extension == ".p4d" || extension == ".poly4d") {
    if (!rational.bottom.roots.empty() || rational.logScale != 0)
      throw std::invalid_argument(
          "a " + extension + " holds a polynomial only, and this versor has bottom roots or a scale; write a .json");
    file << vdbtools::rationalToP4d(rational.top);
  } else {
    file << vdbtools::rationalToJson(rational, note, target);
  }
  outputs.commit();
  report().text() << "wrote " << outputs.names() << ": " << rational.top.roots.size() << " top and "
                  << rational.bottom.roots.size() << " bottom roots\n";
}

void inspect(const std::string& name, const julia::Polynomial& polynomial) {
  std::cout << name << ": " << polynomial.roots.size() << " roots, powers times " << polynomial.powerScale << ", sum "
            << julia::summedPowers(polynomial) << '\n';
  for (const julia::Root& root : polynomial.roots)
    std::cout << "  [" << root.position.a << ' ' << root.position.b << ' ' << root.position.c << ' ' << root.position.d
              << "]  power " << root.power << '\n';
}

void inspect(const vdbtools::RationalFile& file) {
  if (!file.note.empty()) std::cout << "note: " << file.note << '\n';
  std::cout << "C: " << file.rational.logScale << '\n';
  inspect("top", file.rational.top);
  inspect("bottom", file.rational.bottom);
}

void inspect(const vdbtools::WaveFile& file) {
  if (!file.note.empty()) std::cout << "note: " << file.note << '\n';
  const auto text = [](const julia::Quaternion<double>& q) {
    std::ostringstream stream;
    stream << '[' << q.a << ' ' << q.b << ' ' << q.c << ' ' << q.d << ']';
    return stream.str();
  };
  for (const julia::WaveFactor& factor : file.waves.factors) {
    std::cout << "factor: " << factor.waves.size() << " waves, power " << factor.power << '\n';
    for (const julia::Wave& wave : factor.waves)
      std::cout << "  frequency " << text(wave.frequency) << "  cosine " << text(wave.cosine) << "  sine "
                << text(wave.sine) << '\n';
  }
}

std::size_t rootCount(const vdbtools::Texture& texture) {
  return texture.followsThickness() ? 0 : vdbtools::placeTexture(texture, 1, {}).top.roots.size();
}

void list(bool asJson) {
  if (asJson) {
    nlohmann::ordered_json textures = nlohmann::ordered_json::array();
    for (const vdbtools::Texture& texture : vdbtools::textureShelf())
      textures.push_back({{"name", texture.name},
                          {"description", texture.description},
                          {"roots", rootCount(texture)},
                          {"follows_thickness", texture.followsThickness()},
                          {"seed", texture.varies()},
                          {"default", &texture == &vdbtools::defaultTexture()}});
    std::cout << textures.dump(2) << '\n';
    return;
  }
  std::size_t width = 0;
  for (const vdbtools::Texture& texture : vdbtools::textureShelf()) width = std::max(width, texture.name.size());
  for (const vdbtools::Texture& texture : vdbtools::textureShelf())
    std::cout << std::left << std::setw(static_cast<int>(width) + 2) << texture.name << texture.description
              << (&texture == &vdbtools::defaultTexture() ? " The default." : "") << '\n';
}

/// Refuses options that do not belong to the action.
void requireAction(const CommandLine& line, const std::string& action) {
  const auto isFor = [&](std::initializer_list<const char*> names, std::initializer_list<const char*> actions) {
    line.requireUse(std::find(actions.begin(), actions.end(), action) != actions.end(), names,
                    "it is for 'versor " + vdbtools::joined(actions) + "'; leave it out");
  };
  isFor({"output"}, {"new", "add", "scale", "translate"});
  for (const vdbtools::OptionSpec& option : newRootsSpecs()) isFor({option.name.c_str()}, {"new"});
  isFor({"box", "texture"}, {"new"});
  isFor({"json"}, {"list"});
}

void writeWaves(CommandLine& line, const julia::WaveTexture& waves, const std::string& note) {
  if (!line.has("output")) throw std::invalid_argument("no output was given; use -o F.json");
  Outputs outputs(line, {});
  outputs.add("output", line.text("output"), ".json").stream() << vdbtools::wavesToJson(waves, note);
  outputs.commit();
  std::size_t count = 0;
  for (const julia::WaveFactor& factor : waves.factors) count += factor.waves.size();
  report().text() << "wrote " << outputs.names() << ": " << count << " waves in " << waves.factors.size()
                  << " factors\n";
}

/// Writes a texture of the shelf: its waves, or its roots as placed in a box with the dynamics' origin at 0.
void writeTexture(CommandLine& line) {
  const std::string name = line.text("texture");
  std::vector<vdbtools::OptionSpec> ofRoots = newRootsSpecs();
  ofRoots.push_back({.name = "box"});
  for (const vdbtools::OptionSpec& option : ofRoots)
    if (option.name != "seed" && line.has(option.name))
      throw std::invalid_argument("--" + option.name + " belongs to random roots, and --texture " + name +
                                  " has its own; leave one of them out");
  const vdbtools::Texture* texture = vdbtools::findTexture(name);
  if (!texture) throw std::invalid_argument("there is no texture '" + name + "'; 'juliavdb versor list' shows them");
  line.requireUse(texture->varies(), {"seed"}, "the texture '" + name + "' has nothing random; leave it out");
  std::string note = "juliavdb versor new --texture " + name;
  if (!texture->followsThickness()) return write(line, vdbtools::placeTexture(*texture, 1, {}), note);
  std::uint64_t seed = 1;
  if (line.has("seed")) {
    seed =
        vdbtools::parseInteger<std::uint64_t>("seed", line.text("seed"), 0, std::numeric_limits<std::uint64_t>::max());
    note += " --seed " + line.text("seed");
  }
  writeWaves(line, vdbtools::wavesOf(*texture, seed), note);
}

/// The versor that 'new' makes, and the command that makes it, without its output.
vdbtools::RationalFile newVersor(const CommandLine& line) {
  const bool cluster = line.text("placement") == "cluster";
  line.requireUse(cluster, {"centre", "radius"}, "it goes with --placement cluster; give that too, or leave it out");
  line.requireUse(!cluster, {"box"}, "it is for --placement box, and the roots are placed in a cluster; leave it out");
  // Read by the rules of 'fractal'.
  const vdbtools::OptionTable table(vdbtools::randomRootsOptions());
  vdbtools::Recipe recipe;
  for (const std::string& option : table.names()) {
    const std::string name = option.substr(kPrefix.size());
    if (!line.has(name)) continue;
    recipe[option] = line.text(name);
  }
  std::string note = "juliavdb versor new";
  for (const auto& [option, value] : recipe)
    note += " --" + option.substr(kPrefix.size()) + (value == "true" ? "" : " " + value);
  julia::RandomRootsOptions options = vdbtools::parseRandomRoots(vdbtools::RecipeReader(recipe, table));
  if (line.has("box")) {
    // Not parseBox(): roots may be placed on a plane or a line.
    const std::vector<double> b = vdbtools::parseNumbers("box", line.text("box"), 6);
    options.boxMin = {b[0], b[1], b[2]};
    options.boxMax = {b[3], b[4], b[5]};
    note += " --box " + line.text("box");
  }
  return {{0, julia::randomPolynomial(options), {}}, note, {}};
}

}  // namespace

int runVersor(const Arguments& arguments) {
  CommandLine line(kVersorUsage, vdbtools::OptionTable());
  line.addPositional("words", -1, "what to do, and with which files");
  line.addOptions(versorOptionSpecs());
  if (!line.parse(arguments)) return kDone;
  const std::vector<std::string> words = line.texts("words");
  const std::string action = words.empty() ? "" : words.front();
  const auto expect = [&](std::size_t count, const char* what) {
    if (words.size() != count + 1)
      throw std::invalid_argument("'versor " + action + "' takes " + what + "; see 'juliavdb versor --help'");
  };
  if (std::find(kActions.begin(), kActions.end(), action) != kActions.end()) requireAction(line, action);
  if (action == "list") {
    expect(0, "no file");
    list(line.has("json"));
  } else if (action == "new") {
    expect(0, "no file but -o");
    if (line.has("texture")) {
      writeTexture(line);
    } else {
      const vdbtools::RationalFile made = newVersor(line);
      write(line, made.rational, made.note);
    }
  } else if (action == "inspect") {
    expect(1, "one file");
    std::visit([](const auto& file) { inspect(file); }, vdbtools::readVersorFile(words[1]));
  } else if (action == "add") {
    expect(2, "two files");
    write(line, julia::product(vdbtools::readRational(words[1]), vdbtools::readRational(words[2])), "");
  } else if (action == "scale") {
    expect(2, "a file and a factor");
    const double factor = vdbtools::parseNumber("scale", words[2]);
    const vdbtools::RationalFile file = vdbtools::readRationalFile(words[1]);
    write(line, julia::scaled(file.rational, factor), "", file.target);
  } else if (action == "translate") {
    expect(2, "a file and X,Y,Z or X,Y,Z,S");
    const bool four = std::count(words[2].begin(), words[2].end(), ',') == 3;
    const std::vector<double> by = vdbtools::parseNumbers("translate", words[2], four ? 4 : 3);
    const vdbtools::RationalFile file = vdbtools::readRationalFile(words[1]);
    write(line, julia::translated(file.rational, {by[0], by[1], by[2], four ? by[3] : 0}), "", file.target);
  } else {
    const std::string use = "; use list, new, inspect, add, scale or translate";
    if (action.empty()) throw std::invalid_argument("no action was given" + use);
    throw std::invalid_argument("'" + action + "' is unknown" + use + vdbtools::didYouMean(action, kActions));
  }
  return kDone;
}

}  // namespace cli
