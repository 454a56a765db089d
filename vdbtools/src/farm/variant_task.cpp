// SPDX-License-Identifier: Apache-2.0
#include "farm/variant_task.h"

#include "farm/target_store.h"
#include "farm/variant_plan.h"

#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/job/fractal_files.h"

#include <list>
#include <system_error>

namespace vdbtools {
namespace {

/// The files of a task, not yet in their places.
class TaskFiles {
 public:
  TaskFiles(const std::filesystem::path& folder, const PlannedTask& task) {
    for (const std::string& name : task.writes) {
      const std::filesystem::path path = folder / name;
      std::error_code error;
      std::filesystem::create_directories(path.parent_path(), error);
      if (error) throw CreateError("cannot make the folder '" + path.parent_path().string() + "': " + error.message());
      AtomicFile& file = mFiles.emplace_back(path);
      if (isVdbPath(path))
        mWanted.vdb = &file;
      else
        mWanted.meshes.push_back({&file, meshFormat(path)});
    }
  }

  const FractalFiles& wanted() const { return mWanted; }

  void commit() {
    std::vector<AtomicFile*> files;
    for (AtomicFile& file : mFiles) files.push_back(&file);
    commitAll(files);
  }

 private:
  std::list<AtomicFile> mFiles;
  FractalFiles mWanted;
};

}  // namespace

TaskCounts makeVariant(const std::filesystem::path& folder, const Manifest& manifest, std::uint64_t index,
                       Monitor& monitor) {
  const Recipe recipe = taskRecipe(manifest, index);
  const FractalOptions options = parseFractalOptions(withAbsoluteNames(recipe, folderOfNames(manifest)));
  TaskFiles files(folder, manifest.tasks.at(index - 1));
  const Scene scene = SceneMaker(targetsKeptIn(folder / kTargetsName)).make(options, monitor);
  const FractalResult result = writeFractal(scene, recipe, files.wanted(), monitor);
  files.commit();
  TaskCounts counts{{{"evaluatedNodes", static_cast<double>(result.evaluatedNodes)}}};
  if (!files.wanted().meshes.empty()) {
    counts.counts["triangles"] = static_cast<double>(result.mesh.triangles);
    counts.counts["points"] = static_cast<double>(result.mesh.points);
  }
  return counts;
}

}  // namespace vdbtools
