// SPDX-License-Identifier: Apache-2.0
#include "farm/tile_islands.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/files/file_bytes.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <fstream>
#include <string>
#include <string_view>
#include <utility>

namespace vdbtools::farm {
namespace {

using openvdb::Coord;

static_assert(std::endian::native == std::endian::little, "islands are written as numbers lie in memory");
static_assert(sizeof(InsideRun) == 20);

constexpr std::string_view kIslandsMagic = "JVDBISLE";
constexpr std::uint32_t kIslandsVersion = 1;

struct IslandsHeader {
  char magic[8];
  std::uint32_t version, none;
  std::uint64_t parts, faces, beyond, own;
};
static_assert(sizeof(IslandsHeader) == 48);

struct PartRecord {
  std::uint64_t nodes, points, capPoints;
  std::int32_t low[3], high[3], first[3];
  std::uint32_t none;
};
static_assert(sizeof(PartRecord) == 64);

template <class Value>
void putAll(std::ostream& stream, const std::vector<Value>& values) {
  stream.write(reinterpret_cast<const char*>(values.data()),
               static_cast<std::streamsize>(values.size() * sizeof(Value)));
}

PartRecord recordOf(const TilePart& part) {
  PartRecord record{.nodes = part.island.nodes, .points = part.points, .capPoints = part.capPoints};
  for (int axis = 0; axis < 3; ++axis) {
    record.low[axis] = part.island.box.min()[axis];
    record.high[axis] = part.island.box.max()[axis];
    record.first[axis] = part.island.first[axis];
  }
  return record;
}

TilePart partOfRecord(const PartRecord& record) {
  return {
      .island = {.nodes = record.nodes, .box = {Coord(record.low), Coord(record.high)}, .first = Coord(record.first)},
      .points = record.points,
      .capPoints = record.capPoints};
}

[[noreturn]] void refuseIslands(const std::filesystem::path& path, const char* why) {
  throw DataError("the islands '" + inOneLine(path.string()) + "' cannot be used: " + why);
}

void read(std::ifstream& stream, const std::filesystem::path& path, void* to, std::size_t bytes) {
  stream.read(static_cast<char*>(to), static_cast<std::streamsize>(bytes));
  if (!stream) throw IoError("reading '" + inOneLine(path.string()) + "' broke off");
}

void requireParts(std::span<const InsideRun> runs, std::size_t parts, const std::filesystem::path& path) {
  if (std::any_of(runs.begin(), runs.end(), [&](const InsideRun& run) { return run.part >= parts; }))
    refuseIslands(path, "a run belongs to a part that is not there");
}

}  // namespace

void TileIslands::write(std::ostream& stream) const {
  std::vector<InsideRun> faces, beyond, own;
  for (const InsideRun& run : mRuns) {
    const std::optional<InsideRun> mine = ownPart(run);
    if (!mine || mine->last < run.last) {
      InsideRun rest = run;
      if (mine) rest.first = mine->last + 1;
      beyond.push_back(rest);
    }
    if (!mine) continue;
    own.push_back(*mine);
    InsideRun face = *mine;
    if (run.x > mBox.min()[0] && run.y > mBox.min()[1]) face.last = mBox.min()[2];
    if (face.first <= face.last) faces.push_back(face);
  }
  IslandsHeader header{.magic = {},
                       .version = kIslandsVersion,
                       .none = 0,
                       .parts = mParts.size(),
                       .faces = faces.size(),
                       .beyond = beyond.size(),
                       .own = own.size()};
  std::memcpy(header.magic, kIslandsMagic.data(), kIslandsMagic.size());
  stream.write(reinterpret_cast<const char*>(&header), sizeof header);
  std::vector<PartRecord> partRecords;
  partRecords.reserve(mParts.size());
  for (const TilePart& part : mParts) partRecords.push_back(recordOf(part));
  putAll(stream, partRecords);
  putAll(stream, faces);
  putAll(stream, beyond);
  putAll(stream, own);
}

TileIslandsReader::TileIslandsReader(std::filesystem::path path) : mPath(std::move(path)) {
  std::ifstream stream = openToRead(mPath);
  std::error_code error;
  std::uint64_t left = std::filesystem::file_size(mPath, error);
  if (error) throw MissingInputError("cannot open the islands '" + inOneLine(mPath.string()) + "'");
  IslandsHeader header{};
  if (left < sizeof header) refuseIslands(mPath, "it is truncated");
  read(stream, mPath, &header, sizeof header);
  left -= sizeof header;
  if (std::string_view(header.magic, kIslandsMagic.size()) != kIslandsMagic || header.version != kIslandsVersion)
    refuseIslands(mPath, "it is not a file of islands of this version");
  // Counts are compared with the rest of the file before memory is allocated for them.
  const auto take = [&](auto& values, std::uint64_t count) {
    using Value = typename std::remove_reference_t<decltype(values)>::value_type;
    if (count > left / sizeof(Value)) refuseIslands(mPath, "it is truncated");
    values.resize(count);
    read(stream, mPath, values.data(), count * sizeof(Value));
    left -= count * sizeof(Value);
  };
  std::vector<PartRecord> partRecords;
  take(partRecords, header.parts);
  take(mFaces, header.faces);
  take(mBeyond, header.beyond);
  for (const PartRecord& record : partRecords) mParts.push_back(partOfRecord(record));
  requireParts(mFaces, mParts.size(), mPath);
  requireParts(mBeyond, mParts.size(), mPath);
  if (header.own != left / sizeof(InsideRun) || left % sizeof(InsideRun) != 0) refuseIslands(mPath, "it is truncated");
  mOwn = header.own;
  mOwnAt = stream.tellg();
}

void TileIslandsReader::forEachOwn(const std::function<void(std::span<const InsideRun>)>& body) const {
  constexpr std::uint64_t kPiece = 1 << 16;
  std::ifstream stream = openToRead(mPath);
  if (!stream.seekg(mOwnAt)) throw MissingInputError("cannot open the islands '" + inOneLine(mPath.string()) + "'");
  std::vector<InsideRun> piece;
  for (std::uint64_t done = 0; done < mOwn; done += piece.size()) {
    piece.resize(std::min(kPiece, mOwn - done));
    read(stream, mPath, piece.data(), piece.size() * sizeof(InsideRun));
    requireParts(piece, mParts.size(), mPath);
    body(piece);
  }
}

}  // namespace vdbtools::farm
