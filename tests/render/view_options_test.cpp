// SPDX-License-Identifier: Apache-2.0
// The options of a picture: their defaults are those of the structs, and what contradicts is refused.
#include "vdbtools/render/view_options.h"

#include <gtest/gtest.h>

#include <stdexcept>

namespace {

using namespace vdbtools;

FieldPicture parsed(const Recipe& given) {
  return parseFieldPicture(given, OptionTable(fieldPictureOptionSpecs("800x800")));
}

TEST(ViewOptions, AreReadFromText) {
  const FieldPicture picture = parsed({{"size", "30x20"}, {"samples", "9"}, {"eye", "1,2,3"}, {"no-skip", "true"}});
  EXPECT_EQ(picture.render.width, 30);
  EXPECT_EQ(picture.render.height, 20);
  EXPECT_EQ(picture.render.samples, 9);
  EXPECT_EQ(picture.view.eye, openvdb::Vec3d(1, 2, 3));
  EXPECT_FALSE(picture.render.skip);
}

TEST(ViewOptions, RefusesWhatCannotBe) {
  for (const Recipe& given : std::initializer_list<Recipe>{{{"size", "30"}},
                                                           {{"size", "30x20x10"}},
                                                           {{"size", "0x20"}},
                                                           {{"size", "20x"}},
                                                           {{"size", "32769x1"}},
                                                           {{"samples", "2"}},
                                                           {{"elevation", "91"}},
                                                           {{"zoom", "0"}},
                                                           {{"up", "0,0,0"}},
                                                           {{"eye", "1,1,1"}, {"zoom", "1"}},
                                                           {{"delta", "3"}},
                                                           {{"epsilon", "0"}},
                                                           {{"alpha", "40"}}})
    EXPECT_THROW(parsed(given), std::invalid_argument) << given.begin()->first << ' ' << given.begin()->second;
}

}  // namespace
