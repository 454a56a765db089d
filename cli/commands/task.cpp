// SPDX-License-Identifier: Apache-2.0
#include "commands.h"

#include "exit_code.h"
#include "failure.h"
#include "interruption.h"
#include "options.h"
#include "report.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/base/text.h"
#include "vdbtools/farm/task.h"

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <optional>
#include <ostream>

#include <malloc.h>

namespace po = boost::program_options;

namespace cli {
namespace {

constexpr Usage kTaskUsage = {
    "task", "DIR [--index I | --range A-B] [options]",
    "Makes one of the tasks of the plan in the folder DIR. Tasks count from 1. The number is that of --index or "
    "--range, else SLURM_ARRAY_TASK_ID, which Slurm sets for each job of an array, and with SLURM_ARRAY_TASK_STEP so "
    "many tasks from there on; else PARALLEL_SEQ, which GNU parallel sets for each of its jobs.\n\n"
    "A task that is done already is checked and left as it is, and beyond the last task there is nothing to do. A task "
    "may be stopped or killed at any moment and made again, on any machine that sees DIR. Exit code 75 says that it "
    "was stopped by a signal, or that the disk of another machine did not answer; then the task is worth another try.",
    "  juliavdb task farm --index 7\n"
    "  juliavdb task farm --range 7-12\n"};

using Number = std::uint64_t;

struct Range {
  Number first, last;
};

std::optional<Number> numberFrom(const std::string& text) {
  const std::optional<Number> number = vdbtools::wholeFromText<Number>(text);
  return number && *number >= 1 ? number : std::nullopt;
}

/// The value of a variable of the environment; nothing if it is not set.
std::optional<Number> variable(const char* name) {
  const char* text = std::getenv(name);
  if (!text) return std::nullopt;
  const std::optional<Number> number = numberFrom(text);
  if (!number)
    throw std::invalid_argument(std::string(name) + " is '" + text + "'; it must be a whole number of at least 1");
  return number;
}

Range rangeOf(const CommandLine& line) {
  if (line.has("index") && line.has("range")) throw std::invalid_argument("--index and --range exclude each other");
  if (line.has("index")) {
    const std::optional<Number> index = numberFrom(line.text("index"));
    if (!index) line.refuse("index", "a whole number of at least 1");
    return {*index, *index};
  }
  if (line.has("range")) {
    const std::string text = line.text("range");
    const std::size_t dash = std::min(text.find('-'), text.size());
    const std::optional<Number> first = numberFrom(text.substr(0, dash));
    const std::optional<Number> last = numberFrom(text.substr(std::min(dash + 1, text.size())));
    if (!first || !last || *last < *first) line.refuse("range", "two numbers of tasks such as 7-12");
    return {*first, *last};
  }
  if (const std::optional<Number> first = variable("SLURM_ARRAY_TASK_ID")) {
    const Number step = variable("SLURM_ARRAY_TASK_STEP").value_or(1);
    return {*first, *first + std::min(step - 1, std::numeric_limits<Number>::max() - *first)};
  }
  if (const std::optional<Number> index = variable("PARALLEL_SEQ")) return {*index, *index};
  throw std::invalid_argument(
      "which task to make is not known; use --index I or --range A-B, or run this as a job of a Slurm array or of GNU "
      "parallel");
}

/// Keeps freed memory in the process, so that the layers of a lattice reuse the memory of earlier layers. Memory that
/// is returned to the system has to be cleared before it is used again.
void keepFreedMemory() {
#ifdef __GLIBC__
  constexpr int kLargestOfHeap = 32 << 20, kKept = 1 << 30;
  mallopt(M_MMAP_THRESHOLD, kLargestOfHeap);
  mallopt(M_TRIM_THRESHOLD, kKept);
#endif
}

}  // namespace

int runTask(const Arguments& arguments) {
  CommandLine line(kTaskUsage, {});
  line.addPositional("folder", 1, "the folder of the plan");
  line.addOptions()("index", po::value<std::string>()->value_name("I"), "the number of the task")(
      "range", po::value<std::string>()->value_name("A-B"), "the numbers of the first and the last of several tasks");
  if (!line.parse(arguments)) return kDone;
  if (!line.has("folder")) throw std::invalid_argument("no plan was given; name its folder");
  const Range range = rangeOf(line);

  keepFreedMemory();
  vdbtools::farm::TaskRunner runner(line.text("folder"));
  const Number count = runner.manifest().tasks.size();
  if (range.last > count)
    report().text() << "the plan has the tasks 1 to " << count << "; there is nothing to do for "
                    << vdbtools::farm::taskList({std::max(range.first, count + 1)})
                    << (range.last > std::max(range.first, count + 1) ? " and later ones" : "") << '\n';
  std::vector<Failure> failures;
  Number failed = 0, madeTasks = 0, keptTasks = 0;
  for (Number index = range.first; index <= std::min(range.last, count); ++index) {
    try {
      const bool made = runner.run(index, line.progress(), [](const std::string& warning) {
        report().text() << "warning: " << warning << '\n';
      });
      report().count(made ? "madeTasks" : "keptTasks", ++(made ? madeTasks : keptTasks));
      report().text() << "task " << index << (made ? " is done\n" : " was done already\n");
      report().noteKept("finished tasks are kept, and the same command goes on from there");
      if (index == std::min(range.last, count) && failures.empty()) workIsDone();
    } catch (const vdbtools::Interrupted&) {
      throw;
    } catch (...) {
      const Failure failure = currentFailure();
      if (failure.code != kInterrupted) runner.recordFailure(index, failure.code, failure.text);
      if (range.first == range.last) throw;
      if (failures.empty()) failed = index;
      failures.push_back(failure);
    }
  }
  if (failures.empty()) return kDone;
  const std::string others = failures.size() == 1 ? "" : "; " + std::to_string(failures.size() - 1) + " more failed";
  throw FailedWith({failures.front().code, "task " + std::to_string(failed) + ": " + failures.front().text + others});
}

}  // namespace cli
