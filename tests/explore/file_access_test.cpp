// SPDX-License-Identifier: Apache-2.0
#include "explore/file_access.h"

#include "vdbtools/scene/fractal_options.h"
#include "vdbtools/scene/scene.h"

#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <vector>

namespace {

using vdbtools::FractalOptions;
using vdbtools::Recipe;

FractalOptions optionsOf(const Recipe& recipe) { return vdbtools::parseFractalOptions(recipe); }

/// Every kind of text by which options name files.
std::vector<std::string> textsWith(const std::string& file) {
  return {file + ".json",
          file + ".vdb",
          file + ".obj",
          "paint:red@" + file + ".ply:0:1",
          "near:" + file + ".obj:0.1:0:1",
          "texture:" + file + ".png:0:1",
          file + ".vdb:phi",
          "field:" + file + ".vdb:v",
          "iterations:" + file + ".png"};
}

// Promise: "the page can read no other ..."
// Promise: The page of `explore` "can ..."
TEST(FileAccess, NoOptionThatNamesAFileIsForgotten) {
  const vdbtools::MapRegistry maps = vdbtools::builtInMaps();
  const vdbtools::OptionTable table = vdbtools::fractalOptionTable();
  int named = 0;
  for (const auto& map : maps.maps()) {
    Recipe base = {{"map", map->name()}};
    if (map->targetUse() != vdbtools::TargetUse::None) base["input"] = "mine.obj";
    if (map->name() == "rational") base["rational"] = "mine.json";
    if (map->name() == "shape-modulus") {
      base["texture-over"] = "coral";  // its seed, frequency and share are read then
      base["grain"] = "along";         // its turn is read then
    }
    const vdbtools::explore::FileAccess access(optionsOf(base));
    EXPECT_NO_THROW(access.require(optionsOf(base)));
    if (base.contains("input")) base["attributes"] = "velocity";  // the neighbouring frames are read then
    for (const vdbtools::OptionSpec* spec : table.optionsOf(base)) {
      if (spec->argument.empty()) continue;
      bool takesFile = false;
      for (const std::string& text : textsWith("/etc/secret")) {
        std::optional<FractalOptions> options;
        try {
          options = optionsOf(vdbtools::overridden(base, {{spec->name, text}}, table));
        } catch (const std::invalid_argument&) {
          continue;  // it takes no such text
        }
        const bool names = [&] {
          for (const vdbtools::NamedFile& file : vdbtools::filesOf(*options))
            if (file.path.string().find("/etc/secret") != std::string::npos) return true;
          return false;
        }();
        takesFile = takesFile || names;
        if (!names) {
          // The names of a grid, of attributes and of an animation are any text; other maps' options are kept, and read
          // by nobody.
          EXPECT_TRUE(spec->name == "grid" || spec->name == "transfer" || spec->name == "target-animation" ||
                      spec->name == "rest-attribute" || (spec->name == "grain" && text.starts_with("paint:")) ||
                      spec->kept)
              << map->name() << " --" << spec->name << ' ' << text;
          continue;
        }
        ++named;
        EXPECT_THROW(access.require(*options), vdbtools::explore::FileRefused) << "--" << spec->name << ' ' << text;
        EXPECT_NO_THROW(vdbtools::explore::FileAccess(*options).require(*options)) << "--" << spec->name << ' ' << text;
      }
      // Only a target can move, and only one map follows it to rest.
      const bool isUseless = spec->name == "rest" ? map->name() != "shape-modulus"
                                                  : !base.contains("input") && spec->name.starts_with("target-");
      if (!spec->hash.empty() && !spec->kept && !isUseless) {
        EXPECT_TRUE(takesFile) << map->name() << " --" << spec->name << " has a hash of a file, and no file";
      }
    }
  }
  EXPECT_GT(named, 10);
}

// Promise: "the page can read no other ..."
TEST(FileAccess, NamesThatCannotLeaveAFolder) {
  for (const char* name : {"a", "look-1", "My look.2", "_x", "a..b", "0"})
    EXPECT_NO_THROW(vdbtools::explore::requireFileName(name));
  for (const char* name :
       {"", ".", "..", "../a", "a/b", "/a", ".a", "-a", " a", "a\nb", "a\\b", "\xc3\xbc", "a:b", "a*"})
    EXPECT_THROW(vdbtools::explore::requireFileName(name), std::invalid_argument) << name;
  EXPECT_THROW(vdbtools::explore::requireFileName(std::string("a\0b", 3)), std::invalid_argument);
  EXPECT_THROW(vdbtools::explore::requireFileName(std::string(101, 'a')), std::invalid_argument);
}

}  // namespace
