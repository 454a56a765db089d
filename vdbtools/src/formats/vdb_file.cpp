// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/formats/vdb_file.h"

#include "vdbtools/files/file_bytes.h"
#include "vdbtools/files/file_hash.h"

#include <openvdb/io/Archive.h>
#include <openvdb/io/Stream.h>

#include <fstream>
#include <set>
#include <sstream>

namespace vdbtools {
namespace {

// Where io::Archive's header holds the identifier: after the magic number (8 bytes), the file version (4), the
// library's major and minor version (4 each) and the flag for grid offsets (1); 36 characters.
constexpr std::size_t kIdentifierOffset = 21;
constexpr std::size_t kIdentifierLength = 36;

/// "xxxxxxxx-xxxx-xxxx-xxxx-xxxxxxxxxxxx" from the content's hash.
std::string identifierOf(std::string_view bytes) {
  std::string identifier = sha256Hex(bytes).substr(0, kIdentifierLength);
  for (const std::size_t dash : {8u, 13u, 18u, 23u}) identifier[dash] = '-';
  return identifier;
}

bool looksLikeIdentifier(std::string_view text) {
  return text.size() == kIdentifierLength && text[8] == '-' && text[13] == '-' && text[18] == '-' && text[23] == '-';
}

void requireDistinctNames(const std::vector<openvdb::GridBase::Ptr>& grids) {
  std::set<std::string> names;
  for (const auto& grid : grids)
    if (!names.insert(grid->getName()).second)
      throw std::invalid_argument("two grids are called '" + grid->getName() + "'; ask for each once");
}

std::map<std::string, std::string> asText(const openvdb::MetaMap& metadata) {
  std::map<std::string, std::string> result;
  for (auto entry = metadata.beginMeta(); entry != metadata.endMeta(); ++entry)
    if (entry->second) result[entry->first] = entry->second->str();
  return result;
}

/// Checks that the file exists and is a VDB, with our own messages.
void requireVdb(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::error_code ignored;
  if (!file || std::filesystem::is_directory(path, ignored))
    throw MissingInputError("cannot open '" + inOneLine(path.string()) + "': " +
                            (std::filesystem::exists(path, ignored) ? "it is not a readable file" : "no such file"));
  char magic[8] = {};
  file.read(magic, sizeof magic);
  if (file.bad()) throw IoError("reading '" + inOneLine(path.string()) + "' broke off");
  constexpr std::string_view kMagic(" BDV\0\0\0\0", 8);
  if (std::string_view(magic, static_cast<std::size_t>(file.gcount())) != kMagic)
    throw DataError("'" + inOneLine(path.string()) + "' is not a VDB file: it does not begin as one does");
}

/// What made the file. Blender's import of VDB files turns those upright, and only those, whose creator begins with
/// "Houdini", because Houdini has Y up.
std::string creatorText(const std::optional<UpAxis>& up) {
  constexpr const char* kProgram = "JuliaVDB " JULIAVDB_VERSION;
  return up == UpAxis::Y ? std::string("Houdini axes (Y up), written by ") + kProgram : kProgram;
}

/// The quarter turn as a matrix by which OpenVDB multiplies row vectors: its rows are where the axes go.
openvdb::Mat4d matrixOf(const UpTurn& turn) {
  openvdb::Mat4d matrix = openvdb::Mat4d::identity();
  for (int axis = 0; axis < 3; ++axis) {
    openvdb::Vec3d unit(0);
    unit[axis] = 1;
    const openvdb::Vec3d to = turn(unit);
    for (int k = 0; k < 3; ++k) matrix(axis, k) = to[k];
  }
  return matrix;
}

/// The grid as it goes into the file, which shares the tree.
openvdb::GridBase::Ptr filed(const openvdb::GridBase& grid, const VdbWriteOptions& options) {
  openvdb::GridBase::Ptr copy = std::const_pointer_cast<openvdb::GridBase>(grid.copyGrid());
  for (const auto& [key, value] : options.metadata) copy->insertMeta(key, openvdb::StringMetadata(value));
  if (options.turn.turns()) copy->transform().postMult(matrixOf(options.turn));
  copy->setSaveFloatAsHalf(options.half);
  copy->setCreator(creatorText(options.up));
  return copy;
}

/// A file with offsets to its grids, as io::File writes it, so that readers may load them one by one; but to a stream,
/// which io::Stream writes without offsets.
class SeekableArchive final : public openvdb::io::Archive {
 public:
  void writeTo(std::ostream& stream, const openvdb::GridCPtrVec& grids, const openvdb::MetaMap& metadata) const {
    write(stream, grids, /*seekable=*/true, metadata);
  }
};

/// Reads the head of a file and nothing after it.
class HeadArchive final : public openvdb::io::Archive {
 public:
  std::map<std::string, std::string> readMetadata(std::istream& stream) {
    readHeader(stream);
    openvdb::MetaMap metadata;
    metadata.readMeta(stream);
    return asText(metadata);
  }
};

/// Runs @a use with a stream of the file and turns its failures into our errors. On a truncated file, io::File would go
/// on with sizes that the file does not hold and allocate gigabytes; a stream that throws at its end cannot.
template <class Use>
auto withVdb(const std::filesystem::path& path, const Use& use) {
  openvdb::initialize();
  requireVdb(path);
  const std::string name = "'" + inOneLine(path.string()) + "' cannot be read as a VDB: ";
  std::ifstream stream(path, std::ios::binary);
  try {
    stream.exceptions(std::ios::failbit | std::ios::badbit | std::ios::eofbit);
    return use(stream);
  } catch (const std::ios_base::failure&) {
    throw DataError(name + "it is truncated");
  } catch (const openvdb::Exception& error) {
    throw DataError(name + inOneLine(error.what()));
  } catch (const std::bad_alloc&) {
    throw DataError(name + "a size in it exceeds the memory");
  } catch (const std::length_error&) {
    throw DataError(name + "a size in it is impossible");
  }
}

}  // namespace

std::string encodeVdb(const std::vector<openvdb::GridBase::Ptr>& grids, const VdbWriteOptions& options) {
  requireDistinctNames(grids);
  openvdb::MetaMap metadata;
  for (const auto& [key, value] : options.metadata) metadata.insertMeta(key, openvdb::StringMetadata(value));
  if (options.up)
    metadata.insertMeta(openvdb::GridBase::META_GRID_CREATOR, openvdb::StringMetadata(creatorText(options.up)));
  openvdb::GridCPtrVec out;
  for (const auto& grid : grids) out.push_back(filed(*grid, options));
  std::ostringstream stream(std::ios::binary);
  SeekableArchive archive;
  std::uint32_t compression = openvdb::io::COMPRESS_ACTIVE_MASK;
  if (openvdb::io::Archive::hasBloscCompression()) compression |= openvdb::io::COMPRESS_BLOSC;
  archive.setCompression(compression);
  archive.writeTo(stream, out, metadata);
  std::string bytes = std::move(stream).str();
  if (!looksLikeIdentifier(std::string_view(bytes).substr(kIdentifierOffset, kIdentifierLength)))
    throw std::logic_error("the VDB header holds no identifier where it was expected");
  bytes.replace(kIdentifierOffset, kIdentifierLength, kIdentifierLength, '0');
  bytes.replace(kIdentifierOffset, kIdentifierLength, identifierOf(bytes));
  return bytes;
}

VdbFile readVdb(const std::filesystem::path& path) {
  VdbFile result = withVdb(path, [](std::istream& stream) {
    openvdb::io::Stream archive(stream, /*delayLoad=*/false);
    return VdbFile{*archive.getGrids(), asText(*archive.getMetadata())};
  });
  if (result.grids.empty()) throw DataError("'" + path.string() + "' holds no grid");
  return result;
}

std::map<std::string, std::string> readVdbMetadata(const std::filesystem::path& path) {
  return withVdb(path, [](std::istream& stream) { return HeadArchive().readMetadata(stream); });
}

openvdb::FloatGrid::Ptr chooseFloatGrid(const VdbFile& file, const std::string& name,
                                        const std::filesystem::path& path) {
  std::vector<openvdb::FloatGrid::Ptr> candidates;
  std::string list;
  for (const auto& grid : file.grids) {
    list += (list.empty() ? "" : ", ") + ("'" + grid->getName() + "' (" + grid->valueType() + ")");
    const auto floats = openvdb::gridPtrCast<openvdb::FloatGrid>(grid);
    if (floats && (name.empty() || grid->getName() == name)) candidates.push_back(floats);
  }
  if (candidates.size() > 1 && name.empty())
    for (const char* preferred : {"surface", "phi"})
      for (const auto& candidate : candidates)
        if (candidate->getName() == preferred) return candidate;
  if (candidates.size() != 1)
    throw DataError("'" + path.string() + "' has " +
                    (candidates.empty() ? "no float grid" : "more than one float grid") +
                    (name.empty() ? "" : " called '" + name + "'") + "; name one of its grids: " + inOneLine(list));
  return candidates.front();
}

bool isVdbPath(const std::filesystem::path& path) { return lowerExtension(path) == ".vdb"; }

}  // namespace vdbtools
