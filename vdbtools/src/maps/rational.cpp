// SPDX-License-Identifier: Apache-2.0
// The rational map of [Kim15], from a file that 'juliavdb fit' made or from random roots.
#include "maps/built_in_maps.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/formats/peer_formats.h"
#include "vdbtools/maps/map_options.h"

#include "julia/rational_map.h"

#include <stdexcept>

namespace vdbtools {
namespace {

/// The cube in which the shape of an `.o3d` was fitted.
std::optional<openvdb::BBoxd> regionOf(const std::filesystem::path& path) {
  if (lowerExtension(path) != ".o3d") return std::nullopt;
  const OptimisedShape shape = readOptimisedShape(path);
  openvdb::Vec3d low, high;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    low[static_cast<int>(axis)] = shape.centre[axis] - shape.lengths[axis] / 2;
    high[static_cast<int>(axis)] = shape.centre[axis] + shape.lengths[axis] / 2;
  }
  return openvdb::BBoxd(low, high);
}

class RationalInstance final : public MapInstance {
 public:
  RationalInstance(PlacedRoots roots, const julia::Embedding& embedding)
      : mRoots(std::move(roots)), mEmbedding(embedding) {}

  std::unique_ptr<julia::FieldEvaluator> evaluator(Arithmetic arithmetic,
                                                   const julia::OrbitOptions& orbit) const override {
    return makeEvaluator(arithmetic, mEmbedding, orbit,
                         [this]<class Real>() -> std::shared_ptr<const julia::Map<Real>> {
                           return std::make_shared<julia::RationalMap<Real>>(mRoots.placed);
                         });
  }
  bool floatsServe(const julia::OrbitOptions& orbit) const override {
    return vdbtools::floatsServe(orbit, mRoots.placed);
  }
  const julia::Rational* roots() const override { return &mRoots.placed; }
  std::map<std::string, std::string> metadata() const override { return mRoots.metadata(); }

 private:
  PlacedRoots mRoots;
  julia::Embedding mEmbedding;
};

class RationalSettings final : public MapSettings {
 public:
  RationalSettings(const julia::OrbitOptions& orbit, const julia::Embedding& embedding, RootsSettings roots)
      : MapSettings(orbit, embedding), mRoots(std::move(roots)) {}

  std::vector<NamedFile> files() const override {
    return mRoots.file ? std::vector<NamedFile>{*mRoots.file} : std::vector<NamedFile>{};
  }
  MapFiles readFiles() const override {
    MapFiles files{.roots = readRoots(mRoots)};
    if (mRoots.file) files.region = regionOf(mRoots.file->path);
    return files;
  }
  double interiorReach() const override { return interiorReachOf(mRoots); }
  std::shared_ptr<const MapInstance> instance(const MapContext& context) const override {
    return std::make_shared<RationalInstance>(placeRoots(mRoots, context.files.roots, embedding(), context),
                                              embedding());
  }

 private:
  RootsSettings mRoots;
};

class RationalDescriptor final : public MapDescriptor {
 public:
  std::string name() const override { return "rational"; }
  std::string summary() const override {
    return "the rational map of [Kim15], e^C prod (q - t)^T / prod (q - b)^B, which 'juliavdb fit' finds for a shape";
  }
  std::string proofs() const override {
    return "Blocks are proved by ball arithmetic over the roots, and with whole powers over the map's values.";
  }
  TargetUse targetUse() const override { return TargetUse::Optional; }
  bool hasRoots() const override { return true; }

  std::vector<OptionSpec> options() const override {
    std::vector<OptionSpec> options = rootsOptions();
    options.insert(
        options.begin() + 1,
        {.name = "rational",
         .argument = "FILE",
         .defaultValue = "",
         .help = "the rational map: a .json made by 'juliavdb fit', or an .o3d",
         .alternative = "texture",
         .hash = "texture-sha256",
         .kept = true,
         .check = [](const std::string& file) {
           if (!file.empty())
             throw std::invalid_argument("--rational gives the roots of a rational map; use it with --map rational");
         }});
    options.push_back(iterationsOption("3"));
    options.push_back(escapeOption());
    for (OptionSpec& option : embeddingOptions()) options.push_back(std::move(option));
    return options;
  }

  std::shared_ptr<const MapSettings> parse(const RecipeReader& reader) const override {
    const std::string rational = reader.text("rational");
    if (!rational.empty() && reader.has("texture") && reader.text("texture") != "random")
      throw std::invalid_argument("--rational and --texture both give the roots of the map; give only one of them");
    if (rational == "random") reader.refuse("rational", "a file; --texture random draws roots");
    return std::make_shared<RationalSettings>(parseOrbit(reader, "escape"), parseEmbedding(reader),
                                              parseRoots(reader, rational.empty() ? "texture" : "rational"));
  }
};

}  // namespace

MapRegistry::Descriptor rationalMap() { return std::make_shared<RationalDescriptor>(); }

}  // namespace vdbtools
