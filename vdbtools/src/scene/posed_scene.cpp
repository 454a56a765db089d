// SPDX-License-Identifier: Apache-2.0
#include "scene/posed_scene.h"

#include "motion/posed_shell.h"
#include "repair/solid_input.h"
#include "scene/file_hashes.h"
#include "scene/target_parts.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/recipe/option_value.h"

#include <utility>

namespace vdbtools {
namespace {

/// The mesh of a target. @param which  what the target is, for errors
std::shared_ptr<const Mesh> requireMeshOf(const TargetInput& input, const char* which) {
  if (std::shared_ptr<const Mesh> mesh = input.mesh()) return mesh;
  throw DataError(std::string("the target ") + which +
                  " is a VDB, which has no points that could move; give it as a mesh");
}

}  // namespace

void poseScene(Scene& scene, const FractalOptions& options, const TargetInput& atRest, const TargetOpener& open,
               Monitor& monitor) {
  const std::shared_ptr<const Mesh> restMesh = requireMeshOf(atRest, "at rest");
  TargetOptions poseOptions = *options.target;
  // The lattice of the pose is that of a survey: it carries rho, and not the detail.
  if (poseOptions.mend.offset() == 0)
    poseOptions.sdfVoxels = VoxelChoice{.resolution = longestSide(atRest.box()) / surveyVoxel(atRest.box())};
  const std::unique_ptr<const TargetInput> pose = open(poseOptions, monitor);
  const std::shared_ptr<const Mesh> poseMesh = requireMeshOf(*pose, "in its pose");
  const auto motion = std::make_shared<SurfaceMotion>(*poseMesh, *restMesh, options.rest->depth);

  SceneShell& shell = std::get<SceneShell>(scene.domain);
  SceneTarget& target = scene.target.value();
  const DetailReach reach = reachAtRest(shell.exponent, target.distances);
  const double growth = motion->greatestGrowth();
  const Target distances = pose->band(
      pose->distances({.exterior = growth * reach.outside, .interior = growth * reach.inside}, monitor),
      {.exterior = growth * reach.outside, .interior = growth * reach.inside}, monitor);
  monitor.begin(PhaseKind::Motion, 0);
  PosedShell posed = posedShell(shell.exponent, reach, distances, motion, monitor);

  shell.exponent = std::move(posed.exponent);
  target.distances = distances;
  target.volume = insideVolume(*distances.phi);
  if (target.mesh) target.mesh = poseMesh;
  scene.field.deformation = std::move(posed.deformation);
  scene.field.evaluator = carriedAlong(std::move(scene.field.evaluator), scene.field.deformation);

  // The options of the pose, with the numbers that were chosen at rest.
  FractalOptions chosen = std::move(scene.options);
  scene.options = options;
  scene.options.lattice.automatic = chosen.lattice.automatic;
  scene.options.lattice.voxels = chosen.lattice.voxels;
  scene.options.target->sdfVoxels = chosen.target->sdfVoxels;
  scene.metadata.merge(hashesOf(options));
  scene.metadata[kTargetBox] = boxText(distances.box);
  scene.metadata["julia_rest_box"] = boxText(atRest.box());
  scene.metadata["julia_rest_jumps"] = numbersText({posed.jumps});
}

std::unique_ptr<julia::FieldEvaluator> carriedAlong(std::unique_ptr<julia::FieldEvaluator> evaluator,
                                                    const std::shared_ptr<const julia::Deformation>& deformation) {
  if (!deformation) return evaluator;
  return julia::makeDeformedEvaluator(std::move(evaluator), deformation);
}

}  // namespace vdbtools
