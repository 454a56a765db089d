// SPDX-License-Identifier: Apache-2.0
/// @file file_hashes.h
/// The hashes of the files that many recipes name, each file read once.
#pragma once

#include "vdbtools/scene/scene.h"

#include <map>
#include <vector>

namespace vdbtools {

class FileHashes {
 public:
  /// By the names that a recipe has for them. @throw as verifiedHashes()
  const Metadata& of(const FractalOptions& options);

 private:
  std::map<std::vector<NamedFile>, Metadata> mKnown;
};

}  // namespace vdbtools
