// SPDX-License-Identifier: Apache-2.0
#include "products.h"

#include "options.h"
#include "output.h"

#include <vector>

namespace cli {

std::set<vdbtools::Product> productsOf(const CommandLine& line) {
  std::vector<std::string> extensions;
  if (line.has("output")) extensions.push_back(formatOf(line.text("output"), ".vdb"));
  if (line.has("mesh")) extensions.push_back(formatOf(line.text("mesh"), ".ply"));
  return vdbtools::productsOf(extensions);
}

std::set<vdbtools::Product> productsOf(const std::vector<std::string>& makes) {
  std::vector<std::string> extensions;
  for (const std::string& format : makes) extensions.push_back('.' + format);
  return vdbtools::productsOf(extensions);
}

}  // namespace cli
