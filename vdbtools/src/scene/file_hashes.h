// SPDX-License-Identifier: Apache-2.0
/// @file file_hashes.h
/// The hashes of files that many recipes name. Each file is read once.
#pragma once

#include "vdbtools/scene/scene.h"

#include <map>
#include <vector>

namespace vdbtools {

/// The hashes of the files of a fractal, and of its target in memory, by their names in metadata.
/// @throw DataError  a mesh in memory is not the one that the recipe was made with, and as verifiedHashes()
Metadata hashesOf(const FractalOptions& options);

class FileHashes {
 public:
  /// The hashes, by the recipe's names for them. @throw as verifiedHashes()
  const Metadata& of(const FractalOptions& options);

 private:
  std::map<std::vector<NamedFile>, Metadata> mKnown;
};

}  // namespace vdbtools
