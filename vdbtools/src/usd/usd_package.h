// SPDX-License-Identifier: Apache-2.0
/// @file usd_package.h
/// Packages of USD (.usdz): ZIP archives without compression, in which the data of each file begins at a multiple of 64
/// bytes and the first file is the scene. "Usdz File Format Specification", OpenUSD, version 1.3.
#pragma once

#include <functional>
#include <iosfwd>
#include <string>

namespace vdbtools {

/// Writes a package of one scene. The same scene gives the same bytes.
/// @param name        the file name of the scene in the package, ending in .usda
/// @param writeScene  writes the text of the scene
/// @throw DataError   the text is 4 GiB or longer, for which such archives have no room
void writeUsdPackage(std::ostream& stream, const std::string& name,
                     const std::function<void(std::ostream&)>& writeScene);

}  // namespace vdbtools
