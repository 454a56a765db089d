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

/// What a command says of itself.
struct Usage {
  const char* command;   ///< as in "fractal"
  const char* synopsis;  ///< what follows "juliavdb fractal"
  const char* description;
  const char* examples;  ///< lines that work as they stand, given the files they name
  /// The command whose recipes --config takes from files that were made; its own if it is not given.
  const char* recipesOf = nullptr;
  /// Words of which one follows the command, as in "list new inspect"; nullptr: anything may.
  const char* words = nullptr;
  /// An option of recipes that the command line does not take, because the command has its own of that name.
  const char* hides = nullptr;
};

class CommandLine {
 public:
  /// @param recipeOptions  options that make up a recipe; "input" among them is positional
  CommandLine(const Usage& usage, vdbtools::OptionTable recipeOptions);

  /// The command's other options, those that do not affect the result.
  boost::program_options::options_description_easy_init addOptions() { return mOwn.add_options(); }
  /// The same, declared in a table.
  void addOptions(const std::vector<vdbtools::OptionSpec>& options);
  /// A positional argument that is no part of a recipe; @a count -1 takes all that follow.
  void addPositional(const char* name, int count, const char* help);

  /// @return false if help was asked for and shown
  /// @throw std::invalid_argument  what is wrong with the words, in one line
  bool parse(const Arguments& arguments);

  const boost::program_options::variables_map& values() const { return mValues; }
  bool has(const std::string& name) const { return mValues.count(name) != 0; }
  std::string text(const std::string& name) const;
  std::vector<std::string> texts(const std::string& name) const;

  // Values of options that are no part of a recipe, by the rules of those that are.
  double number(const std::string& name) const { return vdbtools::parseNumber(name, text(name)); }
  template <class Integer = int>
  Integer integer(const std::string& name, Integer low, Integer high) const {
    return vdbtools::parseInteger<Integer>(name, text(name), low, high);
  }
  template <class Value>
  Value choice(const std::string& name, std::initializer_list<std::pair<const char*, Value>> choices) const {
    return vdbtools::parseChoice<Value>(name, text(name), choices);
  }
  /// @param wanted  what follows "it must be"
  [[noreturn]] void refuse(const std::string& name, const std::string& wanted) const {
    vdbtools::refuse(name, text(name), wanted);
  }

  /// The recipe: the command line's words over those of --config over the defaults.
  const vdbtools::Recipe& recipe() const { return mRecipe; }
  /// Only what was given on the command line or by --config.
  const vdbtools::Recipe& givenRecipe() const { return mGiven; }
  /// What was given on the command line, of the recipe or of another table.
  vdbtools::Recipe given(const vdbtools::OptionTable& table) const;
  vdbtools::Recipe given() const { return given(mTable); }
  /// Refuses what was typed of the recipe and has an effect in none of the command's runs. What --config or a file's
  /// recipe says may be without one.
  void requireEffect(std::set<vdbtools::Product> makes) const { requireEffect({{mRecipe, std::move(makes)}}); }
  void requireEffect(const std::vector<vdbtools::OptionRun>& runs) const { requireEffect(typedNames(), runs); }
  void requireEffect(std::set<std::string> names, const std::vector<vdbtools::OptionRun>& runs) const;
  /// The options of the recipe that were typed, without the target.
  std::set<std::string> typedNames() const;
  /// Refuses options that are no part of a recipe, where they were given and do nothing.
  /// @param why  "it goes with --estimate; give that too, or leave it out"
  void requireUse(bool used, std::initializer_list<const char*> names, const std::string& why) const;

  /// The file of --config if that has a recipe which the program recorded; else empty.
  const std::filesystem::path& configHolder() const { return mConfigHolder; }
  /// The files that the line names as what is worked on, and that of --config: no output may be one of them.
  vdbtools::InputFiles inputs() const;
  /// The words of those common options that were given, for other commands of this program. How many threads each of
  /// these gets is the caller's to say.
  std::vector<std::string> commonWords() const;
  Progress& progress() const { return *mProgress; }
  /// For a command that serves once its work is done: nothing more is shown.
  void endProgress() { mProgress.reset(); }

 private:
  /// All options by their headings: the command's own first, those that all commands have last.
  struct Group {
    std::string heading;
    boost::program_options::options_description options;
  };
  std::vector<Group> groups() const;

  /// Finds what boost would take for something else: an option without its value, an option that does not exist.
  void checkWords(const Arguments& arguments, const boost::program_options::options_description& all) const;
  void readConfig(const std::string& file);
  void applyThreads();
  void applyInstructions() const;
  void printHelp(const std::string& topic) const;
  std::string shortHelp(const std::vector<Group>& groups) const;
  void describe(const std::string& how) const;

  Usage mUsage;
  vdbtools::OptionTable mTable;
  boost::program_options::options_description mOwn{"Options"}, mFromRecipe{"What to make"}, mCommon{"Common options"},
      mHidden;
  boost::program_options::positional_options_description mPositional;
  std::vector<std::string> mPositionalNames;
  boost::program_options::variables_map mValues;
  vdbtools::Recipe mRecipe, mGiven;
  std::filesystem::path mConfigHolder;
  std::unique_ptr<Progress> mProgress;
};

/// --search, for commands that take a recipe from a file that was made.
void addSearchOption(CommandLine& line);
/// A fractal's recipe with its files where they are today, for opening them: with what --search says, and a note of
/// each file that is elsewhere (vdbtools/records/recorded_files.h). What is recorded keeps the names that it has.
/// @param holder  the file that has the recipe; empty: it was typed, and stays as it is
/// @param wayOut  what else the user can do where a file is missing
/// @throw as vdbtools::findRecordedFiles()
vdbtools::Recipe withFoundFiles(const CommandLine& line, const vdbtools::Recipe& recipe,
                                const std::filesystem::path& holder, const std::string& wayOut = {});

/// The recipe for a command that shows a scene, as far as it is given: of a fractal that this program made its own
/// recipe stands in for the options that were not given, its input among them. Its files are named as they are found
/// today, by withFoundFiles().
vdbtools::Recipe givenSceneRecipe(const CommandLine& line, const std::string& input);
/// The same, completed.
vdbtools::Recipe sceneRecipe(const CommandLine& line, const std::string& input);

}  // namespace cli
