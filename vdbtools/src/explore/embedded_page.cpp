// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/explore/embedded_page.h"

#include <algorithm>
#include <cstddef>
#include <vector>

namespace vdbtools::explore {
namespace {

#include <embedded_page_bytes.h>

std::string_view contentTypeOf(std::string_view name) {
  constexpr std::pair<std::string_view, std::string_view> kTypes[] = {{".html", "text/html; charset=utf-8"},
                                                                      {".js", "text/javascript; charset=utf-8"},
                                                                      {".css", "text/css; charset=utf-8"},
                                                                      {".glsl", "text/plain; charset=utf-8"},
                                                                      {".json", "application/json"},
                                                                      {".svg", "image/svg+xml"},
                                                                      {".png", "image/png"},
                                                                      {".jpg", "image/jpeg"}};
  for (const auto& [extension, type] : kTypes)
    if (name.ends_with(extension)) return type;
  return "application/octet-stream";
}

std::vector<PageFile> allFiles() {
  std::vector<PageFile> files;
  for (const EmbeddedBytes& file : kEmbedded)
    files.push_back({file.name, {reinterpret_cast<const char*>(file.bytes), file.size}, contentTypeOf(file.name)});
  std::sort(files.begin(), files.end(), [](const auto& a, const auto& b) { return a.name < b.name; });
  return files;
}

}  // namespace

std::span<const PageFile> embeddedPage() {
  static const std::vector<PageFile> files = allFiles();
  return files;
}

const PageFile* findPageFile(std::string_view name) {
  for (const PageFile& file : embeddedPage())
    if (file.name == name) return &file;
  return nullptr;
}

}  // namespace vdbtools::explore
