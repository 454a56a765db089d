// SPDX-License-Identifier: Apache-2.0
/// @file mesh_file_check.h
/// What stands between a mesh file and OpenMesh's readers, which trust the file: they skip a vertex line that they
/// cannot parse (so that all later indices mean other points), take a word that is no number for 0, loop for ever or
/// reserve whatever a header asks for, parse single precision, and open other files that this one names. Here each file
/// is checked in full, and rewritten in the plainest form of its format, which they do read right.
#pragma once

#include <openvdb/Types.h>

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace vdbtools {

struct CheckedFile {
  std::string text;                    ///< for OpenMesh; the same polygons
  std::vector<openvdb::Vec3d> points;  ///< in double precision, in the file's order; for STL, empty
  bool binary = false;                 ///< an STL in its binary form
};

/// @throw DataError  see readMesh()
CheckedFile checkObj(const std::filesystem::path& path, std::string_view contents);
CheckedFile checkOff(const std::filesystem::path& path, std::string_view contents);
CheckedFile checkStl(const std::filesystem::path& path, std::string_view contents);

}  // namespace vdbtools
