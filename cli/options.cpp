// SPDX-License-Identifier: Apache-2.0
#include "options.h"

#include "config_list.h"
#include "describe.h"
#include "help_output.h"
#include "option_groups.h"
#include "report.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/base/memory.h"
#include "vdbtools/base/scheduler.h"
#include "vdbtools/base/text.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/files/standard_streams.h"
#include "vdbtools/formats/file_formats.h"
#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/job/sheet_job.h"
#include "vdbtools/maps/device_choice.h"
#include "vdbtools/mesh_files/mesh_reader.h"
#include "vdbtools/recipe/recipe.h"
#include "vdbtools/records/recorded_recipe.h"

#include "julia/instruction_set.h"

#include <tbb/global_control.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <iostream>
#include <memory>
#include <mutex>
#include <ostream>
#include <set>
#include <sstream>
#include <stdexcept>
#include <typeinfo>

namespace po = boost::program_options;

namespace cli {
namespace {

// With abbreviations, every new option would change the command line.
constexpr int kStyle = po::command_line_style::unix_style & ~po::command_line_style::allow_guessing;
constexpr int kMostThreads = 4096;
constexpr std::size_t kMostAtOnce = 32;  ///< a command with more options shows groups of them

constexpr const char* kConfig = "config";
constexpr const char* kRecipeAlias = "recipe";  ///< another name of --config
constexpr const char* kTrustImporter = "trust-importer";
constexpr const char *kQuietOption = "quiet", *kVerboseOption = "verbose";

constexpr const char* kOwn = "Options";
constexpr const char* kCommon = "Common options";

std::string lowerCase(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
  return text;
}

/// The word for a group: "common" for "Common options".
std::string topicOf(const std::string& heading) { return lowerCase(heading.substr(0, heading.find(' '))); }

/// The topic of the requested help: "" for general help, nullopt if none was requested. A topic is the last word.
std::optional<std::string> helpTopic(const Arguments& arguments) {
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const std::string& word = arguments[i];
    if (word == "--") break;
    if (word.starts_with("--help=")) return word.substr(std::string_view("--help=").size());
    if (word != "--help" && word != "-h") continue;
    // If a file name follows, the command was to work on that file.
    if (i + 2 != arguments.size() || arguments.back().find_first_of("./") != std::string::npos) return "";
    return arguments.back();
  }
  return std::nullopt;
}

/// The option that a word names; nullptr if there is none.
const po::option_description* optionOf(const std::string& word, const po::options_description& all) {
  if (word.starts_with("--")) {
    const std::string name = word.substr(2, word.find('=') - 2);
    return name.empty() ? nullptr : all.find_nothrow(name, false);  // an empty name would match all of them
  }
  if (word.size() < 2 || word[0] != '-' || !std::isalpha(static_cast<unsigned char>(word[1]))) return nullptr;
  return all.find_nothrow(word.substr(0, 2), false);
}

bool isHidden(const po::option_description& option, const po::options_description& hidden) {
  return hidden.find_nothrow(option.long_name(), false) != nullptr;
}

/// ": 'a.obj', 'b.obj'": the words that belong to no option.
std::string quotedWords(const Arguments& arguments, const po::options_description& all) {
  std::string words;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const po::option_description* option = optionOf(arguments[i], all);
    if (!option)
      words += (words.empty() ? ": '" : ", '") + arguments[i] + "'";
    else if (option->semantic()->max_tokens() > 0 && arguments[i].find('=') == std::string::npos &&
             (arguments[i].starts_with("--") || arguments[i].size() == 2))
      ++i;
  }
  return words;
}

std::optional<int> parseThreads(const std::string& text) {
  const std::optional<int> threads = vdbtools::wholeFromText<int>(text);
  return threads && *threads >= 1 && *threads <= kMostThreads ? threads : std::nullopt;
}

void applyMemory(const CommandLine& line) {
  static std::optional<vdbtools::MemoryLimit> limit;  // kept as long as the program runs
  const auto apply = [&](const std::string& name, const std::string& text) {
    const std::optional<double> bytes = vdbtools::memoryFromText(text);
    if (!bytes) throw std::invalid_argument(name + " is '" + text + "'; it must be " + vdbtools::kMemoryTexts);
    limit.emplace(*bytes);
  };
  if (line.has("memory")) return apply("--memory", line.text("memory"));
  if (const char* value = std::getenv("JULIAVDB_MEMORY")) apply("JULIAVDB_MEMORY", value);
}

/// A negative number that stands alone, as in 'versor translate F.json -0.1,0,0', is a word and not a short option; so
/// is a list of expressions, as in '--f "-x, y, z"'.
bool isNegativeNumber(const std::string& word) {
  if (word.size() < 2 || word[0] != '-') return false;
  const bool number = std::isdigit(static_cast<unsigned char>(word[1])) || word[1] == '.';
  const bool list = word[1] != '-' && word[1] != 'o' && word.find(',') != std::string::npos;
  return number || list;
}

std::vector<po::option> takeNegativeNumber(std::vector<std::string>& words) {
  const std::string word = words.front();
  if (!isNegativeNumber(word)) return {};
  words.erase(words.begin());
  po::option option;
  option.value.push_back(word);
  option.original_tokens.push_back(word);
  return {option};
}

bool holdsRecipe(const std::string& file) {
  const vdbtools::FileFormat* const format = vdbtools::findFormat(file);
  return (format && format->recipe) || vdbtools::isSheetCell(file);
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
      mOwn("Options", helpWidth()),
      mFromRecipe("What to make", helpWidth()),
      mCommon("Common options", helpWidth()) {
  const std::vector<vdbtools::OptionListing> options = mTable.listing();
  // For 'juliavdb man', 'juliavdb completion' and other programs.
  mHidden.add_options()("describe", po::value<std::string>());
  for (const vdbtools::OptionListing& option : options) {
    if (mUsage.hides && option.name == mUsage.hides) continue;
    if (option.name == "input") {
      mHidden.add_options()("input", valueOf(option));
      mPositional.add("input", 1);
      mPositionalNames.emplace_back("input");
    } else {
      mFromRecipe.add_options()(option.name.c_str(), valueOf(option), option.help.c_str());
    }
  }
  if (!options.empty())
    mCommon.add_options()(
        "config", po::value<std::string>()->value_name("FILE"),
        ("read options from a file: lines NAME = VALUE, a " + vdbtools::namesOf(&vdbtools::FileFormat::recipe) +
         " that this program made, a recipe of 'juliavdb recipe', or cell N of a contact sheet as in sheet.json#7; "
         "options on the command line take precedence. --recipe is the same")
            .c_str());
  mCommon.add_options()("threads", po::value<std::string>()->value_name("N"),
                        "the number of threads (default: SLURM_CPUS_PER_TASK or SLURM_CPUS_ON_NODE, or else all that "
                        "this process may use)")(
      "instructions", po::value<std::string>()->value_name("auto|portable|avx2|avx512"),
      "the vector instructions to use; the result is the same with all of them (default auto, the widest)")(
      "device", po::value<std::string>()->value_name("cpu|auto|opencl[:N|:all]"),
      "where the map is evaluated: the processor (the default), device N of 'juliavdb devices', the first one that can "
      "be used, or with auto the first graphics processor if there is one; the result is the same (docs/gpu.md)")(
      "memory", po::value<std::string>()->value_name("SIZE"),
      "how much memory this run may take, such as 16G or 500M: work that is known to need more is refused before it "
      "begins. unlimited tries everything (default: JULIAVDB_MEMORY, or else what the machine, the control group and "
      "ulimit leave)")(kTrustImporter, po::value<std::string>()->implicit_value("true")->zero_tokens(),
                       "read FBX, DAE, 3DS and X3D, by the library Assimp: a file that somebody made to do harm can "
                       "then do anything, so "
                       "give it for files that you trust only (docs/targets.md)")(
      "progress", po::value<std::string>()->value_name("bar|json|none"),
      "how to show progress on stderr: a bar with the time left for work of more than two seconds (the default), "
      "nothing, or for other programs one JSON object a line and no other text (docs/progress.md). Notes and the "
      "summary "
      "are printed with none, too; --quiet leaves them out")(
      kQuietOption, po::value<std::string>()->implicit_value("true")->zero_tokens(),
      "print warnings and failures only: no progress, no notes, and no summary")(
      kVerboseOption, po::value<std::string>()->implicit_value("true")->zero_tokens(),
      "also print at the end how long each phase took, and how much memory the run took at most")(
      "help,h",
      "describe the command; --help all, --help GROUP or --help NAME shows all of its options, a group of them or one");
}

void CommandLine::addOptions(const std::vector<vdbtools::OptionSpec>& options) {
  for (const vdbtools::OptionListing& option : vdbtools::OptionTable(options).listing())
    mOwn.add_options()(option.name == "output" ? "output,o" : option.name.c_str(), valueOf(option),
                       option.help.c_str());
  mOwnSpecs.insert(mOwnSpecs.end(), options.begin(), options.end());
}

vdbtools::Recipe CommandLine::given(const vdbtools::OptionTable& table) const {
  vdbtools::Recipe recipe;
  for (const std::string& name : table.names())
    if (has(name)) recipe[name] = text(name);
  return recipe;
}

std::set<std::string> CommandLine::typedNames() const {
  std::set<std::string> names;
  for (const auto& [name, value] : given())
    if (name != "input" && !(mUsage.hides && name == mUsage.hides)) names.insert(name);
  return names;
}

void CommandLine::requireEffect(std::set<std::string> names, const std::vector<vdbtools::OptionRun>& runs) const {
  vdbtools::RequiredEffects effects(mTable, std::move(names));
  for (const vdbtools::OptionRun& run : runs)
    if (effects.add(run)) return;
  effects.require();
}

void CommandLine::requireUse(bool used, std::initializer_list<const char*> names, const std::string& why) const {
  if (used) return;
  for (const char* name : names)
    if (has(name) && !mValues[name].defaulted())
      throw std::invalid_argument("--" + std::string(name) + " has no effect: " + why);
}

void CommandLine::addPositional(const char* name, int count, const char* help) {
  if (count == 1)
    mHidden.add_options()(name, po::value<std::string>(), help);
  else
    mHidden.add_options()(name, po::value<std::vector<std::string>>(), help);
  mPositional.add(name, count);
  mPositionalNames.emplace_back(name);
}

Arguments CommandLine::renamed(Arguments arguments, const po::options_description& all) const {
  for (std::string& word : arguments) {
    if (word == "--") break;
    if (!word.starts_with("--") || optionOf(word, all)) continue;
    const std::size_t end = std::min(word.find('='), word.size());
    const std::string name = word.substr(2, end - 2);
    const auto former = mFormerNames.find(name);
    const std::string known = former != mFormerNames.end() ? former->second
                              : name == kRecipeAlias       ? kConfig
                                                           : vdbtools::currentName(name);
    const std::string now = "--" + known + word.substr(end);
    if (optionOf(now, all)) word = now;
  }
  return arguments;
}

bool CommandLine::parse(const Arguments& arguments) {
  if (const std::optional<std::string> topic = helpTopic(arguments)) {
    printHelp(*topic);
    return false;
  }
  po::options_description all;
  all.add(mOwn).add(mFromRecipe).add(mCommon).add(mHidden);
  const Arguments words = renamed(arguments, all);
  checkWords(words, all);
  try {
    po::store(po::command_line_parser(words)
                  .options(all)
                  .positional(mPositional)
                  .style(kStyle)
                  .extra_style_parser(takeNegativeNumber)
                  .run(),
              mValues);
    po::notify(mValues);
  } catch (const po::too_many_positional_options_error&) {
    throw std::invalid_argument("there is one argument too many" + quotedWords(words, all) + "; 'juliavdb " +
                                mUsage.command + " --help' says what is expected");
  } catch (const po::multiple_occurrences& error) {
    throw std::invalid_argument(error.get_option_name() + " is given twice; leave one of them out");
  } catch (const po::error& error) {
    throw std::invalid_argument(std::string(error.what()) + "; see 'juliavdb " + mUsage.command + " --help'");
  }
  if (has("describe")) {
    describe(text("describe"));
    return false;
  }
  applyTalk();
  applyThreads();
  vdbtools::startScheduler();
  applyInstructions();
  applyDevice();
  applyMemory(*this);
  vdbtools::trustImporter(has(kTrustImporter));
  takePipes();
  mGiven = given();
  if (mUsage.hides) mGiven.erase(mUsage.hides);
  if (has("config")) readConfig(text("config"));
  mRecipe = vdbtools::completeRecipe(mGiven, mTable);
  mProgress = std::make_unique<Progress>(parseProgressStyle(has("progress")     ? text("progress")
                                                            : has(kQuietOption) ? "none"
                                                                                : "bar"),
                                         mUsage.command);
  return true;
}

void CommandLine::takePipes() const {
  for (const std::string& name : mPositionalNames) {
    const std::vector<std::string> words = wordsOf(name);
    if (std::find(words.begin(), words.end(), vdbtools::kStandardStream) == words.end()) continue;
    if (name != "input" || !mAcceptsStandardInput)
      throw std::invalid_argument(std::string("'-' is the standard input, which 'juliavdb ") + mUsage.command +
                                  "' does not read; name a file, which may be ./- if it is called so");
    vdbtools::takeStandardInput();
  }
}

std::string CommandLine::text(const std::string& name) const {
  return has(name) ? mValues[name].as<std::string>() : std::string();
}

std::vector<std::string> CommandLine::texts(const std::string& name) const {
  return has(name) ? mValues[name].as<std::vector<std::string>>() : std::vector<std::string>();
}

std::vector<std::string> CommandLine::wordsOf(const std::string& name) const {
  const bool isText = has(name) && mValues[name].value().type() == typeid(std::string);
  return isText ? std::vector<std::string>{text(name)} : texts(name);
}

vdbtools::InputFiles CommandLine::inputs() const {
  vdbtools::InputFiles inputs;
  // "sheet.json#7" names a cell in the file "sheet.json".
  const auto add = [&](const std::string& name) {
    inputs.add(name);
    if (vdbtools::isSheetCell(name)) inputs.add(vdbtools::sheetOfCell(name));
  };
  for (const std::string& name : mPositionalNames)
    for (const std::string& word : wordsOf(name)) add(word);
  if (has("config")) add(text("config"));
  return inputs;
}

std::vector<std::string> CommandLine::commonWords() const {
  std::vector<std::string> words;
  for (const auto& option : mCommon.options()) {
    const std::string& name = option->long_name();
    if (name == "threads" || name == "help" || !has(name)) continue;
    words.push_back("--" + name);
    if (option->semantic()->max_tokens() > 0) words.push_back(text(name));
  }
  return words;
}

void CommandLine::readConfig(const std::string& file) {
  vdbtools::Recipe base;
  if (holdsRecipe(file)) {
    auto [command, recipe] = vdbtools::readRecordedRecipe(file);
    if (command.empty()) throw vdbtools::DataError(vdbtools::noRecipeText(file));
    if (command != (mUsage.recipesOf ? mUsage.recipesOf : mUsage.command))
      throw std::invalid_argument("'" + file + "' was made by 'juliavdb " + command + "', not by 'juliavdb " +
                                  mUsage.command + "'");
    base = std::move(recipe);
    mConfigHolder = file;
  } else {
    // The file is read whole, so that one that cannot be read to its end is not taken for a shorter one.
    const std::string list = vdbtools::readWholeFile(file);
    if (list.find('\0') != std::string::npos)
      throw vdbtools::DataError("'" + file + "' is neither a text of lines NAME = VALUE nor a " +
                                vdbtools::namesOf(&vdbtools::FileFormat::recipe) + " with a recipe");
    base = readConfigList(list, file, mTable);
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
    // The second is for jobs that did not specify the number of processors per task.
    for (const char* name : {"SLURM_CPUS_PER_TASK", "SLURM_CPUS_ON_NODE"})
      if (const char* value = std::getenv(name); value && !threads) threads = parseThreads(value);
  }
  // TBB counts the processors of the affinity mask itself.
  if (!threads) return;
  // Kept until the process ends: to release the limit, oneTBB may start threads, which can fail at exit.
  [[maybe_unused]] static tbb::global_control* control = nullptr;
  control = new tbb::global_control(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(*threads));
}

void CommandLine::applyTalk() const {
  for (const char* name : {kQuietOption, kVerboseOption})
    if (has(name) && report().json())
      throw std::invalid_argument(std::string("--") + name +
                                  " has no effect: --progress json prints events only; leave it out");
  if (has(kQuietOption) && has(kVerboseOption))
    throw std::invalid_argument("--quiet and --verbose exclude each other; leave one of them out");
  if (has(kQuietOption) && has("progress") && text("progress") != "none")
    throw std::invalid_argument("--quiet shows no progress, and --progress asks for it; leave one of them out");
  if (has(kQuietOption)) report().setTalk(Talk::Quiet);
  if (has(kVerboseOption)) report().setTalk(Talk::Verbose);
}

void CommandLine::applyInstructions() const {
  const std::string name = has("instructions") ? text("instructions") : "auto";
  if (name == "auto") return;
  for (const julia::InstructionSet set :
       {julia::InstructionSet::Portable, julia::InstructionSet::Avx2, julia::InstructionSet::Avx512})
    if (name == julia::nameOf(set)) return julia::setInstructionSet(set);
  vdbtools::refuseChoice("instructions", name, std::vector<std::string>{"auto", "portable", "avx2", "avx512"});
}

void CommandLine::applyDevice() const {
  if (!has("device")) return;
  // Each sentence is printed once, however many fields it concerns.
  const auto said = std::make_shared<std::set<std::string>>();
  const auto mutex = std::make_shared<std::mutex>();
  const auto say = [said, mutex](const std::string& sentence) {
    const std::lock_guard lock(*mutex);
    if (said->insert(sentence).second) report().text() << sentence << '\n';
  };
  const std::string sentence = vdbtools::chooseDevice(text("device"), say);
  if (!sentence.empty()) say(sentence);
}

std::vector<CommandLine::Group> CommandLine::groups() const {
  std::vector<Group> groups;
  const auto add = [&](const std::string& heading, const boost::shared_ptr<po::option_description>& option) {
    auto group = std::find_if(groups.begin(), groups.end(), [&](const Group& g) { return g.heading == heading; });
    if (group == groups.end()) {
      groups.push_back({heading, po::options_description(heading, helpWidth())});
      group = groups.end() - 1;
    }
    group->options.add(option);
  };
  for (const auto& option : mOwn.options()) add(kOwn, option);
  const OptionGroups headings(mTable);
  for (const auto& option : mFromRecipe.options()) add(headings.headingOf(option->long_name()), option);
  for (const auto& option : mCommon.options()) add(kCommon, option);
  return groups;
}

void CommandLine::checkWords(const Arguments& arguments, const po::options_description& all) const {
  const auto isOption = [&](const std::string& word) { return optionOf(word, all) != nullptr; };
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const std::string& word = arguments[i];
    if (word == "--") return;
    if (isNegativeNumber(word)) continue;
    const bool isShort = word.size() > 1 && word[0] == '-' && !word.starts_with("--");
    const po::option_description* option = optionOf(word, all);
    if (isShort && (!option || (option->semantic()->max_tokens() == 0 && word.size() > 2)))
      throw std::invalid_argument("'" + word + "' is not an option of 'juliavdb " + mUsage.command +
                                  "'; see 'juliavdb " + mUsage.command + " --help'");
    if (!option) {
      if (!word.starts_with("--")) continue;
      const std::string name = word.substr(2, word.find('=') - 2);
      std::vector<std::string> known;
      for (const auto& each : all.options())
        if (!isHidden(*each, mHidden)) known.push_back(each->long_name());
      throw std::invalid_argument("--" + name + " is not an option of 'juliavdb " + mUsage.command +
                                  "'; see 'juliavdb " + mUsage.command + " --help'" +
                                  vdbtools::didYouMean(name, known, "--"));
    }
    if (option->semantic()->max_tokens() == 0) continue;
    const std::string name = word.substr(0, word.find('='));
    const auto lacking = [&](const std::string& why) {
      std::string argument = option->format_parameter();
      if (const std::size_t at = argument.find(" (="); at != std::string::npos) argument.resize(at);
      throw std::invalid_argument(name + " has no value: " + why + "; give one, as in " + name + ' ' + argument);
    };
    if (word.starts_with("--") && word.find('=') != std::string::npos) {
      if (word.back() == '=' && word.find('=') == word.size() - 1) lacking("nothing follows the equals sign");
      continue;
    }
    if (word.size() > 2 && !word.starts_with("--")) continue;  // -oNAME
    if (i + 1 == arguments.size()) lacking("it is the last word");
    if (isOption(arguments[i + 1])) lacking("'" + arguments[i + 1] + "' follows it");
    ++i;
  }
}

void CommandLine::printHelp(const std::string& topic) const {
  const std::vector<Group> all = groups();
  std::size_t count = 0;
  for (const Group& group : all) count += group.options.options().size();
  std::ostringstream text;
  if (topic.empty() || lowerCase(topic) == "all") {
    text << "Usage: juliavdb " << mUsage.command << ' ' << mUsage.synopsis << "\n\n"
         << wrapped(mUsage.description, helpWidth()) << "\n\n";
    if (topic.empty() && count > kMostAtOnce)
      text << shortHelp(all);
    else
      for (const Group& group : all) text << group.options << '\n';
    text << "Examples:\n" << mUsage.examples;
    return writeHelp(text.str());
  }
  std::vector<std::string> topics{"all"};
  for (const Group& group : all) topics.push_back(topicOf(group.heading));
  for (const Group& group : all)
    if (lowerCase(topic) == topicOf(group.heading)) text << group.options;
  if (!text.str().empty()) return writeHelp(text.str());
  const std::string asked = topic.substr(std::min(topic.find_first_not_of('-'), topic.size()));
  const std::string name = vdbtools::currentName(asked);
  for (const Group& group : all)
    for (const auto& option : group.options.options()) {
      topics.push_back(option->long_name());
      if (option->long_name() != name) continue;
      po::options_description one(group.heading, helpWidth());
      one.add(option);
      text << one;
      return writeHelp(text.str());
    }
  throw std::invalid_argument("there is no help about '" + topic + "'; 'juliavdb " + mUsage.command +
                              " --help' lists the groups, and --help all shows everything" +
                              vdbtools::didYouMean(name, topics));
}

/// The command's own options and the basic ones of its recipe; the others are listed by name, in groups.
std::string CommandLine::shortHelp(const std::vector<Group>& groups) const {
  std::ostringstream text;
  po::options_description basics("Basics", helpWidth());
  for (const Group& group : groups)
    for (const auto& option : group.options.options()) {
      if (group.heading == kOwn || isBasic(option->long_name())) basics.add(option);
    }
  text << basics << "\nMore options, by groups:\n";
  constexpr std::size_t kIndent = 12;
  for (const Group& group : groups) {
    if (group.heading == kOwn) continue;
    std::string line = "  " + topicOf(group.heading);
    line.resize(std::max(kIndent, line.size() + 2), ' ');
    for (const auto& option : group.options.options()) {
      const std::string name = "--" + option->long_name();
      if (line.size() + 1 + name.size() > helpWidth()) {
        text << line << '\n';
        line.assign(kIndent, ' ');
      }
      line += (line.ends_with("  ") || line.size() == kIndent ? "" : " ") + name;
    }
    text << line << '\n';
  }
  text << wrapped(std::string("'juliavdb ") + mUsage.command + " --help GROUP' describes a group, as in '--help " +
                      topicOf(groups.at(1).heading) + "', '--help NAME' an option, and '--help all' everything.",
                  helpWidth())
       << "\n\n";
  return text.str();
}

void CommandLine::describe(const std::string& how) const {
  const std::vector<Group> all = groups();
  std::vector<OptionGroup> described;
  for (const Group& group : all) described.push_back({group.heading, &group.options});
  if (how == "man")
    writeManualPage(std::cout, mUsage, described);
  else if (how == "completion")
    writeCompletionTable(std::cout, mUsage, described, vdbtools::OptionTable(mOwnSpecs), mTable);
  else if (how == "json")
    writeDescription(std::cout, mUsage, described, vdbtools::OptionTable(mOwnSpecs), mTable);
  else
    throw std::invalid_argument("--describe is '" + how + "'; it must be man, completion or json");
}

}  // namespace cli
