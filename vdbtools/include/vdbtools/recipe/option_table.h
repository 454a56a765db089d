// SPDX-License-Identifier: Apache-2.0
/// @file option_table.h
/// The options of a command as values: names, defaults, meanings, and what they do to each other. The command line, the
/// recipes and the documentation all read the same table.
///
/// A command may have a *selector*, an option whose value chooses among variants with options of their own: --map and
/// the maps. The table knows the options of all variants; a recipe uses those of one.
#pragma once

#include <functional>
#include <initializer_list>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

namespace vdbtools {

/// Option name (without dashes in front) -> value. A flag that is set has the value "true".
using Recipe = std::map<std::string, std::string>;

/// What a run makes, as far as that decides which options have an effect.
enum class Product {
  Vdb,        ///< grids in any format
  Mesh,       ///< a file that has room for everything that a mesh may carry
  Stl,        ///< a mesh without attributes
  Glb,        ///< a mesh with levels of detail, always with Y up
  MeshCount,  ///< a mesh that is counted and not written
  Picture,    ///< made by rays through the map itself
  Slice,      ///< made on a plane, of the map itself
  Stack,      ///< slices with the size of their voxels
  Recipe,     ///< a record of all options, for other runs
};

/// What files of these names or extensions are; those of other programs' formats are nothing.
std::set<Product> productsOf(std::span<const std::string> files);

/// A run as its options see it.
struct OptionRun {
  Recipe recipe{};  ///< completed
  std::set<Product> makes{};

  /// Whether it makes one of these. A record of the options is for any of them.
  bool makesAny(std::initializer_list<Product> products) const;
  /// The value of an option; "" if there is none.
  std::string text(const std::string& option) const;
};

/// Why an option has no effect in a run, and what else to give, to stand behind "--NAME has no effect: "; empty where
/// it has one.
using IdleRule = std::function<std::string(const OptionRun&)>;

/// Of an option that belongs to one of these products. @param products  in words, as "a VDB"
IdleRule idleWithout(std::set<Product> makes, std::string products);
/// Of an option that belongs to a flag.
IdleRule idleWithoutFlag(std::string flag);
/// Idle where one of @a rules says so.
IdleRule idleByAny(std::vector<IdleRule> rules);

/// The values that an option accepts, as far as they can be described; option_rows.h makes one with each option's
/// reader.
struct OptionType {
  enum class Kind {
    Text,
    Flag,
    Number,
    Whole,
    Choice,   ///< one of the words
    List,     ///< some of the words, with commas between them
    Vector,   ///< three numbers with commas between them
    Control,  ///< a number, or what gives one at each place (vdbtools/control/control.h)
  };
  Kind kind = Kind::Text;
  double low = -std::numeric_limits<double>::infinity(), high = std::numeric_limits<double>::infinity();
  bool excludesLow = false, excludesHigh = false;  ///< whether a number must differ from these bounds
  std::vector<std::string> words{};  ///< of a choice or a list; of other kinds, words that are accepted besides

  bool holds(double value) const {
    return (excludesLow ? value > low : value >= low) && (excludesHigh ? value < high : value <= high);
  }
  /// The bounds of a number, to stand behind "it must be".
  std::string bounds() const;
};

struct OptionSpec {
  std::string name;
  std::string argument{};                     ///< what the help calls the value; empty: a flag
  std::optional<std::string> defaultValue{};  ///< none: no default, or one that defaultFor finds
  std::string help{};

  /// The default where it depends on what else a recipe says.
  std::function<std::optional<std::string>(const Recipe&)> defaultFor{};
  std::string defaultNote{};  ///< what the help says of the default, where that is not its value

  /// Another option that says the same in another way. A recipe has at most one of the two, and giving one displaces
  /// the other.
  std::string alternative{};
  std::vector<std::string> displaces{};  ///< options that lose their meaning where this one is given
  std::vector<std::string> qualifies{};  ///< options that lose their meaning where this one's value changes

  std::string hash{};  ///< of an option that names a file: the recipe's entry for the file's SHA-256
  OptionType type{};

  IdleRule idle{};  ///< not set: it has an effect in every run

  // Of a variant's options.
  bool followsSelector = false;  ///< a change of the selector sets it back to its default
  /// Is recorded with every variant, also with those that do not read it: it survives a change of the selector.
  bool kept = false;
  /// Throws std::invalid_argument unless the value, given to a variant that does not read it, is well formed.
  std::function<void(const std::string& value)> check{};
};

struct OptionVariant {
  std::string name;
  std::vector<OptionSpec> options{};
  std::vector<std::string> excludes{};  ///< common options that it cannot use
};

/// An option as the help and the documentation list it: what all variants say of it.
struct OptionListing {
  std::string name;
  std::string argument;  ///< empty: a flag
  std::string help;      ///< with its defaults, and the variants that have it where these are not all
};

class OptionTable {
 public:
  OptionTable() = default;
  explicit OptionTable(std::vector<OptionSpec> options) : mCommon(std::move(options)) {}
  /// @param selector  one of @a options, with the name of the usual variant as its default
  /// @throw std::invalid_argument  no such option, no such variant, or two of one name
  OptionTable(std::vector<OptionSpec> options, std::string selector, std::vector<OptionVariant> variants);

  /// The options that a recipe is read by, and those that are kept for other variants.
  std::vector<const OptionSpec*> optionsOf(const Recipe& recipe) const;
  /// One of these; nullptr if a recipe of this variant has no such option.
  const OptionSpec* find(const std::string& name, const Recipe& recipe) const;
  /// Whether any variant has it.
  bool knows(const std::string& name) const;

  /// Every option once, in the order of the table, the variants' behind the selector.
  std::vector<OptionListing> listing() const;
  std::vector<std::string> names() const;
  /// The entries for the SHA-256 of files.
  std::vector<std::string> hashNames() const;

  const std::string& selector() const { return mSelector; }  ///< empty: none
  const std::vector<OptionVariant>& variants() const { return mVariants; }
  /// The variant's name in a recipe, as it stands there or by default; it may not exist.
  std::string selected(const Recipe& recipe) const;
  /// "a, b, c".
  std::string variantList() const;

  /// @throw std::invalid_argument  the recipe holds an option that is unknown or does not go with its variant
  void requireFits(const Recipe& recipe) const;

  /// Why an option has no effect in a run; empty: it has one. An option that is kept for other variants has none.
  std::string idle(const std::string& option, const OptionRun& run) const;

 private:
  const OptionVariant* variant(const std::string& name) const;
  const OptionVariant* variantOf(const Recipe& recipe) const;

  std::vector<OptionSpec> mCommon;
  std::string mSelector;
  std::vector<OptionVariant> mVariants;
};

/// Refuses options that were given and have an effect in none of a command's runs.
class RequiredEffects {
 public:
  /// @param given  what somebody has asked for now, and not what was recorded or is a default
  RequiredEffects(const OptionTable& table, std::set<std::string> given) : mTable(table), mIdle(std::move(given)) {}

  /// @return whether all have an effect in this run or in one before
  bool add(const OptionRun& run);
  /// @throw std::invalid_argument  one has an effect in no run
  void require() const;

 private:
  const OptionTable& mTable;
  std::set<std::string> mIdle;
  std::string mFirst, mWhy;
};

/// @a recipe with every option that has a default and is not given: what is recorded keeps its meaning when a later
/// version has other defaults.
Recipe completeRecipe(Recipe recipe, const OptionTable& table);

/// The entries of @a base that lose their meaning when @a option gets another value.
std::vector<std::string> displacedOptions(const Recipe& base, const std::string& option, const std::string& value,
                                          const OptionTable& table);

/// @a base with the entries of @a given over it: an option displaces its alternative, and another file its old hash.
Recipe overridden(Recipe base, const Recipe& given, const OptionTable& table);

// The options of a table as JSON, for programs that offer them to their own users. `juliavdb COMMAND --describe json`
// and the page of `explore` say the same of an option, because both take it from here.

/// An array of objects in the order of OptionTable::listing(). Values are text unless stated otherwise:
///   name         the option without dashes
///   argument     what the help calls its value; empty for a flag
///   help         with its defaults
///   type         an object: its *kind*, which is text, flag, number, whole, choice, list, vector or control, and where
///   they
///                are known the bounds *low* and *high*, whether these are excluded (*excludesLow*, *excludesHigh*),
///                and the *words* that it accepts (OptionType)
///   default      its value where it is not given but has an effect; missing where there is none
///   alternative  the entry of another option that says the same in another way; missing where there is none
///   displaces    a list of the entries that lose their meaning where this option is given
///
/// If the table has a selector, the variants may differ in their defaults. Such tables also have
///   maps         a list of the variants that have the option
///   defaults     an object of the defaults, by variant; if a variant takes a target, those with a target
/// and *default* is that of the first of these variants which has one.
std::string optionData(const OptionTable& table);

}  // namespace vdbtools
