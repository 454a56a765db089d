// SPDX-License-Identifier: Apache-2.0
#include "explore/scene_store.h"

#include "vdbtools/scene/scene.h"

#include <chrono>

namespace vdbtools::explore {
namespace {

// The current look, and a few previous ones for undo. A scene of the bunny takes some 30 MB.
constexpr std::size_t kMostScenes = 8;
constexpr std::chrono::milliseconds kPatience(
    50);  // how long a waiting request takes to notice that nobody waits for its answer

/// A target that the scenes and the page share.
class SharedInput final : public TargetInput {
 public:
  explicit SharedInput(std::shared_ptr<const TargetInput> input) : mInput(std::move(input)) {}

  const openvdb::BBoxd& box() const override { return mInput->box(); }
  double usualDepth() const override { return mInput->usualDepth(); }
  std::optional<double> chosenSdfResolution(Monitor& monitor) const override {
    return mInput->chosenSdfResolution(monitor);
  }
  Target distances(const BandWidths& widths, Monitor& monitor) const override {
    return mInput->distances(widths, monitor);
  }
  Target band(const Target& distances, const BandWidths& widths, Monitor& monitor) const override {
    return mInput->band(distances, widths, monitor);
  }
  Target bandOf(double voxel, const BandWidths& widths, Monitor& monitor) const override {
    return mInput->bandOf(voxel, widths, monitor);
  }
  CoarseDistances coarseDistances(Monitor& monitor) const override { return mInput->coarseDistances(monitor); }
  std::shared_ptr<const Mesh> solid() const override { return mInput->solid(); }
  std::shared_ptr<const Mesh> mesh() const override { return mInput->mesh(); }

 private:
  std::shared_ptr<const TargetInput> mInput;
};

std::vector<FileState> statesOf(const FractalOptions& options) {
  std::vector<FileState> states;
  for (const NamedFile& file : filesOf(options)) states.push_back(stateOf(file.path));
  return states;
}

}  // namespace

KeptScene::KeptScene(Scene made)
    : mScene(std::move(made)), mRegion(pictureRegion(mScene)), mRenderer(mScene.source(), mRegion) {}

std::string KeptScene::picture(const FieldPicture& picture, Monitor& monitor) {
  std::unique_lock lock(mRendering, std::defer_lock);
  while (!lock.try_lock_for(kPatience)) monitor.throwIfCancelled();
  const FieldImage image = mRenderer.render(pictureOptions(mScene, mRegion, picture), monitor);
  return encodeShadedImage(image, ".png", picture.render.look.backdrop == Backdrop::None, {Pass::Beauty});
}

SceneStore::SceneStore()
    : mMaker([this](const TargetOptions& options, Monitor& monitor) {
        std::shared_ptr<const TargetInput> input = openTarget(options, monitor);
        const std::lock_guard lock(mMutex);
        mTarget = input;
        return std::make_unique<const SharedInput>(std::move(input));
      }) {}

std::shared_ptr<const TargetInput> SceneStore::target() const {
  const std::lock_guard lock(mMutex);
  return mTarget;
}

std::shared_ptr<KeptScene> SceneStore::find(const Sources& sources) {
  for (auto entry = mKept.begin(); entry != mKept.end(); ++entry)
    if (entry->sources == sources) {
      mKept.splice(mKept.begin(), mKept, entry);
      return entry->scene;
    }
  return nullptr;
}

std::shared_ptr<KeptScene> SceneStore::get(const Recipe& recipe, const FractalOptions& options, Turn turn,
                                           Monitor& monitor) {
  const Sources sources{recipe, options.picture, statesOf(options)};
  std::unique_lock lock(mMutex);
  const std::uint64_t number = turn == Turn::Latest ? ++mLatest : 0;
  for (;;) {
    if (std::shared_ptr<KeptScene> kept = find(sources)) return kept;
    if (!mBusy) break;
    mFree.wait_for(lock, kPatience);
    monitor.throwIfCancelled();
    if (turn == Turn::Latest && number != mLatest) throw Superseded();
  }
  mBusy = true;
  lock.unlock();
  const auto release = [&] {
    lock.lock();
    mBusy = false;
    mFree.notify_all();
  };
  std::shared_ptr<KeptScene> made;
  try {
    made = std::make_shared<KeptScene>(mMaker.make(options, monitor));
  } catch (...) {
    release();
    throw;
  }
  release();
  // Only the latest scene of a recipe is ever requested again.
  mKept.remove_if(
      [&](const Entry& entry) { return entry.sources.recipe == recipe && entry.sources.picture == options.picture; });
  mKept.push_front({sources, made});
  if (mKept.size() > kMostScenes) mKept.pop_back();
  return made;
}

}  // namespace vdbtools::explore
