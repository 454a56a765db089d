// SPDX-License-Identifier: Apache-2.0
#include "support/temporary_folder.h"

#include "explore/shell_command.h"

#include "vdbtools/base/text.h"
#include "vdbtools/scene/fractal_options.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <random>
#include <string>
#include <vector>

namespace {

using vdbtools::Recipe;

/// The words that a shell makes of a command, by a shell.
std::vector<std::string> wordsOfShell(const std::string& command) {
  // The words come back each with a zero behind it, which no word can hold.
  const std::string script = "set -- " + command + "\nfor word do printf '%s\\000' \"$word\"; done";
  const TemporaryFolder folder;
  std::FILE* const pipe = ::popen(("sh '" + folder.write("script", script).native() + "'").c_str(), "r");
  std::string bytes;
  char buffer[4096];
  while (const std::size_t count = std::fread(buffer, 1, sizeof buffer, pipe)) bytes.append(buffer, count);
  EXPECT_EQ(::pclose(pipe), 0) << script;
  std::vector<std::string> words;
  for (std::size_t at = 0; at < bytes.size();) {
    const std::size_t end = bytes.find('\0', at);
    words.push_back(bytes.substr(at, end - at));
    at = end + 1;
  }
  return words;
}

// Promise: "*Copy command* gives the command ..."
TEST(ShellCommand, AShellReadsTheWordsThatWereMeant) {
  std::vector<std::string> words = {"",   "plain", "two words", "it's", "''", "$HOME", "`id`",
                                    "\\", "a\nb",  "*",         "~",    "#x", "!",     "a=b",
                                    "-x", ";",     "&",         "|",    "\"", "(x)",   "{a,b}"};
  std::mt19937 random(7);
  for (int i = 0; i < 200; ++i) {
    std::string word;
    for (int length = static_cast<int>(random() % 12); length > 0; --length)
      word += static_cast<char>(1 + random() % 255);
    words.push_back(word);
  }
  std::string command;
  for (const std::string& word : words) command += vdbtools::shellWord(word) + ' ';
  EXPECT_EQ(wordsOfShell(command), words);
}

// Promise: "*Copy command* gives the command ..."
TEST(ShellCommand, EveryOptionIsInTheCommand) {
  const vdbtools::OptionTable table = vdbtools::fractalOptionTable();
  const Recipe recipe = {{"input", "it's mine.obj"},
                         {"map", "shape-modulus"},
                         {"detail", "expr:0.2 + 0.1*x"},
                         {"repair", "true"},
                         {"half", "false"},
                         {"texture-translate", "-0.1,0,0"},
                         {"grid", ""},
                         {"source-sha256", "01234567"}};
  const std::string command =
      vdbtools::explore::fractalCommand(recipe, table, {{"-o", "-a b.vdb"}, {"--mesh", "c.ply"}});
  const std::vector<std::string> words = wordsOfShell(command);
  const auto has = [&](std::initializer_list<const char*> part) {
    return std::search(words.begin(), words.end(), part.begin(), part.end()) != words.end();
  };
  EXPECT_TRUE(has({"juliavdb", "fractal", "it's mine.obj"})) << command;
  EXPECT_TRUE(has({"--detail", "expr:0.2 + 0.1*x"})) << command;
  EXPECT_TRUE(has({"--texture-translate=-0.1,0,0"})) << command;
  EXPECT_TRUE(has({"--repair"})) << command;
  EXPECT_TRUE(has({"-o", "./-a b.vdb", "--mesh", "c.ply"})) << command;
  EXPECT_EQ(words.size(), 3U + 2 + 2 + 1 + 1 + 4) << command;
  EXPECT_EQ(wordsOfShell(vdbtools::explore::fractalCommand({{"input", "-x.obj"}}, table, {})),
            (std::vector<std::string>{"juliavdb", "fractal", "--input=-x.obj"}));
}

TEST(ShellCommand, TheShortestRecipeIsCompletedToTheSame) {
  const vdbtools::OptionTable table = vdbtools::fractalOptionTable();
  const std::vector<Recipe> recipes = {
      {{"input", "a.obj"}},
      {{"input", "a.obj"}, {"detail", "0.6"}, {"texture", "random"}, {"texture-roots", "4"}},
      {{"input", "a.obj"}, {"alpha", "40"}, {"beta", "0.02"}, {"origin", "centre"}},
      {{"map", "quadratic"}, {"c", "-0.2,0.6,0.2,0.2"}, {"voxel-size", "0.02"}},
      {{"map", "mandelbulb"}, {"power", "8"}},
      {{"input", "a.obj"}, {"map", "rational"}, {"rational", "f.json"}, {"rational-sha256", "0123"}}};
  for (const Recipe& given : recipes) {
    const Recipe completed = vdbtools::completeRecipe(given, table);
    const Recipe shortest = vdbtools::explore::shortestRecipe(completed, table);
    EXPECT_EQ(vdbtools::completeRecipe(shortest, table), completed);
    EXPECT_LE(shortest.size(), given.size()) << given.rbegin()->first;
    for (const auto& [name, value] : shortest) {
      Recipe without = shortest;
      without.erase(name);
      EXPECT_NE(vdbtools::completeRecipe(without, table), completed) << name << " is not needed";
    }
  }
}

}  // namespace
