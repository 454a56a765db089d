// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/mesh_files/mesh_names.h"

#include "mesh_files/mesh_formats.h"
#include "mesh_files/text_scan.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/mesh_files/mesh_reader.h"

#include <set>
#include <string>
#include <string_view>

namespace vdbtools {
namespace {

/// A name that applies to the following faces.
struct Named {
  std::string current{};
  bool isUsed = false;  ///< whether a face uses it
  std::set<std::string> seen{};

  void begin(std::string_view name) {
    current = name;
    isUsed = false;
  }
  void use(std::vector<std::string>& names) {
    if (isUsed || current.empty()) return;
    isUsed = true;
    if (seen.insert(current).second) names.push_back(current);
  }
};

}  // namespace

MeshNames readMeshNames(const std::filesystem::path& path) {
  MeshNames names;
  if (const FileFormat* const format = formatOfMesh(path); !format || rowOf(*format).read != still<readObj>)
    return names;
  const std::string contents = readWholeFile(path);
  LineScanner lines(path, contents);
  Named material, group;
  while (const auto line = lines.next()) {
    WordScanner words(line->substr(0, line->find('#')));
    const std::string_view keyword = words.next();
    if (keyword == "usemtl") material.begin(words.next());
    if (keyword == "g" || keyword == "o") group.begin(words.next());
    if (keyword != "f" && keyword != "fo") continue;
    material.use(names.materials);
    group.use(names.groups);
  }
  return names;
}

}  // namespace vdbtools
