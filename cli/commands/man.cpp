// SPDX-License-Identifier: Apache-2.0
// Manual pages, and the completion of shells. Each command describes itself; this file puts the descriptions together.
#include "commands.h"

#include "describe.h"
#include "exit_code.h"
#include "interruption.h"
#include "options.h"
#include "report.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/base/text.h"
#include "vdbtools/files/output_files.h"

#include <algorithm>
#include <functional>
#include <iostream>
#include <sstream>
#include <stdexcept>
#include <system_error>

namespace po = boost::program_options;

namespace cli {
namespace {

constexpr Usage kManUsage = {
    "man", "[COMMAND] | -o DIR",
    "Writes a manual page for 'man': that of the program, or that of a command. They are made from what --help says. "
    "With -o the pages of all commands go into a folder, as juliavdb.1, juliavdb-fractal.1 and so on.",
    "  juliavdb man fractal > juliavdb-fractal.1\n"
    "  juliavdb man plan frames > juliavdb-plan-frames.1\n"
    "  juliavdb man -o man1\n"};

constexpr Usage kCompletionUsage = {
    "completion", "",
    "Writes the completion of command lines for bash: commands, their options, and the values that these may have. An "
    "installed package has it already; otherwise 'source' it in ~/.bashrc.",
    "  juliavdb completion > juliavdb.bash\n"};

constexpr std::pair<ExitCode, const char*> kExits[] = {
    {kDone, "done"},
    {kUsage, "the command line is wrong: an unknown option, or a value that is not allowed"},
    {kBadData, "an input was read but cannot be used, or the result is empty"},
    {kNoInput, "an input is missing"},
    {kInternal, "memory is short, or an error of the program"},
    {kCannotCreate, "an output cannot be created"},
    {kInputOutput, "reading or writing broke off"},
    {kInterrupted,
     "stopped by a signal, or the disk of another machine did not answer; no file is half written, and the same "
     "command may be tried again"},
};

constexpr std::pair<const char*, const char*> kVariables[] = {
    {"SLURM_CPUS_PER_TASK", "the number of threads, where --threads is not given"},
    {"SLURM_CPUS_ON_NODE", "the same, in a job of Slurm without SLURM_CPUS_PER_TASK"},
    {"JULIAVDB_MEMORY", "how much memory a run may take, where --memory is not given"},
    {"SLURM_ARRAY_TASK_ID", "the number of the task that 'juliavdb task' makes, where none is given"},
    {"SLURM_ARRAY_TASK_STEP", "how many tasks from there on it makes"},
    {"PARALLEL_SEQ", "the number of the task, outside of Slurm"},
};

/// All commands, and the parts of those that have parts, by the words that are typed: "fractal", "plan", "plan frames".
std::vector<std::pair<std::string, const Command*>> allCommands() {
  std::vector<std::pair<std::string, const Command*>> all;
  for (const Command& command : commands()) {
    all.emplace_back(command.name, &command);
    for (const Command& part : command.parts()) all.emplace_back(std::string(command.name) + ' ' + part.name, &part);
  }
  return all;
}

/// The text that a command prints when it is asked to describe itself.
std::string described(const Command& command, const char* how) {
  std::ostringstream text;
  std::streambuf* const before = std::cout.rdbuf(text.rdbuf());
  try {
    command.run({"--describe", how});
  } catch (...) {
    std::cout.rdbuf(before);
    throw;
  }
  std::cout.rdbuf(before);
  return text.str();
}

std::string pageName(std::string command) {
  std::replace(command.begin(), command.end(), ' ', '-');
  return command.empty() ? "juliavdb" : "juliavdb-" + command;
}

std::string programPage() {
  std::ostringstream page;
  page
      << ".TH JULIAVDB 1 \"\" \"juliavdb " JULIAVDB_VERSION
         "\" \"JuliaVDB\"\n.nh\n.ad l\n.SH NAME\n"
         "juliavdb \\- turn a mesh into a fractal of the same shape\n.SH SYNOPSIS\n.B juliavdb\n.I COMMAND\n[options]\n"
         ".SH DESCRIPTION\nMakes fractals in the shape of a mesh as OpenVDB level sets, as meshes and as pictures.\n"
         "Each command has a manual page of its own.\n.SH COMMANDS\n";
  for (const auto& [name, command] : allCommands())
    page << ".TP\n.B " << manualText(name) << '\n'
         << manualText(command->summary) << "; see\n.BR " << manualText(pageName(name)) << " (1)\n";
  page << ".SH OPTIONS\n.TP\n\\fB\\-h\\fR, \\fB\\-\\-help\\fR\nlist the commands; after a command, describe it\n.TP\n"
          "\\fB\\-\\-version\\fR\nprint the version\n.SH EXIT STATUS\n";
  for (const auto& [code, meaning] : kExits) page << ".TP\n.B " << code << '\n' << manualText(meaning) << '\n';
  page << ".SH ENVIRONMENT\n";
  for (const auto& [variable, meaning] : kVariables)
    page << ".TP\n.B " << variable << '\n' << manualText(meaning) << '\n';
  return page.str();
}

void writePages(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw vdbtools::CreateError("cannot make the folder '" + folder.string() + "': " + error.message());
  vdbtools::OutputFiles files({});
  const auto write = [&](const std::string& name, const std::string& page) {
    files.add(folder / (pageName(name) + ".1")).stream() << page;
  };
  write("", programPage());
  for (const auto& [name, command] : allCommands()) write(name, described(*command, "man"));
  files.finish();
  const Placing placing;
  files.commit();
  for (const vdbtools::AtomicFile& file : files.files()) report().wrote(file.target());
  workIsDone();
  report().text() << "wrote " << files.files().size() << " pages into " << folder.string() << '\n';
}

constexpr const char* kCompletionHead = R"(# Completion of juliavdb for bash.
# _juliavdb_table COMMAND prints a line for each option: its name, what follows it, and values that it may have.
_juliavdb_table() {
  case $1 in
)";

constexpr const char* kCompletionTail = R"(    *) return 1 ;;
  esac
}

_juliavdb() {
  local cur=${COMP_WORDS[COMP_CWORD]} option=${COMP_WORDS[COMP_CWORD - 1]} key= first= name kind words options=()
  COMPREPLY=()
  # --name=value comes as three words.
  if [[ $cur == = ]]; then
    cur=
  elif [[ $option == = ]] && ((COMP_CWORD > 2)); then
    option=${COMP_WORDS[COMP_CWORD - 2]}
  fi
  ((COMP_CWORD > 1)) && key=${COMP_WORDS[1]}
  if ((COMP_CWORD > 2)) && _juliavdb_table "$key ${COMP_WORDS[2]}" >/dev/null; then
    key+=" ${COMP_WORDS[2]}"
  fi
  while read -r name kind words; do
    if [[ $name == words ]]; then
      first="$kind $words"
      continue
    fi
    options+=("$name")
    if [[ $name == "$option" && $kind != flag ]]; then
      [[ $kind == file ]] && compopt -o default 2>/dev/null
      [[ $kind == folder ]] && compopt -o dirnames 2>/dev/null
      COMPREPLY=($(compgen -W "$words" -- "$cur"))
      return
    fi
  done < <(_juliavdb_table "$key")
  if [[ $cur == -* ]]; then
    COMPREPLY=($(compgen -W "${options[*]}" -- "$cur"))
  elif [[ $first ]] && ((COMP_CWORD <= 2)); then
    COMPREPLY=($(compgen -W "$first" -- "$cur"))
  elif ((COMP_CWORD > 1)); then
    compopt -o default 2>/dev/null
  fi
}

complete -F _juliavdb juliavdb
)";

/// A case of _juliavdb_table.
std::string completionCase(const std::string& command, const std::string& table) {
  return "    '" + command + "') cat <<'END'\n" + table + "END\n      ;;\n";
}

}  // namespace

int runMan(const Arguments& arguments) {
  CommandLine line(kManUsage, vdbtools::OptionTable());
  line.addPositional("command", -1, "the command");
  line.addOptions()("output,o", po::value<std::string>()->value_name("DIR"), "a folder for the pages of all commands");
  if (!line.parse(arguments)) return kDone;
  const std::string wanted = vdbtools::joined(line.texts("command"), " ");
  if (line.has("output")) {
    if (!wanted.empty()) throw std::invalid_argument("-o writes the pages of all commands; leave '" + wanted + "' out");
    writePages(line.text("output"));
    return kDone;
  }
  if (wanted.empty()) {
    std::cout << programPage();
    return kDone;
  }
  for (const auto& [name, command] : allCommands()) {
    if (name != wanted) continue;
    std::cout << described(*command, "man");
    return kDone;
  }
  std::vector<std::string> names;
  for (const auto& [name, command] : allCommands()) names.push_back(name);
  throw std::invalid_argument("'" + wanted + "' is not a command; 'juliavdb --help' lists them" +
                              vdbtools::didYouMean(wanted, names));
}

int runCompletion(const Arguments& arguments) {
  CommandLine line(kCompletionUsage, vdbtools::OptionTable());
  if (!line.parse(arguments)) return kDone;
  std::string words = "words";
  for (const Command& command : commands()) words += std::string(" ") + command.name;
  std::cout << kCompletionHead << completionCase("", words + "\n--help flag\n--version flag\n");
  for (const auto& [name, command] : allCommands())
    std::cout << completionCase(name, described(*command, "completion"));
  std::cout << kCompletionTail;
  return kDone;
}

}  // namespace cli
