// SPDX-License-Identifier: Apache-2.0
/// @file shaded_image.h
/// A shaded picture with the extra passes that compositors use, and its files.
#pragma once

#include "vdbtools/picture/image.h"
#include "vdbtools/recipe/option_table.h"
#include "vdbtools/recipe/recipe_reader.h"

#include <set>
#include <string>
#include <vector>

namespace vdbtools {

enum class Pass { Beauty, Normal, Depth, Albedo, Ao, Id, Trap };

/// Pixels are stored row by row from the top left. A pass that was not requested is empty. Where nothing is visible,
/// passes are 0 and the depth is kNoDepth. Where several rays of a pixel meet the surface, Albedo and Ao are means over
/// these rays, and the other passes belong to the nearest ray.
struct ShadedImage {
  Image beauty;                 ///< linear RGB, premultiplied by the coverage where there is no background
  std::vector<float> coverage;  ///< alpha: the opaque fraction of each pixel
  Image normal;                 ///< outward, in world space, of length 1
  std::vector<float> depth;     ///< along the view axis, world units
  Image albedo;                 ///< linear RGB
  std::vector<float> ao;        ///< the fraction of the sky that is not hidden, 0 to 1
  std::vector<float> id;        ///< 1 where the surface is visible, else 0
  std::vector<float> trap;      ///< how near the orbit comes to the origin
};

/// The passes of an EXR without --passes.
inline const std::set<Pass> kUsualPasses{Pass::Beauty, Pass::Normal, Pass::Depth, Pass::Id};

inline constexpr float kNoDepth = 1e10F;  ///< as in other renderers

/// The option --passes; it has no default. The beauty pass is always included.
OptionSpec passesOptionSpec();
/// Returns the passes of --passes, or @a usual without it. @param possible  those that the renderer makes
/// @throw std::invalid_argument naming the option and the value
std::set<Pass> parsePasses(const RecipeReader& reader, const std::set<Pass>& possible, const std::set<Pass>& usual);

/// Encodes the image. A PNG has the beauty and, if @a alpha, its coverage. An EXR has the passes as layers: R, G, B and
/// A; N.x, N.y, N.z; Z; albedo.R, albedo.G, albedo.B; AO; id; trap; all linear. Throws the same exceptions as
/// encodeImage().
/// @param passes  for an EXR: the passes to write, which the image must have
std::string encodeShadedImage(const ShadedImage& image, const std::string& extension, bool alpha,
                              const std::set<Pass>& passes);

}  // namespace vdbtools
