// SPDX-License-Identifier: Apache-2.0
// A map of one's own behind the seam: here q^3 + c, meshed like the built-in ones.
#include "vdbtools/surface/extract_mesh.h"

#include "julia/log_polar.h"

#include <iostream>

namespace {

class CubicMap final : public julia::Map<double> {
 public:
  explicit CubicMap(const julia::Quaternion<double>& c) : mC(c) {}

  void logModulus(const julia::QuaternionBatch<double>& q, std::span<double> l) const override {
    for (std::size_t i = 0; i < q.size(); ++i) l[i] = julia::logNorm(value(q.get(i)));
  }
  void versor(const julia::QuaternionBatch<double>& q, julia::QuaternionBatch<double>& u) const override {
    u.resize(q.size());
    for (std::size_t i = 0; i < q.size(); ++i) u.set(i, julia::versorOf(value(q.get(i))));
  }
  // Bounded orbits go anywhere below the escape radius, so that is where the surface lies.
  double surfaceLevel(double logEscape) const override { return logEscape; }

 private:
  julia::Quaternion<double> value(const julia::Quaternion<double>& q) const { return q * q * q + mC; }
  julia::Quaternion<double> mC;
};

}  // namespace

int main() {
  using namespace vdbtools;
  openvdb::initialize();
  Monitor monitor;
  const auto map = std::make_shared<CubicMap>(julia::Quaternion<double>{-0.2, 0.6, 0.1, 0.1});
  const auto evaluator = julia::makeFieldEvaluator<double>(map, {}, {.maxIterations = 8});
  const FieldSource source{*evaluator, {}};
  const FractalField field = fractalFieldEverywhere(
      source, {.voxelSize = 0.05, .box = openvdb::BBoxd(openvdb::Vec3d(-1.6), openvdb::Vec3d(1.6))}, monitor);
  const Mesh mesh = extractMesh(field, source, {}, monitor);
  std::cout << mesh.triangles.size() << " triangles\n";
  return mesh.triangles.empty();
}
