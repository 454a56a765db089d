// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/files/named_file.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/base/memory.h"
#include "vdbtools/files/file_bytes.h"

#include <cstdint>
#include <system_error>

namespace vdbtools {

std::map<std::string, std::string> verifiedHashes(std::span<const NamedFile> files) {
  std::map<std::string, std::string> found;
  for (const NamedFile& file : files) {
    // Files that a recipe names are read whole, and hashing a file that does not fit would take hours.
    std::error_code error;
    const std::uintmax_t size = std::filesystem::file_size(file.path, error);
    if (!error) requireMemory(static_cast<double>(size), MemoryUse::File, inOneLine(file.path.native()));
    std::string& hashes = found[file.recordedAs];
    hashes += (hashes.empty() ? "" : ",") + sha256OfFile(file.path);
  }
  for (const NamedFile& file : files) {
    const std::string& hash = found.at(file.recordedAs);
    if (!file.expectedHash.empty() && file.expectedHash != hash)
      throw DataError("'" + file.path.string() + "' has changed since the recipe was made: its SHA-256 is " + hash +
                      " and was " + file.expectedHash + "; to use it all the same, give the options anew");
  }
  return found;
}

}  // namespace vdbtools
