// SPDX-License-Identifier: Apache-2.0
#include "farm/task_files.h"

#include "base/json_text.h"
#include "files/mark_file.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/files/named_file.h"

#include <nlohmann/json.hpp>

#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <climits>
#include <csignal>
#include <ctime>
#include <limits>

namespace vdbtools::farm {
namespace {

namespace fs = std::filesystem;

using Json = nlohmann::ordered_json;

constexpr const char* kKindKey = "juliavdb";
constexpr const char* kRecordKind = "task";
constexpr const char* kRunningKind = "running task";
constexpr const char* kFailedKind = "failed task";

/// A mark without a sign of life for this long, in seconds, belongs to a killed process.
constexpr std::time_t kLifeless = 60;

std::string text(const Json& json) {
  // An error message may contain a file name that is not UTF-8.
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + '\n';
}

/// The object in a file; a value of another kind if there is no file or it holds something else.
Json objectIn(const fs::path& path, const char* kind) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return {};
  try {
    Json json = parsedJson<Json>(readWholeFile(path));
    return json.is_object() && json.value(kKindKey, Json()) == kind ? std::move(json) : Json();
  } catch (const std::runtime_error&) {
    return {};  // it was removed in between
  }
}

std::optional<TaskRecord> recordFrom(const Json& json) {
  if (!json.is_object()) return std::nullopt;
  try {
    TaskRecord record;
    record.hash = json.at("hash").get<std::string>();
    for (const Json& entry : json.at("files"))
      record.files.push_back({entry.at("name").get<std::string>(), wholeOf<std::uint64_t>(entry.at("bytes")),
                              wholeOf<std::int64_t>(entry.at("modified")), entry.at("sha256").get<std::string>()});
    for (const auto& [name, value] : json.at("counts").items()) record.counts[name] = wholeOf<std::uint64_t>(value);
    record.wallSeconds = json.at("wallSeconds").get<double>();
    record.cpuSeconds = json.at("cpuSeconds").get<double>();
    record.peakBytes = wholeOf<std::uint64_t>(json.at("peakBytes"));
    record.host = json.at("host").get<std::string>();
    record.threads = wholeOf<int>(json.at("threads"));
    return record;
  } catch (const nlohmann::json::exception&) {
    return std::nullopt;
  }
}

/// Distinguishes a process from a later one with the same number: its start time, in ticks since the system started.
/// @return empty if there is no such process
std::string startOf(long process) {
  try {
    const std::string status = readWholeFile("/proc/" + std::to_string(process) + "/stat");
    // The name in parentheses may contain anything; the time is the 20th entry after it.
    std::size_t at = status.rfind(')');
    for (int i = 0; i < 20 && at != std::string::npos; ++i) at = status.find(' ', at + 1);
    if (at == std::string::npos) return {};
    return status.substr(at + 1, status.find(' ', at + 1) - at - 1);
  } catch (const std::runtime_error&) {
    return {};
  }
}

/// Whether the process that a mark names may still be running, if locks do not tell.
bool mayBeAlive(const fs::path& path) {
  const Json json = objectIn(path, kRunningKind);
  struct stat status {};
  if (!json.is_object() || ::stat(path.c_str(), &status) != 0) return false;
  try {
    if (json.at("host").get<std::string>() == hostName())
      return startOf(wholeOf<long>(json.at("process"))) == json.at("started").get<std::string>();
  } catch (const nlohmann::json::exception&) {
    return false;
  }
  return std::time(nullptr) - status.st_mtime < kLifeless;
}

bool isRunning(const fs::path& path) {
  switch (stateOfMark(path)) {
    case MarkState::Alive: return true;
    case MarkState::Unknown: return mayBeAlive(path);
    case MarkState::Dead:
    case MarkState::None: break;
  }
  return false;
}

/// @return what is wrong with the file, or ""
std::string misfit(const fs::path& folder, const TaskFile& recorded, FileCheck check) {
  const fs::path path = folder / recorded.name;
  const std::string name = inOneLine(recorded.name);
  const std::optional<TaskFile> present = presentFile(path);
  if (!present) return name + " is gone";
  if (present->bytes != recorded.bytes)
    return name + " has " + std::to_string(present->bytes) + " bytes and was written with " +
           std::to_string(recorded.bytes);
  if (check == FileCheck::Quick && present->modified == recorded.modified) return {};
  try {
    return sha256OfFile(path) == recorded.sha256 ? "" : name + " has changed since it was written";
  } catch (const MissingInputError&) {
    return name + " cannot be read";
  } catch (const IoError&) {
    return name + " cannot be read";
  }
}

/// @param problem  set if there is a side-car that does not match
std::optional<TaskRecord> fittingRecord(const fs::path& folder, const Manifest& manifest, std::uint64_t index,
                                        FileCheck check, std::string& problem) {
  const std::string hash = taskHash(manifest, index);
  const fs::path path = sideCarPath(folder, index);
  std::error_code error;
  if (!fs::exists(path, error)) return std::nullopt;
  std::optional<TaskRecord> record = recordFrom(objectIn(path, kRecordKind));
  const std::vector<std::string>& writes = manifest.tasks[index - 1].writes;
  if (!record) {
    problem = "its record is broken";
  } else if (record->hash != hash) {
    problem = "its record is that of another plan";
  } else if (record->files.size() != writes.size()) {
    problem = "its record is broken";
  } else {
    for (std::size_t i = 0; i < writes.size() && problem.empty(); ++i)
      problem = record->files[i].name == writes[i] ? misfit(folder, record->files[i], check) : "its record is broken";
  }
  if (!problem.empty()) record.reset();
  return record;
}

}  // namespace

std::uint64_t sumOfCounts(std::uint64_t a, std::uint64_t b) {
  if (b > std::numeric_limits<std::uint64_t>::max() - a)
    throw DataError("the counts of the tasks are too large to be added up; run the tasks again");
  return a + b;
}

std::string taskName(std::uint64_t index) {
  constexpr std::size_t kDigits = 4;
  const std::string digits = std::to_string(index);
  return std::string(kDigits - std::min(kDigits, digits.size()), '0') + digits;
}

std::string taskList(const std::vector<std::uint64_t>& indices) {
  std::string list;
  for (std::size_t i = 0; i < indices.size();) {
    std::size_t end = i + 1;
    while (end < indices.size() && indices[end] == indices[end - 1] + 1) ++end;
    list += (list.empty() ? "" : ",") + std::to_string(indices[i]);
    if (end > i + 1) list += "-" + std::to_string(indices[end - 1]);
    i = end;
  }
  return list;
}

fs::path tasksFolder(const fs::path& folder) { return folder / "tasks"; }
fs::path sideCarPath(const fs::path& folder, std::uint64_t index) {
  return tasksFolder(folder) / (taskName(index) + ".json");
}
fs::path runningPath(const fs::path& folder, std::uint64_t index) {
  return tasksFolder(folder) / (taskName(index) + std::string(kRunningSuffix));
}
fs::path failedPath(const fs::path& folder, std::uint64_t index) {
  return tasksFolder(folder) / (taskName(index) + ".failed.json");
}

std::string hostName() {
  std::array<char, HOST_NAME_MAX + 1> name{};
  return ::gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "unknown";
}

std::string encodeRecord(std::uint64_t index, const TaskRecord& record) {
  Json files = Json::array();
  for (const TaskFile& file : record.files)
    files.push_back({{"name", file.name}, {"bytes", file.bytes}, {"modified", file.modified}, {"sha256", file.sha256}});
  return text({{kKindKey, kRecordKind},
               {"task", index},
               {"hash", record.hash},
               {"files", std::move(files)},
               {"counts", record.counts},
               {"wallSeconds", record.wallSeconds},
               {"cpuSeconds", record.cpuSeconds},
               {"peakBytes", record.peakBytes},
               {"host", record.host},
               {"threads", record.threads}});
}

std::string encodeRunning(std::uint64_t index) {
  const long process = ::getpid();
  return text({{kKindKey, kRunningKind},
               {"task", index},
               {"host", hostName()},
               {"process", process},
               {"started", startOf(process)},
               {"since", std::time(nullptr)}});
}

std::string encodeFailure(std::uint64_t index, const std::string& hash, int exitCode, const std::string& error) {
  return text({{kKindKey, kFailedKind},
               {"task", index},
               {"hash", hash},
               {"exit", exitCode},
               {"error", error},
               {"host", hostName()},
               {"time", std::time(nullptr)}});
}

std::optional<TaskFile> presentFile(const fs::path& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0 || !S_ISREG(status.st_mode)) return std::nullopt;
  TaskFile file;
  file.bytes = static_cast<std::uint64_t>(status.st_size);
  file.modified = std::int64_t{status.st_mtim.tv_sec} * 1'000'000'000 + status.st_mtim.tv_nsec;
  return file;
}

std::optional<TaskRecord> finishedTask(const fs::path& folder, const Manifest& manifest, std::uint64_t index,
                                       FileCheck check) {
  std::string problem;
  return fittingRecord(folder, manifest, index, check, problem);
}

TaskStatus taskStatus(const fs::path& folder, const Manifest& manifest, std::uint64_t index, FileCheck check) {
  TaskStatus status;
  status.record = fittingRecord(folder, manifest, index, check, status.error);
  if (status.record) {
    status.state = TaskState::Done;
    return status;
  }
  if (isRunning(runningPath(folder, index))) {
    status.state = TaskState::Running;
    status.error.clear();
    return status;
  }
  const Json failure = objectIn(failedPath(folder, index), kFailedKind);
  if (failure.is_object() && failure.value("hash", Json()) == taskHash(manifest, index)) {
    try {
      status.exitCode = wholeOf<int>(failure.at("exit"));
      status.error =
          inOneLine(failure.at("error").get<std::string>()) + " (exit code " + std::to_string(*status.exitCode) + ")";
      std::error_code gone;
      const fs::file_time_type time = fs::last_write_time(failedPath(folder, index), gone);
      if (!gone) status.failedAt = time;
    } catch (const nlohmann::json::exception&) {
      status.exitCode.reset();  // the record is broken
    }
  }
  if (!status.error.empty()) status.state = TaskState::Failed;
  return status;
}

}  // namespace vdbtools::farm
