// SPDX-License-Identifier: Apache-2.0
/// @file grid_file.h
/// Files of grids that a command writes, in any format of grids.
#pragma once

#include "vdbtools/formats/file_formats.h"

#include <string>
#include <vector>

namespace cli {

class CommandLine;

/// The help on such an output.
std::string gridsHelp();

/// Adds --nvdb-bits.
void addNvdbOption(CommandLine& line);

/// How grids go into the file of -o.
struct GridOutput {
  const vdbtools::FileFormat* format;
  vdbtools::NvdbValues values = vdbtools::NvdbValues::Full;
};

/// @throw std::invalid_argument  an option does nothing in this format, --nvdb-bits is wrong, or this build cannot
///                               write the format
GridOutput gridOutput(const CommandLine& line);

/// Reports by how much values were rounded; nothing for grids that were stored unchanged.
void tellNvdb(const std::vector<vdbtools::NvdbWritten>& grids);

/// Warns of values that 16 bits cannot hold.
void tellClamped(const std::vector<vdbtools::ClampedGrid>& grids);

}  // namespace cli
