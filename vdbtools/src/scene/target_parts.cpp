// SPDX-License-Identifier: Apache-2.0
#include "scene/target_parts.h"

#include <algorithm>
#include <set>

namespace vdbtools {
namespace {

/// The words of all values except file names that stand alone: "red" of "paint:red:0.1:0.6", "uv" of "uv,red".
std::set<std::string> wordsOf(const Recipe& recipe) {
  std::set<std::string> words;
  for (const auto& [option, value] : recipe) {
    if (option == "input") continue;
    std::string word;
    for (const char c : value + ',') {
      if (c != ':' && c != ',' && c != '@') {
        word += c;
        continue;
      }
      words.insert(word);
      word.clear();
    }
  }
  return words;
}

/// The name of the vector of which an attribute may be a part: rest of rest_x or restx.
std::string vectorOf(std::string attribute) {
  if (attribute.empty() || attribute.back() < 'x' || attribute.back() > 'z') return {};
  attribute.pop_back();
  if (attribute.ends_with('_')) attribute.pop_back();
  return attribute;
}

std::string counted(std::size_t count, const std::string& what) {
  return std::to_string(count) + ' ' + what + (count == 1 ? "" : "s");
}

}  // namespace

TargetParts partsOf(const Mesh& mesh) {
  TargetParts parts{.uvs = !mesh.cornerUvs.empty(),
                    .materials = mesh.faceNames.materials.size(),
                    .groups = mesh.faceNames.groups.size()};
  for (const VertexAttribute& attribute : mesh.attributes) parts.attributes.push_back(attribute.name);
  return parts;
}

std::vector<std::string> unusedParts(const TargetParts& parts, const Recipe& recipe) {
  const std::set<std::string> used = wordsOf(recipe);
  std::vector<std::string> unused;
  std::string attributes;
  bool usesMaterials = false, usesGroups = false;
  for (const std::string& attribute : parts.attributes) {
    const std::string vector = vectorOf(attribute);
    const bool isUsed = used.contains(attribute) || (!vector.empty() && used.contains(vector));
    if (attribute.starts_with("material_") && parts.materials > 0)
      usesMaterials = usesMaterials || isUsed;
    else if (attribute.starts_with("group_") && parts.groups > 0)
      usesGroups = usesGroups || isUsed;
    else if (!isUsed)
      attributes += (attributes.empty() ? "" : " ") + attribute;
  }
  if (!attributes.empty()) unused.push_back("the attributes " + attributes);
  if (parts.uvs && !used.contains("texture") && !used.contains("uv")) unused.push_back("texture coordinates");
  if (parts.materials > 0 && !usesMaterials) unused.push_back(counted(parts.materials, "material"));
  if (parts.groups > 1 && !usesGroups) unused.push_back(counted(parts.groups, "group"));
  return unused;
}

}  // namespace vdbtools
