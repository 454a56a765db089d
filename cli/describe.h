// SPDX-License-Identifier: Apache-2.0
/// @file describe.h
/// Describes a command for readers other than `--help`: as a manual page, and as a table from which a shell completes
/// the words of a command line.
#pragma once

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

/// Writes one line for each option, "--name KIND [WORD ...]". KIND says what follows the option: nothing (flag), a
/// file, a folder, or some other value. WORDs are values that it may have. The command's own words come first, after
/// "words".
void writeCompletionTable(std::ostream& stream, const Usage& usage, const std::vector<OptionGroup>& groups);

/// Escapes a text for `man`.
std::string manualText(const std::string& text);

}  // namespace cli
