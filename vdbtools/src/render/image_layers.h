// SPDX-License-Identifier: Apache-2.0
/// @file image_layers.h
/// Stores what pixels show in the layers of a picture.
#pragma once

#include "render/shading.h"
#include "vdbtools/render/shaded_image.h"

#include <cstddef>
#include <set>
#include <utility>

namespace vdbtools::preview {

/// The requested layers of a picture.
class Layers {
 public:
  Layers(int width, int height, const std::set<Pass>& passes) {
    const auto count = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    mImage.beauty = Image(width, height);
    mImage.coverage.resize(count);
    const auto has = [&](Pass pass) { return passes.contains(pass); };
    if (has(Pass::Normal)) mImage.normal = Image(width, height);
    if (has(Pass::Albedo)) mImage.albedo = Image(width, height);
    if (has(Pass::Depth)) mImage.depth.assign(count, kNoDepth);
    if (has(Pass::Ao)) mImage.ao.resize(count);
    if (has(Pass::Id)) mImage.id.resize(count);
    if (has(Pass::Trap)) mImage.trap.resize(count);
  }

  /// @param depth    depth per unit of distance along the ray to the nearest point, world units
  /// @param toWorld  the rotation of normals into world space
  void set(std::size_t at, const Shown& shown, double depth, const openvdb::Mat3d& toWorld) {
    mImage.beauty.pixels[at] = toColour(shown.colour);
    mImage.coverage[at] = static_cast<float>(shown.alpha);
    if (shown.hits == 0) return;
    if (!mImage.normal.pixels.empty()) mImage.normal.pixels[at] = toColour(toWorld * shown.normal);
    if (!mImage.albedo.pixels.empty()) mImage.albedo.pixels[at] = toColour(shown.albedo / shown.hits);
    if (!mImage.depth.empty()) mImage.depth[at] = static_cast<float>(shown.distance * depth);
    if (!mImage.ao.empty()) mImage.ao[at] = static_cast<float>(shown.open / shown.hits);
    if (!mImage.id.empty()) mImage.id[at] = 1;
    if (!mImage.trap.empty()) mImage.trap[at] = static_cast<float>(shown.trap);
  }

  ShadedImage take() { return std::move(mImage); }

 private:
  ShadedImage mImage;
};

}  // namespace vdbtools::preview
