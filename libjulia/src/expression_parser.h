// SPDX-License-Identifier: Apache-2.0
/// @file expression_parser.h
/// What all formulas that users write have in common: their functions and constants, and why one cannot be read.
/// muParser's objects are for one thread each.
#pragma once

#include <muParser.h>

#include <cstddef>
#include <optional>
#include <string>

namespace julia {

/// The functions and the power of expression_pair.h instead of muParser's own, which are the C library's, and pi and e.
void defineFunctions(mu::Parser& parser);
/// Sets the formula of a parser with these functions.
void setFormula(mu::Parser& parser, const std::string& text);

/// Where a variable is assigned to, which muParser would do.
std::optional<std::size_t> assignmentIn(const std::string& text);
inline constexpr const char* kAssignment = "variables cannot be assigned to; a comparison is written ==";

/// The place in @a text, from 0, that the error is about: muParser tells that of some tokens by their end.
std::size_t placeOf(const mu::ParserError& error, const std::string& text);
/// What the error is about, as it stands in @a text.
std::string tokenOf(const mu::ParserError& error, const std::string& text);
/// ", 'TOKEN'", or nothing where there is none. The rest of the text may be one token, so of a long one this is the
/// beginning.
std::string quoted(const std::string& token);
/// @param known  what follows "unknown name; "
std::string meaningOf(const mu::ParserError& error, const std::string& known);

}  // namespace julia
