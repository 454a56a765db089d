// SPDX-License-Identifier: Apache-2.0
#include "queries.h"

#include "device_use.h"
#include "patient_lock.h"
#include "thread_limit.h"

#include "vdbtools/control/control.h"

#include "julia/elementary.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>
#include <vector>

using openvdb::Vec3d;
using vdbtools::Monitor;

namespace {

/// Calls body(first, count) for pieces of this many points.
template <class Body>
void forEachPiece(std::size_t points, std::size_t piece, const QueryWork& work, Monitor& monitor, const Body& body) {
  monitor.begin(vdbtools::PhaseKind::Evaluating, points);
  const std::size_t pieces = (points + piece - 1) / piece;
  inThreads(work.threads, [&] {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, pieces, 1), [&](const auto& range) {
      for (std::size_t i = range.begin(); i < range.end() && !monitor.cancelled(); ++i) {
        const std::size_t first = i * piece, count = std::min(piece, points - first);
        body(first, count);
        monitor.advance(count);
      }
    });
  });
  monitor.throwIfCancelled();
}

std::vector<julia::Point> fractalPoints(const MadeScene& made, std::span<const Vec3d> points) {
  // Not the space of the lattice, which is shifted for some maps.
  const vdbtools::FractalSpace& space = made.scene.placed.space;
  std::vector<julia::Point> at;
  at.reserve(points.size());
  for (const Vec3d& point : points) at.push_back(space.toFractal(point));
  return at;
}

void requireTargetOf(const MadeScene& made, const char* what) {
  if (!made.scene.target)
    throw std::invalid_argument(std::string("the field has no target, and so no ") + what +
                                "; give a target, or ask for something else");
}

/// Reads a control at points of world space.
void sampleControl(const vdbtools::Control& control, std::span<const Vec3d> points, std::span<double> values,
                   const QueryWork& work, Monitor& monitor) {
  constexpr std::size_t kPieceOfControl = 4096;
  forEachPiece(points.size(), kPieceOfControl, work, monitor, [&](std::size_t first, std::size_t count) {
    control.sample(points.subspan(first, count), values.subspan(first, count));
  });
}

/// Calls body for pieces of the points, for evaluations that cost as much as F.
template <class Body>
void forEachBatch(const MadeScene& made, const julia::FieldEvaluator& evaluator, std::span<const Vec3d> points,
                  const QueryWork& work, Monitor& monitor, const Body& body) {
  forEachPiece(points.size(), evaluator.preferredBatch(), work, monitor, [&](std::size_t first, std::size_t count) {
    body(fractalPoints(made, points.subspan(first, count)), first, count);
  });
}

/// Returns a part of a field, which the first thread that needs it makes by make().
/// @param place  (parts): returns where the part is stored
template <class Place, class Make>
const auto& partOf(const MadeScene& made, const Monitor& monitor, const Place& place, const Make& make) {
  const auto lock = lockPatiently(made.parts.mutex, monitor);
  auto& part = place(made.parts);
  if (!part) part = make();
  return *part;
}

const julia::FieldEvaluator& evaluatorFor(const MadeScene& made, const std::string& device, const Monitor& monitor) {
  if (device.empty()) return *made.scene.field.evaluator;
  return partOf(
      made, monitor, [&](FieldParts & parts) -> auto& { return parts.evaluators[device]; },
      [&] { return evaluatorOn(made.scene, device); });
}

}  // namespace

void evaluateAt(const MadeScene& made, std::span<const Vec3d> points, std::span<double> field, const QueryWork& work,
                Monitor& monitor) {
  const julia::FieldEvaluator& evaluator = evaluatorFor(made, work.device, monitor);
  forEachBatch(made, evaluator, points, work, monitor, [&](const auto& at, std::size_t first, std::size_t count) {
    evaluator.evaluate(at, field.subspan(first, count), {});
  });
}

void distancesAt(const MadeScene& made, std::span<const Vec3d> points, std::span<double> distances,
                 const QueryWork& work, Monitor& monitor) {
  requireTargetOf(made, "distance");
  const vdbtools::Control& control = partOf(
      made, monitor, [](FieldParts & parts) -> auto& { return parts.distance; },
      [&] { return vdbtools::distanceControl(made.scene.target->distances); });
  sampleControl(control, points, distances, work, monitor);
}

void thicknessAt(const MadeScene& made, std::span<const Vec3d> points, std::span<double> thickness,
                 const QueryWork& work, Monitor& monitor) {
  requireTargetOf(made, "thickness");
  const vdbtools::Control& control = partOf(
      made, monitor, [](FieldParts & parts) -> auto& { return parts.thickness; },
      [&] {
        openvdb::FloatGrid::ConstPtr tau = made.scene.target->thickness;
        if (!tau) {
          vdbtools::FractalOptions options = made.options;
          options.output.attributes.computed.push_back(vdbtools::PointAttribute::Tau);
          const auto scenes = lockPatiently(made.pictureMutex, monitor);
          tau = made.scenes.make(options, monitor).target.value().thickness;
        }
        return vdbtools::clampedControl(tau);
      });
  sampleControl(control, points, thickness, work, monitor);
}

void fullThicknessAt(const MadeScene& made, std::span<const Vec3d> points, std::span<double> thickness,
                     const QueryWork& work, Monitor& monitor) {
  requireTargetOf(made, "thickness");
  const vdbtools::Control& control = partOf(
      made, monitor, [](FieldParts & parts) -> auto& { return parts.fullThickness; },
      [&] {
        const auto scenes = lockPatiently(made.pictureMutex, monitor);
        return vdbtools::clampedControl(made.scenes.thickness(made.options, vdbtools::kThicknessSlope, monitor).tau);
      });
  sampleControl(control, points, thickness, work, monitor);
}

void octavesAt(const MadeScene& made, std::span<const Vec3d> points, std::span<double> octaves, const QueryWork& work,
               Monitor& monitor) {
  requireTargetOf(made, "octave");
  if (!made.scene.target->octave)
    throw std::invalid_argument(
        "the texture of this field has one frequency everywhere, and so no octave; choose a texture that follows the "
        "thickness, such as texture='scales'");
  const vdbtools::Control& control = partOf(
      made, monitor, [](FieldParts & parts) -> auto& { return parts.octave; },
      [&] { return vdbtools::clampedControl(made.scene.target->octave->grid); });
  sampleControl(control, points, octaves, work, monitor);
}

void exponentsAt(const MadeScene& made, std::span<const Vec3d> points, std::span<double> exponents,
                 const QueryWork& work, Monitor& monitor) {
  const vdbtools::ExponentGrid* const exponent = made.scene.exponent();
  if (!exponent)
    throw std::invalid_argument("the map is '" + made.recipe.at("map") +
                                "', and only the shape modulus of a target has an exponent; give a target and no other "
                                "map, or ask for something else");
  const julia::ScalarField<double>& field = partOf(
      made, monitor, [](FieldParts & parts) -> auto& { return parts.exponent; },
      [&] { return vdbtools::makeExponentField<double>(*exponent); });
  constexpr std::size_t kPieceOfExponent = 2048;
  forEachPiece(points.size(), kPieceOfExponent, work, monitor, [&](std::size_t first, std::size_t count) {
    const std::vector<julia::Point> at = fractalPoints(made, points.subspan(first, count));
    std::vector<double> axes[3];
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (const julia::Point& point : at) axes[axis].push_back(point[axis]);
    field.sample(axes[0], axes[1], axes[2], exponents.subspan(first, count));
  });
}

void versorsAt(const MadeScene& made, std::span<const Vec3d> points, std::span<julia::Quaternion<double>> versors,
               const QueryWork& work, Monitor& monitor) {
  const julia::FieldEvaluator& evaluator = *made.scene.field.evaluator;
  forEachBatch(made, evaluator, points, work, monitor, [&](const auto& at, std::size_t first, std::size_t count) {
    evaluator.versors(at, versors.subspan(first, count));
  });
}

void trapsAt(const MadeScene& made, std::span<const Vec3d> points, std::span<double> traps, const QueryWork& work,
             Monitor& monitor) {
  const julia::FieldEvaluator& evaluator = *made.scene.field.evaluator;
  forEachBatch(made, evaluator, points, work, monitor, [&](const auto& at, std::size_t first, std::size_t count) {
    const std::span<double> values = traps.subspan(first, count);
    evaluator.orbitTraps(at, values);
    for (double& value : values)
      value = value >= julia::kFieldLimit ? std::numeric_limits<double>::infinity() : julia::elementary::exp(value);
  });
}

void gradientsAt(const MadeScene& made, std::span<const Vec3d> points, double step, std::span<Vec3d> gradients,
                 const QueryWork& work, Monitor& monitor) {
  constexpr double kShare = 1e-7;
  const julia::FieldEvaluator& evaluator = partOf(
      made, monitor, [](FieldParts & parts) -> auto& { return parts.inDoubles; },
      [&] { return made.scene.field.map->evaluator(vdbtools::Arithmetic::Double, made.scene.field.orbit); });
  const double scale = made.scene.placed.space.scale;
  const double reach = step > 0 ? step / scale : kShare;
  constexpr std::size_t kStencil = 7;  // the point, and two along each axis
  forEachBatch(made, evaluator, points, work, monitor, [&](const auto& at, std::size_t first, std::size_t count) {
    std::vector<julia::Point> all;
    all.reserve(kStencil * count);
    for (const julia::Point& point : at) {
      all.push_back(point);
      for (std::size_t axis = 0; axis < 3; ++axis)
        for (const double side : {-reach, reach}) {
          all.push_back(point);
          all.back()[axis] += side;
        }
    }
    std::vector<double> field(all.size());
    std::vector<int> steps(all.size());
    evaluator.evaluate(all, field, steps);
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t start = i * kStencil;
      bool smooth = true;
      for (std::size_t k = 0; k < kStencil; ++k)
        smooth = smooth && steps[start + k] == steps[start] && std::abs(field[start + k]) < julia::kFieldLimit;
      for (int axis = 0; axis < 3; ++axis) {
        const std::size_t low = start + 1 + 2 * static_cast<std::size_t>(axis);
        // The actual distance of the two points, which differs by rounding.
        const double across = all[low + 1][static_cast<std::size_t>(axis)] - all[low][static_cast<std::size_t>(axis)];
        gradients[first + i][axis] = smooth && across > 0 ? (field[low + 1] - field[low]) / (across * scale)
                                                          : std::numeric_limits<double>::quiet_NaN();
      }
    }
  });
}

void decideAt(const MadeScene& made, std::span<const Vec3d> centres, std::span<const double> radii,
              std::span<std::int8_t> decisions, const QueryWork& work, Monitor& monitor) {
  const julia::FieldEvaluator& evaluator = *made.scene.field.evaluator;
  const double scale = made.scene.placed.space.scale;
  // Points of the ball are rounded on their way into fractal space.
  constexpr double kRounding = 8 * std::numeric_limits<double>::epsilon();
  const auto radiusAt = [&](std::size_t ball) { return radii.size() == 1 ? radii[0] : radii[ball]; };
  forEachBatch(made, evaluator, centres, work, monitor, [&](const auto& at, std::size_t first, std::size_t count) {
    std::vector<julia::Decision> decided(count);
    for (std::size_t begin = 0; begin < count;) {
      std::size_t end = begin + 1;
      while (end < count && radiusAt(first + end) == radiusAt(first + begin)) ++end;
      const double radius = radiusAt(first + begin);
      double farthest = 0;
      for (std::size_t i = begin; i < end; ++i)
        for (int axis = 0; axis < 3; ++axis)
          farthest =
              std::max(farthest, std::abs(centres[first + i][axis]) + std::abs(made.scene.placed.space.centre[axis]));
      evaluator.decide(std::span(at).subspan(begin, end - begin),
                       radius / scale * (1 + kRounding) + kRounding * (farthest + radius) / scale,
                       std::span(decided).subspan(begin, end - begin));
      begin = end;
    }
    for (std::size_t i = 0; i < count; ++i)
      decisions[first + i] = static_cast<std::int8_t>(decided[i] == julia::Decision::Inside    ? -1
                                                      : decided[i] == julia::Decision::Outside ? 1
                                                                                               : 0);
  });
}

void orbitsAt(const MadeScene& made, std::span<const Vec3d> points, const julia::OrbitTrace& trace,
              const QueryWork& work, Monitor& monitor) {
  const julia::FieldEvaluator& evaluator = *made.scene.field.evaluator;
  const auto row = static_cast<std::size_t>(made.scene.field.orbit.maxIterations) + 1;
  forEachBatch(made, evaluator, points, work, monitor, [&](const auto& at, std::size_t first, std::size_t count) {
    julia::traceOrbits(
        evaluator, at,
        {trace.iterates.subspan(first * row, count * row), trace.logModuli.subspan(first * row, count * row),
         trace.steps.subspan(first, count), trace.ends.subspan(first, count)});
  });
}
