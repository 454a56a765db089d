// SPDX-License-Identifier: Apache-2.0
/// @file arrays.h
/// Arrays of numpy as the library reads them: their shapes and kinds are checked here, with one clear exception.
#pragma once

#include <openvdb/Types.h>

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

/// "(3, 4)"
std::string shapeText(const pybind11::array& array);

/// "(1, 0.5, nan)"
std::string tupleText(const double* numbers, std::size_t count);

/// An array of anything from which numpy makes one. @throw std::invalid_argument
pybind11::array arrayOf(const pybind11::object& values, const char* what);

/// @throw std::invalid_argument  the shape is not (n, 3)
void requireTriples(const pybind11::array& array, const char* what);

/// Converts to doubles in C order, without a copy if they are stored like that already.
/// @throw std::invalid_argument  they are not real numbers
pybind11::array_t<double> doublesOf(const pybind11::array& array, const char* what);

/// The same for an array of shape (n, 3). @throw std::invalid_argument
pybind11::array_t<double> triplesOf(const pybind11::array& array, const char* what);

/// @pre the array has rows of three
std::span<const openvdb::Vec3d> spanOf(const pybind11::array_t<double>& triples);

/// Points in an array of any shape (..., 3).
struct Places {
  pybind11::array_t<double> array;
  std::vector<pybind11::ssize_t> shape;  ///< without the last axis

  std::span<const openvdb::Vec3d> points() const;
  /// The shape of a result that has these axes at each point.
  std::vector<pybind11::ssize_t> shapeWith(std::initializer_list<pybind11::ssize_t> axes) const;
};

/// @throw std::invalid_argument  another shape, numbers that are not real, or a coordinate that is not finite
Places placesOf(const pybind11::object& values, const char* what);

/// The memory of an array that was made for a result.
template <class T>
std::span<T> memoryOf(pybind11::array_t<T>& array) {
  return {array.mutable_data(), static_cast<std::size_t>(array.size())};
}

/// An array that takes over the memory of a vector.
template <class T>
pybind11::array_t<T> arrayTaking(std::vector<T>&& values, const std::vector<pybind11::ssize_t>& shape) {
  auto held = std::make_unique<std::vector<T>>(std::move(values));
  const T* const first = held->data();
  const pybind11::capsule owner(held.release(), [](void* kept) { delete static_cast<std::vector<T>*>(kept); });
  return pybind11::array_t<T>(shape, first, owner);
}
