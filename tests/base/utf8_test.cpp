// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/base/text.h"

#include <gtest/gtest.h>

#include <set>
#include <string>

namespace {

using vdbtools::characterAt;

TEST(Utf8, IsCutWhereCharactersBegin) {
  std::string text;
  std::set<std::size_t> starts;
  for (const char* character : {"a", "\u00e9", "\u20ac", "\U0001f980", "z", "\U0001f980", "\u0301"}) {
    starts.insert(text.size());
    text += character;
  }
  starts.insert(text.size());
  for (std::size_t at = 0; at <= text.size(); ++at) EXPECT_EQ(characterAt(text, at), *--starts.upper_bound(at)) << at;
}

TEST(Utf8, BytesThatAreNoneAreCutNearBy) {
  const std::string bytes(100, '\x80');
  for (std::size_t at = 0; at <= bytes.size(); ++at) {
    EXPECT_LE(characterAt(bytes, at), at);
    EXPECT_GE(characterAt(bytes, at) + 3, at);
  }
  EXPECT_EQ(characterAt("", 0), 0U);
}

}  // namespace
