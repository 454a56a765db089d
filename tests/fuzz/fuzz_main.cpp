// SPDX-License-Identifier: Apache-2.0
// The entries of libFuzzer. One program serves all harnesses: called fuzz_ply, it fuzzes the harness "ply".
#include "harness.h"

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* bytes, std::size_t size, std::size_t capacity);

namespace {

const fuzz::Harness* theHarness = nullptr;

}  // namespace

extern "C" int LLVMFuzzerInitialize(int* /*argc*/, char*** argv) {
  constexpr std::string_view kPrefix = "fuzz_";
  const std::string program = std::filesystem::path((*argv)[0]).filename().string();
  if (program.starts_with(kPrefix)) theHarness = fuzz::findHarness(std::string_view(program).substr(kPrefix.size()));
  if (theHarness) return 0;
  std::fprintf(stderr, "call this program by one of these names:");
  for (const fuzz::Harness& harness : fuzz::harnesses()) std::fprintf(stderr, " fuzz_%s", harness.name);
  std::fprintf(stderr, "\n");
  std::exit(2);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  fuzz::run(*theHarness, {reinterpret_cast<const char*>(bytes), size});
  return 0;
}

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* bytes, std::size_t size, std::size_t capacity,
                                               unsigned seed) {
  // Half of all changes are libFuzzer's own.
  if (!theHarness->mutate || seed % 2 == 0) return LLVMFuzzerMutate(bytes, size, capacity);
  return theHarness->mutate({bytes, capacity}, size, seed / 2);
}
