// SPDX-License-Identifier: Apache-2.0
/// @file option_data.h
/// The options of a table as JSON, for programs that offer them to their own users. `juliavdb COMMAND --describe json`
/// and the page of `explore` say the same of an option, because both take it from here.
#pragma once

#include "vdbtools/recipe/option_table.h"

#include <string>

namespace vdbtools {

/// An array of objects in the order of OptionTable::listing(). Values are text unless stated otherwise:
///   name         the option without dashes
///   argument     what the help calls its value; empty for a flag
///   help         with its defaults
///   type         an object: its *kind*, which is text, flag, number, whole, choice, list, vector or control, and where
///   they
///                are known the bounds *low* and *high*, whether these are excluded (*excludesLow*, *excludesHigh*),
///                and the *words* that it accepts (OptionType)
///   default      its value where it is not given but has an effect; missing where there is none
///   alternative  the entry of another option that says the same in another way; missing where there is none
///   displaces    a list of the entries that lose their meaning where this option is given
///
/// If the table has a selector, the variants may differ in their defaults. Such tables also have
///   maps         a list of the variants that have the option
///   defaults     an object of the defaults, by variant; if a variant takes a target, those with a target
/// and *default* is that of the first of these variants which has one.
std::string optionData(const OptionTable& table);

}  // namespace vdbtools
