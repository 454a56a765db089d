// SPDX-License-Identifier: Apache-2.0
/// @file expression_parser.h
/// The common part of all formulas that users write: their functions and constants, and the reasons why a formula
/// cannot be parsed. Only one thread at a time may use an object of muParser.
#pragma once

#include <muParser.h>

#include <cstddef>
#include <optional>
#include <string>

namespace julia {

/// Defines pi, e, and the functions and the power of expression_pair.h in place of muParser's own, which come from the
/// C library.
void defineFunctions(mu::Parser& parser);
/// Sets the formula of a parser with these functions.
void setFormula(mu::Parser& parser, const std::string& text);

/// The position of an assignment to a variable, which muParser would perform.
std::optional<std::size_t> assignmentIn(const std::string& text);
inline constexpr const char* kAssignment = "variables cannot be assigned to; a comparison is written ==";

/// The position of an error in @a text, from 0. muParser reports the end of some tokens.
std::size_t placeOf(const mu::ParserError& error, const std::string& text);
/// The token of an error, as it is written in @a text.
std::string tokenOf(const mu::ParserError& error, const std::string& text);
/// ", 'TOKEN'", or an empty text if there is no token. A token may extend to the end of the text, so a long one is
/// shortened to its beginning.
std::string quoted(const std::string& token);
/// @param known  what follows "unknown name; "
std::string meaningOf(const mu::ParserError& error, const std::string& known);

}  // namespace julia
