// SPDX-License-Identifier: Apache-2.0
/// @file posed_scene.h
/// Scenes of a target that moves: the scene at rest, carried to a pose.
#pragma once

#include "vdbtools/scene/scene.h"

#include <memory>

namespace vdbtools {

/// A target in its pose, opened, with its motion from there to rest.
struct TargetPose {
  std::unique_ptr<const TargetInput> input;
  std::shared_ptr<SurfaceMotion> motion;
};

/// @param options  with FractalOptions::rest
/// @throw what opening the pose throws
/// @throw DataError  the pose's mesh does not have the faces of that at rest
TargetPose openPose(const FractalOptions& options, const TargetInput& atRest, const TargetOpener& open,
                    Monitor& monitor);

/// Turns the scene of a target at rest, with Scene::rest, into that of the pose that @a options name.
/// @throw what making distances throws
void poseScene(Scene& scene, const FractalOptions& options, const TargetPose& pose, Monitor& monitor);

/// An evaluator of the set at rest, in the pose of a scene. @param deformation  nullptr: the scene has no pose
std::unique_ptr<julia::FieldEvaluator> carriedAlong(std::unique_ptr<julia::FieldEvaluator> evaluator,
                                                    const std::shared_ptr<const julia::Deformation>& deformation);

}  // namespace vdbtools
