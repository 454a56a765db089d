// SPDX-License-Identifier: Apache-2.0
// The shape modulus of [SK23]: the target's exponent for the modulus, a versor for the texture.
#include "maps/built_in_maps.h"
#include "vdbtools/maps/map_options.h"

#include "julia/shape_modulus.h"
#include "julia/wave_versor.h"

#include <mutex>

namespace vdbtools {
namespace {

/// A grid as evaluators read it, each arithmetic's field made when it is first needed.
template <class Grid>
class Fields {
 public:
  explicit Fields(const Grid& grid) : mGrid(grid) {}

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
    if (!field) field = makeField<Real>(mGrid);
    return field;
  }
  template <class Real>
  static auto makeField(const ExponentGrid& grid) {
    return makeExponentField<Real>(grid);
  }
  template <class Real>
  static auto makeField(const OctaveGrid& grid) {
    return makeOctaveField<Real>(grid);
  }

  Grid mGrid;
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
        mExponent(std::make_shared<const Fields<ExponentGrid>>(*context.exponent)),
        mOctave(context.octave ? std::make_shared<const Fields<OctaveGrid>>(*context.octave) : nullptr),
        mRoots(placeRoots(settings, embedding, context)) {}

  std::unique_ptr<julia::FieldEvaluator> evaluator(Arithmetic arithmetic,
                                                   const julia::OrbitOptions& orbit) const override {
    return makeEvaluator(
        arithmetic, mEmbedding, orbit, [this]<class Real>() -> std::shared_ptr<const julia::Map<Real>> {
          const auto exponent = mExponent->get<Real>();
          if (!mOctave) return std::make_shared<julia::ShapeModulus<Real>>(exponent, mRoots.placed, mEmbedding.dropped);
          auto waves = std::make_shared<julia::WaveVersor<Real>>(placeWaves(mSettings, mEmbedding),
                                                                 mOctave->get<Real>(), mEmbedding.dropped);
          return std::make_shared<julia::ShapeModulus<Real>>(exponent, std::move(waves), mEmbedding.dropped);
        });
  }
  bool floatsServe(const julia::OrbitOptions& orbit) const override {
    return mOctave ? floatsServeWaves(orbit) : floatsServeVersor(orbit, mRoots.placed);
  }
  const julia::Rational* roots() const override { return mOctave ? nullptr : &mRoots.placed; }
  std::map<std::string, std::string> facts() const override {
    return mOctave ? std::map<std::string, std::string>() : mRoots.facts();
  }

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
  std::shared_ptr<const Fields<ExponentGrid>> mExponent;
  std::shared_ptr<const Fields<OctaveGrid>> mOctave;  ///< of a texture that follows the thickness; else nullptr
  PlacedRoots mRoots;                                 ///< of the others
};

class ShapeModulusSettings final : public MapSettings {
 public:
  ShapeModulusSettings(const julia::OrbitOptions& orbit, const julia::Embedding& embedding, ShellSettings shell,
                       RootsSettings roots)
      : MapSettings(orbit, embedding), mShell(std::move(shell)), mRoots(std::move(roots)) {}

  std::vector<NamedFile> files() const override {
    std::vector<NamedFile> files;
    if (mRoots.file) files.push_back(*mRoots.file);
    std::vector<ControlSetting> controls = mShell.controls();
    if (mRoots.frequency) controls.push_back(mRoots.frequency);
    for (const auto& control : controls)
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
    options.push_back(frequencyOption());
    options.push_back(shellIterationsOption());
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
