// SPDX-License-Identifier: Apache-2.0
// Powers of triplex numbers: Mandelbulbs and their Julia sets.
#include "maps/built_in_maps.h"
#include "recipe/option_rows.h"
#include "vdbtools/maps/map_options.h"

#include "julia/mandelbulb.h"

#include <algorithm>
#include <cmath>

namespace vdbtools {
namespace {

class MandelbulbInstance final : public MapInstance {
 public:
  MandelbulbInstance(const julia::MandelbulbOptions& options, const julia::Embedding& embedding)
      : mOptions(options), mEmbedding(embedding) {}

  std::unique_ptr<julia::FieldEvaluator> evaluator(Arithmetic arithmetic,
                                                   const julia::OrbitOptions& orbit) const override {
    return makeEvaluator(arithmetic, mEmbedding, orbit,
                         [this]<class Real>() -> std::shared_ptr<const julia::CartesianMap<Real>> {
                           return std::make_shared<julia::Mandelbulb<Real>>(mOptions);
                         });
  }

 private:
  julia::MandelbulbOptions mOptions;
  julia::Embedding mEmbedding;
};

class MandelbulbSettings final : public MapSettings {
 public:
  MandelbulbSettings(const julia::OrbitOptions& orbit, const julia::Embedding& embedding,
                     const julia::MandelbulbOptions& options)
      : MapSettings(orbit, embedding), mOptions(options) {}

  std::optional<double> radius() const override {
    return julia::triplexBound(mOptions, orbit().maxIterations, orbit().escapeRadius);
  }
  std::shared_ptr<const MapInstance> instance(const MapContext&) const override {
    return std::make_shared<MandelbulbInstance>(mOptions, embedding());
  }

 private:
  julia::MandelbulbOptions mOptions;
};

/// Three numbers, or four if the fourth is 0: a quaternion that lies in space.
julia::Point parsePoint(const RecipeReader& reader, const std::string& name) {
  const std::string text = reader.text(name);
  const bool padded = std::count(text.begin(), text.end(), ',') == 3 && parseNumbers(name, text, 4)[3] == 0;
  const openvdb::Vec3d c = parseVector(name, padded ? text.substr(0, text.rfind(',')) : text);
  return {c[0], c[1], c[2]};
}

const OptionRows<julia::MandelbulbOptions>& mandelbulbRows() {
  using julia::MandelbulbOptions, julia::TriplexAngle;
  static const OptionRows<MandelbulbOptions> rows{
      {{.name = "power", .argument = "P", .help = "the power of the triplex numbers, any real number from -100 to 100"},
       number(&MandelbulbOptions::power, within(-100, 100))},
      {{.name = "theta",
        .help = "where the second angle is 0: in the plane, as in [ZB25], or at the pole, as in the well-known set of "
                "power 8"},
       choice<TriplexAngle>(&MandelbulbOptions::angle,
                            {{"plane", TriplexAngle::AbovePlane}, {"pole", TriplexAngle::FromPole}})},
      {{.name = "c",
        .argument = "X,Y,Z",
        .help = "the constant of a Julia set, three numbers",
        .alternative = "mandelbrot",
        .followsSelector = true},
       parsed(&MandelbulbOptions::constant, parsePoint, {.kind = OptionType::Kind::Vector})}};
  return rows;
}

class MandelbulbDescriptor final : public MapDescriptor {
 public:
  std::string name() const override { return "mandelbulb"; }
  std::string summary() const override {
    return "p^n + c on R^3, powers of triplex numbers: Mandelbulbs, and Julia sets";
  }
  std::string proofs() const override { return "Blocks are proved by ball arithmetic for whole powers from 2 to 64."; }
  TargetUse targetUse() const override { return TargetUse::None; }
  int dimension() const override { return 3; }

  std::vector<OptionSpec> options() const override {
    std::vector<OptionSpec> options = mandelbulbRows().specs();
    options.push_back(mandelbrotOption(true));
    options.push_back(iterationsOption("10"));
    options.push_back(radiusOption());
    for (OptionSpec& option : embeddingOptions()) options.push_back(std::move(option));
    return options;
  }

  std::shared_ptr<const MapSettings> parse(const RecipeReader& reader) const override {
    const bool mandelbrot = parseMandelbrot(reader);
    julia::MandelbulbOptions options = mandelbulbRows().read(reader);
    if (!mandelbrot && !options.constant) options.constant = julia::Point{};
    return std::make_shared<MandelbulbSettings>(parseOrbit(reader, "radius"), parseSpatialEmbedding(reader), options);
  }
};

}  // namespace

MapRegistry::Descriptor mandelbulbMap() { return std::make_shared<MandelbulbDescriptor>(); }

}  // namespace vdbtools
