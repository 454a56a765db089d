// SPDX-License-Identifier: Apache-2.0
#include "harness.h"
#include "support/temporary_folder.h"

#include "vdbtools/base/errors.h"

#include <array>
#include <fstream>
#include <stdexcept>
#include <vector>

namespace fuzz {

std::span<const Harness> harnesses() {
  static const std::vector<Harness> all = [] {
    std::vector<Harness> list;
    for (const auto& part : {meshHarnesses(), formatHarnesses(), textHarnesses(), farmHarnesses(), exploreHarnesses()})
      list.insert(list.end(), part.begin(), part.end());
    return list;
  }();
  return all;
}

const Harness* findHarness(std::string_view name) {
  for (const Harness& harness : harnesses())
    if (name == harness.name) return &harness;
  return nullptr;
}

void run(const Harness& harness, std::string_view bytes) {
  if (harness.refusal == Refusal::None) return harness.read(bytes);
  try {
    harness.read(bytes);
  } catch (const vdbtools::DataError&) {
  } catch (const std::invalid_argument&) {
    if (harness.refusal != Refusal::Usage) throw;
  }
}

std::filesystem::path scratchFolder() {
  static const TemporaryFolder folder;
  return folder.path();
}

std::filesystem::path scratchFile(const std::string& name, std::string_view bytes) {
  const std::filesystem::path path = scratchFolder() / name;
  std::ofstream stream(path, std::ios::binary | std::ios::trunc);
  stream.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  stream.close();
  if (!stream) throw std::runtime_error("cannot write " + path.string());
  return path;
}

std::size_t takeChoice(std::string_view& bytes, std::size_t choices) {
  if (bytes.empty()) return 0;
  const auto first = static_cast<unsigned char>(bytes.front());
  bytes.remove_prefix(1);
  return static_cast<unsigned char>(first - '0') % choices;
}

}  // namespace fuzz
