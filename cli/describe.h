// SPDX-License-Identifier: Apache-2.0
/// @file describe.h
/// Describes a command for readers other than `--help`: as a manual page, as a table from which a shell completes the
/// words of a command line, and as JSON for other programs.
#pragma once

#include "vdbtools/recipe/option_table.h"

#include <boost/program_options.hpp>

#include <iosfwd>
#include <string>
#include <vector>

namespace cli {

struct Usage;

/// Options under a heading.
struct OptionGroup {
  std::string heading;
  const boost::program_options::options_description* options;
};

/// The manual page of a command, for `man`.
void writeManualPage(std::ostream& stream, const Usage& usage, const std::vector<OptionGroup>& groups);

/// The section of a manual page on variables of the environment. @param command  empty: those of all commands
void writeVariables(std::ostream& stream, const std::string& command);

/// Writes one line for each option, "--name KIND [WORD ...]". KIND says what follows the option: nothing (flag), a
/// file, a folder, a list of words with commas between them, or some other value. WORDs are values that it may have.
/// The command's own words come first, after "words".
void writeCompletionTable(std::ostream& stream, const Usage& usage, const std::vector<OptionGroup>& groups,
                          const vdbtools::OptionTable& own, const vdbtools::OptionTable& recipe);

/// Writes {command, groups: [{heading, options}]}. An option has at least a *name* without dashes, an *argument*, which
/// is empty for a flag, and a *help*; one with a short form also has its *letter*. What else an option of a table has
/// is described in vdbtools/recipe/option_table.h; only those of a recipe have an *entry*.
/// @param own     the tables of the options that are not part of a recipe
/// @param recipe  the table of the others
void writeDescription(std::ostream& stream, const Usage& usage, const std::vector<OptionGroup>& groups,
                      const vdbtools::OptionTable& own, const vdbtools::OptionTable& recipe);

/// Escapes a text for `man`.
std::string manualText(const std::string& text);

}  // namespace cli
