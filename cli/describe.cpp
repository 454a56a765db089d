// SPDX-License-Identifier: Apache-2.0
#include "describe.h"

#include "options.h"

#include "vdbtools/base/text.h"
#include "vdbtools/maps/texture_shelf.h"
#include "vdbtools/recipe/option_table.h"
#include "vdbtools/recipe/option_value.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cctype>
#include <map>
#include <ostream>
#include <sstream>

namespace po = boost::program_options;

namespace cli {
namespace {

struct Variable {
  const char* name;
  const char* meaning;
  const char* command = "";  ///< the only one that reads it; empty: all do
};

constexpr Variable kVariables[] = {
    {"SLURM_CPUS_PER_TASK", "the number of threads, where --threads is not given"},
    {"SLURM_CPUS_ON_NODE", "the same, in a job of Slurm without SLURM_CPUS_PER_TASK"},
    {"JULIAVDB_MEMORY", "how much memory a run may take, where --memory is not given"},
    {"TMPDIR", "the folder for temporary files"},
    {"JULIAVDB_DEVICE_CACHE",
     "the folder in which programs of devices are kept, or none (default: juliavdb/devices in XDG_CACHE_HOME or "
     "~/.cache)"},
    {"JULIAVDB_DEVICE_TIMEOUT", "how long the compiler of a device may take, in seconds"},
    {"JULIAVDB_OPENCL", "the library by which drivers of OpenCL are found"},
    {"JULIAVDB_OPENCL_DRIVER", "the driver of OpenCL that is used, a library"},
    {"SLURM_ARRAY_TASK_ID", "the number of the task that 'juliavdb task' makes, where none is given", "task"},
    {"SLURM_ARRAY_TASK_STEP", "how many tasks from there on it makes", "task"},
    {"PARALLEL_SEQ", "the number of the task, outside of Slurm", "task"},
};

/// The common description of an option for both kinds of readers.
struct Option {
  std::string name;      ///< without dashes
  char letter = 0;       ///< the short form; 0: none
  std::string argument;  ///< empty: a flag
  std::string fallback;  ///< the default, if Boost's option has one; empty: none
  std::string help;
};

Option describedOption(const po::option_description& description) {
  Option option{.name = description.long_name(), .help = description.description()};
  // "-o [ --output ]" has a short form.
  if (const std::string names = description.format_name(); names.size() > 1 && names[0] == '-' && names[1] != '-')
    option.letter = names[1];
  if (description.semantic()->max_tokens() == 0) return option;
  option.argument = description.format_parameter();
  if (const std::size_t at = option.argument.find(" (="); at != std::string::npos) {
    option.fallback = option.argument.substr(at + 3, option.argument.size() - at - 4);
    option.argument.resize(at);
  }
  return option;
}

std::vector<Option> optionsOf(const OptionGroup& group) {
  std::vector<Option> options;
  for (const auto& description : group.options->options()) options.push_back(describedOption(*description));
  return options;
}

bool contains(const std::string& text, const char* part) { return text.find(part) != std::string::npos; }

/// Whether a part of the help's text for a value, as in "auto|centre|X,Y,Z", is a word to be typed literally.
bool isWord(const std::string& part) {
  if (part.empty() || contains(part, ",") || contains(part, ".")) return false;
  return part.size() <= 2 || std::any_of(part.begin(), part.end(), [](char c) { return std::islower(c) != 0; });
}

/// Whether the help's text for a value has an extension, as in "F.json" and "PART.stl".
bool namesExtension(const std::string& argument) {
  for (std::size_t dot = argument.find('.'); dot != std::string::npos; dot = argument.find('.', dot + 1))
    if (dot > 0 && std::isupper(static_cast<unsigned char>(argument[dot - 1])) != 0 && dot + 1 < argument.size() &&
        std::islower(static_cast<unsigned char>(argument[dot + 1])) != 0)
      return true;
  return false;
}

std::string kindOf(const Option& option) {
  if (option.argument.empty()) return "flag";
  if (contains(option.argument, "DIR")) return "folder";
  return contains(option.argument, "FILE") || contains(option.argument, "MESH") || namesExtension(option.argument)
             ? "file"
             : "value";
}

/// The values that may follow an option, quoted for the shell.
std::string wordsOf(const Option& option) {
  const std::vector<std::string> parts = vdbtools::split(option.argument, '|');
  std::vector<std::string> words;
  for (std::string part : parts) {
    if (const std::size_t bracket = part.find(']'); part.starts_with('[') && bracket != std::string::npos)
      part.erase(0, bracket + 1);
    if (parts.size() > 1 && isWord(part)) words.push_back(part);
  }
  if (contains(option.argument, "NAME") && (option.name == "texture" || option.name == "texture-over"))
    for (const vdbtools::Texture& texture : vdbtools::textureShelf()) words.push_back(texture.name);
  std::string text;
  for (const std::string& word : words) {
    text += ' ';
    for (const char c : word) text += c == '\'' ? "\\'" : std::string(1, c);
  }
  return text;
}

/// "makes a mesh from a VDB": the first sentence, without its full stop.
std::string summaryOf(const std::string& description) {
  std::string text = description;
  std::replace(text.begin(), text.end(), '\n', ' ');
  const auto end = std::min({text.find(". "), text.find(": "), text.find("; "), text.size()});
  text.resize(end);
  if (text.ends_with('.')) text.pop_back();
  text[0] = static_cast<char>(std::tolower(static_cast<unsigned char>(text[0])));
  return text;
}

/// What the tables say of their options, by the names of these. A command's own option hides that of its recipe.
std::map<std::string, nlohmann::json> tableData(const vdbtools::OptionTable& own, const vdbtools::OptionTable& recipe) {
  std::map<std::string, nlohmann::json> data;
  for (const nlohmann::json& option : nlohmann::json::parse(vdbtools::optionData(own)))
    data.emplace(option["name"], option);
  for (nlohmann::json& option : nlohmann::json::parse(vdbtools::optionData(recipe))) {
    option["recipe"] = true;
    data.emplace(option["name"], option);
  }
  return data;
}

/// Writes paragraphs, and tables whose lines are indented: "  NAME   meaning", with continuation lines of the meaning.
void writeManualText(std::ostream& stream, const std::string& description) {
  std::istringstream lines(description);
  bool table = false;
  for (std::string line; std::getline(lines, line);) {
    if (line.empty()) {
      stream << ".PP\n";
      table = false;
      continue;
    }
    const std::size_t begin = line.find_first_not_of(' ');
    const std::size_t gap = line.find("  ", begin);
    if (begin == 2 && gap != std::string::npos) {
      stream << ".TP\n.B " << manualText(line.substr(begin, gap - begin)) << '\n'
             << manualText(line.substr(line.find_first_not_of(' ', gap))) << '\n';
      table = true;
      continue;
    }
    if (begin == 0 && table) {
      stream << ".PP\n";
      table = false;
    }
    stream << manualText(line.substr(begin)) << '\n';
  }
}

void writeOption(std::ostream& stream, const Option& option) {
  stream << ".TP\n\\fB";
  if (option.letter != 0) stream << "\\-" << option.letter << "\\fR, \\fB";
  stream << manualText("--" + option.name) << "\\fR";
  if (!option.argument.empty()) stream << " \\fI" << manualText(option.argument) << "\\fR";
  stream << '\n' << manualText(option.help);
  if (!option.fallback.empty()) stream << manualText(" (default " + option.fallback + ")");
  stream << '\n';
}

}  // namespace

std::string manualText(const std::string& text) {
  std::string result;
  for (const char c : text) {
    const bool lineStart = result.empty() || result.back() == '\n';
    if (lineStart && (c == '.' || c == '\'')) result += "\\&";
    if (c == '\\')
      result += "\\e";
    else if (c == '-')
      result += "\\-";
    else if (c == '\'')
      result += "\\(aq";
    else if (c == '^')
      result += "\\(ha";
    else if (c == '~')
      result += "\\(ti";
    else
      result += c;
  }
  return result;
}

void writeVariables(std::ostream& stream, const std::string& command) {
  stream << ".SH ENVIRONMENT\n";
  for (const Variable& variable : kVariables)
    if (command.empty() || *variable.command == 0 || variable.command == command)
      stream << ".TP\n.B " << manualText(variable.name) << '\n' << manualText(variable.meaning) << '\n';
}

void writeManualPage(std::ostream& stream, const Usage& usage, const std::vector<OptionGroup>& groups) {
  std::string page = std::string("juliavdb-") + usage.command;
  std::replace(page.begin(), page.end(), ' ', '-');
  std::string title = page;
  std::transform(title.begin(), title.end(), title.begin(), [](unsigned char c) { return std::toupper(c); });
  stream << ".TH " << manualText(title) << " 1 \"\" \"juliavdb " JULIAVDB_VERSION "\" \"JuliaVDB\"\n.nh\n.ad l\n"
         << ".SH NAME\n"
         << manualText(page) << " \\- " << manualText(summaryOf(usage.description)) << "\n.SH SYNOPSIS\n.B juliavdb "
         << manualText(usage.command) << "\n"
         << manualText(usage.synopsis) << "\n.SH DESCRIPTION\n";
  writeManualText(stream, usage.description);
  stream << ".SH OPTIONS\n";
  for (const OptionGroup& group : groups) {
    stream << ".SS " << manualText(group.heading) << '\n';
    for (const Option& option : optionsOf(group)) writeOption(stream, option);
  }
  stream << ".SH EXAMPLES\n.nf\n";
  std::istringstream examples(usage.examples);
  for (std::string line; std::getline(examples, line);)
    stream << manualText(line.substr(std::min<std::size_t>(2, line.size()))) << '\n';
  stream << ".fi\n";
  writeVariables(stream, usage.command);
  stream << ".SH SEE ALSO\n.BR juliavdb (1)\n";
}

void writeCompletionTable(std::ostream& stream, const Usage& usage, const std::vector<OptionGroup>& groups,
                          const vdbtools::OptionTable& own, const vdbtools::OptionTable& recipe) {
  const std::map<std::string, nlohmann::json> tables = tableData(own, recipe);
  // Lists, whose words the argument in the help does not name.
  const auto listOf = [&](const Option& option) -> std::string {
    const auto found = tables.find(option.name);
    if (found == tables.end() || !found->second.contains("type")) return {};
    const nlohmann::json& type = found->second["type"];
    if (type["kind"] != "list" || !type.contains("words")) return {};
    return " list " + vdbtools::joined(type["words"].get<std::vector<std::string>>(), " ");
  };
  if (usage.words) stream << "words " << usage.words << '\n';
  for (const OptionGroup& group : groups)
    for (const Option& option : optionsOf(group)) {
      const std::string list = listOf(option);
      const std::string what = (list.empty() ? ' ' + kindOf(option) + wordsOf(option) : list) + '\n';
      stream << "--" << option.name << what;
      if (option.letter != 0) stream << '-' << option.letter << what;
    }
}

void writeDescription(std::ostream& stream, const Usage& usage, const std::vector<OptionGroup>& groups,
                      const vdbtools::OptionTable& own, const vdbtools::OptionTable& recipe) {
  using nlohmann::json;
  const std::map<std::string, json> tables = tableData(own, recipe);
  json description = {{"command", usage.command}, {"groups", json::array()}};
  for (const OptionGroup& group : groups) {
    json described = json::array();
    for (const Option& option : optionsOf(group)) {
      const auto found = tables.find(option.name);
      json data = found != tables.end()
                      ? found->second
                      : json{{"name", option.name}, {"argument", option.argument}, {"help", option.help}};
      if (!option.fallback.empty()) data["default"] = option.fallback;
      if (option.letter != 0) data["letter"] = std::string(1, option.letter);
      described.push_back(std::move(data));
    }
    description["groups"].push_back({{"heading", group.heading}, {"options", std::move(described)}});
  }
  stream << description.dump(1) << '\n';
}

}  // namespace cli
