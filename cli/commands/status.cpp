// SPDX-License-Identifier: Apache-2.0
#include "commands.h"

#include "exit_code.h"
#include "options.h"
#include "report.h"

#include "vdbtools/farm/task.h"

#include <nlohmann/json.hpp>

#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <iostream>
#include <optional>
#include <set>

namespace po = boost::program_options;

namespace cli {
namespace {

constexpr int kMostBatch = 1'000'000;

constexpr Usage kStatusUsage = {
    "status", "DIR [--json] [--exit-code] | [--missing [--lines | --batch N]] [options]",
    "Shows how many tasks of the plan in the folder DIR are done, are being made, have failed, or are missing, and "
    "what they took. What is to come is told from the tasks that are done, as if the others were like them.\n\n"
    "With --missing, nothing is printed but the numbers of the tasks that are neither done nor being made, in the "
    "notation of Slurm's arrays, such as 3,7,10-12; failed tasks are among them.\n\n"
    "With --exit-code, the code is 0 if all tasks are done, that of the tasks if some have failed (the gravest, if "
    "they differ), and 75 if tasks are left to be made.",
    "  juliavdb status farm\n"
    "  juliavdb status farm --json\n"
    "  juliavdb status farm --missing\n"};

using vdbtools::farm::TaskState;

/// Sums over all tasks of one state.
struct Sums {
  std::uint64_t tasks = 0, bytes = 0, peakBytes = 0;
  std::uint64_t made = 0;  ///< triangles, or evaluated nodes
  double cpuSeconds = 0, wallSeconds = 0;
};

std::string rounded(double value, const char* unit) {
  std::array<char, 48> text{};
  std::snprintf(text.data(), text.size(), value < 10 ? "%.1f %s" : "%.0f %s", value, unit);
  return text.data();
}

std::string duration(double seconds) {
  constexpr double kMinute = 60, kHour = 3600, kDay = 86400;
  if (seconds < 2 * kMinute) return rounded(seconds, "s");
  if (seconds < 2 * kHour) return rounded(seconds / kMinute, "min");
  if (seconds < 3 * kDay) return rounded(seconds / kHour, "h");
  return rounded(seconds / kDay, "days");
}

std::string size(double bytes) {
  constexpr double kStep = 1024;
  for (const char* unit : {"KiB", "MiB", "GiB"}) {
    bytes /= kStep;
    if (bytes < kStep) return rounded(bytes, unit);
  }
  return rounded(bytes / kStep, "TiB");
}

/// An estimated number as text.
std::string roughCount(double value) {
  constexpr double kMany = 1e7, kThousand = 1e3;
  std::array<char, 32> text{};
  if (value < kMany) {
    std::snprintf(text.data(), text.size(), "%.0f", value);
    return text.data();
  }
  value /= 1e6;
  const char* unit = "million";
  for (const char* larger : {"billion", "trillion"}) {
    // A number that would be rounded to 1000 of a unit is 1 of the next one.
    if (value < 0.9995 * kThousand) break;
    value /= kThousand;
    unit = larger;
  }
  std::snprintf(text.data(), text.size(), "%.3g %s", value, unit);
  return text.data();
}

/// @param batch  the maximum number of tasks in a range; empty: no ranges
void printLists(const std::vector<std::uint64_t>& missing, bool lines, std::optional<std::uint64_t> batch) {
  if (!lines && !batch) {
    if (!missing.empty()) std::cout << vdbtools::farm::taskList(missing) << '\n';
    return;
  }
  for (std::size_t i = 0; batch && i < missing.size();) {
    std::size_t end = i + 1;
    while (end < missing.size() && end - i < *batch && missing[end] == missing[end - 1] + 1) ++end;
    std::cout << missing[i] << '-' << missing[end - 1] << '\n';
    i = end;
  }
  if (batch) return;
  for (const std::uint64_t index : missing) std::cout << index << '\n';
}

}  // namespace

int runStatus(const Arguments& arguments) {
  CommandLine line(kStatusUsage, {});
  line.addPositional("folder", 1, "the folder of the plan");
  line.addOptions()("missing", po::bool_switch(), "print the numbers of the tasks that have to be made")(
      "lines", po::bool_switch(), "with --missing: one number a line, as GNU parallel reads them")(
      "batch", po::value<std::string>()->value_name("N"),
      "with --missing: ranges of up to N tasks such as 7-12, one a line, as 'juliavdb task --range' reads them")(
      "json", po::bool_switch(), "the same for other programs")("exit-code", po::bool_switch(),
                                                                "end with the code that the tasks have come to")(
      "verify", po::bool_switch(),
      "read every file and compare its SHA-256; otherwise a file of the recorded size and "
      "time counts as unchanged");
  if (!line.parse(arguments)) return kDone;
  if (!line.has("folder")) throw std::invalid_argument("no plan was given; name its folder");
  const bool onlyMissing = line.values()["missing"].as<bool>(), lines = line.values()["lines"].as<bool>();
  if (lines && !onlyMissing) throw std::invalid_argument("--lines goes with --missing only");
  std::optional<std::uint64_t> batch;
  if (line.has("batch")) batch = static_cast<std::uint64_t>(line.integer("batch", 1, kMostBatch));
  if (batch && !onlyMissing) throw std::invalid_argument("--batch goes with --missing only");
  const bool json = line.values()["json"].as<bool>();
  if (json && onlyMissing) throw std::invalid_argument("--json and --missing exclude each other");
  if (batch && lines) throw std::invalid_argument("--batch and --lines exclude each other");
  const auto check =
      line.values()["verify"].as<bool>() ? vdbtools::farm::FileCheck::Content : vdbtools::farm::FileCheck::Quick;

  const std::filesystem::path folder = line.text("folder");
  const vdbtools::farm::Manifest manifest = vdbtools::farm::readManifest(folder);
  const bool triangles =
      vdbtools::farm::makesMesh(manifest) || vdbtools::farm::makes(manifest, vdbtools::farm::kMakeCount);
  Sums done;
  std::uint64_t running = 0, failed = 0;
  std::vector<std::uint64_t> missing;
  std::string failures;
  nlohmann::json failedTasks = nlohmann::json::array();
  std::set<int> codes;
  for (std::uint64_t index = 1; index <= manifest.tasks.size(); ++index) {
    line.progress().throwIfCancelled();
    const vdbtools::farm::TaskStatus status = vdbtools::farm::taskStatus(folder, manifest, index, check);
    switch (status.state) {
      case TaskState::Done: {
        ++done.tasks;
        if (onlyMissing) break;
        const auto made = status.record->counts.find(triangles ? "triangles" : "evaluatedNodes");
        if (made != status.record->counts.end()) done.made = vdbtools::farm::sumOfCounts(done.made, made->second);
        done.cpuSeconds += status.record->cpuSeconds;
        done.wallSeconds += status.record->wallSeconds;
        done.peakBytes = std::max(done.peakBytes, status.record->peakBytes);
        for (const vdbtools::farm::TaskFile& file : status.record->files) done.bytes += file.bytes;
        break;
      }
      case TaskState::Running: ++running; break;
      case TaskState::Failed:
        ++failed;
        if (status.exitCode) codes.insert(*status.exitCode);
        if (json) {
          failedTasks.push_back({{"task", index}, {"error", status.error}});
          if (status.exitCode) failedTasks.back()["code"] = *status.exitCode;
        }
        failures += "task " + std::to_string(index) + " failed: " + status.error + '\n';
        missing.push_back(index);
        break;
      case TaskState::Missing: missing.push_back(index); break;
    }
  }
  int code = kDone;
  if (line.values()["exit-code"].as<bool>() && done.tasks != manifest.tasks.size())
    code = failed ? gravestCode(codes) : static_cast<int>(kInterrupted);
  if (onlyMissing) {
    printLists(missing, lines, batch);
    return code;
  }
  if (json) {
    std::cout << nlohmann::json{{"tasks", manifest.tasks.size()},
                                {"done", done.tasks},
                                {"running", running},
                                {"failed", failedTasks},
                                {"missing", missing.size() - failed},
                                {"toBeMade", vdbtools::farm::taskList(missing)},
                                {triangles ? "triangles" : "evaluatedNodes", done.made},
                                {"cpuSeconds", done.cpuSeconds},
                                {"wallSeconds", done.wallSeconds},
                                {"bytes", done.bytes},
                                {"peakBytes", done.peakBytes}}
                     .dump(1, ' ', false, nlohmann::json::error_handler_t::replace)
              << '\n';
    return code;
  }

  std::cout << manifest.tasks.size() << " tasks: " << done.tasks << " done, " << running << " running, " << failed
            << " failed, " << missing.size() - failed << " missing\n"
            << failures;
  if (!missing.empty()) std::cout << "to be made: " << vdbtools::farm::taskList(missing) << '\n';
  if (done.tasks == 0) return code;
  const double left = static_cast<double>(manifest.tasks.size() - done.tasks);
  const double part = left / static_cast<double>(done.tasks);
  const auto both = [&](const char* what, const std::string& soFar, const std::string& toGo) {
    std::cout << what << ": " << soFar;
    if (left > 0) std::cout << " so far, about " << toGo << " to go";
    std::cout << '\n';
  };
  const auto bytes = static_cast<double>(done.bytes);
  both(triangles ? "triangles" : "evaluated nodes", std::to_string(done.made),
       roughCount(static_cast<double>(done.made) * part));
  both("CPU time", duration(done.cpuSeconds), duration(done.cpuSeconds * part));
  both("time of tasks", duration(done.wallSeconds), duration(done.wallSeconds * part));
  both("files", size(bytes), size(bytes * part));
  std::cout << "memory of a task: at most " << size(static_cast<double>(done.peakBytes)) << '\n';
  return code;
}

}  // namespace cli
