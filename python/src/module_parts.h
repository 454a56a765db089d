// SPDX-License-Identifier: Apache-2.0
/// @file module_parts.h
/// The parts of the module juliavdb._juliavdb, each in a source of its own.
#pragma once

#include "made.h"

#include <pybind11/pybind11.h>

#include <memory>
#include <optional>
#include <string>

/// The methods of a scene that answer for arrays of points (queries.h).
void addFieldMethods(pybind11::class_<MadeScene, std::shared_ptr<MadeScene>>& scene);

/// Planes, averages over versors, and dimensions.
void addStudies(pybind11::module_& module, pybind11::class_<MadeScene, std::shared_ptr<MadeScene>>& scene);

/// The parts of fitting by themselves: charges, monopoles, the energy and its minimum.
void addFitParts(pybind11::module_& module);

/// Grids of numbers, and the signed distances of meshes as such.
void addGrids(pybind11::module_& module);

// What the parts share.

/// The target's mesh, unless the target is a file. @throw std::invalid_argument
std::shared_ptr<const vdbtools::Mesh> targetOf(const pybind11::object& vertices, const pybind11::object& faces);

/// @param text  such as "16G"; empty: the limit of the environment, as for the command @throw std::invalid_argument
std::optional<double> memoryOf(const std::optional<std::string>& text);
