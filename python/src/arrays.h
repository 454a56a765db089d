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

/// Whatever numpy makes an array of. @throw std::invalid_argument
pybind11::array arrayOf(const pybind11::object& values, const char* what);

/// @throw std::invalid_argument  it is no (n, 3)
void requireTriples(const pybind11::array& array, const char* what);

/// Doubles in the order of C, without a copy where they are that already.
/// @throw std::invalid_argument  they are no real numbers
pybind11::array_t<double> doublesOf(const pybind11::array& array, const char* what);

/// The same of an (n, 3). @throw std::invalid_argument
pybind11::array_t<double> triplesOf(const pybind11::array& array, const char* what);

/// @pre rows of three
std::span<const openvdb::Vec3d> spanOf(const pybind11::array_t<double>& triples);

/// Points in an array of any shape (..., 3).
struct Places {
  pybind11::array_t<double> array;
  std::vector<pybind11::ssize_t> shape;  ///< without the last axis

  std::span<const openvdb::Vec3d> points() const;
  /// Of a result that has these axes at each point.
  std::vector<pybind11::ssize_t> shapeWith(std::initializer_list<pybind11::ssize_t> axes) const;
};

/// @throw std::invalid_argument  another shape, no real numbers, a coordinate that is not finite
Places placesOf(const pybind11::object& values, const char* what);

/// The memory of an array that was made for a result.
template <class T>
std::span<T> memoryOf(pybind11::array_t<T>& array) {
  return {array.mutable_data(), static_cast<std::size_t>(array.size())};
}

/// An array over a vector, which it takes and keeps.
template <class T>
pybind11::array_t<T> arrayTaking(std::vector<T>&& values, const std::vector<pybind11::ssize_t>& shape) {
  auto held = std::make_unique<std::vector<T>>(std::move(values));
  const T* const first = held->data();
  const pybind11::capsule owner(held.release(), [](void* kept) { delete static_cast<std::vector<T>*>(kept); });
  return pybind11::array_t<T>(shape, first, owner);
}
