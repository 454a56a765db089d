// SPDX-License-Identifier: Apache-2.0
/// @file task_files.h
/// The files DIR/tasks/0007*.json: their names and what is in them.
#pragma once

#include "vdbtools/farm/task.h"

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace vdbtools::farm {

inline constexpr std::string_view kRunningSuffix = ".running.json";

/// The interval at which a running task touches its mark.
inline constexpr std::chrono::seconds kSignOfLife(10);

std::filesystem::path tasksFolder(const std::filesystem::path& folder);
std::filesystem::path sideCarPath(const std::filesystem::path& folder, std::uint64_t index);
std::filesystem::path runningPath(const std::filesystem::path& folder, std::uint64_t index);
std::filesystem::path failedPath(const std::filesystem::path& folder, std::uint64_t index);

std::string hostName();

std::string encodeRecord(std::uint64_t index, const TaskRecord& record);
/// The text of the running mark, which names this process.
std::string encodeRunning(std::uint64_t index);
std::string encodeFailure(std::uint64_t index, const std::string& hash, int exitCode, const std::string& error);

/// A file's size and time, without its hash; empty if the file does not exist.
std::optional<TaskFile> presentFile(const std::filesystem::path& path);

}  // namespace vdbtools::farm
