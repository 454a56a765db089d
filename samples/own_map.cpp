// SPDX-License-Identifier: Apache-2.0
// A map of one's own with an option of its own, q^P + c, through the same job as the built-in maps: text -> options ->
// scene -> VDB and mesh. Nothing but this file knows of it.
#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/job/fractal_job.h"
#include "vdbtools/maps/map_options.h"
#include "vdbtools/mesh_files/mesh_writer.h"
#include "vdbtools/records/recorded_recipe.h"

#include "julia/cartesian_map.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iostream>

namespace {

using namespace vdbtools;
using Quaternion = julia::Quaternion<double>;

/// The arithmetic: how an iterate makes the next.
template <class Real>
class PowerMap final : public julia::CartesianMap<Real> {
 public:
  PowerMap(int power, const Quaternion& c) : mPower(power), mC(c.as<Real>()) {}

  int dimension() const override { return 4; }
  void begin(const julia::QuaternionBatch<Real>& start, julia::QuaternionBatch<Real>& carried,
             julia::QuaternionBatch<Real>& next) const override {
    step(start, carried, next);
  }
  void step(const julia::QuaternionBatch<Real>& q, const julia::QuaternionBatch<Real>&,
            julia::QuaternionBatch<Real>& next) const override {
    next.resize(q.size());
    for (std::size_t i = 0; i < q.size(); ++i) {
      julia::Quaternion<Real> value = q.get(i);
      for (int k = 1; k < mPower; ++k) value = value * q.get(i);
      next.set(i, value + mC);
    }
  }

 private:
  int mPower;
  julia::Quaternion<Real> mC;
};

/// The map in a scene: makes the evaluators.
class PowerInstance final : public MapInstance {
 public:
  PowerInstance(int power, const Quaternion& c, const julia::Embedding& embedding)
      : mPower(power), mC(c), mEmbedding(embedding) {}

  std::unique_ptr<julia::FieldEvaluator> evaluator(Arithmetic arithmetic,
                                                   const julia::OrbitOptions& orbit) const override {
    return makeEvaluator(arithmetic, mEmbedding, orbit,
                         [this]<class Real>() -> std::shared_ptr<const julia::CartesianMap<Real>> {
                           return std::make_shared<PowerMap<Real>>(mPower, mC);
                         });
  }

 private:
  int mPower;
  Quaternion mC;
  julia::Embedding mEmbedding;
};

/// What a recipe says of it.
class PowerSettings final : public MapSettings {
 public:
  PowerSettings(const julia::OrbitOptions& orbit, const julia::Embedding& embedding, int power, const Quaternion& c)
      : MapSettings(orbit, embedding), mPower(power), mC(c) {}

  /// |q^P + c| >= |q|^P - |c|, run backwards from the escape radius: beyond, every orbit escapes.
  std::optional<double> radius() const override {
    double radius = orbit().escapeRadius;
    for (int i = 0; i < orbit().maxIterations; ++i)
      radius = std::min(radius, std::pow(radius + std::sqrt(julia::normSquared(mC)), 1.0 / mPower));
    return radius;
  }
  std::shared_ptr<const MapInstance> instance(const MapContext&) const override {
    return std::make_shared<PowerInstance>(mPower, mC, embedding());
  }

 private:
  int mPower;
  Quaternion mC;
};

/// What the map is.
class PowerDescriptor final : public MapDescriptor {
 public:
  std::string name() const override { return "power"; }
  std::string summary() const override { return "q^P + c on the quaternions"; }
  std::string proofs() const override { return "Nothing is proved: every node is evaluated."; }
  TargetUse targetUse() const override { return TargetUse::None; }
  std::vector<OptionSpec> options() const override {
    std::vector<OptionSpec> options = embeddingOptions();
    options.push_back(
        {.name = "exponent", .argument = "P", .defaultValue = "3", .help = "the power, a whole number from 2 to 16"});
    options.push_back({.name = "c",
                       .argument = "A,B,C,D",
                       .defaultValue = "-0.2,0.6,0.1,0.1",
                       .help = "the constant",
                       .followsSelector = true});
    options.push_back(iterationsOption("8"));
    options.push_back(escapeOption());
    return options;
  }
  std::shared_ptr<const MapSettings> parse(const RecipeReader& reader) const override {
    const std::vector<double> c = parseNumbers("c", reader.text("c"), 4);
    return std::make_shared<PowerSettings>(parseOrbit(reader, "escape"), parseEmbedding(reader),
                                           reader.integer("exponent", 2, 16), Quaternion{c[0], c[1], c[2], c[3]});
  }
};

struct Made {
  std::string vdb;
  Mesh mesh;
};

/// The job, as 'juliavdb fractal' does it.
Made make(const Recipe& recipe, const MapRegistry& maps) {
  Monitor monitor;
  const Scene scene = makeScene(parseFractalOptions(recipe, maps), monitor);
  Made made;
  MeshCollector collector(made.mesh);
  const FractalPlan plan = planFractal(scene, {.grids = true, .mesh = true});
  const FractalResult result = runFractal(scene, plan, &collector, monitor);
  made.vdb = encodeVdb(result.grids, {.metadata = sceneMetadata(scene, recipe)});
  return made;
}

}  // namespace

/// @param argv  the folder for own_map.vdb and own_map.ply; by default the current one
int main(int argc, char** argv) {
  const std::filesystem::path folder = argc > 1 ? argv[1] : ".";
  MapRegistry maps = builtInMaps();
  maps.add(std::make_shared<PowerDescriptor>());

  const Recipe recipe =
      completeRecipe({{"map", "power"}, {"exponent", "4"}, {"resolution", "60"}}, fractalOptionTable(maps));
  const Made made = make(recipe, maps);
  std::ofstream(folder / "own_map.vdb", std::ios::binary) << made.vdb;
  std::ofstream ply(folder / "own_map.ply", std::ios::binary);
  writeMesh(ply, made.mesh, {});
  std::cout << made.mesh.triangles.size() << " triangles\n";

  // The file says how to make it again.
  const RecordedRecipe recorded = readRecordedRecipe(folder / "own_map.vdb", maps);
  const bool again = recorded.recipe == recipe && make(recorded.recipe, maps).vdb == made.vdb;
  std::cout << (again ? "and the same again from its recipe\n" : "but its recipe makes something else\n");
  return again && !made.mesh.triangles.empty() ? 0 : 1;
}
