// SPDX-License-Identifier: Apache-2.0
/// @file shape_unit.h
/// The option --units of commands that work on the file of a shape but do not have the options of a fractal.
#pragma once

#include "vdbtools/base/units.h"

#include <optional>
#include <string>

namespace cli {

class CommandLine;

void addUnitsOption(CommandLine& line);

/// The unit of the coordinates in the file @a input: the one that it records, or else the unit of --units.
/// @throw std::invalid_argument  --units is no unit, or another one than the file's
std::optional<vdbtools::LengthUnit> unitOf(const CommandLine& line, const std::string& input);

}  // namespace cli
