// SPDX-License-Identifier: Apache-2.0
/// @file field_render.h
/// Pictures of the set F < 0 itself, by rays through the map instead of a grid, as in [ZB25]. All lengths along the
/// rays are in fractal space, where the map is defined; the camera is in the world.
///
/// A ray is sampled where it enters the region, and then at t_{k+1} = t_k + max(alpha t_k^delta, epsilon), where t is
/// the distance from the eye: the clarity function of [HSK89] Eq. 16, with the same t_0 for all rays. Bisection finds
/// the surface between the first sample inside and the one before it. The normal comes from central differences along
/// 13 axes, with the ray's step there, of a field that grows monotonically outwards (F itself jumps back where orbits
/// escape one step earlier). The light is that of previews, with its shadows and its sky. A copy of the set on voxel
/// lattices casts the shadows; the voxels are a few pixels wide and get finer towards the look-at point. The renderer
/// misses details between two samples of a ray; a smaller alpha and epsilon find more of them. A pixel in which the
/// surface ends, or whose lightness varies much, gets as many rays again.
///
/// Skipping: before the march the region is divided into cubes, and a VDB mask holds those that
/// FieldEvaluator::decide() does not prove to be outside. Samples in the other cubes are not evaluated. The remaining
/// samples keep their positions, so the picture has the same bytes with and without skipping. The gain depends on what
/// the map can prove. For most maps everything but a layer around the set is skipped; for a map that proves nothing (a
/// user's pair, or a Mandelbulb with a power that is not an integer) only the space beyond the escape radius is
/// skipped.
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

/// Returns the ball around the part of the set found by a coarse lattice of samples, or around the region if nothing is
/// found.
/// @param region  world units
FramedBall frameSet(const FieldSource& source, const openvdb::BBoxd& region);

/// The length of a step at the distance t: max(alpha t^delta, epsilon), in units of fractal space.
struct Clarity {
  /// If empty, a step is as long as a pixel is wide at the look-at point, and with delta 1 at every distance. [ZB25]
  /// uses 5e-5, a tenth of that for 1000 pixels, which is too slow on a CPU.
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
  julia::OrbitOptions orbit{};                    ///< as in the evaluator
  julia::DropAxis dropAxis = julia::DropAxis::K;  ///< as in the evaluator
  Look look{};  ///< the light and the material; for FieldColour::Clay the material's albedo, too
  std::set<Pass> passes = kUsualPasses;
  bool skip = true;  ///< affects only the speed
};

/// In a picture without a background, the coverage is the share of each pixel's rays that met the set or a shadow.
struct FieldImage : ShadedImage {
  std::uint64_t rays = 0;         ///< number of rays sent
  std::uint64_t evaluations = 0;  ///< number of samples along the rays that were evaluated
};

class Occupancy;
class ShadowProxy;

/// Renders pictures of one set. The provably empty space is determined once for all of them.
class FieldRenderer {
 public:
  /// @param region  world units; the set is cut at its faces
  /// @throw std::invalid_argument  an empty region
  FieldRenderer(const FieldSource& source, const openvdb::BBoxd& region);
  ~FieldRenderer();

  /// Renders a picture, which is the same for any number of threads and with or without skipping.
  /// @throw std::invalid_argument  options out of their ranges
  /// @throw Interrupted
  FieldImage render(const FieldRenderOptions& options, Monitor& monitor);

  /// Estimates the CPU seconds that the first such picture will take, by rendering small parts of it.
  /// @throw  as render()
  double estimatedSeconds(const FieldRenderOptions& options, Monitor& monitor);

 private:
  void prepare(const FieldRenderOptions& options, Monitor& monitor);

  FieldSource mSource;
  openvdb::BBoxd mRegion;                       ///< fractal space
  std::unique_ptr<const Occupancy> mOccupancy;  ///< made for the first picture that skips
  std::unique_ptr<const ShadowProxy> mShadows;  ///< made for a picture, and kept for later pictures that need the same
};

/// Renders a single picture.
FieldImage renderField(const FieldSource& source, const openvdb::BBoxd& region, const FieldRenderOptions& options,
                       Monitor& monitor);

/// Calls encodeShadedImage() without alpha and with the usual passes.
std::string encodeFieldImage(const FieldImage& image, const std::string& extension);

}  // namespace vdbtools
