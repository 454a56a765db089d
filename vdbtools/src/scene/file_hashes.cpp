// SPDX-License-Identifier: Apache-2.0
#include "scene/file_hashes.h"

#include "vdbtools/base/errors.h"

namespace vdbtools {

namespace {

/// Records the hash of a mesh in memory. @throw DataError  it is not the one that the recipe was made with
void addMeshHash(const NamedFile& input, const Mesh& mesh, Metadata& metadata) {
  const std::string hash = sha256OfMesh(mesh);
  if (!input.expectedHash.empty() && input.expectedHash != hash)
    throw DataError("the mesh is not the one that the recipe was made with: its SHA-256 is " + hash + " and was " +
                    input.expectedHash);
  metadata[metadataName(input.recordedAs)] = hash;
}

}  // namespace

Metadata hashesOf(const FractalOptions& options) {
  Metadata metadata;
  for (const auto& [name, hash] : verifiedHashes(filesOf(options))) metadata[metadataName(name)] = hash;
  if (options.target && options.target->mesh) addMeshHash(options.target->input, *options.target->mesh, metadata);
  if (options.rest && options.rest->mesh) addMeshHash(options.rest->file.value(), *options.rest->mesh, metadata);
  return metadata;
}

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
