// SPDX-License-Identifier: Apache-2.0
#include "options.h"

#include "describe.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/job/fractal_options.h"
#include "vdbtools/job/recorded_recipe.h"
#include "vdbtools/job/sheet_file.h"

#include "julia/instruction_set.h"

#include <cctype>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <stdexcept>

namespace po = boost::program_options;

namespace cli {
namespace {

// Guessing abbreviations would make every new option a change of the command line.
constexpr int kStyle = po::command_line_style::unix_style & ~po::command_line_style::allow_guessing;
constexpr unsigned kLineLength = 110;
constexpr int kMostThreads = 4096;

std::optional<int> parseThreads(const std::string& text) {
  const std::optional<int> threads = vdbtools::wholeFromText<int>(text);
  return threads && *threads >= 1 && *threads <= kMostThreads ? threads : std::nullopt;
}

/// A negative number that stands alone, as in 'versor translate F.json -0.1,0,0', is a word and no short option; so is
/// a list of expressions, as in '--f "-x, y, z"'.
std::vector<po::option> takeNegativeNumber(std::vector<std::string>& words) {
  const std::string word = words.front();
  if (word.size() < 2 || word[0] != '-') return {};
  const bool number = std::isdigit(static_cast<unsigned char>(word[1])) || word[1] == '.';
  const bool list = word[1] != '-' && word[1] != 'o' && word.find(',') != std::string::npos;
  if (!number && !list) return {};
  words.erase(words.begin());
  po::option option;
  option.value.push_back(word);
  option.original_tokens.push_back(word);
  return {option};
}

bool isRecipeFile(const std::string& file) {
  const std::string extension = vdbtools::lowerExtension(file);
  return extension == ".vdb" || extension == ".ply" || extension == ".obj" || extension == ".glb" ||
         vdbtools::isSheetCell(file);
}

po::value_semantic* valueOf(const vdbtools::OptionListing& option) {
  auto* value = po::value<std::string>();
  if (option.argument.empty())
    value->implicit_value("true")->zero_tokens();
  else
    value->value_name(option.argument);
  return value;
}

}  // namespace

CommandLine::CommandLine(const Usage& usage, vdbtools::OptionTable recipeOptions)
    : mUsage(usage),
      mTable(std::move(recipeOptions)),
      mOwn("Options", kLineLength),
      mFromRecipe("What to make", kLineLength),
      mCommon("Common options", kLineLength) {
  const std::vector<vdbtools::OptionListing> options = mTable.listing();
  // For 'juliavdb man' and 'juliavdb completion'.
  mHidden.add_options()("describe", po::value<std::string>());
  for (const vdbtools::OptionListing& option : options) {
    if (mUsage.hides && option.name == mUsage.hides) continue;
    if (option.name == "input") {
      mHidden.add_options()("input", valueOf(option));
      mPositional.add("input", 1);
    } else {
      mFromRecipe.add_options()(option.name.c_str(), valueOf(option), option.help.c_str());
    }
  }
  if (!options.empty())
    mCommon.add_options()(
        "config", po::value<std::string>()->value_name("FILE"),
        "read options from a file: lines NAME = VALUE, a VDB, PLY, OBJ or GLB that this program made, or "
        "cell N of a contact sheet as in sheet.json#7; options on the command line take precedence");
  mCommon.add_options()("threads", po::value<std::string>()->value_name("N"),
                        "the number of threads (default: SLURM_CPUS_PER_TASK or SLURM_CPUS_ON_NODE, or else all that "
                        "this process may use)")(
      "instructions", po::value<std::string>()->value_name("auto|portable|avx2|avx512"),
      "the vector instructions to use; they change the speed and no bit of the result (default auto, the widest)")(
      "progress", po::value<std::string>()->value_name("bar|json|none"),
      "how to show progress on stderr: a bar with the time left for work of more than two seconds (the default), "
      "nothing, or for other programs one JSON object a line and no other text (docs/progress.md)")("help,h",
                                                                                                    "show this help");
}

void CommandLine::addOptions(const std::vector<vdbtools::OptionSpec>& options) {
  for (const vdbtools::OptionListing& option : vdbtools::OptionTable(options).listing())
    mOwn.add_options()(option.name.c_str(), valueOf(option), option.help.c_str());
}

vdbtools::Recipe CommandLine::given(const vdbtools::OptionTable& table) const {
  vdbtools::Recipe recipe;
  for (const std::string& name : table.names())
    if (has(name)) recipe[name] = text(name);
  return recipe;
}

void CommandLine::addPositional(const char* name, int count, const char* help) {
  if (count == 1)
    mHidden.add_options()(name, po::value<std::string>(), help);
  else
    mHidden.add_options()(name, po::value<std::vector<std::string>>(), help);
  mPositional.add(name, count);
}

bool CommandLine::parse(const Arguments& arguments) {
  po::options_description all;
  all.add(mOwn).add(mFromRecipe).add(mCommon).add(mHidden);
  try {
    po::store(po::command_line_parser(arguments)
                  .options(all)
                  .positional(mPositional)
                  .style(kStyle)
                  .extra_style_parser(takeNegativeNumber)
                  .run(),
              mValues);
    po::notify(mValues);
  } catch (const po::too_many_positional_options_error&) {
    throw std::invalid_argument("there is one argument too many; 'juliavdb " + std::string(mUsage.command) +
                                " --help' says what is expected");
  } catch (const po::error& error) {
    throw std::invalid_argument(std::string(error.what()) + "; see 'juliavdb " + mUsage.command + " --help'");
  }
  if (has("help")) {
    printHelp();
    return false;
  }
  if (has("describe")) {
    describe(text("describe"));
    return false;
  }
  applyThreads();
  applyInstructions();
  mGiven = given();
  if (mUsage.hides) mGiven.erase(mUsage.hides);
  if (has("config")) readConfig(text("config"));
  mRecipe = vdbtools::completeRecipe(mGiven, mTable);
  mProgress =
      std::make_unique<Progress>(parseProgressStyle(has("progress") ? text("progress") : "bar"), mUsage.command);
  return true;
}

std::string CommandLine::text(const std::string& name) const {
  return has(name) ? mValues[name].as<std::string>() : std::string();
}

std::vector<std::string> CommandLine::texts(const std::string& name) const {
  return has(name) ? mValues[name].as<std::vector<std::string>>() : std::vector<std::string>();
}

void CommandLine::readConfig(const std::string& file) {
  vdbtools::Recipe base;
  if (isRecipeFile(file)) {
    auto [command, recipe] = vdbtools::readRecordedRecipe(file);
    if (command.empty())
      throw vdbtools::DataError("'" + file +
                                "' holds no recipe of juliavdb; only a VDB, PLY, OBJ or GLB that it made does");
    if (command != (mUsage.recipesOf ? mUsage.recipesOf : mUsage.command))
      throw std::invalid_argument("'" + file + "' was made by 'juliavdb " + command + "', not by 'juliavdb " +
                                  mUsage.command + "'");
    base = std::move(recipe);
  } else {
    std::ifstream stream(file);
    if (!stream || std::filesystem::is_directory(file)) throw vdbtools::MissingInputError("cannot open '" + file + "'");
    po::options_description known;
    known.add(mFromRecipe);
    known.add_options()("input", po::value<std::string>());
    if (mUsage.hides) known.add_options()(mUsage.hides, po::value<std::string>());
    try {
      for (const auto& option : po::parse_config_file(stream, known).options)
        if (!base.emplace(option.string_key, option.value.empty() ? "true" : option.value.front()).second)
          throw std::invalid_argument("'" + file + "' sets '" + option.string_key + "' twice; keep only one of them");
    } catch (const po::error& error) {
      throw std::invalid_argument("'" + file + "': " + error.what());
    }
  }
  mGiven = vdbtools::overridden(std::move(base), mGiven, mTable);
}

void CommandLine::applyThreads() {
  std::optional<int> threads;
  if (has("threads")) {
    threads = parseThreads(text("threads"));
    if (!threads)
      throw std::invalid_argument("--threads is '" + text("threads") + "'; it must be a whole number from 1 to " +
                                  std::to_string(kMostThreads));
  } else {
    // The second is there for jobs that did not say how many processors each task is to have.
    for (const char* name : {"SLURM_CPUS_PER_TASK", "SLURM_CPUS_ON_NODE"})
      if (const char* value = std::getenv(name); value && !threads) threads = parseThreads(value);
  }
  // TBB counts the processors of the affinity mask by itself.
  if (threads)
    mThreads = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism,
                                                     static_cast<std::size_t>(*threads));
}

void CommandLine::applyInstructions() const {
  const std::string name = has("instructions") ? text("instructions") : "auto";
  if (name == "auto") return;
  for (const julia::InstructionSet set :
       {julia::InstructionSet::Portable, julia::InstructionSet::Avx2, julia::InstructionSet::Avx512})
    if (name == julia::nameOf(set)) return julia::setInstructionSet(set);
  throw std::invalid_argument("--instructions is '" + name + "'; it must be one of auto, portable, avx2, avx512");
}

void CommandLine::printHelp() const {
  std::cout << "Usage: juliavdb " << mUsage.command << ' ' << mUsage.synopsis << "\n\n" << mUsage.description << "\n\n";
  if (!mOwn.options().empty()) std::cout << mOwn << '\n';
  if (!mFromRecipe.options().empty()) std::cout << mFromRecipe << '\n';
  std::cout << mCommon << "\nExamples:\n" << mUsage.examples;
}

void CommandLine::describe(const std::string& how) const {
  std::vector<OptionGroup> groups;
  for (const auto& [heading, options] :
       {std::pair("Options", &mOwn), {"What to make", &mFromRecipe}, {"Common options", &mCommon}})
    if (!options->options().empty()) groups.push_back({heading, options});
  if (how == "man")
    writeManualPage(std::cout, mUsage, groups);
  else if (how == "completion")
    writeCompletionTable(std::cout, mUsage, groups);
  else
    throw std::invalid_argument("--describe is '" + how + "'; it must be man or completion");
}

vdbtools::Recipe givenSceneRecipe(const CommandLine& line, const std::string& input) {
  if (!vdbtools::isVdbPath(input)) return line.givenRecipe();
  auto [command, recipe] = vdbtools::readRecordedRecipe(input);
  if (command != "fractal") return line.givenRecipe();
  vdbtools::Recipe given = line.givenRecipe();
  given.erase("input");
  return vdbtools::overridden(std::move(recipe), given, vdbtools::fractalOptionTable());
}

vdbtools::Recipe sceneRecipe(const CommandLine& line, const std::string& input) {
  return vdbtools::completeRecipe(givenSceneRecipe(line, input), vdbtools::fractalOptionTable());
}

}  // namespace cli
