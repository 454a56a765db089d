// SPDX-License-Identifier: Apache-2.0
// The main job through the library: any signed distance field becomes a fractal level set and a mesh.
#include "vdbtools/distance/target.h"
#include "vdbtools/exponent/exponent_grid.h"
#include "vdbtools/surface/extract_mesh.h"
#include "vdbtools/surface/level_set.h"

#include "julia/random_roots.h"
#include "julia/shape_modulus.h"

#include <openvdb/tools/LevelSetSphere.h>

#include <iostream>
#include <limits>

int main() {
  using namespace vdbtools;
  openvdb::initialize();
  Monitor monitor;

  // The target: a ball of radius 5, in voxels of 0.2, with a narrow band of 3.
  const auto phi = openvdb::tools::createLevelSetSphere<openvdb::FloatGrid>(5, openvdb::Vec3f(0), 0.2f);
  Target target = makeTarget(phi, std::nullopt);
  const FractalSpace space = fitFractalSpace(*target.phi, target.box);

  // Its exponent, in a band as wide as the shell needs.
  const ExponentGridOptions shell{.alpha = 30.0, .beta = 0.0};
  extendBand(target, space.scale * exteriorReach(shell), std::numeric_limits<double>::infinity(), monitor);
  const ExponentGrid exponent = exponentGrid(target, space, shell, monitor);

  // The map: that exponent, and the direction of a random polynomial.
  const julia::Rational versor{.top = julia::randomPolynomial({.seed = 3, .count = 8})};
  const auto map =
      std::make_shared<julia::ShapeModulus<double>>(makeExponentField<double>(exponent), versor, julia::DropAxis::K);
  const auto evaluator = julia::makeFieldEvaluator<double>(map, {}, exponent.orbit);

  const FieldSource source{*evaluator, space};
  const FractalField field = fractalField(source, exponent, {.voxelSize = 0.2}, monitor);
  const Mesh mesh = extractMesh(field, source, {}, monitor);
  const auto surface = levelSet(field, mesh, monitor);
  std::cout << mesh.triangles.size() << " triangles, " << surface->activeVoxelCount() << " voxels\n";
  return mesh.triangles.empty() || !checkSurface(*surface).failure.empty();
}
