// SPDX-License-Identifier: Apache-2.0
/// @file vertex_column.h
/// Data at the points of meshes other than positions and normals: colours, vectors, numbers, texture coordinates.
#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace vdbtools {

enum class ColumnKind {
  Number,
  Vector,             ///< three components
  LinearRgb,          ///< a colour: three components, with the primaries of sRGB; 0 to 1
  TextureCoordinate,  ///< two components
};

/// A column of a table whose rows are the points. Its values are floats, as many as it has components.
struct VertexColumn {
  std::string name;
  ColumnKind kind = ColumnKind::Number;
};

constexpr std::size_t componentsOf(ColumnKind kind) {
  switch (kind) {
    case ColumnKind::Number: return 1;
    case ColumnKind::TextureCoordinate: return 2;
    case ColumnKind::Vector:
    case ColumnKind::LinearRgb: return 3;
  }
  return 0;
}

/// The number of floats per row.
inline std::size_t rowLength(std::span<const VertexColumn> columns) {
  std::size_t length = 0;
  for (const VertexColumn& column : columns) length += componentsOf(column.kind);
  return length;
}

}  // namespace vdbtools
