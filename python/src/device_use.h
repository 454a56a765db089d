// SPDX-License-Identifier: Apache-2.0
/// @file device_use.h
/// The devices of OpenCL, for the process and for single calls. What happens to one later is a warning of Python.
#pragma once

#include "vdbtools/scene/scene.h"

#include "julia/evaluator.h"

#include <memory>
#include <string>

/// Evaluates maps there from now on. The interpreter's lock must be held.
/// @return as vdbtools::chooseDevice() @throw as that
std::string useDevice(const std::string& choice);

/// The scene's field on a device, whatever the process uses. The interpreter's lock must not be held.
/// @throw as vdbtools::chooseDevice()
std::unique_ptr<julia::FieldEvaluator> evaluatorOn(const vdbtools::Scene& scene, const std::string& choice);
