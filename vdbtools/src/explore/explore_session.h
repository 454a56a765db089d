// SPDX-License-Identifier: Apache-2.0
/// @file explore_session.h
/// Answers the requests of the page, without HTTP. It keeps no state apart from a cache of scenes and the list of jobs;
/// everything else is in the recipes of the requests.
#pragma once

#include "explore/file_access.h"
#include "explore/job_queue.h"
#include "explore/scene_store.h"
#include "vdbtools/explore/explore_server.h"

#include <nlohmann/json.hpp>

#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

namespace vdbtools::explore {

struct ExploreRequest {
  std::string method;  ///< GET, POST or DELETE
  std::string path;    ///< the path after the key, such as "volume/0123"
  std::string name;    ///< the parameter "name" of the query
  std::string body;
};

struct ExploreAnswer {
  int status = 200;
  std::string type = "application/json";
  std::string body;
};

/// May be used from many threads at once.
class ExploreSession {
 public:
  /// Makes the first scene. @throw as ExploreServer
  ExploreSession(const ExploreOptions& options, Monitor& monitor);

  /// The maximum size of the body of a request, bytes.
  static std::size_t mostBytes(const std::string& path);

  /// Answers a request. It throws nothing but std::bad_alloc; other errors become answers.
  /// @param monitor  is cancelled when nobody waits for the answer any more
  ExploreAnswer answer(const ExploreRequest& request, Monitor& monitor);

  /// Ends all jobs.
  void stop() { mJobs.stop(); }

 private:
  using json = nlohmann::json;
  struct Look {
    Recipe given, completed;
    FractalOptions options;
  };
  struct Volume {
    std::string id;
    std::shared_ptr<const std::string> bytes;
  };

  Look lookOf(const json& body) const;
  /// The same, with the resolution of the body.
  Look lookToMake(const json& body) const;
  std::shared_ptr<KeptScene> sceneOf(const Look& look, SceneStore::Turn turn, Monitor& monitor);

  json start();
  json target();
  json scene(const json& body, Monitor& monitor);
  std::string volume(const std::string& id);
  std::string targetMesh(Monitor& monitor);
  std::string picture(const json& body, Monitor& monitor);
  json look(const json& body);
  json colouring(const json& body, Monitor& monitor);
  json advice(const json& body, Monitor& monitor);
  std::string made(const json& body, Monitor& monitor);
  json make(const json& body);
  json jobs();
  json recipe(const std::string& name, const std::string& bytes);
  json command(const json& body);
  json sequence(const json& body);
  std::string exported(const json& body, Monitor& monitor);

  OptionTable mTable;
  Recipe mGiven;
  std::filesystem::path mFolder;
  FileAccess mAccess;
  SceneStore mScenes;
  std::mutex mMutex;  // guards the volumes
  std::list<Volume> mVolumes;
  std::mutex mTargetMutex;  // guards the mesh
  std::shared_ptr<const TargetInput> mMeshOf;
  std::string mTargetMesh;
  JobQueue mJobs;
};

}  // namespace vdbtools::explore
