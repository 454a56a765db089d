// SPDX-License-Identifier: Apache-2.0
#include "made.h"

#include "vdbtools/base/number_text.h"
#include "vdbtools/files/atomic_file.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/job/fractal_files.h"
#include "vdbtools/job/scene_picture.h"
#include "vdbtools/recipe/option_value.h"
#include "vdbtools/render/view_options.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <list>
#include <stdexcept>
#include <utility>

using vdbtools::Monitor;
using vdbtools::Recipe;

std::shared_ptr<MadeScene> makeNamedScene(const Recipe& given, std::shared_ptr<const vdbtools::Mesh> mesh,
                                          Monitor& monitor) {
  auto made = std::make_shared<MadeScene>();
  made->recipe = given;
  if (mesh) made->recipe["input"] = kMemory;
  made->recipe = vdbtools::completeRecipe(std::move(made->recipe), vdbtools::fractalOptionTable());
  vdbtools::FractalOptions options = vdbtools::parseFractalOptions(made->recipe);
  if (mesh) options.target.value().mesh = std::move(mesh);
  made->scene = vdbtools::makeScene(options, monitor);
  // The fields and files of the scene need the mesh no more, and the caller may want its memory.
  if (made->scene.options.target) made->scene.options.target->mesh.reset();
  return made;
}

void evaluateAt(const MadeScene& made, std::span<const openvdb::Vec3d> points, std::span<double> field,
                Monitor& monitor) {
  const auto broken = std::find_if(points.begin(), points.end(), [](const auto& point) { return !point.isFinite(); });
  if (broken != points.end())
    throw std::invalid_argument("point " + std::to_string(broken - points.begin()) +
                                " has a coordinate that is not finite");
  const julia::FieldEvaluator& evaluator = *made.scene.evaluator;
  const vdbtools::FractalSpace& space = made.scene.space;
  monitor.begin("evaluating", points.size());
  const std::size_t batch = evaluator.preferredBatch(), batches = (points.size() + batch - 1) / batch;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, batches, 1), [&](const auto& range) {
    std::vector<julia::Point> at;
    for (std::size_t i = range.begin(); i < range.end() && !monitor.cancelled(); ++i) {
      const std::size_t first = i * batch, count = std::min(batch, points.size() - first);
      at.clear();
      for (const openvdb::Vec3d& point : points.subspan(first, count)) at.push_back(space.toFractal(point));
      evaluator.evaluate(at, field.subspan(first, count), {});
      monitor.advance(count);
    }
  });
  monitor.throwIfCancelled();
}

vdbtools::OptionTable viewTable() {
  std::vector<vdbtools::OptionSpec> options = vdbtools::fieldPictureOptionSpecs("800x800");
  options.push_back(vdbtools::colourOptionSpec());
  return vdbtools::OptionTable(std::move(options));
}

void checkView(const Recipe& view) { vdbtools::parseFieldPicture(view, viewTable()); }

vdbtools::Image pictureOf(const MadeScene& made, const Recipe& view, Monitor& monitor) {
  const vdbtools::FieldPicture picture = vdbtools::parseFieldPicture(view, viewTable());
  const openvdb::BBoxd region = vdbtools::pictureRegion(made.scene);
  const vdbtools::FieldRenderOptions options = vdbtools::pictureOptions(made.scene, region, picture);
  return vdbtools::renderField(made.scene.source(), region, options, monitor).beauty;
}

std::shared_ptr<MadeFractal> makeFractal(std::shared_ptr<const MadeScene> made, bool wantGrids, Monitor& monitor) {
  auto fractal = std::make_shared<MadeFractal>();
  fractal->made = std::move(made);
  const vdbtools::Scene& scene = fractal->made->scene;
  vdbtools::MeshCollector collector(fractal->mesh, &fractal->values);
  fractal->result = vdbtools::runFractal(scene, vdbtools::planScene(scene), wantGrids, &collector, monitor);
  fractal->hasGrids = wantGrids;
  return fractal;
}

namespace {

/// @param known  separated by spaces @throw std::invalid_argument
void requireExtension(const std::string& path, const std::string& known) {
  const std::vector<std::string> extensions = vdbtools::split(known, ' ');
  if (std::find(extensions.begin(), extensions.end(), vdbtools::lowerExtension(path)) == extensions.end())
    throw std::invalid_argument("the file to write is '" + path + "'; its extension must be one of " + known);
}

}  // namespace

void writeFiles(MadeFractal& fractal, const std::vector<std::string>& paths, Monitor& monitor) {
  for (const std::string& path : paths) requireExtension(path, std::string(".vdb ") + vdbtools::kMeshExtensions);
  std::list<vdbtools::AtomicFile> files;
  std::vector<vdbtools::AtomicFile*> all;
  vdbtools::FractalFiles wanted;
  for (const std::string& path : paths) {
    all.push_back(&files.emplace_back(path));
    if (vdbtools::lowerExtension(path) != ".vdb")
      wanted.meshes.push_back({all.back(), vdbtools::meshFormat(path)});
    else if (std::exchange(wanted.vdb, all.back()))
      throw std::invalid_argument("two VDB files were given; write them one after the other");
  }
  const vdbtools::Scene& scene = fractal.made->scene;
  if (wanted.vdb && !fractal.hasGrids) {
    vdbtools::FractalResult result = vdbtools::runFractal(scene, vdbtools::planScene(scene), true, nullptr, monitor);
    fractal.result.grids = std::move(result.grids);
    fractal.result.check = std::move(result.check);
    fractal.hasGrids = true;
  }
  vdbtools::writeMadeFractal(scene, fractal.made->recipe, fractal.result, fractal.mesh, fractal.values, wanted,
                             monitor);
  vdbtools::commitAll(all);
}

std::shared_ptr<MadeFit> makeFit(const Recipe& given, std::shared_ptr<const vdbtools::Mesh> mesh, Monitor& monitor) {
  auto fit = std::make_shared<MadeFit>();
  fit->recipe = given;
  if (mesh) fit->recipe["input"] = kMemory;
  fit->recipe = vdbtools::completeRecipe(std::move(fit->recipe), vdbtools::fitOptionTable());
  vdbtools::FitOptions options = vdbtools::parseFitOptions(fit->recipe);
  options.target.mesh = std::move(mesh);
  fit->result = vdbtools::runFit(options, false, monitor);
  return fit;
}

void writeFit(const MadeFit& fit, const std::string& path, Monitor& monitor) {
  requireExtension(path, ".json .o3d");
  vdbtools::AtomicFile file(path);
  monitor.begin("writing", 0);
  const bool json = vdbtools::lowerExtension(path) == ".json";
  file.stream() << (json ? vdbtools::fitToJson(fit.result, fit.recipe) : vdbtools::fitToO3d(fit.result, monitor));
  monitor.throwIfCancelled();
  file.commit();
}
