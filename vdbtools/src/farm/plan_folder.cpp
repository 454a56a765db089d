// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/farm/manifest.h"

#include "farm/tile_task.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/files/atomic_file.h"

#include <system_error>

namespace vdbtools::farm {

namespace fs = std::filesystem;

namespace {

/// Creates and removes a file where the first file of the plan would be created: the manifest, or the first missing
/// folder. It creates no folder, because another process that tests at the same time could take it for an existing one.
void requireWritable(const fs::path& folder) {
  std::error_code error;
  fs::path first = fs::absolute(folder / kManifestName).lexically_normal();
  while (!fs::exists(first.parent_path(), error) && first.parent_path().has_relative_path())
    first = first.parent_path();
  if (!fs::is_directory(first.parent_path(), error))
    throw CreateError("cannot make the folder '" + folder.string() + "': '" + first.parent_path().string() +
                      "' is not a folder");
  if (fs::is_symlink(fs::symlink_status(first, error)))
    throw CreateError("cannot make the folder '" + folder.string() + "': '" + first.string() +
                      "' is a link to what is not there");
  const AtomicFile file(first);
}

}  // namespace

void requireNewPlanFolder(const fs::path& folder) {
  if (folder.empty()) throw CreateError("the name of the plan's folder is empty");
  std::error_code error;
  const fs::file_status status = fs::status(folder, error);
  if (status.type() == fs::file_type::not_found) return requireWritable(folder);
  if (status.type() != fs::file_type::directory)
    throw CreateError("'" + folder.string() + "' is not a folder; a plan needs one of its own");
  const bool empty = fs::is_empty(folder, error);
  if (error) throw CreateError("cannot look into '" + folder.string() + "': " + error.message());
  if (!empty)
    throw CreateError("the folder '" + folder.string() +
                      "' is not empty; a plan needs one of its own, so give another name or remove what is there");
  requireWritable(folder);
}

void writePlan(const fs::path& folder, const Manifest& manifest) {
  std::error_code error;
  if (fs::exists(folder / kManifestName, error))
    throw CreateError("another plan was made in '" + folder.string() + "' meanwhile; give another name");
  const bool made = fs::create_directories(folder, error);
  if (error) throw CreateError("cannot make the folder '" + folder.string() + "': " + error.message());
  try {
    AtomicFile file(folder / kManifestName);
    file.stream() << encodeManifest(manifest);
    file.commit();
  } catch (...) {
    // Written by a plan of tiles; with it the folder would seem to be in use.
    fs::remove(folder / kPreparedName, error);
    if (made) fs::remove(folder, error);
    throw;
  }
}

}  // namespace vdbtools::farm
