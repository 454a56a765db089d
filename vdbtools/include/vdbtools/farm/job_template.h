// SPDX-License-Identifier: Apache-2.0
/// @file job_template.h
/// Scripts that give the tasks of a plan to any engine, written as templates. A template is a script in which
/// `@{NAME}` stands for a field, and `@@{` for the characters `@{`:
///
/// - `name`: of the folder of the plan
/// - `folder`, `program`: absolute paths of that folder and of this program
/// - `tasks`: the missing tasks, as 3,7,10-12
/// - `count`: how many these are
/// - `jobs`, `threads`, `batch`: as in the options of 'juliavdb submit'
/// - `task-arguments`: the words behind the program that make a task; `--index N` or `--range A-B` follows
/// - `merge-arguments`: the words behind the program that merge all tasks
/// - `arguments`: the words behind -- of the command line
/// - `task`: the number of a task, within `each task`
///
/// `@{NAME}` is the plain text, with lists of words as a shell reads them, `@{NAME:shell}` is quoted for a shell, and
/// `@{NAME:json}` is JSON, which Python reads as well. Lines between one of `@{if tasks}`, `@{if merge}` or
/// `@{each task}` and `@{end}`, each on a line of its own, are there only if tasks are missing, only if a merge is
/// wanted, or once for each missing task. Such blocks do not nest.
#pragma once

#include <cstdint>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace vdbtools::farm {

struct JobFields {
  std::string name, folder, program;
  std::vector<std::uint64_t> tasks;
  int jobs = 1, threads = 1;
  std::uint64_t batch = 1;
  std::vector<std::string> taskArguments;
  std::vector<std::string> mergeArguments;  ///< empty: no merge is wanted
  std::vector<std::string> arguments;
};

class JobTemplate {
 public:
  /// @param file  the name of the template, for messages
  /// @throw DataError  an unknown field or form, a block that is not closed or nested, no `#!` at the beginning, no
  ///                   way to the tasks: a template needs program, task-arguments, and tasks or task
  JobTemplate(const std::string& file, std::string_view text);

  /// Whether the field occurs.
  bool has(const std::string& field) const { return mFields.contains(field); }

  /// @throw DataError  the template has no field for the merge or the words that are wanted, or a field has control
  ///                   characters, which a script could take for the end of a line
  std::string fill(const JobFields& fields) const;

 private:
  struct Piece {
    std::string text;   ///< literal, if there is no field
    std::string field;  ///< empty: a literal
    std::string form;   ///< "", "shell" or "json"
  };
  enum class Block { Always, IfTasks, IfMerge, EachTask };
  struct Part {
    Block block = Block::Always;
    std::vector<Piece> pieces{};
  };
  void addLine(std::string_view line, std::size_t number, Part& part);

  std::string mFile;
  std::vector<Part> mParts;
  std::set<std::string> mFields;
};

}  // namespace vdbtools::farm
