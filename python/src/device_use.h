// SPDX-License-Identifier: Apache-2.0
/// @file device_use.h
/// The devices of OpenCL, for the process and for single calls. Later notices of a device become warnings of Python.
#pragma once

#include "vdbtools/base/monitor.h"
#include "vdbtools/scene/scene.h"

#include "julia/evaluator.h"

#include <functional>
#include <memory>
#include <string>

/// Evaluates maps on a device from now on. The caller must hold the interpreter's lock.
/// @return, @throw  as vdbtools::chooseDevice()
std::string useDevice(const std::string& choice);

/// Makes an evaluator of the scene's field on a device, whatever device the process uses. The caller must not hold the
/// interpreter's lock.
/// @throw as vdbtools::chooseDevice()
std::unique_ptr<julia::FieldEvaluator> evaluatorOn(const vdbtools::Scene& scene, const std::string& choice);

/// Runs @a work while a device is that of the process, one call at a time. What other threads begin meanwhile may use
/// it too, and has the same bits. The caller must not hold the interpreter's lock.
/// @throw as vdbtools::chooseDevice(), or what @a work throws, or vdbtools::Interrupted
void onDevice(const std::string& choice, const vdbtools::Monitor& monitor, const std::function<void()>& work);
