// SPDX-License-Identifier: Apache-2.0
/// @file harness.h
/// What is fuzzed: a function that gives bytes to one of the program's readers, under a name, and what that reader may
/// throw. Anything else that it throws ends the process, as a crash does. README.md says how to run and to add one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

namespace fuzz {

/// What a reader may do about bytes that it cannot use.
enum class Refusal {
  Data,   ///< DataError: it was a file. A std::invalid_argument would tell users that they had mistyped something
  Usage,  ///< std::invalid_argument too: it was something that users type
  None,   ///< nothing: bad bytes are an answer, too
};

/// Changes bytes in a way that keeps more of a format's structure than libFuzzer's own mutations do.
/// @param bytes  the first @a size of them are in use
/// @return how many are in use afterwards
using Mutator = std::size_t(std::span<std::uint8_t> bytes, std::size_t size, unsigned seed);

struct Harness {
  const char* name;
  void (*read)(std::string_view bytes);
  Refusal refusal = Refusal::Data;
  Mutator* mutate = nullptr;
};

/// All of them.
std::span<const Harness> harnesses();

/// nullptr: there is none of that name.
const Harness* findHarness(std::string_view name);

/// Reads, and takes the refusals that are allowed. Others leave as exceptions.
void run(const Harness& harness, std::string_view bytes);

/// Puts bytes into a file in a folder that is this process's own. The next call with the same name replaces it.
std::filesystem::path scratchFile(const std::string& name, std::string_view bytes);
/// That folder.
std::filesystem::path scratchFolder();

/// Takes the first byte of an input as a choice among several. Printable, so that seeds can be read: '0' is the first.
std::size_t takeChoice(std::string_view& bytes, std::size_t choices);

// Those of each file.
std::span<const Harness> meshHarnesses();
std::span<const Harness> formatHarnesses();
std::span<const Harness> textHarnesses();
std::span<const Harness> farmHarnesses();
std::span<const Harness> exploreHarnesses();

}  // namespace fuzz
