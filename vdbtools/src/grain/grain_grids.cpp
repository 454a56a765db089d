// SPDX-License-Identifier: Apache-2.0
#include "base/elementary.h"
#include "base/in_parallel.h"
#include "vdbtools/grain/grain.h"

#include <openvdb/tools/Dense.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <stdexcept>

namespace vdbtools {
namespace {

using Complex = std::complex<double>;
using julia::SurfacePhase;
using openvdb::Coord;
using openvdb::CoordBBox;
using openvdb::FloatGrid;
using openvdb::Vec3d;

/// Sums over the points near a node.
struct NodeSums {
  float along[2] = {}, across[2] = {}, depth = 0, weight = 0;
};

/// exp(i x) at equal steps of x.
class PhaseSteps {
 public:
  PhaseSteps(const Complex& start, double perStep)
      : mValue(start), mStep(elementary::cos(perStep), elementary::sin(perStep)) {}
  const Complex& value() const { return mValue; }
  void advance() {
    mValue = {mValue.real() * mStep.real() - mValue.imag() * mStep.imag(),
              mValue.real() * mStep.imag() + mValue.imag() * mStep.real()};
  }

 private:
  Complex mValue, mStep;
};

Complex advanced(const SurfacePhase& phase, const Vec3d& by) {
  const double turn = phase.gradient[0] * by[0] + phase.gradient[1] * by[1] + phase.gradient[2] * by[2];
  return phase.value * Complex(elementary::cos(turn), elementary::sin(turn));
}

constexpr const char* kOctave = "grain_octave";
constexpr const char* kWavelength = "grain_wavelength";

}  // namespace

void setGrainScale(FloatGrid& depth, const GrainScale& scale) {
  depth.insertMeta(kOctave, openvdb::Int32Metadata(scale.octave));
  depth.insertMeta(kWavelength, openvdb::DoubleMetadata(scale.wavelength));
}

GrainScale grainScale(const FloatGrid& depth) {
  const auto octave = depth.getMetadata<openvdb::Int32Metadata>(kOctave);
  const auto wavelength = depth.getMetadata<openvdb::DoubleMetadata>(kWavelength);
  if (!octave || !wavelength) throw std::invalid_argument("a grid of a grain does not say how long its waves are");
  return {octave->value(), wavelength->value()};
}

GrainPhases grainPhases(const GrainSurface& surface, std::span<const Complex> directions,
                        std::span<const double> wavelength, Monitor& monitor) {
  constexpr double kTurn = 6.28318530717958647693;
  const julia::SurfaceGraph& graph = surface.graph;
  std::vector<Complex> along(graph.size()), across(graph.size());
  for (std::size_t i = 0; i < graph.size(); ++i) {
    along[i] = directions[i] * (kTurn / wavelength[i]);
    across[i] = along[i] * Complex(0, 1);
  }
  const auto cancelled = [&] { return monitor.cancelled(); };
  GrainPhases phases;
  phases.along = julia::stripePhases(graph, along, cancelled);
  monitor.throwIfCancelled();
  phases.across = julia::stripePhases(graph, across, cancelled);
  monitor.throwIfCancelled();
  return phases;
}

GrainGrids grainGrids(const GrainSurface& surface, const GrainPhases& phases, std::span<const double> wavelength,
                      double reach, const LocalThickness& thickness, Monitor& monitor) {
  constexpr double kSupport = 2;  // spacings around a point in which it counts
  constexpr double kBeyond = 2;   // voxels
  const julia::SurfaceGraph& graph = surface.graph;
  const FloatGrid& tau = *thickness.tau;
  const double voxel = tau.voxelSize()[0];
  const CoordBBox nodes = tau.evalActiveVoxelBoundingBox();
  const Coord size = nodes.dim();
  const auto rows = static_cast<std::size_t>(size[1]), columns = static_cast<std::size_t>(size[2]);
  std::vector<NodeSums> sums(nodes.volume());
  inParallel(static_cast<std::size_t>(size[0]), 4, monitor, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = 0; i < graph.size(); ++i) {
      const Vec3d middle = tau.worldToIndex(Vec3d(graph.position(i).data())) - nodes.min().asVec3d();
      const Vec3d normal(graph.normal(i).data());
      const double radius = kSupport * graph.spacing(i) / voxel;
      const double height = reach * surface.thickness[i] / voxel + kBeyond;
      // Half the box of a cylinder.
      int low[3], high[3];
      for (int axis = 0; axis < 3; ++axis) {
        const double along1 = std::abs(normal[axis]);
        const double half = height * along1 + radius * std::sqrt(std::max(0., 1 - along1 * along1));
        low[axis] = std::max(0, static_cast<int>(std::ceil(middle[axis] - half)));
        high[axis] = std::min(size[axis] - 1, static_cast<int>(std::floor(middle[axis] + half)));
      }
      low[0] = std::max(low[0], static_cast<int>(begin));
      high[0] = std::min(high[0], static_cast<int>(end) - 1);
      const double radiusSquared = radius * radius, heightSquared = height * height;
      const double perWave = voxel / wavelength[i];
      for (int x = low[0]; x <= high[0]; ++x)
        for (int y = low[1]; y <= high[1]; ++y) {
          const Vec3d first = Vec3d(x, y, low[2]) - middle;
          // Along the row, the squares are quadratic functions; most rows miss the cylinder altogether.
          PhaseSteps u(0, 0), v(0, 0);
          bool begun = false;
          NodeSums* row = &sums[(static_cast<std::size_t>(x) * rows + static_cast<std::size_t>(y)) * columns];
          for (int z = low[2]; z <= high[2]; ++z) {
            const Vec3d way(first[0], first[1], first[2] + (z - low[2]));
            const double up = way.dot(normal), upSquared = up * up;
            const double aside = way.lengthSqr() - upSquared;
            if (upSquared >= heightSquared || aside >= radiusSquared) continue;
            if (!begun) {
              u = PhaseSteps(advanced(phases.along[i], way * voxel), phases.along[i].gradient[2] * voxel);
              v = PhaseSteps(advanced(phases.across[i], way * voxel), phases.across[i].gradient[2] * voxel);
              begun = true;
            } else {
              u.advance();
              v.advance();
            }
            const double near = 1 - aside / radiusSquared, level = 1 - upSquared / heightSquared;
            const double weight = near * near * level * level;
            NodeSums& node = row[z];
            node.along[0] += static_cast<float>(weight * u.value().real());
            node.along[1] += static_cast<float>(weight * u.value().imag());
            node.across[0] += static_cast<float>(weight * v.value().real());
            node.across[1] += static_cast<float>(weight * v.value().imag());
            node.depth += static_cast<float>(weight * up * perWave);
            node.weight += static_cast<float>(weight);
          }
        }
    }
  });
  GrainGrids grids;
  std::vector<float> values(sums.size());
  const auto grid = [&](const auto& read) {
    for (std::size_t i = 0; i < sums.size(); ++i) values[i] = sums[i].weight > 0 ? read(sums[i]) / sums[i].weight : 0;
    FloatGrid::Ptr made = FloatGrid::create(0.0f);
    made->setTransform(tau.transform().copy());
    openvdb::tools::copyFromDense(openvdb::tools::Dense<float>(nodes, values.data()), *made, 0.0f);
    return made;
  };
  grids.alongCosine = grid([](const NodeSums& s) { return s.along[0]; });
  grids.alongSine = grid([](const NodeSums& s) { return s.along[1]; });
  grids.acrossCosine = grid([](const NodeSums& s) { return s.across[0]; });
  grids.acrossSine = grid([](const NodeSums& s) { return s.across[1]; });
  grids.depth = grid([](const NodeSums& s) { return s.depth; });
  return grids;
}

}  // namespace vdbtools
