// SPDX-License-Identifier: Apache-2.0
#include "made.h"

#include "patient_lock.h"

#include "vdbtools/base/text.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/files/output_files.h"
#include "vdbtools/job/fractal_job.h"
#include "vdbtools/recipe/option_value.h"
#include "vdbtools/records/recorded_recipe.h"
#include "vdbtools/render/view_options.h"
#include "vdbtools/scene/scene.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

using vdbtools::Monitor;
using vdbtools::Recipe;

NamedOptions namedOptions(const Recipe& given, MemoryTarget target, const OwnFunctions& functions) {
  vdbtools::MapRegistry maps = vdbtools::builtInMaps(functions.versor);
  if (functions.map) maps.add(functionMap(functions.map));
  NamedOptions named{given, {}};
  if (target.mesh) named.recipe["input"] = kMemory;
  if (target.rest) named.recipe["rest"] = kMemory;
  named.recipe = vdbtools::completeRecipe(std::move(named.recipe), vdbtools::fractalOptionTable(maps));
  named.options = vdbtools::parseFractalOptions(named.recipe, maps);
  if (target.mesh) named.options.target.value().mesh = std::move(target.mesh);
  if (target.rest) named.options.rest.value().mesh = std::move(target.rest);
  return named;
}

std::shared_ptr<MadeScene> makeNamedScene(const Recipe& given, MemoryTarget target, const OwnFunctions& functions,
                                          Monitor& monitor) {
  auto made = std::make_shared<MadeScene>();
  NamedOptions named = namedOptions(given, std::move(target), functions);
  made->recipe = std::move(named.recipe);
  made->options = std::move(named.options);
  made->inputs = vdbtools::inputsOf(made->options);
  made->scene = made->scenes.make(made->options, monitor);
  return made;
}

vdbtools::OptionTable viewTable() {
  std::vector<vdbtools::OptionSpec> options = vdbtools::pictureOptionSpecs("800x800", true);
  options.push_back(vdbtools::colourOptionSpec());
  return vdbtools::OptionTable(std::move(options));
}

namespace {

const vdbtools::Scene& pictureScene(const MadeScene& made, Monitor& monitor) {
  const vdbtools::FractalOptions options = vdbtools::forPictures(made.options);
  if (!options.picture) return made.scene;
  const auto lock = lockPatiently(made.pictureMutex, monitor);
  if (!made.pictureScene) made.pictureScene = made.scenes.make(options, monitor);
  return *made.pictureScene;
}

/// @throw std::invalid_argument
vdbtools::FieldPicture parseView(const Recipe& view) {
  vdbtools::FieldPicture picture = vdbtools::parseFieldPicture(view, viewTable());
  if (picture.render.look.backdrop == vdbtools::Backdrop::None)
    throw std::invalid_argument("--background is none, and the array has no alpha; give a colour, or leave it out");
  return picture;
}

}  // namespace

void checkView(const Recipe& view) { parseView(view); }

vdbtools::Image pictureOf(const MadeScene& made, const Recipe& view, Monitor& monitor) {
  const vdbtools::FieldPicture picture = parseView(view);
  const vdbtools::Scene& scene = pictureScene(made, monitor);
  const openvdb::BBoxd region = vdbtools::pictureRegion(scene);
  const vdbtools::FieldRenderOptions options = vdbtools::pictureOptions(scene, region, picture);
  return vdbtools::renderField(scene.source(), region, options, monitor).beauty;
}

std::shared_ptr<MadeFractal> makeFractal(std::shared_ptr<const MadeScene> made, bool wantGrids, Monitor& monitor) {
  auto fractal = std::make_shared<MadeFractal>();
  fractal->made = std::move(made);
  const vdbtools::Scene& scene = fractal->made->scene;
  vdbtools::requireMemoryForMesh(scene);
  vdbtools::MeshCollector collector(fractal->mesh, &fractal->values);
  fractal->result = vdbtools::runFractal(scene, vdbtools::planFractal(scene, {.grids = wantGrids, .mesh = true}),
                                         &collector, monitor);
  if (wantGrids) fractal->grids = std::make_shared<vdbtools::FractalResult>(fractal->result);
  return fractal;
}

namespace {

/// The grids that files contain besides the mesh. @throw vdbtools::Interrupted
std::shared_ptr<const vdbtools::FractalResult> withGrids(MadeFractal& fractal, Monitor& monitor) {
  const auto lock = lockPatiently(fractal.gridsMutex, monitor);
  if (!fractal.grids) {
    const vdbtools::Scene& scene = fractal.made->scene;
    vdbtools::FractalResult made =
        vdbtools::runFractal(scene, vdbtools::planFractal(scene, {.grids = true}), nullptr, monitor);
    auto all = std::make_shared<vdbtools::FractalResult>(fractal.result);
    all->grids = std::move(made.grids);
    all->check = std::move(made.check);
    fractal.grids = std::move(all);
  }
  return fractal.grids;
}

}  // namespace

std::vector<std::string> writeFiles(MadeFractal& fractal, const std::vector<std::string>& paths, Monitor& monitor) {
  for (const std::string& path : paths) {
    const vdbtools::FileFormat* const format = vdbtools::findFormat(path);
    if (!format || !(format->writesGrids || format->writesMesh))
      throw std::invalid_argument("the file to write is '" + path + "'; its extension must be one of " +
                                  vdbtools::extensionsOf(&vdbtools::FileFormat::writesGrids) + " for grids, " +
                                  vdbtools::extensionsOf(&vdbtools::FileFormat::writesMesh) + " for the mesh");
    vdbtools::requireBuilt(*format);
  }
  vdbtools::OutputFiles files(vdbtools::withRecordedFiles(fractal.made->inputs));
  vdbtools::FractalFiles wanted;
  for (const std::string& path : paths) {
    wanted.files.push_back({&files.add(path), vdbtools::findFormat(path)});
  }
  const std::shared_ptr<const vdbtools::FractalResult> grids =
      wanted.wantGrids() ? withGrids(fractal, monitor) : nullptr;
  const std::vector<vdbtools::ClampedGrid> clamped =
      vdbtools::writeMadeFractal(fractal.made->scene, fractal.made->recipe, grids ? *grids : fractal.result,
                                 fractal.mesh, fractal.values, wanted, monitor);
  files.commit();
  return vdbtools::textsOf(clamped);
}

std::shared_ptr<MadeFit> makeFit(const Recipe& given, std::shared_ptr<const vdbtools::Mesh> mesh, Monitor& monitor) {
  auto fit = std::make_shared<MadeFit>();
  fit->recipe = given;
  if (mesh) fit->recipe["input"] = kMemory;
  fit->recipe = vdbtools::completeRecipe(std::move(fit->recipe), vdbtools::fit::fitOptionTable());
  vdbtools::fit::FitOptions options = vdbtools::fit::parseFitOptions(fit->recipe);
  if (!mesh) fit->inputs.add(options.target.input);
  options.target.mesh = std::move(mesh);
  fit->result = vdbtools::fit::runFit(options, false, monitor);
  return fit;
}

void writeFit(const MadeFit& fit, const std::string& path, Monitor& monitor) {
  const std::string extension = vdbtools::lowerExtension(path);
  if (extension != ".json" && extension != ".o3d")
    throw std::invalid_argument("the file to write is '" + path + "'; its extension must be .json or .o3d");
  vdbtools::OutputFiles files(vdbtools::withRecordedFiles(fit.inputs));
  std::ostream& file = files.add(path).stream();
  monitor.begin(vdbtools::PhaseKind::Writing, 0);
  const bool json = extension == ".json";
  file << (json ? vdbtools::fit::fitToJson(fit.result, fit.recipe) : vdbtools::fit::fitToO3d(fit.result, monitor));
  monitor.throwIfCancelled();
  files.commit();
}
