// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/base/text.h"

#include <gtest/gtest.h>

#include <random>
#include <string>
#include <vector>

namespace {

using vdbtools::didYouMean;
using vdbtools::editDistance;
using vdbtools::nearestWord;

std::string randomWord(std::mt19937& random) {
  std::string word(random() % 7, ' ');
  for (char& c : word) c = static_cast<char>('a' + random() % 3);
  return word;
}

TEST(NearWords, TheDistanceIsSymmetricAndZeroOnlyForEqualWords) {
  std::mt19937 random(1);
  for (int n = 0; n < 2000; ++n) {
    const std::string a = randomWord(random), b = randomWord(random);
    EXPECT_EQ(editDistance(a, b), editDistance(b, a)) << a << ' ' << b;
    EXPECT_EQ(editDistance(a, b) == 0, a == b) << a << ' ' << b;
    EXPECT_LE(editDistance(a, b), std::max(a.size(), b.size()));
    EXPECT_GE(editDistance(a, b), std::max(a.size(), b.size()) - std::min(a.size(), b.size()));
  }
}

TEST(NearWords, EachEditCountsOnce) {
  std::mt19937 random(2);
  for (int n = 0; n < 500; ++n) {
    const std::string word = "x" + randomWord(random) + "y";
    const std::size_t at = random() % (word.size() - 1);
    std::string added = word, dropped = word, replaced = word, exchanged = word;
    added.insert(at, 1, 'q');
    dropped.erase(at, 1);
    replaced[at] = 'q';
    std::swap(exchanged[at], exchanged[at + 1]);
    for (const std::string& other : {added, dropped, replaced}) EXPECT_EQ(editDistance(word, other), 1U) << other;
    EXPECT_EQ(editDistance(word, exchanged), exchanged == word ? 0U : 1U) << word;
  }
}

TEST(NearWords, WhatIsMeant) {
  const std::vector<std::string> known{"detail", "resolution", "threads", "c", "repair", "repair-gap"};
  EXPECT_EQ(nearestWord("detial", known), "detail");
  EXPECT_EQ(nearestWord("Resolutoin", known), "resolution");
  EXPECT_EQ(nearestWord("thr", known), "threads");
  EXPECT_EQ(nearestWord("repiar", known), "repair");
  EXPECT_FALSE(nearestWord("frobnicate", known));
  EXPECT_FALSE(nearestWord("", known));
  EXPECT_FALSE(nearestWord("d", known)) << "one letter could mean anything";
  EXPECT_FALSE(nearestWord(std::string(100000, 'd'), known));
  EXPECT_EQ(didYouMean("detial", known, "--"), "; did you mean '--detail'?");
  EXPECT_EQ(didYouMean("frobnicate", known), "");
}

}  // namespace
