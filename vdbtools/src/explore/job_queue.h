// SPDX-License-Identifier: Apache-2.0
/// @file job_queue.h
/// Makes the files that the page requests, one job at a time, while the other jobs wait. A job does what `juliavdb
/// fractal` does, and its files have the same bytes.
#pragma once

#include "vdbtools/explore/explore_server.h"
#include "vdbtools/recipe/option_table.h"

#include <condition_variable>
#include <deque>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace vdbtools::explore {

struct JobRequest {
  Recipe recipe;                     ///< completed, with the resolution
  Recipe given;                      ///< the options of it that the page shows
  std::string name;                  ///< the files' name, without the folder and the extension
  std::vector<std::string> formats;  ///< some of writtenFormats() (formats/file_formats.h), each once
  bool overwrite = false;
};

enum class JobState { Queued, Running, Done, Failed, Cancelled };

/// A job as the page sees it.
struct JobStatus {
  int number = 0;
  JobRequest request;
  JobState state = JobState::Queued;
  std::string phase;
  double share = 0;                   ///< the done share of the work, from 0 to 1
  double left = -1;                   ///< remaining seconds; negative if unknown
  std::vector<std::string> files;     ///< the names of its files, once they are complete
  std::string error;                  ///< why a job failed
  std::vector<std::string> warnings;  ///< what whoever uses its files should know, one line each
};

/// The files that a job has made.
struct MadeFiles {
  Recipe recipe;  ///< completed
  std::vector<std::filesystem::path> files;
};

/// May be used from many threads at once.
class JobQueue {
 public:
  /// @param folder  where the files go
  /// @param inputs  all files that recipes of jobs may name: no job replaces one of them
  JobQueue(std::filesystem::path folder, InputFiles inputs, MakeShare makeShare);
  /// Cancels what is running, and waits for its end.
  ~JobQueue();
  JobQueue(const JobQueue&) = delete;
  JobQueue& operator=(const JobQueue&) = delete;

  /// @return the job's number, from 1
  /// @throw std::invalid_argument  a file exists already or is an input, there is no format or an unknown one, the name
  ///                               is not allowed, or too many jobs wait
  int add(const JobRequest& request);
  /// The last hundred jobs or so, in the order in which they were added.
  std::vector<JobStatus> list() const;
  /// Returns nothing if there is no such job, or if it has not made its files.
  std::optional<MadeFiles> madeFiles(int number) const;
  /// @return false if there is no such job
  bool cancel(int number);
  /// Cancels the running job, and starts no other.
  void stop();

 private:
  class Job;
  void work();
  void run(Job& job);
  std::filesystem::path fileOf(const JobRequest& request, const std::string& format) const;
  void requireFree(const JobRequest& request) const;

  std::filesystem::path mFolder;
  InputFiles mInputs;
  MakeShare mMakeShare;
  mutable std::mutex mMutex;  // guards everything below
  std::condition_variable mWake;
  bool mStopped = false;
  int mLast = 0;
  std::deque<std::shared_ptr<Job>> mJobs;
  std::thread mThread;
};

}  // namespace vdbtools::explore
