// SPDX-License-Identifier: Apache-2.0
/// @file python_functions.h
/// Functions of Python that the library calls, in whichever thread asks: for as long as one runs, it has the
/// interpreter's lock. What it raises goes its way as an exception of C++ and is raised in the calling thread.
#pragma once

#include "function_map.h"

#include "vdbtools/maps/map_registry.h"

#include <pybind11/pybind11.h>

/// @param function  None, or a function of points (n, 3): what the recipe calls "function" as a versor
vdbtools::VersorFunction versorOf(const pybind11::object& function);

/// @param function  None, or a function of iterates (n, 4) and the starts of their orbits (n, 4)
MapFunction mapOf(const pybind11::object& function);
