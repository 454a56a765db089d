// SPDX-License-Identifier: Apache-2.0
#include "formats/vdb_transform.h"

#include "base/lattice_transform.h"
#include "vdbtools/files/file_bytes.h"

#include <array>
#include <cmath>

namespace vdbtools {
namespace {

using Vector = std::array<double, 3>;

double finiteNumber(VdbCursor& cursor) {
  const auto number = cursor.number<double>();
  if (!std::isfinite(number)) cursor.refuse("has a transform with a number that is not finite");
  return number;
}

Vector vector(VdbCursor& cursor) {
  Vector v;
  for (double& number : v) number = finiteNumber(cursor);
  return v;
}

/// Reads the scale, the voxel size, and what OpenVDB derives from them.
void scale(VdbCursor& cursor, bool uniform, bool mayBeTiny) {
  const Vector by = vector(cursor), voxel = vector(cursor), inverse = vector(cursor), inverseSquare = vector(cursor),
               inverseTwice = vector(cursor);
  const auto near = [](double a, double b) {
    constexpr double kTolerance = 1e-6;
    return std::abs(a - b) <= kTolerance * std::abs(b);
  };
  for (std::size_t i = 0; i < by.size(); ++i) {
    if (by[i] == 0) cursor.refuse("has a transform with a scale of 0");
    if (!near(voxel[i], std::abs(by[i])) || !near(inverse[i], 1 / by[i]) ||
        !near(inverseSquare[i], 1 / by[i] / by[i]) || !near(inverseTwice[i], 0.5 / by[i]) ||
        (uniform && by[i] != by[0]))
      cursor.refuse("has a transform whose numbers contradict each other");
  }
  // OpenVDB reads such a scale, but copies it only if it is uniform and nothing is added to it.
  if (!mayBeTiny && !isOrdinaryScale({by[0], by[1], by[2]}))
    cursor.refuse("has a transform with voxels that are too small for OpenVDB");
}

/// OpenVDB multiplies row vectors, so the last column must be that of the identity matrix.
void affineMatrix(VdbCursor& cursor) {
  double m[4][4];
  for (auto& row : m)
    for (double& number : row) number = finiteNumber(cursor);
  if (m[0][3] != 0 || m[1][3] != 0 || m[2][3] != 0 || m[3][3] != 1) cursor.refuse("has a transform that is not affine");
  const double determinant = m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
                             m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
                             m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
  if (determinant == 0 || !std::isfinite(determinant)) cursor.refuse("has a transform that has no inverse");
}

void linearMap(VdbCursor& cursor, std::string_view type) {
  if (type == "AffineMap" || type == "UnitaryMap") {
    affineMatrix(cursor);
  } else if (type == "ScaleMap" || type == "UniformScaleMap") {
    const bool uniform = type == "UniformScaleMap";
    scale(cursor, uniform, /*mayBeTiny=*/uniform);
  } else if (type == "TranslationMap") {
    vector(cursor);
  } else if (type == "ScaleTranslateMap" || type == "UniformScaleTranslateMap") {
    vector(cursor);
    scale(cursor, type == "UniformScaleTranslateMap", /*mayBeTiny=*/false);
  } else {
    cursor.refuse("has a transform of a type that is not known, '" + inOneLine(type) + "'");
  }
}

}  // namespace

void walkOverVdbTransform(VdbCursor& cursor) {
  const std::string_view type = cursor.text();
  if (type != "NonlinearFrustumMap") return linearMap(cursor, type);
  const Vector low = vector(cursor), high = vector(cursor);
  const double taper = finiteNumber(cursor), depth = finiteNumber(cursor);
  for (std::size_t i = 0; i < low.size(); ++i)
    if (!(low[i] < high[i])) cursor.refuse("has a transform with an empty frustum");
  if (taper == 0 || depth == 0) cursor.refuse("has a transform with an empty frustum");
  linearMap(cursor, cursor.text());
}

}  // namespace vdbtools
