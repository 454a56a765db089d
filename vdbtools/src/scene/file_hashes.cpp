// SPDX-License-Identifier: Apache-2.0
#include "scene/file_hashes.h"

namespace vdbtools {

const Metadata& FileHashes::of(const FractalOptions& options) {
  const std::vector<NamedFile> files = filesOf(options);
  const auto [known, isNew] = mKnown.try_emplace(files);
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
