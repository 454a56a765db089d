// SPDX-License-Identifier: Apache-2.0
// The shape modulus of [SK23]: the target's exponent for the modulus, a versor for the texture.
#include "maps/built_in_maps.h"
#include "maps/placed_versor.h"
#include "vdbtools/maps/map_options.h"
#include "vdbtools/maps/versor_options.h"

#include "julia/shape_modulus.h"

#include <algorithm>
#include <utility>

namespace vdbtools {
namespace {

class ShapeModulusInstance final : public MapInstance {
 public:
  ShapeModulusInstance(const VersorSettings& settings, const julia::Embedding& embedding, const MapContext& context,
                       const VersorFunction& function)
      : mEmbedding(embedding),
        mFiles{.roots = context.files.roots},
        mTarget(*context.target),
        mSpace(context.space),
        mUnmovedSpace(context.unmovedSpace),
        mExponent(sharedField(*context.exponent)),
        mVersor(settings, embedding, context, function) {}

  std::unique_ptr<julia::FieldEvaluator> evaluator(Arithmetic arithmetic,
                                                   const julia::OrbitOptions& orbit) const override {
    return makeEvaluator(arithmetic, mEmbedding, orbit,
                         [this]<class Real>() -> std::shared_ptr<const julia::Map<Real>> {
                           return std::make_shared<julia::ShapeModulus<Real>>(
                               mExponent->get<Real>(), mVersor.field<Real>(), mEmbedding.dropped);
                         });
  }
  bool floatsServe(const julia::OrbitOptions& orbit) const override { return mVersor.floatsServe(orbit); }
  const julia::Rational* roots() const override { return mVersor.roots(); }
  std::map<std::string, std::string> metadata() const override { return mVersor.metadata(); }

  std::optional<std::uint64_t> seed() const override { return mVersor.seed(); }
  std::shared_ptr<const MapInstance> reseeded(std::uint64_t seed) const override {
    if (!mVersor.seed()) return MapInstance::reseeded(seed);
    auto other = std::make_shared<ShapeModulusInstance>(*this);
    other->mVersor.reseed(seed, {.files = mFiles, .target = &mTarget, .space = mSpace, .unmovedSpace = mUnmovedSpace});
    return other;
  }

 private:
  julia::Embedding mEmbedding;
  MapFiles mFiles;  ///< including the files that random roots need
  Target mTarget;
  FractalSpace mSpace, mUnmovedSpace;
  SharedFieldPtr mExponent;
  PlacedVersor mVersor;
};

class ShapeModulusSettings final : public MapSettings {
 public:
  ShapeModulusSettings(const julia::OrbitOptions& orbit, const julia::Embedding& embedding, ShellSettings shell,
                       VersorSettings versor, VersorFunction function)
      : MapSettings(orbit, embedding),
        mShell(std::move(shell)),
        mVersor(std::move(versor)),
        mFunction(std::move(function)) {}

  std::vector<NamedFile> files() const override {
    std::vector<NamedFile> files = filesOf(mVersor);
    for (const auto& control : mShell.controls())
      for (NamedFile& file : control->files()) files.push_back(std::move(file));
    return files;
  }
  MapFiles readFiles() const override { return vdbtools::readFiles(mVersor); }
  const ShellSettings* shell() const override { return &mShell; }
  const ControlSetting* frequency() const override {
    const ControlSetting& frequency = mVersor.under.roots.frequency;
    return frequency ? &frequency : nullptr;
  }
  std::vector<MapControl> controls() const override { return controlsOf(mVersor); }
  double interiorReach() const override {
    const auto reach = [](const VersorSource& source) { return source.isRoots() ? interiorReachOf(source.roots) : 0; };
    return std::max(reach(mVersor.under), mVersor.over ? reach(*mVersor.over) : 0);
  }

  std::shared_ptr<const MapInstance> instance(const MapContext& context) const override {
    return std::make_shared<ShapeModulusInstance>(mVersor, embedding(), context, mFunction);
  }

 private:
  ShellSettings mShell;
  VersorSettings mVersor;
  VersorFunction mFunction;
};

class ShapeModulusDescriptor final : public MapDescriptor {
 public:
  explicit ShapeModulusDescriptor(VersorFunction function) : mFunction(std::move(function)) {}

  std::string name() const override { return "shape-modulus"; }
  std::string summary() const override {
    return "the shape of a target with the texture of a versor [SK23]: f(q) = e^E p(q)/|p(q)|, E = alpha (phi - beta)";
  }
  std::string proofs() const override {
    return "Where E lies outside of the shell's interval the sign is known without an orbit. Inside it, blocks are "
           "proved by ball arithmetic over E and, with textures, whole powers and fields of directions, over the "
           "versor.";
  }
  TargetUse targetUse() const override { return TargetUse::Needed; }
  bool hasRoots() const override { return true; }

  std::vector<OptionSpec> options() const override {
    std::vector<OptionSpec> options = shellOptions();
    for (OptionSpec& option : rootsOptions()) options.push_back(std::move(option));
    options.push_back(frequencyOption());
    for (OptionSpec& option : grainOptions()) options.push_back(std::move(option));
    for (OptionSpec& option : layerOptions()) options.push_back(std::move(option));
    options.push_back(shellIterationsOption());
    options.push_back(shellEscapeOption());
    for (OptionSpec& option : embeddingOptions()) options.push_back(std::move(option));
    return options;
  }

  std::shared_ptr<const MapSettings> parse(const RecipeReader& reader) const override {
    return std::make_shared<ShapeModulusSettings>(parseOrbit(reader, "escape"), parseEmbedding(reader),
                                                  parseShell(reader), parseVersor(reader, static_cast<bool>(mFunction)),
                                                  mFunction);
  }

 private:
  VersorFunction mFunction;
};

}  // namespace

MapRegistry::Descriptor shapeModulusMap(const VersorFunction& function) {
  return std::make_shared<ShapeModulusDescriptor>(function);
}

}  // namespace vdbtools
