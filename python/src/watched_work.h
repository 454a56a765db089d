// SPDX-License-Identifier: Apache-2.0
/// @file watched_work.h
/// Long work on behalf of a Python thread: other Python threads run meanwhile, a callback receives the progress, and
/// Ctrl-C or a lack of memory stops the work.
#pragma once

#include "vdbtools/base/monitor.h"

#include <pybind11/pybind11.h>

#include <functional>
#include <optional>
#include <string>

/// What the work of a call may take.
struct Resources {
  std::optional<double> memory{};  ///< bytes that the process may take meanwhile, see vdbtools::MemoryLimit
  int threads = 0;                 ///< greatest number of threads, not negative; 0: all
  std::string device{};            ///< where the work evaluates maps (onDevice()); empty: on the device of the process
};

/// Does @a work in a thread of its own. Meanwhile the calling thread, which releases the interpreter's lock in between,
/// checks for signals and calls @a progress. Returns or throws after the work has ended.
/// @param progress  None, or a function of the phase's name and of the share of it that is done (0 to 1; None if it is
///                  not known). It is called in the calling thread. If it returns False, the work is cancelled
/// @param work      must not touch Python's objects
/// @throw pybind11::error_already_set  a signal's handler or the callback raised an exception: KeyboardInterrupt
/// @throw as onDevice(), if a device is named
/// @throw vdbtools::MemoryError  the machine has hardly any memory left
/// @throw what @a work throws, including vdbtools::Interrupted
void doWatched(const pybind11::object& progress, const Resources& resources,
               const std::function<void(vdbtools::Monitor&)>& work);
