// SPDX-License-Identifier: Apache-2.0
#include "arrays.h"

#include "vdbtools/base/text.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace py = pybind11;

std::string shapeText(const py::array& array) { return py::str(array.attr("shape")).cast<std::string>(); }

std::string tupleText(const double* numbers, std::size_t count) {
  std::string text;
  for (std::size_t i = 0; i < count; ++i) text += (i == 0 ? "(" : ", ") + vdbtools::shortText(numbers[i]);
  return text + ")";
}

py::array arrayOf(const py::object& values, const char* what) {
  py::array array = py::array::ensure(values);
  if (!array) throw std::invalid_argument(std::string(what) + " must be an array of numbers");
  return array;
}

void requireTriples(const py::array& array, const char* what) {
  if (array.ndim() != 2 || array.shape(1) != 3)
    throw std::invalid_argument(std::string(what) + " must be an array of the shape (n, 3); it is " + shapeText(array));
}

py::array_t<double> doublesOf(const py::array& array, const char* what) {
  const char kind = array.dtype().kind();
  if (kind != 'f' && kind != 'i' && kind != 'u')
    throw std::invalid_argument(std::string(what) + " must hold real numbers");
  return py::array_t<double, py::array::c_style | py::array::forcecast>(array);
}

py::array_t<double> triplesOf(const py::array& array, const char* what) {
  requireTriples(array, what);
  return doublesOf(array, what);
}

std::span<const openvdb::Vec3d> spanOf(const py::array_t<double>& triples) {
  static_assert(sizeof(openvdb::Vec3d) == 3 * sizeof(double));
  return {reinterpret_cast<const openvdb::Vec3d*>(triples.data()), static_cast<std::size_t>(triples.size() / 3)};
}

std::span<const openvdb::Vec3d> Places::points() const { return spanOf(array); }

std::vector<py::ssize_t> Places::shapeWith(std::initializer_list<py::ssize_t> axes) const {
  std::vector<py::ssize_t> all = shape;
  all.insert(all.end(), axes);
  return all;
}

Places placesOf(const py::object& values, const char* what) {
  const py::array given = arrayOf(values, what);
  if (given.ndim() < 1 || given.shape(given.ndim() - 1) != 3)
    throw std::invalid_argument(std::string(what) + " must be an array of the shape (..., 3), one row of three for " +
                                "each point; it is " + shapeText(given));
  Places places{doublesOf(given, what), {given.shape(), given.shape() + given.ndim() - 1}};
  const std::span<const openvdb::Vec3d> points = places.points();
  const auto broken = std::find_if(points.begin(), points.end(), [](const auto& point) { return !point.isFinite(); });
  if (broken == points.end()) return places;
  // The place of the point in the array.
  std::string indices;
  auto rest = static_cast<py::ssize_t>(broken - points.begin());
  for (std::size_t axis = places.shape.size(); axis-- > 0;) {
    indices = std::to_string(rest % places.shape[axis]) + (indices.empty() ? "" : ", ") + indices;
    rest /= places.shape[axis];
  }
  throw std::invalid_argument(std::string(what) + (indices.empty() ? "" : "[" + indices + "]") + " is " +
                              tupleText(broken->asPointer(), 3) + "; coordinates must be finite");
}
