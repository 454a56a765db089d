// SPDX-License-Identifier: Apache-2.0
#include "scene/prepared_scene.h"

#include "scene/placed_target.h"
#include "scene/posed_scene.h"

#include "base/json_text.h"
#include "repair/solid_input.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/base/text.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/maps/versor_options.h"
#include "vdbtools/recipe/option_value.h"

#include <nlohmann/json.hpp>

#include <cmath>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

namespace vdbtools {
namespace {

using nlohmann::json;
using openvdb::BBoxd;
using openvdb::CoordBBox;
using openvdb::FloatGrid;
using openvdb::Vec3d;

constexpr const char* kEntry = "julia_prepared";

// As text, because a number of JSON cannot be infinite.
json number(double value) { return numbersText({value}); }
double numberOf(const json& value) {
  const std::optional<double> result = numberFromText(value.get<std::string>());
  if (!result) throw DataError("'" + value.get<std::string>() + "' is not a number");
  return *result;
}

json vector(const Vec3d& v) { return {number(v[0]), number(v[1]), number(v[2])}; }
Vec3d vectorOf(const json& v) { return {numberOf(v.at(0)), numberOf(v.at(1)), numberOf(v.at(2))}; }

json space(const FractalSpace& s) { return {{"centre", vector(s.centre)}, {"scale", number(s.scale)}}; }
FractalSpace spaceOf(const json& s) { return {vectorOf(s.at("centre")), numberOf(s.at("scale"))}; }

json box(const BBoxd& b) { return {vector(b.min()), vector(b.max())}; }
BBoxd boxOf(const json& b) { return {vectorOf(b.at(0)), vectorOf(b.at(1))}; }

json nodes(const std::optional<CoordBBox>& b) {
  if (!b) return nullptr;
  return {b->min()[0], b->min()[1], b->min()[2], b->max()[0], b->max()[1], b->max()[2]};
}
std::optional<CoordBBox> nodesOf(const json& b) {
  if (b.is_null()) return std::nullopt;
  const auto c = [&](std::size_t i) { return wholeOf<int>(b.at(i)); };
  return CoordBBox(c(0), c(1), c(2), c(3), c(4), c(5));
}

json orbit(const julia::OrbitOptions& o) {
  return {{"iterations", o.maxIterations},
          {"escape", number(o.escapeRadius)},
          {"trap", number(o.logTrap)},
          {"confirm_trap", o.confirmTrap}};
}
julia::OrbitOptions recordedOrbit(const json& o) {
  return {.maxIterations = wholeOf<int>(o.at("iterations")),
          .escapeRadius = numberOf(o.at("escape")),
          .logTrap = numberOf(o.at("trap")),
          .confirmTrap = o.at("confirm_trap").get<bool>()};
}

json range(const std::pair<double, double>& r) { return {number(r.first), number(r.second)}; }
std::pair<double, double> rangeOf(const json& r) { return {numberOf(r.at(0)), numberOf(r.at(1))}; }

json exponentNumbers(const ExponentGrid& e) {
  return {{"space", space(e.space)},
          {"shell", range({e.shell.lower, e.shell.upper})},
          {"shell_of_nodes", range({e.shellOfNodes.lower, e.shellOfNodes.upper})},
          {"knee", range({e.knee.at, e.knee.more})},
          {"orbit", orbit(e.orbit)},
          {"dense_box", nodes(e.denseBox)},
          {"scale", e.scale ? number(*e.scale) : json()},
          {"alpha", range(e.alphaRange)},
          {"beta", range(e.betaRange)},
          {"interpolation", static_cast<int>(e.interpolation)}};
}

ExponentGrid exponentOf(const json& e, FloatGrid::Ptr grid) {
  ExponentGrid result{.grid = std::move(grid), .space = spaceOf(e.at("space"))};
  std::tie(result.shell.lower, result.shell.upper) = rangeOf(e.at("shell"));
  std::tie(result.shellOfNodes.lower, result.shellOfNodes.upper) = rangeOf(e.at("shell_of_nodes"));
  std::tie(result.knee.at, result.knee.more) = rangeOf(e.at("knee"));
  result.orbit = recordedOrbit(e.at("orbit"));
  result.denseBox = nodesOf(e.at("dense_box"));
  if (!e.at("scale").is_null()) result.scale = numberOf(e.at("scale"));
  result.alphaRange = rangeOf(e.at("alpha"));
  result.betaRange = rangeOf(e.at("beta"));
  const int interpolation = wholeOf<int>(e.at("interpolation"));
  if (interpolation != static_cast<int>(julia::Interpolation::Trilinear) &&
      interpolation != static_cast<int>(julia::Interpolation::Quadratic))
    throw DataError("the interpolation " + std::to_string(interpolation) + " is not known");
  result.interpolation = static_cast<julia::Interpolation>(interpolation);
  return result;
}

/// The lattice of the target's distances is kept to the last bit, because random roots are placed by it.
json target(const Target& t) {
  json entry = {{"box", box(t.box)}, {"dense_box", nodes(t.denseBox)}};
  if (t.phi->transform().mapType() == openvdb::math::UniformScaleTranslateMap::mapType())
    entry["lattice"] = latticeText(*t.phi);
  return entry;
}
Target targetOf(const json& t, FloatGrid::Ptr phi) {
  if (t.contains("lattice")) placeOnLattice(*phi, t["lattice"].get<std::string>());
  return {.phi = std::move(phi), .box = boxOf(t.at("box")), .denseBox = nodesOf(t.at("dense_box"))};
}

/// A copy that may be given another name; the values are shared.
FloatGrid::Ptr named(const FloatGrid::Ptr& grid, const char* name) {
  FloatGrid::Ptr copy = grid->copy();
  copy->setName(name);
  return copy;
}

FloatGrid::Ptr gridOf(const VdbFile& file, const char* name, const std::filesystem::path& path) {
  FloatGrid::Ptr grid = chooseFloatGrid(file, name, path);
  grid->removeMeta(kEntry);
  return grid;
}

/// @throw DataError  a number that cannot belong to a scene
void requireSound(const Scene& scene) {
  const auto require = [](bool sound, const char* what) {
    if (!sound) throw DataError(std::string("its ") + what + " cannot be");
  };
  const auto isPlaced = [](const FractalSpace& s) {
    return s.centre.isFinite() && s.scale > 0 && std::isfinite(s.scale);
  };
  const auto isOrbit = [](const julia::OrbitOptions& o) {
    return o.maxIterations > 0 && o.escapeRadius > 1 && std::isfinite(o.escapeRadius) && !std::isnan(o.logTrap);
  };
  const auto isRange = [](const std::pair<double, double>& r) { return r.first <= r.second; };
  const auto isBox = [](const BBoxd& b) { return b.min().isFinite() && b.max().isFinite() && b.isSorted(); };
  require(scene.voxelSize > 0 && std::isfinite(scene.voxelSize), "voxel size");
  require(isOrbit(scene.field.orbit), "orbit");
  require(isPlaced(scene.field.space) && isPlaced(scene.placed.space) && isPlaced(scene.placed.unmoved), "space");
  if (scene.target) {
    const Target& target = scene.target->distances;
    require(isBox(target.box) && (!target.denseBox || !target.denseBox->empty()), "target");
    for (const auto& [name, control] : scene.target->controls)
      require(isPlaced(control.space) && !control.grid->evalActiveVoxelBoundingBox().empty(), "controls");
  }
  if (!scene.exponent()) {
    require(isBox(scene.region()), "region");
    return;
  }
  const ExponentGrid& e = *scene.exponent();
  // The map reads the exponent in its own space.
  require(e.space.centre == scene.placed.space.centre && e.space.scale == scene.placed.space.scale,
          "spaces, of which the exponent has another one,");
  require(isPlaced(e.space) && isOrbit(e.orbit) && isRange({e.shell.lower, e.shell.upper}) &&
              isRange({e.shellOfNodes.lower, e.shellOfNodes.upper}) && std::isfinite(e.knee.at) && e.knee.more >= 0 &&
              std::isfinite(e.knee.more) && isRange(e.alphaRange) && isRange(e.betaRange) &&
              (!e.denseBox || !e.denseBox->empty()) && (!e.scale || std::isfinite(*e.scale)),
          "exponent");
}

/// @param space  the space in which the map reads the octave
SceneTarget sceneTargetOf(const VdbFile& file, const json& entry, const FractalSpace& space,
                          const FractalOptions& options, const std::filesystem::path& path) {
  SceneTarget target{.distances = targetOf(entry.at("target"), gridOf(file, "phi", path)),
                     .volume = numberOf(entry.at("target_volume"))};
  if (options.output.attributes.has(PointAttribute::Tau)) target.thickness = gridOf(file, "thickness", path);
  if (options.map->frequency()) target.octave = OctaveGrid{gridOf(file, "octave", path), space};
  for (const MapControl& control : options.map->controls())
    for (const std::string& name : gridNames(control)) {
      const FractalSpace where = spaceOf(entry.at("controls").at(name));
      target.controls[name] = {gridOf(file, ("control-" + name).c_str(), path), where};
    }
  return target;
}

}  // namespace

std::string encodePreparedScene(const Scene& scene) {
  json entry = {{"voxel_size", number(scene.voxelSize)},
                {"orbit", orbit(scene.field.orbit)},
                {"doubles", scene.field.arithmetic == Arithmetic::Double},
                {"space", space(scene.field.space)},
                {"placed", space(scene.placed.space)},
                {"unmoved", space(scene.placed.unmoved)},
                {"facts", scene.metadata}};
  std::vector<openvdb::GridBase::Ptr> grids;
  if (scene.target) {
    const Target& distances = scene.rest ? scene.rest->distances : scene.target->distances;
    entry["target"] = target(distances);
    entry["target_volume"] = number(scene.target->volume);
    grids.push_back(named(distances.phi, "phi"));
    if (scene.target->octave) grids.push_back(named(scene.target->octave->grid, "octave"));
    json controls = json::object();
    for (const auto& [name, control] : scene.target->controls) {
      controls[name] = space(control.space);
      grids.push_back(named(control.grid, ("control-" + name).c_str()));
    }
    if (!controls.empty()) entry["controls"] = std::move(controls);
    if (scene.target->thickness) {
      const FloatGrid::Ptr thickness = scene.target->thickness->deepCopy();
      thickness->setName("thickness");
      grids.push_back(thickness);
    }
  }
  if (const ExponentGrid* const exponent = scene.rest ? &scene.rest->exponent : scene.exponent()) {
    entry["exponent"] = exponentNumbers(*exponent);
    grids.push_back(named(exponent->grid, "exponent"));
  } else {
    entry["region"] = box(scene.region());
  }
  // A VDB must have a grid.
  if (grids.empty()) grids.push_back(named(FloatGrid::create(), "none"));
  return encodeVdb(grids, {.half = false, .metadata = {{kEntry, entry.dump()}}});
}

Scene readPreparedScene(const FractalOptions& options, const std::filesystem::path& path) {
  const VdbFile file = readVdb(path);
  const auto found = file.metadata.find(kEntry);
  if (found == file.metadata.end()) throw DataError("'" + path.string() + "' holds no prepared scene");
  const auto refuse = [&](const std::string& why) {
    throw DataError("'" + inOneLine(path.native()) + "' holds a prepared scene that cannot be used: " + why +
                    "; plan again");
  };
  Scene scene;
  try {
    const json entry = parsedJson<json>(found->second);
    scene.options = options;
    scene.voxelSize = numberOf(entry.at("voxel_size"));
    scene.field.orbit = recordedOrbit(entry.at("orbit"));
    scene.field.arithmetic = entry.at("doubles").get<bool>() ? Arithmetic::Double : Arithmetic::Float;
    scene.field.space = spaceOf(entry.at("space"));
    scene.placed = {spaceOf(entry.at("placed")), spaceOf(entry.at("unmoved"))};
    scene.metadata = entry.at("facts").get<Metadata>();
    if (entry.contains("target")) scene.target = sceneTargetOf(file, entry, scene.placed.space, options, path);
    const bool needsTarget =
        options.target || options.map->shell() || options.map->frequency() || !options.map->controls().empty();
    if (needsTarget && !scene.target) throw DataError("there is no target");
    if (options.map->shell())
      scene.domain = SceneShell{exponentOf(entry.at("exponent"), gridOf(file, "exponent", path))};
    else
      scene.domain = boxOf(entry.at("region"));
    requireSound(scene);
  } catch (const json::exception& error) {
    refuse(error.what());
  } catch (const DataError& error) {
    refuse(error.what());
  }
  const MapFiles files = options.map->readFiles();
  scene.field.map = mapInstance(scene, files);
  scene.field.evaluator = scene.field.map->evaluator(scene.field.arithmetic, scene.field.orbit);
  if (options.rest) {
    Monitor unwatched;
    const std::unique_ptr<const TargetInput> rest = openTarget(targetAtRest(*options.rest, *options.target), unwatched);
    scene.rest = SceneAtRest{*scene.exponent(), scene.target->distances, rest->mesh(), rest->box()};
    poseScene(scene, options, openPose(options, *rest, openTarget, unwatched), unwatched);
  }
  return scene;
}

}  // namespace vdbtools
