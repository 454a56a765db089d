// SPDX-License-Identifier: Apache-2.0
// The shape modulus of [SK23]: the target's exponent for the modulus, a versor for the texture.
#include "maps/built_in_maps.h"
#include "vdbtools/maps/map_options.h"

#include "julia/shape_modulus.h"

#include <mutex>

namespace vdbtools {
namespace {

/// The exponent as evaluators read it, each arithmetic's made when it is first needed.
class ExponentFields {
 public:
  explicit ExponentFields(const ExponentGrid& exponent) : mExponent(exponent) {}

  template <class Real>
  std::shared_ptr<const julia::ScalarField<Real>> get() const {
    if constexpr (std::is_same_v<Real, float>)
      return made<float>(mFloats);
    else
      return made<double>(mDoubles);
  }

 private:
  template <class Real>
  std::shared_ptr<const julia::ScalarField<Real>> made(std::shared_ptr<const julia::ScalarField<Real>>& field) const {
    const std::lock_guard lock(mMutex);
    if (!field) field = makeExponentField<Real>(mExponent);
    return field;
  }

  ExponentGrid mExponent;
  mutable std::mutex mMutex;
  mutable std::shared_ptr<const julia::ScalarField<float>> mFloats;
  mutable std::shared_ptr<const julia::ScalarField<double>> mDoubles;
};

class ShapeModulusInstance final : public MapInstance {
 public:
  ShapeModulusInstance(const RootsSettings& settings, const julia::Embedding& embedding, const MapContext& context)
      : mSettings(settings),
        mEmbedding(embedding),
        mFiles(context.files),
        mTarget(*context.target),
        mSpace(context.space),
        mUnmovedSpace(context.unmovedSpace),
        mExponent(std::make_shared<const ExponentFields>(*context.exponent)),
        mRoots(placeRoots(settings, embedding, context)) {
    if (context.octave) mOctave = *context.octave;
  }

  std::unique_ptr<julia::FieldEvaluator> evaluator(Arithmetic arithmetic,
                                                   const julia::OrbitOptions& orbit) const override {
    return makeEvaluator(
        arithmetic, mEmbedding, orbit, [this]<class Real>() -> std::shared_ptr<const julia::Map<Real>> {
          if (mOctave)
            return std::make_shared<julia::ShapeModulus<Real>>(
                mExponent->get<Real>(),
                std::make_shared<julia::WaveVersor<Real>>(wavesOf(*mSettings.texture, mSettings.random.seed, mEmbedding),
                                                          makeOctaveField<Real>(*mOctave), mEmbedding.dropped),
                mEmbedding.dropped);
          return std::make_shared<julia::ShapeModulus<Real>>(mExponent->get<Real>(), mRoots.placed, mEmbedding.dropped);
        });
  }
  bool floatsServe(const julia::OrbitOptions& orbit) const override {
    return vdbtools::floatsServe(orbit, mRoots.placed);
  }
  const julia::Rational* roots() const override { return &mRoots.placed; }
  std::map<std::string, std::string> facts() const override { return mRoots.facts(); }

  std::optional<std::uint64_t> seed() const override { return seedOf(mSettings); }
  std::shared_ptr<const MapInstance> reseeded(std::uint64_t seed) const override {
    if (!seedOf(mSettings)) return MapInstance::reseeded(seed);
    auto other = std::make_shared<ShapeModulusInstance>(*this);
    other->mSettings.random.seed = seed;
    other->mRoots = placeRoots(other->mSettings, mEmbedding,
                               {.files = mFiles, .target = &mTarget, .space = mSpace, .unmovedSpace = mUnmovedSpace});
    return other;
  }

 private:
  RootsSettings mSettings;
  julia::Embedding mEmbedding;
  MapFiles mFiles;
  Target mTarget;
  FractalSpace mSpace, mUnmovedSpace;
  std::shared_ptr<const ExponentFields> mExponent;
  PlacedRoots mRoots;
  std::optional<OctaveGrid> mOctave;
};

class ShapeModulusSettings final : public MapSettings {
 public:
  ShapeModulusSettings(const julia::OrbitOptions& orbit, const julia::Embedding& embedding, ShellSettings shell,
                       RootsSettings roots)
      : MapSettings(orbit, embedding), mShell(std::move(shell)), mRoots(std::move(roots)) {}

  std::vector<NamedFile> files() const override {
    std::vector<NamedFile> files;
    if (mRoots.file) files.push_back(*mRoots.file);
    for (const auto& control : mShell.controls())
      for (NamedFile& file : control->files()) files.push_back(std::move(file));
    return files;
  }
  MapFiles readFiles() const override { return {.roots = readRoots(mRoots)}; }
  const ShellSettings* shell() const override { return &mShell; }
  const ControlSetting* frequency() const override { return mRoots.frequency ? &mRoots.frequency : nullptr; }
  double interiorReach() const override { return interiorReachOf(mRoots); }

  std::shared_ptr<const MapInstance> instance(const MapContext& context) const override {
    return std::make_shared<ShapeModulusInstance>(mRoots, embedding(), context);
  }

 private:
  ShellSettings mShell;
  RootsSettings mRoots;
};

class ShapeModulusDescriptor final : public MapDescriptor {
 public:
  std::string name() const override { return "shape-modulus"; }
  std::string summary() const override {
    return "the shape of a target with the texture of a versor [SK23]: f(q) = e^E p(q)/|p(q)|, E = alpha (phi - beta)";
  }
  std::string proofs() const override {
    return "Where E lies outside of the shell's interval the sign is known without an orbit. Inside it, blocks are "
           "proved by ball arithmetic over E and, with whole powers, over the versor.";
  }
  TargetUse targetUse() const override { return TargetUse::Needed; }
  bool hasRoots() const override { return true; }

  std::vector<OptionSpec> options() const override {
    std::vector<OptionSpec> options = shellOptions();
    for (OptionSpec& option : rootsOptions()) options.push_back(std::move(option));
    options.push_back(iterationsOption("3"));
    options.push_back(shellEscapeOption());
    for (OptionSpec& option : embeddingOptions()) options.push_back(std::move(option));
    return options;
  }

  std::shared_ptr<const MapSettings> parse(const RecipeReader& reader) const override {
    return std::make_shared<ShapeModulusSettings>(parseOrbit(reader, "escape"), parseEmbedding(reader),
                                                  parseShell(reader), parseRoots(reader, "versor"));
  }
};

}  // namespace

MapRegistry::Descriptor shapeModulusMap() { return std::make_shared<ShapeModulusDescriptor>(); }

}  // namespace vdbtools
