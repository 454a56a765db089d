// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/farm/job_template.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/base/text.h"
#include "vdbtools/farm/task.h"
#include "vdbtools/files/file_bytes.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <optional>

namespace vdbtools::farm {
namespace {

const std::vector<std::string> kFieldNames = {"name",  "folder",         "program",         "tasks",
                                              "count", "jobs",           "threads",         "batch",
                                              "task",  "task-arguments", "merge-arguments", "arguments"};

constexpr std::string_view kFieldOpen = "@{";

[[noreturn]] void refuseTemplate(const std::string& file, std::size_t line, const std::string& what) {
  throw DataError("the template '" + file + "'" + (line > 0 ? ", line " + std::to_string(line) : "") + ": " + what);
}

std::string asJson(const nlohmann::json& value) {
  // Names of files need not be UTF-8.
  return value.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::string asWords(const std::vector<std::string>& words) { return joined(words, " ", shellWord); }

std::string formed(const std::string& text, const std::string& form) {
  return form == "json" ? asJson(text) : form == "shell" ? shellWord(text) : text;
}

std::string formed(const std::vector<std::string>& words, const std::string& form) {
  return form == "json" ? asJson(words) : asWords(words);
}

std::string valueOfField(const JobFields& fields, const std::string& field, const std::string& form,
                         std::uint64_t task) {
  if (field == "name") return formed(fields.name, form);
  if (field == "folder") return formed(fields.folder, form);
  if (field == "program") return formed(fields.program, form);
  if (field == "tasks") return formed(taskList(fields.tasks), form);
  if (field == "count") return std::to_string(fields.tasks.size());
  if (field == "jobs") return std::to_string(fields.jobs);
  if (field == "threads") return std::to_string(fields.threads);
  if (field == "batch") return std::to_string(fields.batch);
  if (field == "task") return std::to_string(task);
  if (field == "task-arguments") return formed(fields.taskArguments, form);
  if (field == "merge-arguments") return formed(fields.mergeArguments, form);
  return formed(fields.arguments, form);
}

bool hasControls(const std::string& text) { return withoutControls(text) != text; }

}  // namespace

JobTemplate::JobTemplate(const std::string& file, std::string_view text) : mFile(inOneLine(file)) {
  if (!text.starts_with("#!"))
    refuseTemplate(mFile, 1, "it does not begin with #! and the program that runs it, such as #!/bin/sh");
  if (text.find('\0') != std::string_view::npos) refuseTemplate(mFile, 0, "it is not a text");
  Part part;
  std::size_t number = 0, opened = 0;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size() - 1) + 1;
    const std::string_view line = text.substr(0, end), word = trimmed(line.substr(0, line.find('\n')));
    text.remove_prefix(end);
    ++number;
    const bool ends = word == "@{end}";
    const std::optional<Block> begins = word == "@{if tasks}"    ? std::optional(Block::IfTasks)
                                        : word == "@{if merge}"  ? std::optional(Block::IfMerge)
                                        : word == "@{each task}" ? std::optional(Block::EachTask)
                                                                 : std::nullopt;
    if (!ends && !begins) {
      addLine(line, number, part);
      continue;
    }
    if (begins && opened > 0)
      refuseTemplate(mFile, number,
                     "a block begins within that of line " + std::to_string(opened) +
                         "; blocks do not nest, so end the other one first");
    if (ends && opened == 0) refuseTemplate(mFile, number, "@{end} ends no block");
    mParts.push_back(std::move(part));
    part = {.block = begins.value_or(Block::Always)};
    opened = begins ? number : 0;
  }
  if (opened > 0) refuseTemplate(mFile, opened, "the block that begins here has no @{end}");
  mParts.push_back(std::move(part));
  for (const char* needed : {"program", "task-arguments"})
    if (!has(needed))
      refuseTemplate(mFile, 0, "it lacks @{" + std::string(needed) + "}, without which it cannot make a task");
  if (!has("tasks") && !has("task"))
    refuseTemplate(mFile, 0, "it lacks @{tasks}, and @{task} between @{each task} and @{end}: give one of them");
}

void JobTemplate::addLine(std::string_view line, std::size_t number, Part& part) {
  std::string literal;
  const auto flush = [&] {
    if (!literal.empty()) part.pieces.push_back({literal, {}, {}});
    literal.clear();
  };
  while (!line.empty()) {
    const std::size_t at = line.find(kFieldOpen);
    literal += line.substr(0, std::min(at, line.size()));
    if (at == std::string_view::npos) break;
    line.remove_prefix(at + kFieldOpen.size());
    if (!literal.empty() && literal.back() == '@') {
      literal += '{';
      continue;
    }
    const std::size_t close = line.find('}');
    if (close == std::string_view::npos)
      refuseTemplate(mFile, number, "a field that begins with @{ has no }; write @@{ for the characters themselves");
    const std::string word(line.substr(0, close));
    line.remove_prefix(close + 1);
    const std::size_t colon = std::min(word.find(':'), word.size());
    const std::string field = word.substr(0, colon), form = word.substr(std::min(colon + 1, word.size()));
    if (std::find(kFieldNames.begin(), kFieldNames.end(), field) == kFieldNames.end())
      refuseTemplate(mFile, number, "there is no field '" + inOneLine(field) + "'" + didYouMean(field, kFieldNames));
    if (colon < word.size() && form != "shell" && form != "json")
      refuseTemplate(mFile, number,
                     "the form of '" + inOneLine(word) + "' must be shell or json, as in @{" + field + ":shell}");
    if (field == "task" && part.block != Block::EachTask)
      refuseTemplate(mFile, number, "@{task} stands outside of @{each task} and @{end}");
    flush();
    part.pieces.push_back({{}, field, form});
    mFields.insert(field);
  }
  flush();
}

std::string JobTemplate::fill(const JobFields& fields) const {
  if (!fields.mergeArguments.empty() && !has("merge-arguments"))
    refuseTemplate(mFile, 0, "it lacks @{merge-arguments}, and a merge is wanted; add it, or give no output to merge");
  if (!fields.arguments.empty() && !has("arguments"))
    refuseTemplate(mFile, 0, "it lacks @{arguments}, so the words behind -- would be lost; leave them out");
  std::vector<std::string> texts{fields.name, fields.folder, fields.program};
  for (const auto* words : {&fields.taskArguments, &fields.mergeArguments, &fields.arguments})
    texts.insert(texts.end(), words->begin(), words->end());
  if (const auto bad = std::find_if(texts.begin(), texts.end(), hasControls); bad != texts.end())
    refuseTemplate(mFile, 0, "'" + inOneLine(*bad) + "' has control characters, which cannot stand in a script");
  std::string script;
  for (const Part& part : mParts) {
    const auto add = [&](std::uint64_t task) {
      for (const Piece& piece : part.pieces)
        script += piece.field.empty() ? piece.text : valueOfField(fields, piece.field, piece.form, task);
    };
    switch (part.block) {
      case Block::Always: add(0); break;
      case Block::IfTasks:
        if (!fields.tasks.empty()) add(0);
        break;
      case Block::IfMerge:
        if (!fields.mergeArguments.empty()) add(0);
        break;
      case Block::EachTask:
        for (const std::uint64_t task : fields.tasks) add(task);
        break;
    }
  }
  return script;
}

}  // namespace vdbtools::farm
