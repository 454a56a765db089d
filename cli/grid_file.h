// SPDX-License-Identifier: Apache-2.0
/// @file grid_file.h
/// Files of grids that a command writes: VDB, or NanoVDB where the name says so.
#pragma once

#include "vdbtools/formats/nvdb_file.h"

#include <optional>
#include <vector>

namespace cli {

class CommandLine;

/// For Outputs::add().
inline constexpr const char* kGridExtensions = ".vdb .nvdb";
/// The help on such an output.
inline constexpr const char* kGridsHelp = "the grids to write: .vdb, or .nvdb for NanoVDB, which holds no recipe";

/// --nvdb-bits.
void addNvdbOption(CommandLine& line);

/// How the values of -o are stored, if it is a NanoVDB file.
/// @throw std::invalid_argument  --nvdb-bits is wrong or for a VDB, --half is for a NanoVDB file, or this build cannot
///                               write one
std::optional<vdbtools::NvdbValues> nvdbValues(const CommandLine& line);

/// Says how far values were rounded; nothing of grids that are as they were.
void tellNvdb(const std::vector<vdbtools::NvdbWritten>& grids);

}  // namespace cli
