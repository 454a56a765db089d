// SPDX-License-Identifier: Apache-2.0
/// @file control_kinds.h
/// The kinds of sources that parseControl() knows, one file each. A parser handles an option's text if it has the form
/// of its kind, and returns nullptr otherwise.
#pragma once

#include "vdbtools/control/control.h"
#include "vdbtools/recipe/recipe_reader.h"

namespace vdbtools {

using ControlSourcePtr = std::shared_ptr<const ControlSource>;

/// @throw std::invalid_argument  a number that is not finite
ControlSourcePtr parseNumberControl(const RecipeReader& reader, const std::string& option);
/// @throw std::invalid_argument  a broken ramp
ControlSourcePtr parseRampControl(const RecipeReader& reader, const std::string& option);
ControlSourcePtr parseGridControl(const RecipeReader& reader, const std::string& option);
/// @throw std::invalid_argument  a broken paint:...
ControlSourcePtr parsePaintControl(const RecipeReader& reader, const std::string& option);
/// @throw std::invalid_argument  a broken texture:...
ControlSourcePtr parseTextureControl(const RecipeReader& reader, const std::string& option);
/// @throw std::invalid_argument  a broken near:...
ControlSourcePtr parseNearControl(const RecipeReader& reader, const std::string& option);
/// @throw std::invalid_argument  an expression that cannot be read
ControlSourcePtr parseExpressionControl(const RecipeReader& reader, const std::string& option);

/// The source of an expression that is part of an option's text. @throw std::invalid_argument  from julia
ControlSourcePtr expressionSource(const std::string& expression, const std::string& option);
/// Whether expressions know a name even without the attributes of a mesh.
bool isExpressionVariable(const std::string& name);

}  // namespace vdbtools
