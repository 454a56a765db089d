// SPDX-License-Identifier: Apache-2.0
#include "scene/posed_scene.h"

#include "motion/posed_shell.h"
#include "repair/solid_input.h"
#include "scene/file_hashes.h"
#include "scene/target_parts.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/recipe/option_value.h"
#include "vdbtools/target/target_survey.h"

#include <utility>

namespace vdbtools {
namespace {

/// @param which  what the target is, for errors
const Mesh& requireMesh(const std::shared_ptr<const Mesh>& mesh, const char* which) {
  if (mesh) return *mesh;
  throw DataError(std::string("the target ") + which +
                  " is a VDB, which has no points that could move; give it as a mesh");
}

}  // namespace

TargetPose openPose(const FractalOptions& options, const TargetInput& atRest, const TargetOpener& open,
                    Monitor& monitor) {
  TargetPose pose{.input = open(*options.target, monitor), .motion = {}};
  pose.motion = std::make_shared<SurfaceMotion>(requireMesh(pose.input->mesh(), "in its pose"),
                                                requireMesh(atRest.mesh(), "at rest"), options.rest->depth);
  return pose;
}

void poseScene(Scene& scene, const FractalOptions& options, const TargetPose& pose, Monitor& monitor) {
  SceneAtRest& rest = scene.rest.value();
  SceneShell& shell = std::get<SceneShell>(scene.domain);
  SceneTarget& target = scene.target.value();
  const DetailReach reach = reachAtRest(rest.exponent, rest.distances);
  const double growth = pose.motion->greatestGrowth();
  const BandWidths widths{.exterior = growth * reach.outside, .interior = growth * reach.inside};
  // The lattice of the pose is that of a survey: it carries the way back, and not the detail.
  const Target distances = pose.input->bandOf(surveyVoxel(rest.box) * pose.motion->size(), widths, monitor);
  monitor.begin(PhaseKind::Motion, 0);
  PosedShell posed = posedShell(rest.exponent, reach, distances, pose.motion, monitor);

  shell.exponent = std::move(posed.exponent);
  target.distances = distances;
  target.volume = insideVolume(*distances.phi);
  if (target.mesh) target.mesh = pose.input->mesh();
  scene.velocity = velocityOf(options, pose.input->mesh());
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
  scene.metadata["julia_rest_box"] = boxText(rest.box);
  scene.metadata["julia_rest_jumps"] = numbersText({posed.jumps});
  rest.jumps = posed.jumps;
}

std::unique_ptr<julia::FieldEvaluator> carriedAlong(std::unique_ptr<julia::FieldEvaluator> evaluator,
                                                    const std::shared_ptr<const julia::Deformation>& deformation) {
  if (!deformation) return evaluator;
  return julia::makeDeformedEvaluator(std::move(evaluator), deformation);
}

}  // namespace vdbtools
