// SPDX-License-Identifier: Apache-2.0
#include "job/file_hashes.h"

namespace vdbtools {

const Facts& FileHashes::of(const FractalOptions& options) {
  std::string key;
  const std::vector<NamedFile> files = filesOf(options);
  for (const NamedFile& file : files)
    key += file.recordedAs + '\n' + file.path.string() + '\n' + file.expectedHash + '\n';
  const auto [known, isNew] = mKnown.try_emplace(key);
  if (!isNew) return known->second;
  try {
    for (const auto& [name, hash] : verifiedHashes(files)) known->second[name] = hash;
  } catch (...) {
    mKnown.erase(known);
    throw;
  }
  return known->second;
}

}  // namespace vdbtools
