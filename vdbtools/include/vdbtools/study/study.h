// SPDX-License-Identifier: Apache-2.0
/// @file study.h
/// The room `study` measures fractals as [SK23] does: likelihoods, circles, dimensions. It uses the rooms up to `job`.
///
/// This header measures what a target alone decides about its fractals, whatever the versor ([SK23] 3.3.1, Fig. 8): the
/// likelihood that a point lies in the set, counted over many random versors, and the target's distance on circles
/// about the origin of the dynamics. Where alpha (phi - beta) is low or high enough, the target decides; in between,
/// the versor does.
#pragma once

#include "vdbtools/base/monitor.h"
#include "vdbtools/job/fractal_job.h"
#include "vdbtools/mesh/mesh.h"
#include "vdbtools/mesh/mesh_sink.h"
#include "vdbtools/picture/image.h"
#include "vdbtools/picture/plot.h"
#include "vdbtools/picture/slice_image.h"
#include "vdbtools/scene/fractal_options.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace vdbtools {

/// The options of `juliavdb study` that affect its result: those options of `juliavdb fractal` that describe the sets
/// of a target and random versors.
OptionTable studyOptionTable();

inline constexpr int kMostVersors = 1'000'000;

struct StudyOptions {
  int versors = 1000;    ///< how many, 1 to kMostVersors
  bool circles = false;  ///< whether the circles are wanted
};

/// A circle in the plane, about the origin of the dynamics or its foot on the plane.
struct StudyCircle {
  double radius = 0;                         ///< world units
  double mean = 0, least = 0, greatest = 0;  ///< phi over the circle, world units
  double sphereMean = 0;                     ///< mean of phi over the sphere of that radius about the origin itself
  double membership = 0;  ///< the share of the circle that lies in the set, averaged over the versors
};

struct Study {
  int versors = 0;
  std::vector<int> inside;  ///< for each pixel, row by row: how many of the sets hold it
  std::vector<StudyCircle> circles;
  /// Between these values (world units) phi leaves the membership of a point open. The lower one is -inf if phi alone
  /// never puts a point inside. There is no range if alpha or beta varies, or with one iteration, which leaves nothing
  /// open.
  std::optional<std::pair<double, double>> undecided;
  bool originInside = false;  ///< whether phi < 0 at the dynamics' origin
};

/// The directions of a grain as a mesh to look at.
struct GrainStrokes {
  /// The target's mesh, if it is one; a small triangle for each point, whose tip shows the direction; and red octahedra
  /// where there is none.
  Mesh mesh;
  std::vector<VertexColumn> columns;  ///< colours by the local thickness, and the direction as the vector "grain"
  std::vector<float> values;          ///< of the columns, row by row
  std::size_t points = 0;
  std::size_t singular = 0;  ///< places about which the direction turns as a whole
  /// The share of the points where the waves along the grain are as long as is wanted, within a factor of 1.5; and
  /// across it.
  std::pair<double, double> inStep;
  std::pair<double, double> thickness;  ///< the least and the greatest over the points, world units
};

/// Draws the grain of a fractal on its target.
/// @throw std::invalid_argument  the options have no grain
/// @throw DataError, Interrupted
GrainStrokes grainStrokes(const FractalOptions& options, Monitor& monitor);

/// Counts over the versors of the seeds S, S + 1 and so on, where S is the seed in the options of the scene: the k-th
/// set is what makeScene() evaluates with the seed S + k. The circles reach from the origin to the farthest pixel of
/// the plane. The result is the same for any number of threads.
/// @throw std::invalid_argument  as VersorSeeds; a number of versors out of its range or past the last seed
/// @throw DataError, Interrupted
Study runStudy(const Scene& scene, const SlicePlane& plane, const StudyOptions& options, Monitor& monitor);

/// Black where all of the sets hold the pixel, white where none does.
Image studyImage(const SlicePlane& plane, const Study& study);

/// The circles as CSV, with a line of names.
std::string studyCsv(const Study& study);

/// phi against the radius, with the undecided range shaded.
Plot studyPlot(const Study& study);

// How the mesh of a fractal grows with its resolution N: triangles = c N^D. D is the slope of log(triangles) over log
// N, and an estimate of the fractal dimension of the surface, as in [KD20], who found 2.1868 for theirs. A smooth
// surface has 2. After a finite number of iterations, every surface is smooth at small scales: where the voxels are
// smaller than its finest detail, the slope falls back to 2. D therefore belongs to the range of N over which it was
// measured.

/// The range of the resolutions over which a dimension is measured, and their minimum number.
inline constexpr int kLeastGrowthResolution = 8, kMostGrowthResolution = 1'000'000;
inline constexpr std::size_t kLeastGrowthRows = 3;

/// The mesh of a fractal at one resolution.
struct GrowthRow {
  int resolution = 0;  ///< voxels along the longest side, as in the option
  std::uint64_t triangles = 0, points = 0, evaluatedNodes = 0;
};

/// Makes the mesh at each of these resolutions, and counts and discards it. The distances of the target stay those that
/// @a options ask for.
/// @throw what makeScene() and runFractal() throw
std::vector<GrowthRow> measureGrowth(FractalOptions options, std::span<const int> resolutions, Monitor& monitor);

/// y = factor x^exponent, fitted by least squares of the logarithms.
struct PowerLaw {
  double factor = 0, exponent = 0;
  double standardError = 0;  ///< of the exponent
  /// The 95 % interval of the exponent, by Student's t with two degrees of freedom less than there are points.
  std::pair<double, double> interval{0, 0};
};

/// @throw std::invalid_argument  fewer than three points, a number that is not above 0, or the same x for all points
PowerLaw fitPowerLaw(std::span<const std::pair<double, double>> points);

/// The power law of the number of triangles over the resolution.
PowerLaw growthLaw(std::span<const GrowthRow> rows);

}  // namespace vdbtools
