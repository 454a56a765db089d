// SPDX-License-Identifier: Apache-2.0
/// @file field_render.h
/// Pictures of the set F < 0 itself, by rays through the map instead of a grid, as [ZB25] makes them. All lengths along
/// the rays are in fractal space, where the map lives; the camera is in the world.
///
/// A ray is sampled where it enters the region, and from there on at t_{k+1} = t_k + max(alpha t_k^delta, epsilon),
/// where t is the distance from the eye: the clarity function of [HSK89] Eq. 16, with the same t_0 for all rays.
/// Bisection finds the surface between the first sample inside and the one before it. The normal comes from central
/// differences at the step of the ray there, along 13 axes, of a field that grows monotonically outwards (F itself
/// jumps back where orbits escape one step earlier). The light is that of previews, with its shadows and its sky; what
/// throws the shadows is the set on lattices of voxels some pixels wide, which get finer towards the point looked at.
/// Details between two samples of a ray are missed; a smaller alpha and epsilon find more of them. A pixel in which the
/// surface ends, or whose lightness varies much, gets as many rays again.
///
/// Skipping: before the march the region is divided into cubes, and a VDB mask holds those that
/// FieldEvaluator::decide() does not prove to be outside. Samples in the others are not evaluated. The remaining
/// samples stay where they are, so the picture has the same bytes with and without skipping. How much this saves
/// depends on what the map can prove: for most maps everything but a layer around the set is skipped; for a map that
/// proves nothing (a user's pair, or a Mandelbulb with a power that is not an integer) only what lies beyond the escape
/// radius.
#pragma once

#include "vdbtools/base/grids.h"
#include "vdbtools/base/monitor.h"
#include "vdbtools/field/fractal_field.h"
#include "vdbtools/picture/image.h"
#include "vdbtools/render/camera.h"
#include "vdbtools/render/field_colour.h"
#include "vdbtools/render/look.h"
#include "vdbtools/render/shaded_image.h"

#include "julia/embedding.h"
#include "julia/orbit.h"

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <vector>

namespace vdbtools {

/// The ball around what a coarse lattice of samples finds of the set, or around the region if it finds nothing.
/// @param region  world units
FramedBall frameSet(const FieldSource& source, const openvdb::BBoxd& region);

/// The length of a step at the distance t: max(alpha t^delta, epsilon), in units of fractal space.
struct Clarity {
  /// Without a value, steps are as long as a pixel is wide: at the look-at point, and with delta 1 at every distance.
  /// [ZB25] uses 5e-5, a tenth of that for 1000 pixels, which is too slow on a CPU.
  std::optional<double> alpha;
  int delta = 1;          ///< 0, 1 or 2
  double epsilon = 5e-5;  ///< the shortest step, at least 1e-9; the default of [ZB25]
};

struct FieldRenderOptions {
  Camera camera;
  int width = 800, height = 800;  ///< pixels
  int samples = 4;                ///< rays per pixel: 1, 4, 9 or 16; twice as many where the pixel is rough
  Clarity clarity;
  FieldColouring colour{};
  julia::OrbitOptions orbit{};                    ///< the evaluator's
  julia::DropAxis dropAxis = julia::DropAxis::K;  ///< the evaluator's
  Look look{};  ///< the light and the material; for FieldColour::Clay the material's albedo, too
  std::set<Pass> passes = kUsualPasses;
  bool skip = true;  ///< changes the speed only
};

/// The coverage of a picture without a background is the part of each pixel's rays that met the set or a shadow.
struct FieldImage : ShadedImage {
  std::uint64_t rays = 0;         ///< how many were sent
  std::uint64_t evaluations = 0;  ///< how many samples along the rays were evaluated
};

class Occupancy;
class ShadowProxy;

/// Renders pictures of one set. The space that is proved to be empty is found once for all of them.
class FieldRenderer {
 public:
  /// @param region  world units; the set is cut at its faces
  /// @throw std::invalid_argument  an empty region
  FieldRenderer(const FieldSource& source, const openvdb::BBoxd& region);
  ~FieldRenderer();

  /// The same picture for any number of threads and with or without skipping.
  /// @throw std::invalid_argument  options out of their ranges
  /// @throw Interrupted
  FieldImage render(const FieldRenderOptions& options, Monitor& monitor);

  /// CPU seconds that the first such picture will take, by a few parts of it.
  /// @throw  as render()
  double estimatedSeconds(const FieldRenderOptions& options, Monitor& monitor);

 private:
  void prepare(const FieldRenderOptions& options, Monitor& monitor);

  FieldSource mSource;
  openvdb::BBoxd mRegion;                       ///< fractal space
  std::unique_ptr<const Occupancy> mOccupancy;  ///< made for the first picture that skips
  std::unique_ptr<const ShadowProxy> mShadows;  ///< made for a picture, and kept for others that need the same
};

/// Renders a single picture.
FieldImage renderField(const FieldSource& source, const openvdb::BBoxd& region, const FieldRenderOptions& options,
                       Monitor& monitor);

/// encodeShadedImage() without alpha, with the usual passes.
std::string encodeFieldImage(const FieldImage& image, const std::string& extension);

}  // namespace vdbtools
