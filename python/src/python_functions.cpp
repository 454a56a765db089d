// SPDX-License-Identifier: Apache-2.0
#include "python_functions.h"

#include "arrays.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

namespace py = pybind11;

namespace {

using openvdb::Vec3d;

/// Loads numpy before threads need it. pybind11 before 2.12 would load it when it makes its first array, in one of
/// these threads: that one gives up the interpreter's lock meanwhile, and waits for it for ever once another one, which
/// has it, waits for numpy.
void loadNumpy() {
  py::module_::import("numpy");
  py::dtype::of<double>();
}

/// A reference to a function that may be called and released in any thread, because the last evaluator with the
/// function may end in any thread.
std::shared_ptr<py::object> heldInAnyThread(const py::object& function) {
  loadNumpy();
  return {new py::object(function), [](py::object* object) {
            const py::gil_scoped_acquire lock;
            delete object;
          }};
}

/// "the function swirl of texture". The caller must hold the interpreter's lock.
std::string titleOf(const py::object& function, const char* option) {
  const py::object name = py::getattr(function, "__name__", py::none());
  return "the function " + (py::isinstance<py::str>(name) ? name.cast<std::string>() + " " : std::string()) + "of " +
         option;
}

/// The real numbers of an array that a function returned. @throw std::invalid_argument
std::vector<double> numbersReturned(const py::array& given, const std::string& title) {
  if (const char kind = given.dtype().kind(); kind != 'f' && kind != 'i' && kind != 'u')
    throw std::invalid_argument(title + " must return real numbers");
  const py::array_t<double, py::array::c_style | py::array::forcecast> numbers(given);
  return {numbers.data(), numbers.data() + numbers.size()};
}

std::vector<double> directionsFrom(const py::object& function, std::span<const Vec3d> points) {
  const py::gil_scoped_acquire lock;
  const auto count = static_cast<py::ssize_t>(points.size());
  py::array_t<double> at({count, py::ssize_t{3}});
  std::copy_n(points.data()->asPointer(), 3 * points.size(), at.mutable_data());
  const std::string title = titleOf(function, "texture");
  const py::array given = arrayOf(function(at), ("what " + title + " returns").c_str());
  if (given.ndim() != 2 || given.shape(0) != count || (given.shape(1) != 3 && given.shape(1) != 4))
    throw std::invalid_argument(title + " was given " + std::to_string(count) +
                                " points and returned an array of the shape " + shapeText(given) +
                                "; it must be (n, 3) or (n, 4), one row a point");
  std::vector<double> values = numbersReturned(given, title);
  const auto broken = std::find_if(values.begin(), values.end(), [](double x) { return !std::isfinite(x); });
  if (broken != values.end()) {
    const auto components = static_cast<std::size_t>(given.shape(1));
    const std::size_t row = static_cast<std::size_t>(broken - values.begin()) / components;
    throw std::invalid_argument(title + " returned " + tupleText(&values[row * components], components) +
                                " at the point " + tupleText(points[row].asPointer(), 3) +
                                "; directions must be finite");
  }
  return values;
}

std::vector<double> iteratesFrom(const py::object& function, std::span<const double> iterates,
                                 std::span<const double> starts) {
  const py::gil_scoped_acquire lock;
  const auto count = static_cast<py::ssize_t>(iterates.size() / 4);
  py::array_t<double> q({count, py::ssize_t{4}}), c({count, py::ssize_t{4}});
  std::copy(iterates.begin(), iterates.end(), q.mutable_data());
  std::copy(starts.begin(), starts.end(), c.mutable_data());
  const std::string title = titleOf(function, "map");
  const py::array given = arrayOf(function(q, c), ("what " + title + " returns").c_str());
  if (given.ndim() != 2 || given.shape(0) != count || given.shape(1) != 4)
    throw std::invalid_argument(title + " was given " + std::to_string(count) +
                                " iterates and returned an array of the shape " + shapeText(given) +
                                "; it must be (n, 4), one row an iterate");
  return numbersReturned(given, title);
}

}  // namespace

vdbtools::VersorFunction versorOf(const py::object& function) {
  if (function.is_none()) return {};
  return [held = heldInAnyThread(function)](std::span<const Vec3d> points) { return directionsFrom(*held, points); };
}

MapFunction mapOf(const py::object& function) {
  if (function.is_none()) return {};
  return [held = heldInAnyThread(function)](std::span<const double> iterates, std::span<const double> starts) {
    return iteratesFrom(*held, iterates, starts);
  };
}
