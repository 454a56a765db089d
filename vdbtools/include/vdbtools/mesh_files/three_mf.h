// SPDX-License-Identifier: Apache-2.0
/// @file three_mf.h
/// Writes meshes as 3MF, a format for 3D printing: a zip with a model in XML (3MF Core Specification 1.3, ISO/IEC
/// 25422). The unit is the millimetre.
#pragma once

#include "vdbtools/mesh/mesh.h"

#include <map>
#include <string>

namespace vdbtools {

/// Whether this build can write 3MF, which requires libzip.
bool canWrite3mf();
/// Whether this build can read 3MF (mesh_reader.h), which requires libexpat, too.
bool canRead3mf();

/// Returns the bytes of a file with one object, with positions as 32-bit floats. The same mesh gives the same bytes.
/// @param mesh      millimetres, closed and oriented outward
/// @param metadata  stored under the project's own names
/// @throw std::invalid_argument  this build has no libzip
std::string encode3mf(const Mesh& mesh, const std::map<std::string, std::string>& metadata = {});

}  // namespace vdbtools
