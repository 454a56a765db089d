// SPDX-License-Identifier: Apache-2.0
/// @file watched_work.h
/// Long work on behalf of a Python thread: other Python threads run meanwhile, a callback hears of the progress, and
/// Ctrl-C stops the work, and so does memory that runs out.
#pragma once

#include "vdbtools/base/monitor.h"

#include <pybind11/pybind11.h>

#include <functional>
#include <optional>

/// Does @a work in a thread of its own while the calling one, which gives up the interpreter's lock in between, looks
/// for signals and calls @a progress. Returns or throws after the work has ended.
/// @param progress  None, or a function of the phase's name and of the share of it that is done (0 to 1; None where it
///                  is not known). It is called in the calling thread. Where it returns False, the work is cancelled
/// @param memory    bytes that the process may take meanwhile, see vdbtools::MemoryLimit
/// @param work      must not touch Python's objects
/// @throw pybind11::error_already_set  a signal's handler or the callback raised an exception: KeyboardInterrupt
/// @throw vdbtools::MemoryError  the machine has next to none left
/// @throw what @a work throws, vdbtools::Interrupted among it
void doWatched(const pybind11::object& progress, std::optional<double> memory,
               const std::function<void(vdbtools::Monitor&)>& work);
