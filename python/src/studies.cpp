// SPDX-License-Identifier: Apache-2.0
// Measurements on planes and over resolutions.
#include "module_parts.h"

#include "arrays.h"
#include "watched_work.h"

#include "vdbtools/scene/scene.h"
#include "vdbtools/study/study.h"

#include <pybind11/stl.h>

#include <cstdint>
#include <stdexcept>
#include <utility>

namespace py = pybind11;

namespace {

using openvdb::Vec3d;
using vdbtools::Monitor;

/// The plane of a picture, as framed by the options --axis, --position and --size.
/// @param usual  a point of the plane if no position is given @throw std::invalid_argument
vdbtools::SlicePlane planeOf(const MadeScene& made, const std::string& axis, const std::optional<double>& position,
                             int size, const Vec3d& usual) {
  if (axis != "x" && axis != "y" && axis != "z")
    throw std::invalid_argument("axis is '" + axis + "'; it must be x, y or z");
  if (size < 1 || size > vdbtools::kMostSlicePixels)
    throw std::invalid_argument("size is " + std::to_string(size) + "; it must be from 1 to " +
                                std::to_string(vdbtools::kMostSlicePixels));
  const auto number = static_cast<vdbtools::Axis>(axis[0] - 'x');
  return {number, position.value_or(usual[static_cast<int>(number)]), vdbtools::sliceFrame(made.scene), size};
}

/// The positions of the pixels, (height, width, 3).
py::array_t<double> planeAt(const MadeScene& made, const std::string& axis, const std::optional<double>& position,
                            int size) {
  const vdbtools::SlicePlane plane = planeOf(made, axis, position, size, vdbtools::sliceFrame(made.scene).getCenter());
  py::array_t<double> places({plane.height(), plane.width(), 3});
  double* to = places.mutable_data();
  for (int y = 0; y < plane.height(); ++y)
    for (int x = 0; x < plane.width(); ++x) {
      const Vec3d at = plane.position(x, y);
      for (int k = 0; k < 3; ++k) *to++ = at[k];
    }
  return places;
}

py::dict studyOf(const MadeScene& made, const std::string& axis, const std::optional<double>& position, int size,
                 int versors, const py::object& progress, const std::optional<int>& threads) {
  const vdbtools::SlicePlane plane = planeOf(made, axis, position, size, made.scene.field.space.centre);
  if (versors < 1 || versors > vdbtools::kMostVersors)
    throw std::invalid_argument("versors is " + std::to_string(versors) + "; it must be from 1 to " +
                                std::to_string(vdbtools::kMostVersors));
  vdbtools::Study study;
  const Resources resources{made.memory, threadsOf(threads), made.device};
  doWatched(progress, resources, [&](Monitor& monitor) {
    study = vdbtools::runStudy(made.scene, plane, {.versors = versors, .circles = true}, monitor);
  });
  py::dict result;
  result["versors"] = study.versors;
  result["inside"] = arrayTaking(std::move(study.inside), {plane.height(), plane.width()});
  py::dict circles;
  const auto column = [&](const char* name, double vdbtools::StudyCircle::*member) {
    std::vector<double> values;
    for (const vdbtools::StudyCircle& circle : study.circles) values.push_back(circle.*member);
    const auto count = static_cast<py::ssize_t>(values.size());
    circles[name] = arrayTaking(std::move(values), {count});
  };
  column("radius", &vdbtools::StudyCircle::radius);
  column("mean", &vdbtools::StudyCircle::mean);
  column("least", &vdbtools::StudyCircle::least);
  column("greatest", &vdbtools::StudyCircle::greatest);
  column("sphere_mean", &vdbtools::StudyCircle::sphereMean);
  column("membership", &vdbtools::StudyCircle::membership);
  result["circles"] = circles;
  result["undecided"] = study.undecided;
  result["origin_inside"] = study.originInside;
  return result;
}

py::dict dimensionOf(const vdbtools::Recipe& recipe, const py::object& vertices, const py::object& faces,
                     const std::vector<int>& resolutions, const GivenResources& resources, const py::object& progress) {
  for (std::size_t i = 0; i < resolutions.size(); ++i)
    if (resolutions[i] < vdbtools::kLeastGrowthResolution || resolutions[i] > vdbtools::kMostGrowthResolution ||
        (i > 0 && resolutions[i] <= resolutions[i - 1]))
      throw std::invalid_argument("resolutions hold " + std::to_string(resolutions[i]) +
                                  "; they must be whole numbers from " +
                                  std::to_string(vdbtools::kLeastGrowthResolution) + " to " +
                                  std::to_string(vdbtools::kMostGrowthResolution) + ", the smallest first");
  if (resolutions.size() < vdbtools::kLeastGrowthRows)
    throw std::invalid_argument("resolutions must be at least three");
  for (const char* option : {"resolution", "voxel-size"})
    if (recipe.contains(option))
      throw std::invalid_argument(std::string("--") + option +
                                  " is given, but the resolutions are those of the study; leave it out");
  std::shared_ptr<const vdbtools::Mesh> mesh = targetOf(vertices, faces);
  std::vector<vdbtools::GrowthRow> rows;
  doWatched(progress, resourcesOf(resources), [&](Monitor& monitor) {
    rows = vdbtools::measureGrowth(namedOptions(recipe, {.mesh = std::move(mesh)}).options, resolutions, monitor);
  });
  const vdbtools::PowerLaw law = vdbtools::growthLaw(rows);
  py::dict result;
  result["dimension"] = law.exponent;
  result["standard_error"] = law.standardError;
  result["interval"] = law.interval;
  result["factor"] = law.factor;
  const auto column = [&](const char* name, const auto& numberOf) {
    std::vector<std::int64_t> values;
    for (const vdbtools::GrowthRow& row : rows) values.push_back(static_cast<std::int64_t>(numberOf(row)));
    const auto count = static_cast<py::ssize_t>(values.size());
    result[name] = arrayTaking(std::move(values), {count});
  };
  column("resolutions", [](const auto& row) { return row.resolution; });
  column("triangles", [](const auto& row) { return row.triangles; });
  column("points", [](const auto& row) { return row.points; });
  column("evaluated_nodes", [](const auto& row) { return row.evaluatedNodes; });
  return result;
}

}  // namespace

void addStudies(py::module_& module, py::class_<MadeScene, std::shared_ptr<MadeScene>>& scene) {
  scene.def("plane", planeAt).def("study", studyOf);
  module.def("dimension", dimensionOf);
}
