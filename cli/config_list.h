// SPDX-License-Identifier: Apache-2.0
/// @file config_list.h
/// The text files of --config: lines NAME = VALUE.
#pragma once

#include "vdbtools/recipe/option_table.h"

#include <string>

namespace cli {

/// @param text  what the file holds, as in vdbtools/recipe/option_list.h
/// @param file  what it is called, for messages
/// @param table  the options that may stand in it
/// @return what it sets, as it is written there; no value has been looked at
/// @throw std::invalid_argument  a line that is none of these, an option that does not exist, or one that is set twice
vdbtools::Recipe readConfigList(const std::string& text, const std::string& file, const vdbtools::OptionTable& table);

}  // namespace cli
