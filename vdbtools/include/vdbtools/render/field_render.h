// SPDX-License-Identifier: Apache-2.0
/// @file field_render.h
/// Pictures of the set F < 0 itself, by rays through the map and through no grid, as [ZB25] makes them. All lengths of
/// the march are in fractal space, where the map lives; the camera is in the world.
///
/// A ray is sampled where it enters the region, and from there on at t_{k+1} = t_k + max(alpha t_k^delta, epsilon), t
/// the distance from the eye: the clarity function of [HSK89] Eq. 16, from one t_0 for all rays. Between the first
/// sample inside and the one before it the surface is found by bisection. The normal comes from central differences at
/// the hit's own step, along 13 axes and of a field that grows monotonely outwards (F starts anew where orbits escape a
/// step earlier); Phong's model shades. Details that lie between two samples of a ray are not seen; a smaller alpha and
/// epsilon find more.
///
/// Skipping: before the march the region is covered with cubes, and those that FieldEvaluator::decide() proves to be
/// outside are remembered in a VDB mask. Samples in such a cube are not evaluated, and no other sample moves: the
/// picture has the same bytes as without. How much that saves depends on what the map can prove: mostly all but a
/// layer around the set; for a map that proves nothing (a user's pair, a Mandelbulb of a power that is not whole) only
/// what lies beyond the escape radius.
#pragma once

#include "vdbtools/base/grids.h"
#include "vdbtools/base/monitor.h"
#include "vdbtools/field/fractal_field.h"
#include "vdbtools/picture/image.h"

#include "julia/embedding.h"

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

namespace vdbtools {

struct Camera {
  openvdb::Vec3d eye{0, 0, 5}, lookAt{0, 0, 0};  ///< world units, apart from each other
  openvdb::Vec3d up{0, 1, 0};  ///< is up in the picture; another one is taken if the view goes along it
  double fieldOfView = 30;     ///< degrees, vertical, 1 to 150
};

/// The same camera, turned about the axis through its look-at point along its up: a frame of a turntable.
Camera turned(const Camera& camera, double degrees);

/// The ball around what a coarse lattice of samples finds of the set; around the region where it finds nothing.
struct FramedBall {
  openvdb::Vec3d centre;  ///< world units
  double radius = 0;      ///< world units
};
FramedBall frameSet(const FieldSource& source, const openvdb::BBoxd& region);

/// Looks at the ball, which touches the frame's nearer pair of edges at zoom 1; angles as in PreviewOptions.
/// @param aspect  width over height
Camera cameraAround(const FramedBall& ball, double azimuth, double elevation, double fieldOfView, double zoom,
                    double aspect);

/// max(alpha t^delta, epsilon): units of fractal space.
struct Clarity {
  /// None: steps are as long as a pixel is wide at the look-at point, and at any distance for delta 1. [ZB25] takes
  /// 5e-5, which is a tenth of that for 1000 pixels, and too slow on processors.
  std::optional<double> alpha;
  int delta = 1;          ///< 0, 1 or 2
  double epsilon = 5e-5;  ///< the shortest step, > 0; [ZB25]'s default
};

enum class FieldColour {
  Direction,   ///< the components in R^3 of the first step's direction, f x g / |f x g| of [ZB25] with cross products
  Versor,      ///< the imaginary components of the same versor, as in slices
  Iterations,  ///< how many steps the orbits just outside took
  Trap,        ///< how near an orbit just inside came to the origin
  Clay,        ///< one colour
};

struct FieldRenderOptions {
  Camera camera;
  int width = 800, height = 800;  ///< pixels
  int samples = 4;                ///< rays a pixel: 1, 4, 9 or 16
  Clarity clarity;
  FieldColour colour = FieldColour::Direction;
  julia::DropAxis dropAxis = julia::DropAxis::K;  ///< the evaluator's
  int maxIterations = 3;                          ///< the evaluator's
  double escapeRadius = 20;                       ///< the evaluator's
  bool background = true;  ///< under the beauty; without, it is black, and premultiplied by the coverage
  bool skip = true;        ///< changes the speed only
};

/// Row by row from the top left.
struct FieldImage {
  Image beauty;                 ///< linear RGB
  std::vector<float> coverage;  ///< the part of a pixel's rays that met the set
  Image normal;                 ///< world space, outward, of the pixel's nearest hit; 0 without one
  std::vector<float> depth;     ///< of the same, along the view axis, world units; kNoDepth without one
  std::vector<float> id;        ///< 1 where the set is seen, else 0

  std::uint64_t rays = 0;         ///< that were sent
  std::uint64_t evaluations = 0;  ///< of samples along the rays: what skipping saves
};

inline constexpr float kNoDepth = 1e10F;  ///< as other renderers have it

class Occupancy;

/// Renders pictures of one set; what is known to be empty is found once for all of them.
class FieldRenderer {
 public:
  /// @param region  world units; the set is cut at its faces
  /// @throw std::invalid_argument  an empty region
  FieldRenderer(const FieldSource& source, const openvdb::BBoxd& region);
  ~FieldRenderer();

  /// The same picture for any number of threads and with or without skipping.
  /// @throw std::invalid_argument  options out of their domain
  /// @throw Interrupted
  FieldImage render(const FieldRenderOptions& options, Monitor& monitor);

 private:
  FieldSource mSource;
  openvdb::BBoxd mRegion;                       ///< fractal space
  std::unique_ptr<const Occupancy> mOccupancy;  ///< from the first picture on that skips
};

/// One picture.
FieldImage renderField(const FieldSource& source, const openvdb::BBoxd& region, const FieldRenderOptions& options,
                       Monitor& monitor);

/// The channels R G B, A, N.x N.y N.z, Z and id, linear; RGB and no others in a PNG. As encodeImage().
std::string encodeFieldImage(const FieldImage& image, const std::string& extension);

}  // namespace vdbtools
