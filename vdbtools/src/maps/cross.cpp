// SPDX-License-Identifier: Apache-2.0
// The cross-product maps of R^3 of [ZB25].
#include "maps/built_in_maps.h"
#include "recipe/option_rows.h"
#include "vdbtools/maps/map_options.h"

#include "julia/cross_map.h"
#include "julia/mandelbulb.h"

#include <stdexcept>

namespace vdbtools {
namespace {

using julia::CrossPair, julia::CrossScheme;

class CrossInstance final : public MapInstance {
 public:
  CrossInstance(const julia::CrossOptions& options, const julia::Embedding& embedding)
      : mOptions(options), mEmbedding(embedding) {}

  std::unique_ptr<julia::FieldEvaluator> evaluator(Arithmetic arithmetic,
                                                   const julia::OrbitOptions& orbit) const override {
    return makeEvaluator(arithmetic, mEmbedding, orbit,
                         [this]<class Real>() -> std::shared_ptr<const julia::CartesianMap<Real>> {
                           return std::make_shared<julia::CrossMap<Real>>(mOptions);
                         });
  }

 private:
  julia::CrossOptions mOptions;
  julia::Embedding mEmbedding;
};

class CrossSettings final : public MapSettings {
 public:
  CrossSettings(const julia::OrbitOptions& orbit, const julia::Embedding& embedding, const julia::CrossOptions& options)
      : MapSettings(orbit, embedding), mOptions(options) {}

  std::optional<double> radius() const override {
    // |f x g| = |p|^2 for these pairs.
    const CrossPair pair = mOptions.pair;
    const bool squares = pair == CrossPair::A || pair == CrossPair::APrime || pair == CrossPair::D;
    if (!squares || mOptions.scheme == CrossScheme::FixedFactor) return orbit().escapeRadius;
    julia::MandelbulbOptions square{.power = 2};
    if (mOptions.scheme == CrossScheme::Julia) square.constant = mOptions.constant;
    return julia::triplexBound(square, orbit().maxIterations, orbit().escapeRadius);
  }

  /// Irrational numbers, so that no node of the lattice lies on the planes of symmetry. On such a plane, A and A' are
  /// not defined, which counts as outside (cross_map.h), and other pairs have sheets of the set. Neither has a volume,
  /// and a ray meets either only by chance, but whole planes of nodes would show a cut or a disc.
  openvdb::Vec3d latticeShift() const override { return {0.6180339887498949, 0.4142135623730951, 0.2360679774997897}; }

  std::shared_ptr<const MapInstance> instance(const MapContext&) const override {
    return std::make_shared<CrossInstance>(mOptions, embedding());
  }

 private:
  julia::CrossOptions mOptions;
};

const OptionRows<julia::CrossOptions>& crossRows() {
  using julia::CrossOptions;
  static const OptionRows<CrossOptions> rows{
      {{.name = "scheme",
        .help =
            "the equation of Zimmermann and Bruckner (2025): 3 is p x g(c), 4 is f(p) x g(p) + c, and 5 is the same "
            "with a fixed c",
        .qualifies = {"c"}},
       choice<CrossScheme>(
           &CrossOptions::scheme,
           {{"3", CrossScheme::FixedFactor}, {"4", CrossScheme::Mandelbrot}, {"5", CrossScheme::Julia}})},
      {{.name = "pair",
        .help = "the functions f and g, from the paper or your own",
        .defaultFor = [](const Recipe& recipe) { return recipe.contains("f") || recipe.contains("g") ? "user" : "A"; },
        .defaultNote = "A, or user if --f is given",
        .displaces = {"f", "g"}},
       choice<CrossPair>(&CrossOptions::pair, {{"A", CrossPair::A},
                                               {"A'", CrossPair::APrime},
                                               {"B", CrossPair::B},
                                               {"C", CrossPair::C},
                                               {"D", CrossPair::D},
                                               {"E", CrossPair::E},
                                               {"user", CrossPair::User}})},
      {{.name = "f",
        .argument = "X,Y,Z",
        .help = "the first function of your own pair, such as \"x*x, y*y, z*z\"",
        .displaces = {"pair"}},
       withoutDefault(text(&CrossOptions::f))},
      {{.name = "g",
        .argument = "X,Y,Z",
        .help = "the second function of your own pair, such as \"cos(x), cos(y), cos(z)\"",
        .displaces = {"pair"}},
       withoutDefault(text(&CrossOptions::g))},
      {{.name = "c",
        .argument = "X,Y,Z",
        .help = "the constant of scheme 5, three numbers",
        .defaultFor = [](const Recipe& recipe) -> std::optional<std::string> {
          const auto scheme = recipe.find("scheme");
          if (scheme == recipe.end() || scheme->second != "5") return std::nullopt;
          return "-1,0,0";
        },
        .defaultNote = "-1,0,0",
        .followsSelector = true},
       vector(&CrossOptions::constant)}};
  return rows;
}

julia::CrossOptions parseCross(const RecipeReader& reader) {
  julia::CrossOptions options = crossRows().read(reader);
  for (const char* function : {"f", "g"}) {
    if (options.pair == CrossPair::User && !reader.has(function))
      throw std::invalid_argument(std::string("--pair user needs --") + function +
                                  ", three expressions with commas between them, such as \"x*x, y*y, z*z\"");
    if (options.pair != CrossPair::User && reader.has(function))
      throw std::invalid_argument(std::string("--") + function + " applies to --pair user only, and the pair is " +
                                  reader.text("pair") + "; give one of the two");
  }
  if (options.scheme != CrossScheme::Julia && reader.has("c"))
    throw std::invalid_argument("--c applies to --scheme 5 only; in scheme " + reader.text("scheme") +
                                " the constant is the point itself");
  return options;
}

class CrossDescriptor final : public MapDescriptor {
 public:
  std::string name() const override { return "cross"; }
  std::string summary() const override { return "f(p) x g(p) + c on R^3, the cross-product maps of [ZB25]"; }
  std::string proofs() const override {
    return "Ball arithmetic proves blocks, except for a user's own pair, and for A and A' in scheme 3 after its first "
           "step.";
  }
  TargetUse targetUse() const override { return TargetUse::None; }
  int dimension() const override { return 3; }

  std::vector<OptionSpec> options() const override {
    std::vector<OptionSpec> options = crossRows().specs();
    options.push_back(iterationsOption("10"));
    options.push_back(radiusOption());
    for (OptionSpec& option : embeddingOptions()) options.push_back(std::move(option));
    return options;
  }

  std::shared_ptr<const MapSettings> parse(const RecipeReader& reader) const override {
    return std::make_shared<CrossSettings>(parseOrbit(reader, "radius"), parseSpatialEmbedding(reader),
                                           parseCross(reader));
  }
};

}  // namespace

MapRegistry::Descriptor crossMap() { return std::make_shared<CrossDescriptor>(); }

}  // namespace vdbtools
