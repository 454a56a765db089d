// SPDX-License-Identifier: Apache-2.0
/// @file render_mesh.h
/// The part of `render` that shows meshes.
#pragma once

#include "vdbtools/render/preview.h"

#include <string>

namespace cli {

class CommandLine;

/// Whether an input is a mesh and not a VDB.
bool isMesh(const std::string& input);

/// The picture of a mesh.
/// @throw std::invalid_argument  a value of --colour that a mesh does not have; what reading the mesh throws
vdbtools::ShadedImage imageOfMesh(const CommandLine& line, const std::string& input,
                                  const vdbtools::PreviewOptions& picture, vdbtools::Monitor& monitor);

}  // namespace cli
