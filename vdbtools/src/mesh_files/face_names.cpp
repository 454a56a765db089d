// SPDX-License-Identifier: Apache-2.0
#include "mesh_files/face_names.h"

#include "mesh_files/text_scan.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/files/standard_streams.h"

#include <algorithm>
#include <system_error>

namespace vdbtools {
namespace {

/// Of each kind. Attributes of a mesh with many groups would need much memory, and nobody would choose among them.
constexpr std::size_t kMostFaceNames = 32;
/// Numbers of all attributes of one kind.
constexpr std::size_t kMostShares = std::size_t{1} << 26;

/// A name as it can stand in the value of an option and in the header of a PLY.
std::string plainName(const std::string& prefix, const std::string& name) {
  std::string plain = prefix;
  for (const char c : name) {
    const bool kept =
        (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '-' || c == '.';
    plain += kept ? c : '_';
  }
  return plain;
}

std::string_view withoutBlanks(std::string_view text) {
  constexpr std::string_view kBlank = " \t\r\v\f";
  const std::size_t begin = text.find_first_not_of(kBlank);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(kBlank) - begin + 1);
}

/// A file beside another one, or in a folder there; empty if there is none.
std::filesystem::path besideFile(const std::filesystem::path& file, const std::string& name) {
  const std::filesystem::path relative = name;
  if (relative.empty() || !relative.is_relative() || name.find('\0') != std::string::npos) return {};
  for (const std::filesystem::path& part : relative)
    if (part == "..") return {};
  std::filesystem::path place = file.parent_path() / relative;
  std::error_code error;
  return std::filesystem::is_regular_file(place, error) ? place : std::filesystem::path();
}

}  // namespace

std::map<std::string, std::array<float, 3>> readMaterialColours(const std::filesystem::path& path,
                                                                std::string_view contents) {
  std::map<std::string, std::array<float, 3>> colours;
  std::optional<std::string> name;
  LineScanner lines(path, contents);
  while (const auto line = lines.next()) {
    WordScanner words(line->substr(0, line->find('#')));
    const std::string_view keyword = words.next();
    if (keyword == "newmtl") name = words.next();
    if (keyword != "Kd") continue;
    if (!name) lines.fail("a colour stands before any material; the file is damaged or truncated: export it again");
    const std::string_view red = words.next();
    if (red == "spectral" || red == "xyz") continue;
    const std::string_view green = words.next(), blue = words.next();
    const auto channel = [&](std::string_view word) { return static_cast<float>(lines.number(word)); };
    const float first = channel(red);
    colours[*name] = {first, green.empty() ? first : channel(green), blue.empty() ? first : channel(blue)};
  }
  return colours;
}

std::uint32_t FaceNames::numberOf(Names& names, std::string_view name) {
  if (name.empty()) return kNone;
  const auto known = names.numbers.find(name);
  if (known != names.numbers.end()) return known->second;
  const auto number = static_cast<std::uint32_t>(names.list.size());
  names.list.emplace_back(name);
  names.numbers.emplace(name, number);
  return number;
}

void FaceNames::addLibrary(std::string_view rest) {
  const std::string_view whole = withoutBlanks(rest);
  if (whole.empty()) return;
  mLibraries.emplace_back(whole);
  // Several libraries may follow one another; a name with a blank is seldom meant so.
  WordScanner words(whole);
  for (std::string_view word = words.next(); !word.empty(); word = words.next())
    if (word != whole) mLibraries.emplace_back(word);
}

void FaceNames::addFace() {
  if (mRuns.empty() || mRuns.back().material != mMaterial || mRuns.back().group != mGroup)
    mRuns.push_back({mMaterial, mGroup, 0});
  ++mRuns.back().faces;
}

FaceNameList FaceNames::list() const { return {usedOf(mMaterials, &Run::material), usedOf(mGroups, &Run::group)}; }

std::vector<std::string> FaceNames::usedOf(const Names& names, std::uint32_t Run::*which) const {
  std::vector<std::string> used;
  std::vector<bool> isUsed(names.list.size());
  for (const Run& run : mRuns) {
    if (run.*which == kNone || isUsed[run.*which]) continue;
    isUsed[run.*which] = true;
    used.push_back(names.list[run.*which]);
  }
  return used;
}

void FaceNames::addAttributes(const std::filesystem::path& file, const Polygons& polygons, Mesh& mesh) const {
  if (mRuns.empty() || (mMaterials.list.empty() && mGroups.list.empty())) return;
  std::vector<float> facesAt(mesh.points.size());
  for (std::size_t face = 0; face < polygons.size(); ++face)
    for (const std::uint32_t corner : polygons.corners(face)) ++facesAt[corner];
  if (mesh.attributes.empty()) addColours(file, polygons, facesAt, mesh);
  addShares("material_", mMaterials, &Run::material, polygons, facesAt, mesh);
  addShares("group_", mGroups, &Run::group, polygons, facesAt, mesh);
}

void FaceNames::addShares(const std::string& prefix, const Names& names, std::uint32_t Run::*which,
                          const Polygons& polygons, const std::vector<float>& facesAt, Mesh& mesh) const {
  const bool differ =
      std::any_of(mRuns.begin(), mRuns.end(), [&](const Run& run) { return run.*which != mRuns.front().*which; });
  if (!differ) return;
  const std::size_t most = std::min(kMostFaceNames, kMostShares / std::max<std::size_t>(1, mesh.points.size()));
  std::vector<std::size_t> places;  // of each name's attribute; two names may become one
  for (std::size_t n = 0; n < std::min(most, names.list.size()); ++n) {
    const std::string name = plainName(prefix, names.list[n]);
    const auto known = std::find_if(mesh.attributes.begin(), mesh.attributes.end(),
                                    [&](const VertexAttribute& attribute) { return attribute.name == name; });
    places.push_back(static_cast<std::size_t>(known - mesh.attributes.begin()));
    if (known == mesh.attributes.end()) mesh.attributes.push_back({name, std::vector<float>(mesh.points.size())});
  }
  std::size_t face = 0;
  for (const Run& run : mRuns)
    for (const std::size_t end = face + run.faces; face < end; ++face) {
      if (run.*which >= places.size()) continue;
      std::vector<float>& values = mesh.attributes[places[run.*which]].values;
      for (const std::uint32_t corner : polygons.corners(face)) ++values[corner];
    }
  std::sort(places.begin(), places.end());
  places.erase(std::unique(places.begin(), places.end()), places.end());
  for (const std::size_t place : places)
    for (std::size_t p = 0; p < mesh.points.size(); ++p)
      if (facesAt[p] > 0) mesh.attributes[place].values[p] /= facesAt[p];
}

void FaceNames::addColours(const std::filesystem::path& file, const Polygons& polygons,
                           const std::vector<float>& facesAt, Mesh& mesh) const {
  if (isStandardInput(file)) return;
  std::map<std::string, std::array<float, 3>> colours;
  for (const std::string& library : mLibraries)
    if (const std::filesystem::path place = besideFile(file, library); !place.empty())
      colours.merge(readMaterialColours(place, readWholeFile(place)));
  if (std::none_of(mMaterials.list.begin(), mMaterials.list.end(),
                   [&](const std::string& name) { return colours.contains(name); }))
    return;
  constexpr std::array<float, 3> kWhite{1, 1, 1};
  std::vector<std::array<float, 3>> ofMaterial;
  for (const std::string& name : mMaterials.list)
    ofMaterial.push_back(colours.contains(name) ? colours.at(name) : kWhite);
  for (std::size_t channel = 0; channel < 3; ++channel) {
    std::vector<float> values(mesh.points.size());
    std::size_t face = 0;
    for (const Run& run : mRuns) {
      const float value = (run.material < ofMaterial.size() ? ofMaterial[run.material] : kWhite)[channel];
      for (const std::size_t end = face + run.faces; face < end; ++face)
        for (const std::uint32_t corner : polygons.corners(face)) values[corner] += value;
    }
    for (std::size_t p = 0; p < values.size(); ++p) values[p] = facesAt[p] > 0 ? values[p] / facesAt[p] : 1;
    constexpr const char* kChannels[] = {"red", "green", "blue"};
    mesh.attributes.push_back({kChannels[channel], std::move(values)});
  }
}

}  // namespace vdbtools
