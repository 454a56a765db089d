// SPDX-License-Identifier: Apache-2.0
#include "farm/variant_task.h"

#include "farm/target_store.h"
#include "farm/variant_plan.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/files/output_files.h"
#include "vdbtools/job/fractal_job.h"

#include <functional>
#include <set>
#include <stdexcept>
#include <system_error>
#include <utility>

namespace vdbtools::farm {
namespace {

/// The files of a task before they are committed.
class TaskFiles {
 public:
  TaskFiles(const std::filesystem::path& folder, const PlannedTask& task, InputFiles inputs)
      : mFiles(std::move(inputs)) {
    for (const std::string& name : task.writes) {
      const std::filesystem::path path = folder / name;
      std::error_code error;
      std::filesystem::create_directories(path.parent_path(), error);
      if (error) throw CreateError("cannot make the folder '" + path.parent_path().string() + "': " + error.message());
      mWanted.files.push_back({&mFiles.add(path), findFormat(name)});
    }
  }

  const FractalFiles& wanted() const { return mWanted; }

  void commit() { mFiles.commit(); }

 private:
  OutputFiles mFiles;
  FractalFiles mWanted;
};

/// Runs code that uses the recipe of a task. If the recipe is invalid, the plan is at fault, not the request.
/// @throw DataError  instead of std::invalid_argument
template <class Body>
auto withRecipe(std::uint64_t index, const Body& body) {
  try {
    return body();
  } catch (const std::invalid_argument& error) {
    throw DataError("the plan's recipe of task " + std::to_string(index) + " cannot be used: " + error.what() +
                    "; plan again");
  }
}

FractalOptions optionsOf(const Manifest& manifest, std::uint64_t index) {
  return withRecipe(index, [&] {
    return parseFractalOptions(withAbsoluteNames(taskRecipe(manifest, index), folderOfNames(manifest)));
  });
}

/// The key under which the distances of a task's target are stored; "" if they are not.
std::string targetKeyOf(const Manifest& manifest, std::uint64_t index) {
  try {
    const FractalOptions options = optionsOf(manifest, index);
    return options.target ? targetKey(*options.target) : std::string();
  } catch (const DataError&) {
    return {};  // the task itself will report it
  }
}

/// Iterates backwards over the tasks that are not done, until @a seen returns true. The last tasks are done last.
void forEachToCome(const std::filesystem::path& folder, const Manifest& manifest,
                   const std::function<bool(std::uint64_t index)>& seen) {
  for (std::uint64_t index = manifest.tasks.size(); index >= 1; --index)
    if (!finishedTask(folder, manifest, index, FileCheck::Quick) && seen(index)) return;
}

}  // namespace

VariantMaker::VariantMaker(std::filesystem::path folder, const Manifest& manifest)
    : mFolder(std::move(folder)),
      mManifest(manifest),
      mScenes(targetsKeptIn(mFolder / kTargetsName, [this](const std::string& key) {
        bool wanted = false;
        forEachToCome(mFolder, mManifest, [&](std::uint64_t index) {
          return wanted = index != mIndex && targetKeyOf(mManifest, index) == key;
        });
        return wanted;
      })) {}

TaskCounts VariantMaker::make(std::uint64_t index, Monitor& monitor) {
  mIndex = index;
  const FractalOptions options = optionsOf(mManifest, index);
  TaskFiles files(mFolder, mManifest.tasks.at(index - 1), inputsOf(options));
  const FractalResult result = withRecipe(index, [&] {
    const Scene scene = mScenes.make(options, monitor);
    return writeFractal(scene, taskRecipe(mManifest, index), files.wanted(), monitor);
  });
  files.commit();
  TaskCounts counts{{{"evaluatedNodes", result.evaluatedNodes}}, textsOf(result.clamped)};
  if (files.wanted().wantMesh()) {
    counts.counts["triangles"] = result.mesh.triangles;
    counts.counts["points"] = result.mesh.points;
  }
  return counts;
}

void removeUnneededTargets(const std::filesystem::path& folder, const Manifest& manifest) {
  const std::filesystem::path targets = folder / kTargetsName;
  std::set<std::string> unneeded = keptTargets(targets);
  if (unneeded.empty()) return;
  forEachToCome(folder, manifest, [&](std::uint64_t index) {
    unneeded.erase(targetKeyOf(manifest, index));
    return unneeded.empty();
  });
  if (!unneeded.empty()) removeKeptTargets(targets, unneeded);
}

}  // namespace vdbtools::farm
