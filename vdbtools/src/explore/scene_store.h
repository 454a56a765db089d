// SPDX-License-Identifier: Apache-2.0
/// @file scene_store.h
/// Makes the scenes that the page requests, one at a time, and keeps the latest of them for pictures.
#pragma once

#include "files/file_state.h"
#include "vdbtools/render/view_options.h"
#include "vdbtools/scene/scene.h"

#include <condition_variable>
#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <vector>

namespace vdbtools::explore {

/// A later request has replaced this one.
class Superseded : public std::runtime_error {
 public:
  Superseded() : std::runtime_error("a later request has taken the place of this one") {}
};

/// A scene at a fixed address, because evaluators and renderers refer to it.
class KeptScene {
 public:
  explicit KeptScene(Scene made);
  KeptScene(const KeptScene&) = delete;
  KeptScene& operator=(const KeptScene&) = delete;

  const Scene& scene() const { return mScene; }

  /// The bytes of a PNG; one picture at a time.
  /// @throw as FieldRenderer::render(), FieldView::camera()
  std::string picture(const FieldPicture& picture, Monitor& monitor);

 private:
  Scene mScene;
  openvdb::BBoxd mRegion;
  FieldRenderer mRenderer;
  std::timed_mutex mRendering;
};

/// May be used from many threads at once.
class SceneStore {
 public:
  SceneStore();

  enum class Turn {
    Latest,  ///< a later request of this kind replaces one that still waits
    Waits    ///< it waits for its turn
  };

  /// The scene of a completed recipe: one of those that are kept, if none of its files has changed since, or a new one.
  /// @throw Superseded, Interrupted, and as parseFractalOptions() and makeScene()
  std::shared_ptr<KeptScene> get(const Recipe& recipe, const FractalOptions& options, Turn turn, Monitor& monitor);

  /// The target that was opened last; nullptr if none was.
  std::shared_ptr<const TargetInput> target() const;

 private:
  /// What a scene is made from: its recipe, and the state of the files that it names before they were read.
  struct Sources {
    Recipe recipe;
    bool picture = false;  ///< as FractalOptions has it
    std::vector<FileState> files;

    bool operator==(const Sources&) const = default;
  };
  struct Entry {
    Sources sources;
    std::shared_ptr<KeptScene> scene;
  };
  std::shared_ptr<KeptScene> find(const Sources& sources);

  mutable std::mutex mMutex;  // guards everything below except mMaker, which belongs to the thread that has set mBusy
  std::condition_variable mFree;
  bool mBusy = false;
  std::uint64_t mLatest = 0;
  std::list<Entry> mKept;  ///< the most recently used first
  std::shared_ptr<const TargetInput> mTarget;
  SceneMaker mMaker;
};

}  // namespace vdbtools::explore
