// SPDX-License-Identifier: Apache-2.0
/// @file config_list.h
/// The text files of --config, with lines NAME = VALUE.
#pragma once

#include "vdbtools/recipe/option_table.h"

#include <string>

namespace cli {

/// @param text   the content of the file, in the format of vdbtools/recipe/recipe.h
/// @param file   its name, for messages
/// @param table  the options that it may set
/// @return the settings as written there; their values are not checked
/// @throw std::invalid_argument  a malformed line, an unknown option, or an option that is set twice
vdbtools::Recipe readConfigList(const std::string& text, const std::string& file, const vdbtools::OptionTable& table);

}  // namespace cli
