// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/scene/scene.h"

#include "scene/scene_colouring.h"

namespace vdbtools {

openvdb::BBoxd pictureRegion(const Scene& scene) {
  if (scene.options.lattice.box) return *scene.options.lattice.box;
  return scene.exponent() ? meshBox(planScene(scene)) : scene.region();
}

FieldRenderOptions pictureOptions(const Scene& scene, const openvdb::BBoxd& region, const FieldPicture& picture,
                                  FieldColour usual) {
  FieldRenderOptions options = picture.render;
  options.camera = picture.view.camera(scene.source(), region,
                                       static_cast<double>(options.width) / static_cast<double>(options.height),
                                       scene.options.output.axes.target);
  const std::optional<ColourChoice>& chosen = scene.options.output.attributes.colour;
  options.colour = sceneColouring(scene, picture.colour.value_or(chosen.value_or(ColourChoice{.by = usual})));
  options.orbit = scene.field.orbit;
  options.dropAxis = scene.options.map->embedding().dropped;
  return options;
}

}  // namespace vdbtools
