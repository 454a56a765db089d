// SPDX-License-Identifier: Apache-2.0
#include "module_parts.h"

#include "arrays.h"
#include "queries.h"
#include "watched_work.h"

#include <pybind11/stl.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>

namespace py = pybind11;

namespace {

using openvdb::Vec3d;
using vdbtools::Monitor;

QueryWork workOf(const std::optional<int>& threads, const std::optional<std::string>& device = {}) {
  return {threadsOf(threads), device.value_or("")};
}

py::array_t<double> fieldAt(const MadeScene& made, const py::object& points, const py::object& progress,
                            const std::optional<int>& threads, const std::optional<std::string>& device) {
  const Places places = placesOf(points, "points");
  const QueryWork work = workOf(threads, device);
  py::array_t<double> result(places.shape);
  const std::span<double> values = memoryOf(result);
  const std::span<const Vec3d> at = places.points();
  doWatched(progress, {.memory = made.memory}, [&](Monitor& monitor) { evaluateAt(made, at, values, work, monitor); });
  return result;
}

using NumberQuery = void (*)(const MadeScene&, std::span<const Vec3d>, std::span<double>, const QueryWork&, Monitor&);

/// A method that gives a number for each point.
template <NumberQuery kQuery>
py::array_t<double> numbersAt(const MadeScene& made, const py::object& points, const py::object& progress,
                              const std::optional<int>& threads) {
  const Places places = placesOf(points, "points");
  const QueryWork work = workOf(threads);
  py::array_t<double> result(places.shape);
  const std::span<double> values = memoryOf(result);
  const std::span<const Vec3d> at = places.points();
  doWatched(progress, {.memory = made.memory}, [&](Monitor& monitor) { kQuery(made, at, values, work, monitor); });
  return result;
}

using Quaternions = std::vector<julia::Quaternion<double>>;

/// The components that the map has: three of one of R^3.
py::array_t<double> quaternionsIn(std::vector<py::ssize_t> shape, const Quaternions& quaternions, int dimension) {
  shape.push_back(dimension);
  py::array_t<double> array(shape);
  double* to = array.mutable_data();
  for (const julia::Quaternion<double>& q : quaternions) {
    const double components[] = {q.a, q.b, q.c, q.d};
    to = std::copy_n(components, dimension, to);
  }
  return array;
}

py::array_t<double> versorAt(const MadeScene& made, const py::object& points, const py::object& progress,
                             const std::optional<int>& threads) {
  const Places places = placesOf(points, "points");
  const QueryWork work = workOf(threads);
  const std::span<const Vec3d> at = places.points();
  Quaternions versors(at.size());
  doWatched(progress, {.memory = made.memory}, [&](Monitor& monitor) { versorsAt(made, at, versors, work, monitor); });
  return quaternionsIn(places.shape, versors, made.scene.field.evaluator->dimension());
}

py::array_t<double> gradientAt(const MadeScene& made, const py::object& points, const std::optional<double>& step,
                               const py::object& progress, const std::optional<int>& threads) {
  const Places places = placesOf(points, "points");
  const QueryWork work = workOf(threads);
  if (step && !(*step > 0 && std::isfinite(*step)))
    throw std::invalid_argument("step is " + tupleText(&*step, 1) + "; it must be above 0 and finite, or None");
  py::array_t<double> result(places.shapeWith({3}));
  const std::span<Vec3d> gradients(reinterpret_cast<Vec3d*>(result.mutable_data()), places.points().size());
  const std::span<const Vec3d> at = places.points();
  doWatched(progress, {.memory = made.memory},
            [&](Monitor& monitor) { gradientsAt(made, at, step.value_or(0), gradients, work, monitor); });
  return result;
}

py::array_t<std::int8_t> decisionsAt(const MadeScene& made, const py::object& centres, const py::object& radii,
                                     const py::object& progress, const std::optional<int>& threads) {
  const Places places = placesOf(centres, "centres");
  const QueryWork work = workOf(threads);
  const py::array_t<double> given = doublesOf(arrayOf(radii, "radius"), "radius");
  if (given.ndim() != 0 && std::vector<py::ssize_t>(given.shape(), given.shape() + given.ndim()) != places.shape)
    throw std::invalid_argument("radius must be one number, or an array with one for each centre, of the shape " +
                                py::str(py::cast(places.shape)).cast<std::string>() + "; it is " + shapeText(given));
  const std::span<const double> all(given.data(), static_cast<std::size_t>(given.size()));
  for (const double radius : all)
    if (!(radius >= 0 && std::isfinite(radius)))
      throw std::invalid_argument("radius is " + tupleText(&radius, 1) + "; it must be 0 or more, and finite");
  py::array_t<std::int8_t> result(places.shape);
  const std::span<std::int8_t> decisions = memoryOf(result);
  const std::span<const Vec3d> at = places.points();
  doWatched(progress, {.memory = made.memory},
            [&](Monitor& monitor) { decideAt(made, at, all, decisions, work, monitor); });
  return result;
}

/// (iterates, log_moduli, steps, ends)
py::tuple orbitsOf(const MadeScene& made, const py::object& points, const py::object& progress,
                   const std::optional<int>& threads) {
  const Places places = placesOf(points, "points");
  const QueryWork work = workOf(threads);
  const std::span<const Vec3d> at = places.points();
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  const py::ssize_t row = py::ssize_t{made.scene.field.orbit.maxIterations} + 1;
  const std::size_t entries = at.size() * static_cast<std::size_t>(row);
  Quaternions iterates(entries, {kNaN, kNaN, kNaN, kNaN});
  py::array_t<double> logModuli(places.shapeWith({row}));
  py::array_t<int> steps(places.shape);
  std::vector<julia::OrbitEnd> ends(at.size());
  const std::span<double> l = memoryOf(logModuli);
  std::fill(l.begin(), l.end(), kNaN);
  const julia::OrbitTrace trace{iterates, l, memoryOf(steps), ends};
  doWatched(progress, {.memory = made.memory}, [&](Monitor& monitor) { orbitsAt(made, at, trace, work, monitor); });
  py::array_t<std::uint8_t> codes(places.shape);
  std::transform(ends.begin(), ends.end(), codes.mutable_data(),
                 [](julia::OrbitEnd end) { return static_cast<std::uint8_t>(end); });
  return py::make_tuple(quaternionsIn(places.shapeWith({row}), iterates, made.scene.field.evaluator->dimension()),
                        logModuli, steps, codes);
}

}  // namespace

void addFieldMethods(py::class_<MadeScene, std::shared_ptr<MadeScene>>& scene) {
  scene.def("evaluate", fieldAt)
      .def("distance", numbersAt<distancesAt>)
      .def("thickness", numbersAt<thicknessAt>)
      .def("full_thickness", numbersAt<fullThicknessAt>)
      .def("octave", numbersAt<octavesAt>)
      .def("exponent", numbersAt<exponentsAt>)
      .def("trap", numbersAt<trapsAt>)
      .def("versor", versorAt)
      .def("gradient", gradientAt)
      .def("decide", decisionsAt)
      .def("orbit", orbitsOf)
      .def_property_readonly("space", [](const MadeScene& made) {
        const vdbtools::FractalSpace& space = made.scene.placed.space;
        return py::make_tuple(py::make_tuple(space.centre[0], space.centre[1], space.centre[2]), space.scale);
      });
}
