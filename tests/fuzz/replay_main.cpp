// SPDX-License-Identifier: Apache-2.0
// Gives inputs to the harnesses without libFuzzer, so that any compiler can build it.
//
//   fuzz_replay REGRESSIONS          every file of REGRESSIONS/HARNESS/, and the seeds
//   fuzz_replay --seeds FOLDER       writes the seeds into FOLDER/HARNESS/
//   fuzz_replay HARNESS FILE...      these files
#include "harness.h"
#include "seeds.h"

#include "vdbtools/files/file_bytes.h"

#include <algorithm>
#include <chrono>
#include <exception>
#include <fstream>
#include <iostream>
#include <set>
#include <string>
#include <vector>

#include <sys/resource.h>

namespace {

namespace fs = std::filesystem;

constexpr double kMostSeconds = 10;  ///< for an input of 64 KiB; sanitizers and slow machines included
constexpr double kMostBytes = 2e9;   ///< that the process ever had

double mostBytesSoFar() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return 1024. * static_cast<double>(usage.ru_maxrss);
}

/// @return whether it went well
bool replay(const std::string& name, const std::string& what, std::string_view bytes) {
  const fuzz::Harness* const harness = fuzz::findHarness(name);
  if (!harness) {
    std::cerr << what << ": there is no harness '" << name << "'\n";
    return false;
  }
  const auto begin = std::chrono::steady_clock::now();
  try {
    fuzz::run(*harness, bytes);
  } catch (const std::exception& error) {
    std::cerr << what << ": " << error.what() << '\n';
    return false;
  } catch (...) {
    std::cerr << what << ": it threw something that is no std::exception\n";
    return false;
  }
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  if (took.count() > kMostSeconds) {
    std::cerr << what << ": it took " << took.count() << " s\n";
    return false;
  }
  // Once it had that much, what comes next cannot be told from it.
  static bool reported = false;
  if (const double taken = mostBytesSoFar(); !reported && taken > kMostBytes) {
    std::cerr << what << ": it took " << taken / 1e9 << " GB\n";
    reported = true;
    return false;
  }
  return true;
}

int replayAll(const fs::path& regressions) {
  bool good = true;
  std::size_t files = 0;
  std::set<std::string> seeded;
  for (const fuzz::Seed& seed : fuzz::seeds()) {
    seeded.insert(seed.harness);
    if (fuzz::findHarness(seed.harness) || seed.harness != "http_head")
      good = replay(seed.harness, "seed " + seed.harness + "/" + seed.name, seed.bytes) && good;
  }
  for (const fuzz::Harness& harness : fuzz::harnesses())
    if (!seeded.contains(harness.name)) {
      std::cerr << "the harness '" << harness.name << "' has no seed\n";
      good = false;
    }
  std::vector<fs::path> paths;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(regressions))
    if (entry.is_regular_file()) paths.push_back(entry.path());
  std::sort(paths.begin(), paths.end());
  for (const fs::path& path : paths) {
    const std::string harness = path.parent_path().filename().string();
    // The server's own harness is there only where the server is.
    if (harness == "http_head" && !fuzz::findHarness(harness)) continue;
    good = replay(harness, path.string(), vdbtools::readWholeFile(path)) && good;
    ++files;
  }
  std::cout << files << " regressions and the seeds of " << seeded.size() << " harnesses\n";
  return good ? 0 : 1;
}

int writeSeeds(const fs::path& folder) {
  for (const fuzz::Seed& seed : fuzz::seeds()) {
    fs::create_directories(folder / seed.harness);
    std::ofstream stream(folder / seed.harness / seed.name, std::ios::binary);
    stream.write(seed.bytes.data(), static_cast<std::streamsize>(seed.bytes.size()));
    if (!stream.flush()) {
      std::cerr << "cannot write into " << folder << '\n';
      return 1;
    }
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) try {
  const std::vector<std::string> words(argv + 1, argv + argc);
  if (words.size() == 2 && words[0] == "--seeds") return writeSeeds(words[1]);
  if (words.empty() || words[0].starts_with('-')) {
    std::cerr << "usage: fuzz_replay REGRESSIONS | --seeds FOLDER | HARNESS FILE...\n";
    return 2;
  }
  if (words.size() == 1) return replayAll(words[0]);
  bool good = true;
  for (std::size_t i = 1; i < words.size(); ++i)
    good = replay(words[0], words[i], vdbtools::readWholeFile(words[i])) && good;
  return good ? 0 : 1;
} catch (const std::exception& error) {
  std::cerr << "fuzz_replay: " << error.what() << '\n';
  return 1;
}
