// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/files/file_format.h"

#include "vdbtools/files/file_bytes.h"

#include <vector>

namespace vdbtools {

const FileFormat* formatByName(FormatList formats, std::string_view name) {
  const std::string lower = lowerCase(name);
  for (const FileFormat* format : formats)
    if (lower.ends_with(format->extension)) return format;
  return nullptr;
}

std::string formatTexts(FormatList formats, bool FileFormat::*fact, std::string_view FileFormat::*text,
                        std::string_view between, std::string_view beforeLast) {
  std::vector<std::string_view> texts;
  for (const FileFormat* format : formats)
    if (format->*fact) texts.push_back(format->*text);
  std::string list;
  for (std::size_t i = 0; i < texts.size(); ++i) {
    if (i > 0) list += i + 1 < texts.size() ? between : beforeLast;
    list += texts[i];
  }
  return list;
}

}  // namespace vdbtools
