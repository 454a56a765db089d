// SPDX-License-Identifier: Apache-2.0
/// @file module_parts.h
/// The parts of the module juliavdb._juliavdb, each in a source of its own.
#pragma once

#include "made.h"
#include "watched_work.h"

#include <pybind11/pybind11.h>

#include <memory>
#include <optional>
#include <string>
#include <tuple>

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

/// The arguments memory, threads and device of a call, each of which may be None.
using GivenResources = std::tuple<std::optional<std::string>, std::optional<int>, std::optional<std::string>>;

/// Without memory, the limit of the environment counts, as for the command. @throw std::invalid_argument
Resources resourcesOf(const GivenResources& given);

/// @param threads  if given, the greatest number of threads @return it; 0: all @throw std::invalid_argument
int threadsOf(const std::optional<int>& threads);
