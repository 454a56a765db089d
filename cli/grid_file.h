// SPDX-License-Identifier: Apache-2.0
/// @file grid_file.h
/// Files of grids that a command writes: VDB, or NanoVDB if the name has its extension.
#pragma once

#include "vdbtools/formats/nvdb_file.h"

#include <optional>
#include <vector>

namespace cli {

class CommandLine;

/// The extensions for Outputs::add().
inline constexpr const char* kGridExtensions = ".vdb .nvdb";
/// The help on such an output.
inline constexpr const char* kGridsHelp = "the grids to write: .vdb, or .nvdb for NanoVDB, which holds no recipe";

/// Adds --nvdb-bits.
void addNvdbOption(CommandLine& line);

/// How the values of -o are stored, if it is a NanoVDB file.
/// @throw std::invalid_argument  --nvdb-bits is wrong or given for a VDB, --half is given for a NanoVDB file, or this
///                               build cannot write NanoVDB
std::optional<vdbtools::NvdbValues> nvdbValues(const CommandLine& line);

/// Reports by how much values were rounded; nothing for grids that were stored unchanged.
void tellNvdb(const std::vector<vdbtools::NvdbWritten>& grids);

}  // namespace cli
