// SPDX-License-Identifier: Apache-2.0
#include "commands.h"

#include "child_process.h"
#include "exit_code.h"
#include "failure.h"
#include "interruption.h"
#include "merge_request.h"
#include "options.h"
#include "report.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/base/text.h"
#include "vdbtools/farm/job_template.h"
#include "vdbtools/farm/task.h"
#include "vdbtools/files/atomic_file.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/files/input_files.h"
#include "vdbtools/recipe/option_value.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <system_error>
#include <thread>

#include <unistd.h>

namespace po = boost::program_options;

namespace cli {
namespace {

namespace fs = std::filesystem;

constexpr Usage kSubmitUsage = {
    "submit",
    "DIR --engine slurm|parallel|script [--template FILE] [-o F.vdb] [--mesh F.ply] [options] [-- ENGINE ARGS]",
    "Gives the missing tasks of the plan in the folder DIR to Slurm, as the jobs of an array, to GNU parallel on this "
    "machine, or to any other engine by a script that you write as a template. With -o or --mesh, 'juliavdb merge' "
    "follows once they are all done; under Slurm as a job that depends on them. The words behind -- go to sbatch or to "
    "parallel, as in '-- --partition=long --mem=8G', or into the field 'arguments' of the template.\n\n"
    "This is done by a short script, DIR/logs/submit.sh or DIR/logs/submit; --dry-run prints it instead. After a "
    "failure, or if tasks were killed, give the same command again: only tasks that are neither done nor being made "
    "are submitted. GNU "
    "parallel is waited for, and the exit code is that of the tasks: the one that all failed ones share, or else the "
    "gravest. --threads N is the number of processors of each task, and not of this command; --memory, --instructions, "
    "--trust-importer and --progress are handed on to each task and to the merge.",
    "  juliavdb submit farm --engine parallel --jobs 2 -o bunny.vdb --mesh bunny.ply\n"
    "  juliavdb submit farm --engine slurm --dry-run -- --partition=long --time=02:00:00\n"
    "  juliavdb submit farm --engine script --template tractor.py --dry-run -o bunny.vdb\n"};

enum class Engine { Slurm, Parallel, Script };

/// Slurm's own default of MaxArraySize; indices stay below it.
constexpr std::uint64_t kUsualArraySize = 1001;
constexpr int kUsualJobs =
    100;  ///< tasks of a Slurm array that run at the same time: a shared disk should not serve more readers
constexpr int kMostJobs = 1'000'000;

/// Quotes words for a shell, each with a blank before it.
std::string quoted(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += " " + vdbtools::shellWord(word);
  return text;
}

/// The command that starts this program on any machine that has it at the same path.
std::string ownPath() {
  std::error_code error;
  const fs::path path = fs::read_symlink("/proc/self/exe", error);
  if (error) throw vdbtools::MissingInputError("the path of this program is not known: " + error.message());
  return path.string();
}

bool isInPath(const std::string& program) {
  const char* path = std::getenv("PATH");
  std::string_view rest = path ? path : "";
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find(':'), rest.size());
    const fs::path candidate = fs::path(rest.substr(0, end)) / program;
    if (end > 0 && ::access(candidate.c_str(), X_OK) == 0) return true;
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  return false;
}

/// The limit of the cluster's configuration, or Slurm's default if it cannot be queried.
std::uint64_t mostArraySize() {
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(::popen("scontrol show config 2>/dev/null", "re"), ::pclose);
  std::array<char, 512> text{};
  std::uint64_t size = kUsualArraySize;
  while (pipe && std::fgets(text.data(), static_cast<int>(text.size()), pipe.get()))
    if (unsigned long long value = 0; std::sscanf(text.data(), "MaxArraySize = %llu", &value) == 1 && value > 1)
      size = value;
  return size;
}

struct Submission {
  fs::path folder;  ///< absolute
  std::uint64_t tasks = 0;
  std::vector<std::uint64_t> missing;
  int jobs = 0, threads = 1;
  std::uint64_t batch = 1;  ///< tasks per process
  bool threadsGiven = false;
  std::vector<int> devices;         ///< for the tasks, by their slots in GNU parallel; empty for none
  bool allocatesGpus = false;       ///< whether Slurm gives each task a graphics processor
  std::vector<std::string> common;  ///< options of each task and of the merge
  std::vector<std::string> merge;   ///< the words after "juliavdb merge ."; empty: no merge
  std::vector<std::string> engineArguments;
};

std::string slurmScript(const Submission& s) {
  const std::string program = vdbtools::shellWord(ownPath());
  const std::string name = vdbtools::shellWord("--job-name=" + s.folder.filename().string());
  const std::string common = name + " --open-mode=append" + quoted(s.engineArguments);
  std::string script =
      "#!/bin/sh\n"
      "# Submits the missing tasks of a plan to Slurm" +
      std::string(s.merge.empty() ? "" : ", and the merge of all tasks once they are done") + ".\nset -eu\ncd " +
      vdbtools::shellWord(s.folder.string()) + "\n";
  if (!s.missing.empty()) {
    // Indices of an array must stay below its maximum size. For more tasks, each job makes several.
    const std::uint64_t most = mostArraySize() - 1;
    const std::uint64_t each = std::max(s.batch, (s.tasks + most - 1) / most);
    std::vector<std::uint64_t> array;
    for (const std::uint64_t index : s.missing)
      if (const std::uint64_t job = (index - 1) / each + 1; array.empty() || array.back() != job) array.push_back(job);
    const std::string which = each == 1 ? "--index \"$SLURM_ARRAY_TASK_ID\""
                                        : "--range \"$((SLURM_ARRAY_TASK_ID * " + std::to_string(each) + " - " +
                                              std::to_string(each - 1) + "))-$((SLURM_ARRAY_TASK_ID * " +
                                              std::to_string(each) + "))\"";
    script += "tasks=$(sbatch --parsable --array=" + vdbtools::farm::taskList(array) + "%" + std::to_string(s.jobs) +
              " --requeue --signal=B:TERM@60 \\\n    --cpus-per-task=" + std::to_string(s.threads) +
              (s.allocatesGpus ? " --gres=gpu:1" : "") + " --output=logs/%A_%a.log " + common + " \\\n    --wrap=" +
              vdbtools::shellWord("exec " + program + " task ." + quoted(s.common) +
                                  (s.allocatesGpus ? " --device opencl " : " ") + which) +
              ")\necho \"tasks: job ${tasks%%;*}\"\n";
  }
  if (!s.merge.empty())
    script +=
        "merge=$(sbatch --parsable " +
        std::string(s.missing.empty() ? ""
                                      : "--dependency=\"afterok:${tasks%%;*}\" --kill-on-invalid-dep=yes \\\n    ") +
        "--cpus-per-task=" + std::to_string(s.threads) + " --output=logs/%j.log " + common +
        " \\\n    --wrap=" + vdbtools::shellWord("exec " + program + " merge ." + quoted(s.common) + quoted(s.merge)) +
        ")\necho \"merge: job ${merge%%;*}\"\n";
  return script;
}

/// The option by which GNU parallel replaces {device}: the slots get the devices in turn.
std::string devicesBySlot(const std::vector<int>& devices) {
  const auto textOf = [](int device) { return std::to_string(device); };
  return " --rpl '{device} $_ = (" + vdbtools::joined(devices, ",", textOf) + ")[($job->slot() - 1) % " +
         std::to_string(devices.size()) + "]'";
}

std::string parallelScript(const Submission& s) {
  const std::string program = vdbtools::shellWord(ownPath());
  std::string script =
      "#!/bin/sh\n"
      "# Makes the missing tasks of a plan by GNU parallel" +
      std::string(s.merge.empty() ? "" : ", and merges all tasks once they are done") +
      ".\nset -eu\n# What is running is told to stop as well, and waited for.\ntrap 'exit 75' INT TERM\ncd " +
      vdbtools::shellWord(s.folder.string()) + "\n" + program + " status . --missing " +
      (s.batch == 1 ? "--lines" : "--batch " + std::to_string(s.batch)) + " |\n" +
      "  parallel --no-run-if-empty --jobs " + std::to_string(s.jobs) +
      " --joblog +logs/joblog --termseq TERM,2000,KILL,25" + (s.devices.empty() ? "" : devicesBySlot(s.devices)) +
      quoted(s.engineArguments) + " --quote \\\n    " + program + " task . --threads " + std::to_string(s.threads) +
      quoted(s.common) + (s.devices.empty() ? "" : " --device opencl:{device}") +
      (s.batch == 1 ? " --index {}\n" : " --range {}\n");
  if (!s.merge.empty())
    script += program + " merge ." + (s.threadsGiven ? " --threads " + std::to_string(s.threads) : "") +
              quoted(s.common) + quoted(s.merge) + "\n";
  return script;
}

/// @param jobTemplate  the template of --template
std::string scriptOf(const Submission& s, const vdbtools::farm::JobTemplate& jobTemplate) {
  std::vector<std::string> task{"task", s.folder.string(), "--threads", std::to_string(s.threads)};
  task.insert(task.end(), s.common.begin(), s.common.end());
  std::vector<std::string> merge;
  if (!s.merge.empty()) {
    merge = {"merge", s.folder.string()};
    if (s.threadsGiven) merge.insert(merge.end(), {"--threads", std::to_string(s.threads)});
    merge.insert(merge.end(), s.common.begin(), s.common.end());
    merge.insert(merge.end(), s.merge.begin(), s.merge.end());
  }
  return jobTemplate.fill({.name = s.folder.filename().string(),
                           .folder = s.folder.string(),
                           .program = ownPath(),
                           .tasks = s.missing,
                           .jobs = s.jobs,
                           .threads = s.threads,
                           .batch = s.batch,
                           .taskArguments = std::move(task),
                           .mergeArguments = std::move(merge),
                           .arguments = s.engineArguments});
}

const char* programOf(Engine engine) {
  return engine == Engine::Slurm ? "sbatch" : engine == Engine::Parallel ? "parallel" : "the script of --template";
}

/// The state of the tasks after the script has ended.
struct Outcome {
  std::vector<std::uint64_t> notDone, running;
  std::map<std::uint64_t, std::string> errors;  ///< of the tasks that have failed
  std::set<int> codes;                          ///< exit codes of the failures
};

/// The exit codes of tasks that GNU parallel has logged after position @a from, for tasks that ended by themselves.
/// They are needed because a full disk may have no room for the task's own record of its failure.
std::map<std::uint64_t, int> loggedCodes(const fs::path& joblog, std::uintmax_t from, std::uint64_t tasks) {
  std::map<std::uint64_t, int> codes;
  std::ifstream log = vdbtools::openToRead(joblog);
  log.seekg(static_cast<std::streamoff>(from));
  for (std::string line; std::getline(log, line);) {
    // Seq, Host, Starttime, JobRuntime, Send, Receive, Exitval, Signal, Command; the last word is the task's number, or
    // a range of them.
    const std::vector<std::string> columns = vdbtools::split(line, '\t');
    if (columns.size() < 9) continue;
    const auto code = vdbtools::wholeFromText<int>(columns[6]);
    const std::vector<std::string> ends = vdbtools::split(line.substr(line.rfind(' ') + 1), '-');
    const auto first = vdbtools::wholeFromText<std::uint64_t>(ends.front());
    const auto last = vdbtools::wholeFromText<std::uint64_t>(ends.back());
    if (!code || !first || !last || columns[7] != "0") continue;
    for (std::uint64_t index = *first; index <= std::min(*last, tasks); ++index) codes[index] = *code;
  }
  return codes;
}

/// @param since  earlier failures belong to previous submissions and are ignored
Outcome outcomeOf(const Submission& s, const vdbtools::farm::Manifest& manifest,
                  const std::map<std::uint64_t, int>& logged, fs::file_time_type since) {
  Outcome outcome;
  for (std::uint64_t index = 1; index <= manifest.tasks.size(); ++index) {
    const vdbtools::farm::TaskStatus status =
        vdbtools::farm::taskStatus(s.folder, manifest, index, vdbtools::farm::FileCheck::Quick);
    if (status.state == vdbtools::farm::TaskState::Done) continue;
    if (status.state == vdbtools::farm::TaskState::Running) {
      outcome.running.push_back(index);
      continue;
    }
    outcome.notDone.push_back(index);
    if (status.failedAt && *status.failedAt < since) continue;
    const auto code = logged.find(index);
    if (status.state == vdbtools::farm::TaskState::Failed) outcome.errors[index] = status.error;
    if (status.exitCode)
      outcome.codes.insert(*status.exitCode);
    else if (code != logged.end() && code->second != kDone)
      outcome.codes.insert(code->second);
  }
  return outcome;
}

std::string tasksText(const std::vector<std::uint64_t>& tasks) {
  return (tasks.size() == 1 ? "task " : "tasks ") + vdbtools::farm::taskList(tasks);
}

/// Throws the error for a script that failed. The failing tasks have printed their reasons, but among the output of all
/// other tasks, so the message repeats the first few of them.
/// @param code  the exit code of the script
[[noreturn]] void refuseOutcome(const Submission& s, Engine engine, const Outcome& outcome, int code) {
  const std::string program = programOf(engine), all = " of " + std::to_string(s.tasks);
  constexpr const char* kAgain = "the same command goes on from there";
  constexpr int kEngineFailed =
      255;  // exit code of GNU parallel itself; codes up to 101 are the number of failed tasks
  // The words after -- are all that an engine receives besides the script.
  const int engineCode = s.engineArguments.empty() ? kInterrupted : kUsage;
  if (interrupted())
    throw FailedWith({kInterrupted, "interrupted; " +
                                        (outcome.notDone.empty()
                                             ? ""
                                             : tasksText(outcome.notDone) + all +
                                                   (outcome.notDone.size() == 1 ? " is" : " are") + " not done, and ") +
                                        kAgain});
  if (engine != Engine::Parallel || (code == kEngineFailed && outcome.codes.empty()))
    throw FailedWith({engineCode, program + " failed with code " + std::to_string(code) + ", and has said why above; " +
                                      (s.engineArguments.empty() ? std::string() : "see the words behind --; ") +
                                      kAgain});
  if (outcome.notDone.empty() && outcome.running.empty()) {
    const bool known = gravestCode({code}) == code;
    throw FailedWith(
        {known ? code : kInterrupted,
         "all tasks are done, but not their merge, which has said why above; the same command merges them"});
  }
  if (outcome.notDone.empty())
    throw FailedWith({kInterrupted, tasksText(outcome.running) + all +
                                        " are still being made by others; once they are done, " + kAgain});
  constexpr std::size_t kNamed = 3;
  std::string reasons;
  std::size_t named = 0;
  for (const auto& [index, error] : outcome.errors) {
    if (named++ == kNamed) break;
    reasons += (reasons.empty() ? ": " : "; ") + ("task " + std::to_string(index) + ": " + error);
  }
  if (outcome.errors.size() > kNamed) reasons += "; " + std::to_string(outcome.errors.size() - kNamed) + " more failed";
  throw FailedWith({gravestCode(outcome.codes), tasksText(outcome.notDone) + all +
                                                    (outcome.notDone.size() == 1 ? " is" : " are") + " not done" +
                                                    reasons + "; " + kAgain});
}

/// Runs the script and waits for it.
void runScript(const Submission& s, Engine engine, const vdbtools::farm::Manifest& manifest, const fs::path& script) {
  const fs::path joblog = s.folder / "logs" / "joblog";
  std::error_code error;
  std::uintmax_t logged = fs::file_size(joblog, error);
  if (error) logged = 0;
  const fs::file_time_type since = fs::last_write_time(script);  // by the clock of the disk on which the records are
  std::cout.flush();
  const int code = engine == Engine::Script ? runProgram({script.string()}) : runProgram({"/bin/sh", script.string()});
  if (engine == Engine::Parallel) vdbtools::farm::removeUnneeded(s.folder, manifest);
  if (code == kDone) return;
  std::map<std::uint64_t, int> codes;
  if (engine == Engine::Parallel && fs::exists(joblog, error)) codes = loggedCodes(joblog, logged, s.tasks);
  Outcome outcome = outcomeOf(s, manifest, codes, since);
  // The disk may be so full that not even the failures could be recorded.
  if (outcome.codes.empty() && fs::space(s.folder, error).available == 0) outcome.codes.insert(kInputOutput);
  refuseOutcome(s, engine, outcome, code);
}

/// Reads --gpus.
void addGpus(const CommandLine& line, Engine engine, Submission& submission) {
  const std::string value = line.text("gpus");
  if (line.has("device"))
    throw std::invalid_argument("--gpus and --device both say where tasks are evaluated; leave out one of them");
  if (engine == Engine::Script)
    throw std::invalid_argument("--gpus goes with --engine slurm or parallel; put --device into the template instead");
  if (engine == Engine::Slurm) {
    if (value != "allocated")
      throw std::invalid_argument("--gpus is '" + value + "'; Slurm chooses the devices, so it must be 'allocated'");
    submission.allocatesGpus = true;
    return;
  }
  for (const std::string& word : vdbtools::split(value, ',')) {
    const auto number = vdbtools::wholeFromText<int>(word);
    if (!number || *number < 0)
      throw std::invalid_argument("--gpus is '" + value +
                                  "'; with --engine parallel it must be numbers of devices such as 0,1, which "
                                  "'juliavdb devices' lists");
    submission.devices.push_back(*number);
  }
}

}  // namespace

int runSubmit(const Arguments& arguments) {
  CommandLine line(kSubmitUsage, {});
  line.addPositional("folder", 1, "the folder of the plan");
  line.addOptions()("engine", po::value<std::string>()->value_name("slurm|parallel|script"), "what runs the tasks")(
      "template", po::value<std::string>()->value_name("FILE"),
      "with --engine script: the template of the script that submits the tasks (docs/farm.md); those for OpenCue, "
      "Deadline and Tractor are installed in share/juliavdb/templates")("dry-run", po::bool_switch(),
                                                                        "print the script, and do nothing")(
      "jobs", po::value<std::string>()->value_name("N"),
      "how many tasks may run at a time (default: 100 for slurm and script; for parallel the processors that this "
      "process may use, divided by --threads)")(
      "batch", po::value<std::string>()->value_name("N"),
      "how many tasks a process makes one after another, which spares small ones reading what they share (default: 1)");
  line.addOptions()(
      "gpus", po::value<std::string>()->value_name("LIST|allocated"),
      "the devices that evaluate the tasks, as 'juliavdb devices' numbers them, such as 0,1: with parallel, "
      "each slot has one of them in turn, and --jobs is their number; with slurm, 'allocated' asks for one "
      "graphics processor for each task (--gres=gpu:1)");
  addMergeOptions(line);
  const auto dashes = std::find(arguments.begin(), arguments.end(), "--");
  if (!line.parse(Arguments(arguments.begin(), dashes))) return kDone;
  if (!line.has("folder")) throw std::invalid_argument("no plan was given; name its folder");
  if (!line.has("engine"))
    throw std::invalid_argument("no engine was given; use --engine slurm, --engine parallel or --engine script");
  const auto engine = line.choice<Engine>(
      "engine", {{"slurm", Engine::Slurm}, {"parallel", Engine::Parallel}, {"script", Engine::Script}});
  line.requireUse(engine == Engine::Script, {"template"}, "it goes with --engine script; give that, or leave it out");
  std::optional<vdbtools::farm::JobTemplate> jobTemplate;
  if (engine == Engine::Script) {
    if (!line.has("template"))
      throw std::invalid_argument("--engine script needs a template; name it with --template FILE");
    jobTemplate.emplace(line.text("template"), vdbtools::readWholeFile(line.text("template")));
    line.requireUse(jobTemplate->has("batch"), {"batch"},
                    "the template has no field @{batch}; add it there, or leave this out");
  }

  const vdbtools::farm::Manifest manifest = vdbtools::farm::readManifest(line.text("folder"));
  Submission submission;
  submission.folder = fs::canonical(line.text("folder"));
  submission.tasks = manifest.tasks.size();
  const MergeRequest merge = parseMergeRequest(line);
  if (!merge.empty()) {
    if (manifest.kind != vdbtools::farm::PlanKind::Tiles)
      throw std::invalid_argument("only a plan of tiles is merged; leave out -o, --mesh and --index");
    requireMergeable(submission.folder, manifest, merge);
    if (jobTemplate) {
      vdbtools::InputFiles inputs;
      inputs.add(line.text("template"));
      for (const auto& output : {merge.files.grids, merge.files.mesh, merge.index, merge.counts})
        if (output) inputs.requireNot(*output);
    }
    submission.merge = mergeWords(line);
  }
  submission.common = line.commonWords();
  if (dashes != arguments.end()) submission.engineArguments.assign(dashes + 1, arguments.end());
  submission.threadsGiven = line.has("threads");
  if (submission.threadsGiven) submission.threads = line.integer("threads", 1, kMostJobs);
  if (line.has("batch")) submission.batch = static_cast<std::uint64_t>(line.integer("batch", 1, kMostJobs));
  if (line.has("gpus")) addGpus(line, engine, submission);
  const int processors = static_cast<int>(std::thread::hardware_concurrency());
  submission.jobs = line.has("jobs")              ? line.integer("jobs", 1, kMostJobs)
                    : !submission.devices.empty() ? static_cast<int>(submission.devices.size())
                    : engine == Engine::Parallel  ? std::max(1, processors / submission.threads)
                                                  : kUsualJobs;
  for (std::uint64_t index = 1; index <= manifest.tasks.size(); ++index) {
    const auto state =
        vdbtools::farm::taskStatus(submission.folder, manifest, index, vdbtools::farm::FileCheck::Quick).state;
    if (state == vdbtools::farm::TaskState::Missing || state == vdbtools::farm::TaskState::Failed)
      submission.missing.push_back(index);
  }

  const std::string script = jobTemplate               ? scriptOf(submission, *jobTemplate)
                             : engine == Engine::Slurm ? slurmScript(submission)
                                                       : parallelScript(submission);
  if (line.values()["dry-run"].as<bool>()) {
    std::cout << script;
    return kDone;
  }
  if (submission.missing.empty() && submission.merge.empty()) {
    vdbtools::farm::removeUnneeded(submission.folder, manifest);
    report().text() << "there is nothing to submit: every task is done, or is being made\n";
    return kDone;
  }
  const std::string program = programOf(engine);
  if (engine != Engine::Script && !isInPath(program))
    throw vdbtools::MissingInputError("there is no program '" + program + "' in PATH; install it (Debian: " +
                                      (engine == Engine::Slurm ? "slurm-client" : "parallel") +
                                      "), or choose another --engine");
  const fs::path logs = submission.folder / vdbtools::farm::kLogsName;
  std::error_code error;
  fs::create_directories(logs, error);
  if (error) throw vdbtools::CreateError("cannot create '" + logs.string() + "': " + error.message());
  const fs::path place = logs / (engine == Engine::Script ? "submit" : "submit.sh");
  {
    vdbtools::AtomicFile file(place);
    file.stream() << script;
    file.commit();
  }
  if (engine == Engine::Script) {
    fs::permissions(place, fs::perms::owner_exec | fs::perms::group_exec, fs::perm_options::add, error);
    if (error) throw vdbtools::CreateError("cannot make '" + place.string() + "' executable: " + error.message());
  }
  runScript(submission, engine, manifest, place);
  return kDone;
}

}  // namespace cli
