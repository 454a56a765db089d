// SPDX-License-Identifier: Apache-2.0
/// @file options.h
/// The command line of one command: its own options, those of a recipe, and the ones that all commands have.
#pragma once

#include "commands/commands.h"
#include "progress.h"

#include "vdbtools/files/input_files.h"
#include "vdbtools/recipe/option_value.h"
#include "vdbtools/recipe/recipe.h"

#include <boost/program_options.hpp>

#include <filesystem>
#include <initializer_list>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace cli {

/// The description of a command.
struct Usage {
  const char* command;   ///< the command's name, such as "fractal"
  const char* synopsis;  ///< what follows "juliavdb fractal"
  const char* description;
  const char* examples;  ///< lines that work as they stand, given the files they name
  /// The command whose recipes --config accepts from generated files; by default the command itself.
  const char* recipesOf = nullptr;
  /// The words that can follow the command, as in "list new inspect"; nullptr: anything may follow.
  const char* words = nullptr;
  /// An option of recipes that the command line does not take, because the command has its own option of that name.
  const char* hides = nullptr;
};

class CommandLine {
 public:
  /// @param recipeOptions  options that make up a recipe; "input" among them is positional
  CommandLine(const Usage& usage, vdbtools::OptionTable recipeOptions);

  /// Adds the command's other options, which do not affect the result.
  boost::program_options::options_description_easy_init addOptions() { return mOwn.add_options(); }
  /// The same for options that a table describes.
  void addOptions(const std::vector<vdbtools::OptionSpec>& options);
  /// Adds a positional argument that is not part of a recipe; @a count -1 takes all that follow.
  void addPositional(const char* name, int count, const char* help);

  /// Accepts an option by the name that it had in earlier versions, too. Help does not show that name.
  void addFormerName(const std::string& former, const std::string& now) { mFormerNames[former] = now; }

  /// Lets the positional argument "input" be "-", the standard input. parse() then stores it
  /// (vdbtools/files/standard_streams.h). All other commands refuse a positional argument of that name.
  void acceptStandardInput() { mAcceptsStandardInput = true; }

  /// @return false if help was requested and shown
  /// @throw std::invalid_argument  says in one line what is wrong with the words
  bool parse(const Arguments& arguments);

  const boost::program_options::variables_map& values() const { return mValues; }
  bool has(const std::string& name) const { return mValues.count(name) != 0; }
  std::string text(const std::string& name) const;
  std::vector<std::string> texts(const std::string& name) const;

  // Values of options that are not part of a recipe, parsed by the same rules as those that are.
  double number(const std::string& name) const { return vdbtools::parseNumber(name, text(name)); }
  template <class Integer = int>
  Integer integer(const std::string& name, Integer low, Integer high) const {
    return vdbtools::parseInteger<Integer>(name, text(name), low, high);
  }
  template <class Value>
  Value choice(const std::string& name, const vdbtools::Choices<Value>& choices) const {
    return vdbtools::chosen<Value>(name, text(name), choices);
  }
  /// @param wanted  what follows "it must be"
  [[noreturn]] void refuse(const std::string& name, const std::string& wanted) const {
    vdbtools::refuse(name, text(name), wanted);
  }

  /// The recipe: the command line overrides --config, which overrides the defaults.
  const vdbtools::Recipe& recipe() const { return mRecipe; }
  /// Only what was given on the command line or by --config.
  const vdbtools::Recipe& givenRecipe() const { return mGiven; }
  /// The options that were given on the command line, for the recipe or for another table.
  vdbtools::Recipe given(const vdbtools::OptionTable& table) const;
  vdbtools::Recipe given() const { return given(mTable); }
  /// Refuses recipe options on the command line that affect none of the command's runs. Options from --config or a
  /// file's recipe may be without effect.
  void requireEffect(std::set<vdbtools::Product> makes) const { requireEffect({{mRecipe, std::move(makes)}}); }
  void requireEffect(const std::vector<vdbtools::OptionRun>& runs) const { requireEffect(typedNames(), runs); }
  void requireEffect(std::set<std::string> names, const std::vector<vdbtools::OptionRun>& runs) const;
  /// The recipe options on the command line, without the target.
  std::set<std::string> typedNames() const;
  /// Refuses options that are not part of a recipe if they were given but not used.
  /// @param why  "it goes with --estimate; give that too, or leave it out"
  void requireUse(bool used, std::initializer_list<const char*> names, const std::string& why) const;

  /// The file of --config if it holds a recipe that the program recorded; else empty.
  const std::filesystem::path& configHolder() const { return mConfigHolder; }
  /// The files on the command line that the command works on, and the file of --config; no output may be one of them.
  vdbtools::InputFiles inputs() const;
  /// The words of the common options that were given, to pass on to other commands of this program. The caller decides
  /// how many threads each of them gets.
  std::vector<std::string> commonWords() const;
  Progress& progress() const { return *mProgress; }
  /// For a command that serves once its work is done: ends the progress display.
  void endProgress() { mProgress.reset(); }

 private:
  /// All options by their headings: the command's own first, the common ones last.
  struct Group {
    std::string heading;
    boost::program_options::options_description options;
  };
  std::vector<Group> groups() const;

  /// Replaces former names of options by their current ones: --versor-seed becomes --texture-seed.
  Arguments renamed(Arguments arguments, const boost::program_options::options_description& all) const;
  /// Finds words that boost would misread: an option without its value, an option that does not exist.
  void checkWords(const Arguments& arguments, const boost::program_options::options_description& all) const;
  void readConfig(const std::string& file);
  /// The word or words of a positional argument.
  std::vector<std::string> wordsOf(const std::string& name) const;
  void takePipes() const;
  void applyThreads();
  void applyTalk() const;
  void applyInstructions() const;
  void applyDevice() const;
  void printHelp(const std::string& topic) const;
  std::string shortHelp(const std::vector<Group>& groups) const;
  void describe(const std::string& how) const;

  Usage mUsage;
  vdbtools::OptionTable mTable;
  std::vector<vdbtools::OptionSpec> mOwnSpecs;  ///< those of mOwn that come from tables
  boost::program_options::options_description mOwn{"Options"}, mFromRecipe{"What to make"}, mCommon{"Common options"},
      mHidden;
  boost::program_options::positional_options_description mPositional;
  std::vector<std::string> mPositionalNames;
  boost::program_options::variables_map mValues;
  vdbtools::Recipe mRecipe, mGiven;
  std::filesystem::path mConfigHolder;
  std::map<std::string, std::string> mFormerNames;
  bool mAcceptsStandardInput = false;
  std::unique_ptr<Progress> mProgress;
};

}  // namespace cli
