// SPDX-License-Identifier: Apache-2.0
// VDB files, rationals and pictures.
#include "formats/picture_file.h"
#include "formats/vdb_head.h"
#include "harness.h"

#include "vdbtools/base/memory.h"
#include "vdbtools/formats/nvdb_file.h"
#include "vdbtools/formats/peer_formats.h"
#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/formats/versor_file.h"
#include "vdbtools/target/target_input.h"

#include <array>
#include <cstring>
#include <random>
#include <stdexcept>

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* bytes, std::size_t size, std::size_t capacity)
    __attribute__((weak));

namespace fuzz {
namespace {

using namespace vdbtools;

void readVdbFile(std::string_view bytes) {
  const VdbFile file = decodeVdb(std::string(bytes));
  for (const openvdb::GridBase::Ptr& grid : file.grids) {
    grid->evalActiveVoxelBoundingBox();
    for (auto entry = grid->beginMeta(); entry != grid->endMeta(); ++entry)
      if (entry->second) entry->second->str();
  }
  // As a control reads it: every value.
  const openvdb::FloatGrid::Ptr floats = chooseFloatGrid(file, "", "file.vdb");
  float sum = 0;
  for (auto leaf = floats->tree().cbeginLeaf(); leaf; ++leaf)
    for (auto value = leaf->cbeginValueOn(); value; ++value) sum += *value;
  if (sum == 1) floats->setName("one");  // so that the sum is needed
}

/// A few bytes may announce any size: what needs more memory than this is refused.
template <class Read>
void withMemory(double bytes, Read read) {
  const MemoryLimit limit(residentMemory() + bytes);
  try {
    read();
  } catch (const MemoryError&) {
  }
}

void openVdbTarget(std::string_view bytes) {
  TargetOptions options;
  options.input.path = scratchFile("target.vdb", bytes);
  Monitor monitor;
  withMemory(500e6, [&] { openTarget(options, monitor)->box(); });
}

void readVdbHead(std::string_view bytes) {
  vdbHeadMetadata(bytes);
  readVdbMetadata(scratchFile("head.vdb", bytes));
}

/// A grid of NanoVDB takes 300 KB, most of them zeros: a zero and two bytes stand for as many zeros.
std::string withZeros(std::string_view bytes) {
  constexpr std::size_t kMost = 2'000'000;
  std::string result;
  while (!bytes.empty() && result.size() < kMost) {
    const char byte = bytes.front();
    bytes.remove_prefix(1);
    std::uint16_t count = 1;
    if (byte == '\0' && bytes.size() >= sizeof count) {
      std::memcpy(&count, bytes.data(), sizeof count);
      bytes.remove_prefix(sizeof count);
    }
    result.append(count, byte);
  }
  return result;
}

void readNvdbFile(std::string_view bytes) {
  const std::size_t choice = takeChoice(bytes, 2);
  withMemory(500e6, [&] { decodeNvdb(choice == 0 ? std::string(bytes) : withZeros(bytes)); });
}

/// What is read can be written, and reads back as the same.
void requireRoundTrip(const julia::Rational& rational) {
  const std::string text = rationalToJson(rational);
  if (rationalToJson(rationalFileFromJson(text, "again").rational) != text)
    throw std::logic_error("a rational does not come back as it was written");
}

void readWaves(std::string_view bytes) {
  const std::string text = wavesToJson(waveFileFromJson(bytes, "file.json").waves);
  if (wavesToJson(waveFileFromJson(text, "again").waves) != text)
    throw std::logic_error("waves do not come back as they were written");
}

void readJson(std::string_view bytes) { requireRoundTrip(rationalFileFromJson(bytes, "file.json").rational); }

void readP4d(std::string_view bytes) {
  julia::Rational rational;
  rational.top = polynomialFromP4d(bytes, "file.p4d");
  requireRoundTrip(rational);
}

void readO3d(std::string_view bytes) { requireRoundTrip(optimisedShapeFromO3d(bytes, "file.o3d").rational); }

void readAnyPicture(std::string_view bytes) {
  // Less than the 2 GB of a find: decoders need something beside the values.
  withMemory(32e6, [&] {
    const DecodedImage image = readPicture(scratchFile("picture", bytes));
    if (image.values.size() != std::size_t(image.width) * std::size_t(image.height) * std::size_t(image.channels))
      throw std::logic_error("a picture has another number of values than its size says");
  });
}

/// Puts numbers with a meaning where a VDB has numbers: sizes, counts and offsets have 4 or 8 bytes, flags and
/// kinds one, floats two or four. Where numbers begin is found by looking for small ones; what matters about most of
/// them is whether they are a little too large, far too large or negative.
std::size_t mutateVdb(std::span<std::uint8_t> bytes, std::size_t size, unsigned seed) {
  std::minstd_rand random(seed);
  if (size < 64) return LLVMFuzzerMutate ? LLVMFuzzerMutate(bytes.data(), size, bytes.size()) : size;
  const auto pick = [&](std::size_t count) { return std::uniform_int_distribution<std::size_t>(0, count - 1)(random); };
  std::size_t at = pick(size - 8);
  const std::size_t width = std::array<std::size_t, 4>{1, 2, 4, 8}[pick(4)];
  // A size or a count: few digits that are not 0. The next one from here on, if there is one near.
  for (std::size_t i = 0; width >= 4 && i < 256 && at + width < size; ++i, ++at)
    if (bytes[at] != 0 && bytes[at + 2] == 0 && bytes[at + 3] == 0) break;
  if (at + width > size) at = size - width;
  std::uint64_t value = 0;
  std::memcpy(&value, bytes.data() + at, width);
  switch (pick(9)) {
    case 0: ++value; break;
    case 1: --value; break;
    case 2: value = 0; break;
    case 3: value = ~std::uint64_t{0}; break;
    case 4: value = std::uint64_t{1} << (8 * width - 1); break;
    case 5: value = (std::uint64_t{1} << (8 * width - 1)) - 1; break;
    case 6: value *= 2; break;
    case 7: value ^= std::uint64_t{1} << pick(8 * width); break;
    default: value = size - at; break;
  }
  std::memcpy(bytes.data() + at, &value, width);
  // Now and then a piece is left out or comes twice, as when a count and what it counts disagree.
  if (pick(8) == 0) {
    const std::size_t length = 1 + pick(std::min<std::size_t>(64, size - at));
    if (pick(2) == 0) {
      std::memmove(bytes.data() + at, bytes.data() + at + length, size - at - length);
      return size - length;
    }
    if (size + length <= bytes.size()) {
      std::memmove(bytes.data() + at + length, bytes.data() + at, size - at);
      return size + length;
    }
  }
  return size;
}

constexpr std::array<Harness, 9> kFormatHarnesses = {{
    {"vdb", readVdbFile, Refusal::Data, mutateVdb},
    {"vdb_target", openVdbTarget, Refusal::Data, mutateVdb},
    {"vdb_head", readVdbHead, Refusal::Data, mutateVdb},
    {"nvdb", readNvdbFile, Refusal::Data, mutateVdb},
    {"rational", readJson},
    {"waves", readWaves},
    {"p4d", readP4d},
    {"o3d", readO3d},
    {"picture", readAnyPicture},
}};

}  // namespace

std::span<const Harness> formatHarnesses() { return kFormatHarnesses; }

}  // namespace fuzz
