// SPDX-License-Identifier: Apache-2.0
/// @file field_methods.h
/// The methods of a scene that answer for arrays of points (queries.h).
#pragma once

#include "made.h"

#include <pybind11/pybind11.h>

void addFieldMethods(pybind11::class_<MadeScene, std::shared_ptr<MadeScene>>& scene);
