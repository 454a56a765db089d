// SPDX-License-Identifier: Apache-2.0
// q^2 + c: the quaternion Julia sets, and their Mandelbrot set.
//
// The two use different interfaces. The Mandelbrot set carries the c of each orbit from step to step, which only
// CartesianMap can do. The Julia set goes through the log-polar form of Map: its iterates are e^l u, which are rounded
// differently from q^2 + c. Changing its interface would change results that recipes promise byte for byte, and
// docs/precision.md has measured 32-bit floats for this form.
#include "maps/built_in_maps.h"
#include "vdbtools/maps/map_options.h"

#include "julia/mandelbulb.h"
#include "julia/quadratic_map.h"

namespace vdbtools {
namespace {

using Quaternion = julia::Quaternion<double>;

class JuliaInstance final : public MapInstance {
 public:
  JuliaInstance(const Quaternion& c, const julia::Embedding& embedding) : mC(c), mEmbedding(embedding) {}

  std::unique_ptr<julia::FieldEvaluator> evaluator(Arithmetic arithmetic,
                                                   const julia::OrbitOptions& orbit) const override {
    return makeEvaluator(arithmetic, mEmbedding, orbit,
                         [this]<class Real>() -> std::shared_ptr<const julia::Map<Real>> {
                           return std::make_shared<julia::QuadraticMap<Real>>(mC);
                         });
  }
  bool floatsServe(const julia::OrbitOptions& orbit) const override { return vdbtools::floatsServe(orbit, {}); }

 private:
  Quaternion mC;
  julia::Embedding mEmbedding;
};

class MandelbrotInstance final : public MapInstance {
 public:
  explicit MandelbrotInstance(const julia::Embedding& embedding) : mEmbedding(embedding) {}

  std::unique_ptr<julia::FieldEvaluator> evaluator(Arithmetic arithmetic,
                                                   const julia::OrbitOptions& orbit) const override {
    return makeEvaluator(arithmetic, mEmbedding, orbit,
                         []<class Real>() -> std::shared_ptr<const julia::CartesianMap<Real>> {
                           return std::make_shared<julia::QuadraticMandelbrot<Real>>();
                         });
  }

 private:
  julia::Embedding mEmbedding;
};

class QuadraticSettings final : public MapSettings {
 public:
  /// @param c  empty: the starting point itself
  QuadraticSettings(const julia::OrbitOptions& orbit, const julia::Embedding& embedding,
                    const std::optional<Quaternion>& c)
      : MapSettings(orbit, embedding), mC(c) {}

  std::optional<double> radius() const override {
    if (mC) return julia::quadraticBound(*mC, orbit().maxIterations, orbit().escapeRadius);
    return julia::triplexBound({.power = 2}, orbit().maxIterations, orbit().escapeRadius);
  }
  std::shared_ptr<const MapInstance> instance(const MapContext&) const override {
    if (mC) return std::make_shared<JuliaInstance>(*mC, embedding());
    return std::make_shared<MandelbrotInstance>(embedding());
  }

 private:
  std::optional<Quaternion> mC;
};

Quaternion parseConstant(const std::string& text) {
  const std::vector<double> c = parseNumbers("c", text, 4);
  return {c[0], c[1], c[2], c[3]};
}

class QuadraticDescriptor final : public MapDescriptor {
 public:
  std::string name() const override { return "quadratic"; }
  std::string summary() const override { return "q^2 + c on the quaternions: Julia sets, and the Mandelbrot set"; }
  std::string proofs() const override { return "Blocks are proved by ball arithmetic."; }
  TargetUse targetUse() const override { return TargetUse::Optional; }

  std::vector<OptionSpec> options() const override {
    OptionSpec iterations = iterationsOption("3");
    iterations.defaultFor = [](const Recipe& recipe) {
      const auto mandelbrot = recipe.find("mandelbrot");
      return mandelbrot != recipe.end() && mandelbrot->second != "false" ? "10" : "3";
    };
    iterations.defaultNote = "3, or 10 with --mandelbrot";
    std::vector<OptionSpec> options{
        {.name = "c",
         .argument = "A,B,C[,D]",
         .defaultValue = "0,0,0,0",
         .help = "the constant of a Julia set, four numbers",
         .alternative = "mandelbrot",
         .followsSelector = true,
         .kept = true,
         .check = [](const std::string& text) { parseConstant(text); }},
        mandelbrotOption(false),
        iterations,
        escapeOption(),
    };
    for (OptionSpec& option : embeddingOptions()) options.push_back(std::move(option));
    return options;
  }

  std::shared_ptr<const MapSettings> parse(const RecipeReader& reader) const override {
    std::optional<Quaternion> c;
    if (!parseMandelbrot(reader)) c = reader.has("c") ? parseConstant(reader.text("c")) : Quaternion{};
    return std::make_shared<QuadraticSettings>(parseOrbit(reader, "escape"), parseEmbedding(reader), c);
  }
};

}  // namespace

MapRegistry::Descriptor quadraticMap() { return std::make_shared<QuadraticDescriptor>(); }

}  // namespace vdbtools
