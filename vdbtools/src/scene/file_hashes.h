// SPDX-License-Identifier: Apache-2.0
/// @file file_hashes.h
/// The hashes of files that many recipes name. Each file is read once.
#pragma once

#include "vdbtools/scene/scene.h"

#include <map>
#include <vector>

namespace vdbtools {

class FileHashes {
 public:
  /// The hashes, by the recipe's names for them. @throw as verifiedHashes()
  const Metadata& of(const FractalOptions& options);

 private:
  std::map<std::vector<NamedFile>, Metadata> mKnown;
};

}  // namespace vdbtools
