// SPDX-License-Identifier: Apache-2.0
/// @file study.h
/// What a target alone says of its fractals, whatever the versor ([SK23] 3.3.1, Fig. 8): the likelihood that a point
/// lies in the set, by counting over many random versors, and the target's distance over circles about the dynamics'
/// origin. Where alpha (phi - beta) is low or high enough, it decides; between the two the versor does.
#pragma once

#include "vdbtools/job/fractal_job.h"
#include "vdbtools/picture/image.h"
#include "vdbtools/picture/plot.h"
#include "vdbtools/picture/slice_image.h"

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace vdbtools {

/// The options of `juliavdb study` that affect its result: those of `juliavdb fractal` that describe the sets of a
/// target and random versors.
OptionTable studyOptionTable();

inline constexpr int kMostVersors = 1'000'000;

struct StudyOptions {
  int versors = 1000;    ///< how many, 1 to kMostVersors
  bool circles = false;  ///< whether the circles are wanted
};

/// One circle of the plane, about the dynamics' origin or its foot on the plane.
struct StudyCircle {
  double radius = 0;                         ///< world units
  double mean = 0, least = 0, greatest = 0;  ///< phi over the circle, world units
  double sphereMean = 0;                     ///< phi over the sphere of that radius, about the origin itself
  double membership = 0;                     ///< the share of the circle that lies in the set, mean over the versors
};

struct Study {
  int versors = 0;
  std::vector<int> inside;  ///< of the plane's pixels, row by row: in how many of the sets they lie
  std::vector<StudyCircle> circles;
  /// Between these, world units, phi at a point leaves its membership open; from -inf on if phi alone never puts a
  /// point inside. None if alpha or beta varies, and with one iteration, which leaves nothing open.
  std::optional<std::pair<double, double>> undecided;
  bool originInside = false;  ///< whether phi < 0 at the dynamics' origin
};

/// Counts over the versors of the seeds S, S + 1 and so on, S that of the scene's options: the k-th set is what
/// makeScene() evaluates with --versor-seed S + k. The same result for any number of threads. The circles reach from
/// the origin to the plane's farthest pixel.
/// @throw std::invalid_argument  as VersorSeeds; a number of versors out of its domain or past the last seed
/// @throw DataError, Interrupted
Study runStudy(const Scene& scene, const SlicePlane& plane, const StudyOptions& options, Monitor& monitor);

/// Black where all sets hold the pixel, white where none does.
Image studyImage(const SlicePlane& plane, const Study& study);

/// The circles as CSV, with a line of names.
std::string studyCsv(const Study& study);

/// phi over the radius, with the undecided range shaded.
Plot studyPlot(const Study& study);

}  // namespace vdbtools
