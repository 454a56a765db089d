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
    "completion",
    "[bash|zsh|fish]",
    "Writes the completion of command lines for a shell, by default bash: commands, their options, and the values that "
    "these may have. An installed package has all three. Otherwise 'source' that for bash in ~/.bashrc, put that for "
    "zsh into a folder of its fpath as _juliavdb, and that for fish into ~/.config/fish/completions.",
    "  juliavdb completion > juliavdb.bash\n"
    "  juliavdb completion zsh > _juliavdb\n"
    "  juliavdb completion fish > juliavdb.fish\n",
    nullptr,
    "bash zsh fish"};

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
  writeVariables(page, "");
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

// Each script has the same table, and a function that reads it. _juliavdb_table COMMAND prints a line for each option:
// its name, what follows it, and values that it may have, which with "list" may stand in a list with commas between
// them.
constexpr const char* kBashHead = R"(# Completion of juliavdb for bash.
# _juliavdb_table COMMAND prints a line for each option: its name, what follows it, and values that it may have.
_juliavdb_table() {
  case $1 in
)";

constexpr const char* kZshHead = R"(#compdef juliavdb
# _juliavdb_table COMMAND prints a line for each option: its name, what follows it, and values that it may have.
_juliavdb_table() {
  case $1 in
)";

constexpr const char* kFishHead = R"(# Completion of juliavdb for fish.
# __juliavdb_table COMMAND prints a line for each option: its name, what follows it, and values that it may have.
function __juliavdb_table
  switch "$argv[1]"
)";

constexpr const char* kBashTail = R"(    *) return 1 ;;
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
      if [[ $kind == list && $cur == *,* ]]; then
        COMPREPLY=($(compgen -P "${cur%,*}," -W "$words" -- "${cur##*,}"))
      fi
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

constexpr const char* kZshTail = R"(    *) return 1 ;;
  esac
}

_juliavdb() {
  local cur=$words[CURRENT] option=$words[CURRENT-1] key= first= name kind values
  local -a options
  # --name=value is one word.
  if [[ $cur == --*=* ]]; then
    option=${cur%%=*}
    compset -P '*='
    cur=${cur#*=}
  fi
  (( CURRENT > 2 )) && key=$words[2]
  if (( CURRENT > 3 )) && _juliavdb_table "$key $words[3]" >/dev/null; then
    key+=" $words[3]"
  fi
  while read -r name kind values; do
    if [[ $name == words ]]; then
      first="$kind $values"
      continue
    fi
    options+=($name)
    if [[ $name == $option && $kind != flag ]]; then
      [[ $kind == file ]] && _files
      [[ $kind == folder ]] && _files -/
      [[ $kind == list ]] && compset -P '*,'
      [[ -n $values ]] && compadd -- ${(Q)${=values}}
      return
    fi
  done < <(_juliavdb_table "$key")
  if [[ $cur == -* ]]; then
    compadd -- $options
  elif [[ -n $first ]] && (( CURRENT <= 3 )); then
    compadd -- ${=first}
  elif (( CURRENT > 2 )); then
    _files
  fi
}

_juliavdb "$@"
)";

constexpr const char* kFishTail = R"(    case '*'
      return 1
  end
end

function __juliavdb_complete
  set -l typed (commandline -opc)
  set -l cur (commandline -ct)
  set -l option $typed[-1]
  set -l key ''
  set -l before ''
  if string match -q -- '--*=*' $cur
    set option (string split -m 1 = -- $cur)[1]
    set before $option=
  end
  test (count $typed) -gt 1; and set key $typed[2]
  if test (count $typed) -gt 2; and __juliavdb_table "$key $typed[3]" >/dev/null
    set key "$key $typed[3]"
  end
  set -l options
  set -l first
  for line in (__juliavdb_table "$key")
    set -l parts (string split ' ' -- $line)
    if test $parts[1] = words
      set first $parts[2..-1]
      continue
    end
    set -a options $parts[1]
    if test $parts[1] = "$option"; and test $parts[2] != flag
      if test $parts[2] = file; or test $parts[2] = folder
        __fish_complete_path (string replace -- "$before" '' $cur)
      end
      if test $parts[2] = list; and string match -q -- '*,*' $cur
        set before (string replace -r -- '[^,]*$' '' $cur)
      end
      for value in $parts[3..-1]
        printf '%s\n' $before(string unescape -- $value)
      end
      return
    end
  end
  if string match -q -- '-*' $cur
    printf '%s\n' $options
  else if test (count $first) -gt 0; and test (count $typed) -le 2
    printf '%s\n' $first
  else if test (count $typed) -gt 1
    __fish_complete_path $cur
  end
end

complete -c juliavdb -f -a '(__juliavdb_complete)'
)";

struct Shell {
  const char* name;
  const char *head, *tail;
  /// A case of the table, for a command and its lines.
  std::string (*caseOf)(const std::string& command, const std::string& table);
};

std::string caseOfBash(const std::string& command, const std::string& table) {
  return "    '" + command + "') cat <<'END'\n" + table + "END\n      ;;\n";
}

/// A text between single quotes, within which fish has these two escapes.
std::string caseOfFish(const std::string& command, const std::string& table) {
  std::string text;
  for (const char c : table) text += c == '\\' || c == '\'' ? std::string("\\") + c : std::string(1, c);
  return "    case '" + command + "'\n      printf '%s' '" + text + "'\n";
}

constexpr Shell kShells[] = {{"bash", kBashHead, kBashTail, caseOfBash},
                             {"zsh", kZshHead, kZshTail, caseOfBash},
                             {"fish", kFishHead, kFishTail, caseOfFish}};

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
  line.addPositional("shell", 1, "the shell");
  if (!line.parse(arguments)) return kDone;
  const std::string wanted = line.has("shell") ? line.text("shell") : kShells[0].name;
  const auto shell = std::ranges::find(kShells, wanted, &Shell::name);
  if (shell == std::end(kShells)) line.refuse("shell", "bash, zsh or fish");
  std::string words = "words";
  for (const Command& command : commands()) words += std::string(" ") + command.name;
  std::cout << shell->head << shell->caseOf("", words + "\n--help flag\n--version flag\n");
  for (const auto& [name, command] : allCommands()) std::cout << shell->caseOf(name, described(*command, "completion"));
  std::cout << shell->tail;
  return kDone;
}

}  // namespace cli
