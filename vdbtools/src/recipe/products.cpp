// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/formats/file_formats.h"
#include "vdbtools/recipe/option_table.h"

namespace vdbtools {

std::set<Product> productsOf(std::span<const std::string> files) {
  std::set<Product> products;
  for (const std::string& file : files) {
    if (file.ends_with(".count")) products.insert(Product::MeshCount);
    const FileFormat* const format = findFormat(file);
    if (!format) continue;
    if (format->writesGrids) products.insert(Product::Vdb);
    if (format->writesMesh)
      products.insert(format->levels                           ? Product::Glb
                      : format->columns == FormatColumns::None ? Product::Stl
                                                               : Product::Mesh);
  }
  return products;
}

}  // namespace vdbtools
