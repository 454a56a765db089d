// SPDX-License-Identifier: Apache-2.0
/// @file shaded_image.h
/// A shaded picture with what compositors want beside it, and its files.
#pragma once

#include "vdbtools/picture/image.h"
#include "vdbtools/recipe/option_table.h"
#include "vdbtools/recipe/recipe_reader.h"

#include <set>
#include <string>
#include <vector>

namespace vdbtools {

enum class Pass { Beauty, Normal, Depth, Albedo, Ao, Id, Trap };

/// Row by row from the top left. A pass that was not asked for is empty. Where nothing is seen, passes are 0 and the
/// depth is kNoDepth; where several rays of a pixel meet the surface, those but Albedo and Ao, which are means over
/// these rays, are of the nearest.
struct ShadedImage {
  Image beauty;                 ///< linear RGB, premultiplied by the coverage where there is no background
  std::vector<float> coverage;  ///< alpha: the part of each pixel that is not transparent
  Image normal;                 ///< outward, in world space, of length 1
  std::vector<float> depth;     ///< along the view axis, world units
  Image albedo;                 ///< linear RGB
  std::vector<float> ao;        ///< the part of the sky that is not hidden, 0 to 1
  std::vector<float> id;        ///< 1 where the surface is seen, else 0
  std::vector<float> trap;      ///< how near the orbit comes to the origin
};

/// What an EXR has without --passes.
inline const std::set<Pass> kUsualPasses{Pass::Beauty, Pass::Normal, Pass::Depth, Pass::Id};

inline constexpr float kNoDepth = 1e10F;  ///< as in other renderers

/// --passes; it has no default. The beauty is always one of them.
OptionSpec passesOptionSpec();
/// What --passes says, or @a usual. @param possible  those that the renderer makes
/// @throw std::invalid_argument naming the option and the value
std::set<Pass> parsePasses(const RecipeReader& reader, const std::set<Pass>& possible, const std::set<Pass>& usual);

/// The image as the bytes of a file. A PNG has the beauty and, if @a alpha, its coverage. An EXR has the passes as
/// layers: R, G, B and A; N.x, N.y, N.z; Z; albedo.R, albedo.G, albedo.B; AO; id; trap; all linear.
/// The same exceptions as encodeImage().
/// @param passes  of an EXR; those that the image has
std::string encodeShadedImage(const ShadedImage& image, const std::string& extension, bool alpha,
                              const std::set<Pass>& passes);

}  // namespace vdbtools
