// SPDX-License-Identifier: Apache-2.0
/// @file posed_scene.h
/// Scenes of a target that moves: the scene at rest, carried to a pose.
#pragma once

#include "vdbtools/scene/scene.h"

#include <memory>

namespace vdbtools {

/// Turns the scene of a target at rest, with Scene::rest, into that of the pose that @a options name.
/// @throw what opening the pose throws
/// @throw DataError  the pose's mesh does not have the faces of that at rest
void poseScene(Scene& scene, const FractalOptions& options, const TargetOpener& open, Monitor& monitor);

/// An evaluator of the set at rest, in the pose of a scene. @param deformation  nullptr: the scene has no pose
std::unique_ptr<julia::FieldEvaluator> carriedAlong(std::unique_ptr<julia::FieldEvaluator> evaluator,
                                                    const std::shared_ptr<const julia::Deformation>& deformation);

}  // namespace vdbtools
