// SPDX-License-Identifier: Apache-2.0
/// @file python_functions.h
/// Functions of Python that the library calls from any thread. While such a function runs, its thread holds the
/// interpreter's lock. An exception of the function passes through the library as one of C++, and is raised again in
/// the thread that called the module.
#pragma once

#include "function_map.h"

#include "vdbtools/maps/map_registry.h"

#include <pybind11/pybind11.h>

/// @param function  None, or a function of points (n, 3), which a recipe refers to as the versor "function"
vdbtools::VersorFunction versorOf(const pybind11::object& function);

/// @param function  None, or a function of iterates (n, 4) and the starts of their orbits (n, 4)
MapFunction mapOf(const pybind11::object& function);
