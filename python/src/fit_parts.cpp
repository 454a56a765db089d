// SPDX-License-Identifier: Apache-2.0
// The parts of fitting, each by itself. Coordinates are those of the map's space.
#include "module_parts.h"

#include "arrays.h"
#include "watched_work.h"

#include "vdbtools/formats/versor_file.h"

#include "julia/fit/cancelled.h"
#include "julia/fit/electrostatics.h"
#include "julia/fit/minimise.h"
#include "julia/fit/monopoles.h"
#include "julia/fit/shape_energy.h"
#include "julia/fit/surface.h"

#include <pybind11/stl.h>

#include <cstdint>
#include <stdexcept>
#include <tuple>
#include <utility>

namespace py = pybind11;

namespace {

using julia::Point;
using julia::Rational;
using vdbtools::Monitor;

static_assert(sizeof(Point) == 3 * sizeof(double));

std::span<const Point> pointsIn(const Places& places) {
  return {reinterpret_cast<const Point*>(places.array.data()), static_cast<std::size_t>(places.array.size() / 3)};
}

julia::TriangleSurface surfaceOf(const py::object& vertices, const py::object& faces) {
  const std::shared_ptr<const vdbtools::Mesh> mesh = targetOf(vertices, faces);
  if (!mesh || faces.is_none()) throw std::invalid_argument("a surface needs vertices and faces; give both");
  julia::TriangleSurface surface;
  for (const openvdb::Vec3d& point : mesh->points) surface.points.push_back({point[0], point[1], point[2]});
  for (const openvdb::Vec3I& triangle : mesh->triangles)
    surface.triangles.push_back({triangle[0], triangle[1], triangle[2]});
  return surface;
}

py::array_t<double> triplesFrom(std::span<const Point> points) {
  py::array_t<double> array({static_cast<py::ssize_t>(points.size()), py::ssize_t{3}});
  if (!points.empty()) std::copy_n(points.front().data(), 3 * points.size(), array.mutable_data());
  return array;
}

/// Runs work that stops when the monitor is cancelled.
template <class Work>
void stoppable(Monitor& monitor, const Work& work) {
  try {
    work([&monitor] { return monitor.cancelled(); });
  } catch (const julia::Cancelled&) {
    monitor.throwIfCancelled();
    throw;
  }
}

/// Numbers of one row. @throw std::invalid_argument
std::vector<double> rowOf(const py::object& values, const char* what, std::size_t size) {
  const py::array_t<double> array = doublesOf(arrayOf(values, what), what);
  if (array.ndim() != 1 || static_cast<std::size_t>(array.size()) != size)
    throw std::invalid_argument(std::string(what) + " must hold " + std::to_string(size) +
                                " numbers, one for each point; it has the shape " + shapeText(array));
  return {array.data(), array.data() + array.size()};
}

py::array_t<double> spreadOver(const py::object& vertices, const py::object& faces, std::size_t count,
                               std::uint64_t seed) {
  const julia::TriangleSurface surface = surfaceOf(vertices, faces);
  std::vector<Point> points;
  {
    const py::gil_scoped_release free;
    points = julia::blueNoise(surface, count, seed);
  }
  return triplesFrom(points);
}

py::tuple chargeOf(const py::object& vertices, const py::object& faces, double tolerance, const py::object& progress,
                   const std::optional<int>& threads) {
  const julia::TriangleSurface surface = surfaceOf(vertices, faces);
  julia::SurfaceCharge charge;
  doWatched(progress, {.threads = threadsOf(threads)}, [&](Monitor& monitor) {
    monitor.begin(vdbtools::PhaseKind::Electrostatics, 0);
    stoppable(monitor, [&](const auto& cancelled) {
      charge = julia::solveExteriorDirichlet(surface, {.tolerance = tolerance, .cancelled = cancelled});
    });
  });
  const auto count = static_cast<py::ssize_t>(charge.density.size());
  return py::make_tuple(arrayTaking(std::move(charge.density), {count}), charge.capacitance, charge.iterations,
                        charge.residual);
}

py::array_t<double> potentialAt(const py::object& vertices, const py::object& faces, const py::object& density,
                                const py::object& points) {
  const julia::TriangleSurface surface = surfaceOf(vertices, faces);
  const Places places = placesOf(points, "points");
  julia::SurfaceCharge charge;
  charge.density = rowOf(density, "density", surface.triangles.size());
  py::array_t<double> result(places.shape);
  const std::span<double> values = memoryOf(result);
  {
    const py::gil_scoped_release free;
    julia::potential(surface, charge, pointsIn(places), values);
  }
  return result;
}

py::tuple monopolesOver(const py::object& vertices, const py::object& faces, const py::object& points,
                        const py::object& potentials, double epsilon, std::size_t most, std::size_t candidates,
                        std::uint64_t seed, const py::object& progress, const std::optional<int>& threads) {
  const julia::TriangleSurface surface = surfaceOf(vertices, faces);
  const Places places = placesOf(points, "points");
  const std::vector<double> known = rowOf(potentials, "potentials", places.points().size());
  julia::MonopoleFit fit;
  doWatched(progress, {.threads = threadsOf(threads)}, [&](Monitor& monitor) {
    monitor.begin(vdbtools::PhaseKind::Monopoles, 0);
    stoppable(monitor, [&](const auto& cancelled) {
      fit = julia::fitMonopoles(surface, pointsIn(places), known,
                                {.epsilon = epsilon,
                                 .maxCount = most,
                                 .candidatesPerStep = candidates,
                                 .seed = seed,
                                 .cancelled = cancelled});
    });
  });
  std::vector<Point> at;
  std::vector<double> weights;
  for (const julia::Monopole& monopole : fit.monopoles) {
    at.push_back(monopole.position);
    weights.push_back(monopole.weight);
  }
  const auto count = static_cast<py::ssize_t>(weights.size()), steps = static_cast<py::ssize_t>(fit.residuals.size());
  return py::make_tuple(triplesFrom(at), arrayTaking(std::move(weights), {count}),
                        arrayTaking(std::move(fit.residuals), {steps}));
}

/// A rational as a tuple of Python: C, the roots of the top (n, 5) with tau, and those of the bottom with beta. A row
/// is a position and a power.
using RationalParts = std::tuple<double, py::object, double, py::object, double>;

julia::Polynomial polynomialOf(const py::object& roots, double powerScale, const char* what) {
  const py::array_t<double> rows = doublesOf(arrayOf(roots, what), what);
  const bool none = rows.size() == 0;
  if (!none && (rows.ndim() != 2 || rows.shape(1) != 5))
    throw std::invalid_argument(std::string(what) + " must be an array of the shape (n, 5), a position of four " +
                                "numbers and a power in each row; it is " + shapeText(rows));
  julia::Polynomial polynomial{{}, powerScale};
  const double* row = rows.data();
  for (py::ssize_t i = 0; !none && i < rows.shape(0); ++i, row += 5)
    polynomial.roots.push_back({{row[0], row[1], row[2], row[3]}, row[4]});
  return polynomial;
}

Rational rationalOf(const RationalParts& parts) {
  Rational rational{std::get<0>(parts), polynomialOf(std::get<1>(parts), std::get<2>(parts), "top"),
                    polynomialOf(std::get<3>(parts), std::get<4>(parts), "bottom")};
  julia::requireFinite(rational);
  return rational;
}

py::tuple partsOf(const Rational& rational) {
  const auto rows = [](const julia::Polynomial& polynomial) {
    py::array_t<double> array({static_cast<py::ssize_t>(polynomial.roots.size()), py::ssize_t{5}});
    double* to = array.mutable_data();
    for (const julia::Root& root : polynomial.roots)
      for (const double number : {root.position.a, root.position.b, root.position.c, root.position.d, root.power})
        *to++ = number;
    return array;
  };
  return py::make_tuple(rational.logScale, rows(rational.top), rational.top.powerScale, rows(rational.bottom),
                        rational.bottom.powerScale);
}

py::tuple rationalFrom(const py::object& positions, const py::object& weights, double powerPerWeight,
                       bool rootsAtOrigin) {
  const Places places = placesOf(positions, "positions");
  const std::span<const Point> at = pointsIn(places);
  const std::vector<double> all = rowOf(weights, "weights", at.size());
  std::vector<julia::Monopole> monopoles;
  for (std::size_t i = 0; i < at.size(); ++i) monopoles.push_back({at[i], all[i]});
  return partsOf(julia::rationalFromMonopoles(monopoles, powerPerWeight, rootsAtOrigin));
}

py::array_t<double> weightsOf(const py::object& points, const py::object& phi, double cellSize,
                              const std::string& kind) {
  if (kind != "inverse-distance" && kind != "layers")
    throw std::invalid_argument("kind is '" + kind + "'; it must be inverse-distance or layers");
  if (!(cellSize > 0)) throw std::invalid_argument("cell_size is " + std::to_string(cellSize) + "; it must be above 0");
  const Places places = placesOf(points, "points");
  const std::span<const Point> at = pointsIn(places);
  const std::vector<double> distances = rowOf(phi, "phi", at.size());
  std::vector<julia::FitCell> cells;
  for (std::size_t i = 0; i < at.size(); ++i) cells.push_back({at[i], static_cast<float>(distances[i])});
  std::vector<double> weights = julia::cellWeights(
      cells, kind == "layers" ? julia::CellWeights::Layers : julia::CellWeights::InverseDistance, cellSize);
  const auto count = static_cast<py::ssize_t>(weights.size());
  return arrayTaking(std::move(weights), {count});
}

std::unique_ptr<julia::ShapeEnergy> energyOf(const py::object& points, const py::object& weights,
                                             const RationalParts& roots, double alpha, double penalty) {
  const Places places = placesOf(points, "points");
  const std::span<const Point> at = pointsIn(places);
  std::vector<double> all = rowOf(weights, "weights", at.size());
  const Rational rational = rationalOf(roots);
  const py::gil_scoped_release free;
  return std::make_unique<julia::ShapeEnergy>(at, std::move(all), rational,
                                              julia::ShapeEnergyOptions{.alpha = alpha, .powerPenalty = penalty});
}

py::array_t<double> rowsOf(const std::vector<julia::Quaternion<double>>& quaternions) {
  py::array_t<double> array({static_cast<py::ssize_t>(quaternions.size()), py::ssize_t{4}});
  double* to = array.mutable_data();
  for (const julia::Quaternion<double>& q : quaternions)
    for (const double number : {q.a, q.b, q.c, q.d}) *to++ = number;
  return array;
}

/// (value, by C, by the top's powers, by tau, by the bottom's powers, by beta, by the top's places, by the bottom's)
py::tuple energyAt(const julia::ShapeEnergy& energy, const RationalParts& parts) {
  const Rational rational = rationalOf(parts);
  julia::RationalGradient gradient;
  double value = 0;
  {
    const py::gil_scoped_release free;
    value = energy.evaluate(rational, &gradient, julia::GradientOf::PowersAndPlaces);
  }
  const auto top = static_cast<py::ssize_t>(gradient.top.size()),
             bottom = static_cast<py::ssize_t>(gradient.bottom.size());
  return py::make_tuple(value, gradient.logScale, arrayTaking(std::move(gradient.top), {top}), gradient.topScale,
                        arrayTaking(std::move(gradient.bottom), {bottom}), gradient.bottomScale,
                        rowsOf(gradient.topPlaces), rowsOf(gradient.bottomPlaces));
}

py::array_t<double> logModuliOf(const julia::ShapeEnergy& energy, const RationalParts& parts) {
  const Rational rational = rationalOf(parts);
  py::array_t<double> result(static_cast<py::ssize_t>(energy.weights().size()));
  const std::span<double> values = memoryOf(result);
  const py::gil_scoped_release free;
  energy.logModuli(rational, values);
  return result;
}

/// Runs an optimiser of the energy. @param lower  receives its options and returns the value
/// @return (rational, value, the values on the way)
template <class Lower>
py::tuple lowestOf(Rational& rational, int iterations, double tolerance, const py::object& progress,
                   const std::optional<int>& threads, const Lower& lower) {
  std::vector<double> values;
  double value = 0;
  doWatched(progress, {.threads = threadsOf(threads)}, [&](Monitor& monitor) {
    monitor.begin({vdbtools::PhaseKind::Fit, "energy"}, 0);
    stoppable(monitor, [&](const auto& cancelled) {
      value = lower({.maxIterations = iterations,
                     .tolerance = tolerance,
                     .onStep = [&](double now, const Rational&) { values.push_back(now); },
                     .cancelled = cancelled});
    });
  });
  const auto count = static_cast<py::ssize_t>(values.size());
  return py::make_tuple(partsOf(rational), value, arrayTaking(std::move(values), {count}));
}

py::tuple minimumOf(const julia::ShapeEnergy& energy, const RationalParts& start, bool full, int iterations,
                    double tolerance, const py::object& progress, const std::optional<int>& threads) {
  Rational rational = rationalOf(start);
  return lowestOf(rational, iterations, tolerance, progress, threads, [&](const julia::MinimiseOptions& options) {
    return julia::minimise(energy, rational, full ? julia::FitVariables::Full : julia::FitVariables::Coarse, options);
  });
}

py::tuple movedRoots(julia::ShapeEnergy& energy, const RationalParts& start, double reach, int iterations,
                     double tolerance, const py::object& progress, const std::optional<int>& threads) {
  Rational rational = rationalOf(start);
  const std::vector<double> reaches(rational.top.roots.size() + rational.bottom.roots.size(), reach);
  return lowestOf(rational, iterations, tolerance, progress, threads, [&](const julia::MinimiseOptions& options) {
    return julia::moveRoots(energy, rational, reaches, options);
  });
}

/// L and the versor of f at points. @return (l, (..., 4))
py::tuple rationalAt(const RationalParts& parts, const py::object& points) {
  const julia::RationalEvaluator<double> evaluator(rationalOf(parts));
  const Places places = placesOf(points, "points");
  const std::span<const Point> at = pointsIn(places);
  julia::QuaternionBatch<double> q, u;
  q.resize(at.size());
  for (std::size_t i = 0; i < at.size(); ++i) q.set(i, {at[i][0], at[i][1], at[i][2], 0});
  py::array_t<double> l(places.shape), versors(places.shapeWith({4}));
  const std::span<double> values = memoryOf(l);
  double* to = versors.mutable_data();
  {
    const py::gil_scoped_release free;
    evaluator.logModulus(q, values);
    evaluator.versor(q, u);
  }
  for (std::size_t i = 0; i < at.size(); ++i)
    for (const double component : {u.a[i], u.b[i], u.c[i], u.d[i]}) *to++ = component;
  return py::make_tuple(l, versors);
}

}  // namespace

void addFitParts(py::module_& module) {
  module.def("blue_noise", spreadOver);
  module.def("charge", chargeOf);
  module.def("potential", potentialAt);
  module.def("monopoles", monopolesOver);
  module.def("rational_from_monopoles", rationalFrom);
  module.def("cell_weights", weightsOf);
  module.def("rational_at", rationalAt);
  module.def("rational_json", [](const RationalParts& parts) { return vdbtools::rationalToJson(rationalOf(parts)); });
  module.def("rational_read", [](const std::string& path) { return partsOf(vdbtools::readRational(path)); });
  py::class_<julia::ShapeEnergy>(module, "Energy")
      .def(py::init(&energyOf))
      .def("value",
           [](const julia::ShapeEnergy& energy, const RationalParts& parts) {
             const Rational rational = rationalOf(parts);
             const py::gil_scoped_release free;
             return energy.evaluate(rational, nullptr);
           })
      .def("at", energyAt)
      .def("log_moduli", logModuliOf)
      .def("minimise", minimumOf)
      .def("move_roots", movedRoots);
}
