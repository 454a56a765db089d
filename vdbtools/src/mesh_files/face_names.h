// SPDX-License-Identifier: Apache-2.0
/// @file face_names.h
/// The materials and groups of an OBJ as attributes of its points, with the colours of a material library (.mtl).
#pragma once

#include "mesh/polygon.h"
#include "vdbtools/mesh/mesh.h"

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace vdbtools {

/// The diffuse colours (Kd) of a material library by the names of its materials, as the numbers stand there.
/// @throw DataError  a colour is not made of numbers, or stands before any material
std::map<std::string, std::array<float, 3>> readMaterialColours(const std::filesystem::path& path,
                                                                std::string_view contents);

/// The names of the faces of an OBJ, in the order of the file.
class FaceNames {
 public:
  void setMaterial(std::string_view name) { mMaterial = numberOf(mMaterials, name); }
  void setGroup(std::string_view name) { mGroup = numberOf(mGroups, name); }
  /// @param rest  what follows the word "mtllib"
  void addLibrary(std::string_view rest);
  /// Notes that the next face has the current names.
  void addFace();

  /// Those that a face has.
  FaceNameList list() const;

  /// Adds attributes to a mesh with all its points: "material_NAME" and "group_NAME", the share of the faces at a point
  /// that have this name, where faces differ in it; and red, green and blue, the mean colour of the faces there, if the
  /// mesh has none and a library in the folder of @a file has colours. Faces without a colour are white.
  /// @throw DataError  as readMaterialColours()
  void addAttributes(const std::filesystem::path& file, const Polygons& polygons, Mesh& mesh) const;

 private:
  static constexpr std::uint32_t kNone = 0xffffffff;
  struct Names {
    std::vector<std::string> list{};
    std::map<std::string, std::uint32_t, std::less<>> numbers{};
  };
  struct Run {
    std::uint32_t material, group;
    std::size_t faces;
  };
  std::vector<std::string> usedOf(const Names& names, std::uint32_t Run::*which) const;
  static std::uint32_t numberOf(Names& names, std::string_view name);
  void addShares(const std::string& prefix, const Names& names, std::uint32_t Run::*which, const Polygons& polygons,
                 const std::vector<float>& facesAt, Mesh& mesh) const;
  void addColours(const std::filesystem::path& file, const Polygons& polygons, const std::vector<float>& facesAt,
                  Mesh& mesh) const;

  Names mMaterials, mGroups;
  std::uint32_t mMaterial = kNone, mGroup = kNone;
  std::vector<Run> mRuns;
  std::vector<std::string> mLibraries;
};

}  // namespace vdbtools
