// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/farm/plan_folder.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/files/atomic_file.h"

#include <system_error>
#include <vector>

namespace vdbtools {

namespace fs = std::filesystem;

namespace {

/// Makes the folder and a file in it, and takes both away again.
void requireWritable(const fs::path& folder) {
  std::error_code error;
  std::vector<fs::path> made;
  for (fs::path part = fs::absolute(folder).lexically_normal(); !fs::exists(part, error) && part.has_relative_path();
       part = part.parent_path())
    made.push_back(part);
  fs::create_directories(folder, error);
  if (error) throw CreateError("cannot make the folder '" + folder.string() + "': " + error.message());
  const auto takeAway = [&] {
    for (const fs::path& part : made) fs::remove(part, error);
  };
  try {
    const AtomicFile file(folder / kManifestName);
  } catch (...) {
    takeAway();
    throw;
  }
  takeAway();
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
  const bool made = fs::create_directories(folder, error);
  if (error) throw CreateError("cannot make the folder '" + folder.string() + "': " + error.message());
  try {
    AtomicFile file(folder / kManifestName);
    file.stream() << encodeManifest(manifest);
    file.commit();
  } catch (...) {
    if (made) fs::remove(folder, error);
    throw;
  }
}

}  // namespace vdbtools
