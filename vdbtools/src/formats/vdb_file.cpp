// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/formats/vdb_file.h"

#include "base/lattice_transform.h"
#include "formats/grid_formats.h"
#include "formats/recorded_memory.h"
#include "formats/turn_matrix.h"
#include "formats/vdb_check.h"
#include "formats/vdb_cursor.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/files/named_file.h"

#include <openvdb/io/Archive.h>
#include <openvdb/io/GridDescriptor.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <memory>
#include <set>
#include <sstream>
#include <type_traits>
#include <utility>

namespace vdbtools {
namespace {

// Offsets in io::Archive's header: after the magic number (8 bytes) come the version of the format (4), the library's
// major and minor version (4 each), the flag for grid offsets (1), and an identifier of 36 characters.
constexpr std::size_t kFormatOffset = 8, kMajorOffset = 12, kMinorOffset = 16;
constexpr std::size_t kIdentifierOffset = 21;
constexpr std::size_t kIdentifierLength = 36;

std::uint32_t headNumber(std::string_view bytes, std::size_t offset) {
  std::uint32_t number;
  std::memcpy(&number, bytes.data() + offset, sizeof(number));
  return number;
}

void setHeadNumber(std::string& bytes, std::size_t offset, std::uint32_t number) {
  std::memcpy(bytes.data() + offset, &number, sizeof(number));
}

// Format 225 of OpenVDB 13 adds grids of 16-bit floats, of which nothing is written here, to 224 of OpenVDB 10. So what
// is written is of format 224, with any library: the bytes are the same, and older programs read them.
constexpr std::uint32_t kWrittenFormat = 224, kWrittenMajor = 10, kWrittenMinor = 0, kSameButForTypes = 225;

void writeAsOldestFormat(std::string& bytes) {
  const std::uint32_t format = headNumber(bytes, kFormatOffset);
  if (format != kWrittenFormat && format != kSameButForTypes) return;
  setHeadNumber(bytes, kFormatOffset, kWrittenFormat);
  setHeadNumber(bytes, kMajorOffset, kWrittenMajor);
  setHeadNumber(bytes, kMinorOffset, kWrittenMinor);
}

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

/// The "creator" of the file. Blender's import of VDB files rotates only those whose creator begins with "Houdini",
/// because Houdini has Y up.
std::string creatorText(const std::optional<UpAxis>& up) {
  constexpr const char* kProgram = "JuliaVDB " JULIAVDB_VERSION;
  return up == UpAxis::Y ? std::string("Houdini axes (Y up), written by ") + kProgram : kProgram;
}

constexpr double kLargestInHalf = 65504;

/// Sets a finite number beyond the range of half floats to its end. @return whether it was
template <class Real>
requires std::is_floating_point_v<Real>
bool clampToHalf(Real& value) {
  if (!(std::abs(value) > Real(kLargestInHalf)) || !std::isfinite(value)) return false;
  value = std::copysign(Real(kLargestInHalf), value);
  return true;
}

template <class Real>
bool clampToHalf(openvdb::math::Vec3<Real>& vector) {
  bool any = false;
  for (int axis = 0; axis < 3; ++axis) any |= clampToHalf(vector[axis]);
  return any;
}

/// Whether clampToHalf() would change the value.
template <class Value>
bool overflowsHalf(Value value) {
  return clampToHalf(value);
}

template <class Tree>
bool hasHalfOverflow(const Tree& tree) {
  using Leaf = typename Tree::LeafNodeType;
  if (overflowsHalf(tree.background())) return true;
  for (auto leaf = tree.cbeginLeaf(); leaf; ++leaf)
    if (std::any_of(leaf->buffer().data(), leaf->buffer().data() + Leaf::SIZE,
                    [](const auto& value) { return overflowsHalf(value); }))
      return true;
  auto tile = tree.cbeginValueAll();
  for (tile.setMaxDepth(Tree::DEPTH - 2); tile; ++tile)
    if (overflowsHalf(*tile)) return true;
  return false;
}

/// Replaces the grid by a copy without values that are too large for half floats, if it is of this type and has some.
/// @return how many active values were too large
template <class Grid>
std::uint64_t clampGridToHalf(openvdb::GridBase::Ptr& grid) {
  const auto typed = openvdb::gridPtrCast<Grid>(grid);
  if (!typed || !hasHalfOverflow(typed->tree())) return 0;
  const typename Grid::Ptr copy = typed->deepCopy();
  std::uint64_t active = 0;
  for (auto value = copy->beginValueAll(); value; ++value) {
    typename Grid::ValueType clamped = *value;
    if (!clampToHalf(clamped)) continue;
    value.setValue(clamped);
    if (value.isValueOn()) active += value.getVoxelCount();
  }
  typename Grid::ValueType background = copy->background();
  clampToHalf(background);
  copy->tree().root().setBackground(background, /*updateChildNodes=*/false);
  grid = copy;
  return active;
}

/// Prepares a grid for half floats.
void limitToHalf(openvdb::GridBase::Ptr& grid, std::vector<ClampedGrid>* report) {
  const std::uint64_t values = clampGridToHalf<openvdb::FloatGrid>(grid) + clampGridToHalf<openvdb::DoubleGrid>(grid) +
                               clampGridToHalf<openvdb::Vec3SGrid>(grid) + clampGridToHalf<openvdb::Vec3DGrid>(grid);
  if (report && values > 0) report->push_back({grid->getName(), values});
}

std::uint32_t writtenCompression() {
  return openvdb::io::COMPRESS_ACTIVE_MASK |
         (openvdb::io::Archive::hasBloscCompression() ? openvdb::io::COMPRESS_BLOSC : 0);
}

/// The grid for the file, which shares the tree, with the statistics that OpenVDB would add itself.
openvdb::GridBase::Ptr filed(const openvdb::GridBase& grid, const VdbWriteOptions& options) {
  openvdb::GridBase::Ptr copy = std::const_pointer_cast<openvdb::GridBase>(grid.copyGrid());
  for (const auto& [key, value] : options.metadata) copy->insertMeta(key, openvdb::StringMetadata(value));
  turnGrid(*copy, options.turn);
  copy->setSaveFloatAsHalf(options.half);
  copy->setCreator(creatorText(options.up));
  copy->addStatsMetadata();
  copy->insertMeta(openvdb::GridBase::META_FILE_MEM_BYTES,
                   openvdb::Int64Metadata(static_cast<std::int64_t>(recordedMemoryOf(*copy))));
  copy->insertMeta(openvdb::GridBase::META_FILE_COMPRESSION,
                   openvdb::StringMetadata(openvdb::io::compressionToString(writtenCompression())));
  return copy;
}

/// Writes a file with offsets to its grids, like io::File, so that readers may load them one by one, but to a stream,
/// for which io::Stream writes no offsets.
class SeekableArchive final : public openvdb::io::Archive {
 public:
  void writeTo(std::ostream& stream, const openvdb::GridCPtrVec& grids, const openvdb::MetaMap& metadata) const {
    write(stream, grids, /*seekable=*/true, metadata);
  }
};

/// A read-only buffer over existing bytes.
class MemoryBuffer final : public std::streambuf {
 public:
  explicit MemoryBuffer(std::string& bytes) { setg(bytes.data(), bytes.data(), bytes.data() + bytes.size()); }

 private:
  pos_type seekoff(off_type offset, std::ios::seekdir from, std::ios::openmode) override {
    const off_type base = from == std::ios::beg ? 0 : from == std::ios::cur ? gptr() - eback() : egptr() - eback();
    const off_type to = base + offset;
    if (to < 0 || to > egptr() - eback()) return off_type(-1);
    setg(eback(), eback() + to, egptr());
    return to;
  }
  pos_type seekpos(pos_type position, std::ios::openmode mode) override {
    return seekoff(position, std::ios::beg, mode);
  }
};

/// Reads what checkVdb() has accepted. OpenVDB's own readers of files cannot skip grids of unknown types, nor the
/// values of points.
class CheckedArchive final : public openvdb::io::Archive {
 public:
  CheckedArchive(std::string& bytes, const VdbContents& contents) : mBuffer(bytes), mContents(contents) {
    // The stream throws at the end of the bytes, which OpenVDB would not notice.
    mStream.exceptions(std::ios::failbit | std::ios::badbit | std::ios::eofbit);
    readHeader(mStream);
    requireAt(contents.metadataBegin);
    openvdb::io::setStreamMetadataPtr(mStream, mTags, /*transfer=*/false);
    openvdb::io::setVersion(mStream, libraryVersion(), fileVersion());
    openvdb::io::setDataCompression(mStream, compression());
  }

  std::map<std::string, std::string> metadata() {
    mStream.seekg(static_cast<std::streamoff>(mContents.metadataBegin));
    openvdb::MetaMap metadata;
    metadata.readMeta(mStream);
    requireAt(mContents.metadataEnd);
    return asText(metadata);
  }

  openvdb::GridPtrVec grids() {
    openvdb::GridPtrVec grids;
    NamedGridMap named;
    for (const VdbGridEntry& entry : mContents.grids)
      if (entry.content != VdbContent::Nothing) {
        grids.push_back(grid(entry));
        named[entry.name] = grids.back();
      }
    for (const VdbGridEntry& entry : mContents.grids)
      if (entry.content == VdbContent::Instance) connectInstance(descriptorOf(entry), named);
    return grids;
  }

 private:
  static openvdb::io::GridDescriptor descriptorOf(const VdbGridEntry& entry) {
    openvdb::io::GridDescriptor descriptor(entry.name, entry.type, entry.half);
    descriptor.setInstanceParentName(entry.parent);
    return descriptor;
  }

  openvdb::GridBase::Ptr grid(const VdbGridEntry& entry) {
    openvdb::GridBase::Ptr grid = openvdb::GridBase::createGrid(entry.type);
    grid->setSaveFloatAsHalf(entry.half);
    mStream.seekg(static_cast<std::streamoff>(entry.begin));
    if (entry.content == VdbContent::Places)
      readPlaces(*grid);
    else
      readGrid(grid, descriptorOf(entry), mStream);
    requireAt(entry.end);
    // Names are used in single-line messages.
    if (const std::string name = grid->getName(), line = inOneLine(name); line != name) grid->setName(line);
    return grid;
  }

  /// Like readGrid(), without the values of the leaves.
  void readPlaces(openvdb::GridBase& grid) {
    readGridCompression(mStream);
    openvdb::io::setGridClass(mStream, openvdb::GRID_UNKNOWN);
    openvdb::io::setGridBackgroundValuePtr(mStream, nullptr);
    grid.readMeta(mStream);
    grid.removeMeta(openvdb::GridBase::META_FILE_DELAYED_LOAD);
    grid.readTransform(mStream);
    grid.readTopology(mStream);
  }

  /// Checks that OpenVDB has read exactly what was checked.
  void requireAt(std::size_t position) {
    if (mStream.tellg() != static_cast<std::streamoff>(position))
      throw std::logic_error("OpenVDB has read other bytes of a VDB than were checked");
  }

  MemoryBuffer mBuffer;
  std::istream mStream{&mBuffer};
  const VdbContents& mContents;
  openvdb::io::StreamMetadata::Ptr mTags = std::make_shared<openvdb::io::StreamMetadata>();
};

/// Runs @a use, which reads a VDB, and converts its failures to exceptions of this library.
template <class Use>
auto readingVdb(const Use& use) {
  openvdb::initialize();
  try {
    return use();
  } catch (const std::ios_base::failure&) {
    throw DataError("it is truncated");
  } catch (const openvdb::Exception& error) {
    throw DataError(inOneLine(error.what()));
  }
}

/// As above for a file, whose name begins the messages.
template <class Use>
auto readingVdb(const std::filesystem::path& path, const Use& use) {
  try {
    return readingVdb(use);
  } catch (const DataError& error) {
    throw DataError("'" + inOneLine(path.string()) + "' cannot be read as a VDB: " + error.what());
  }
}

/// Reads as many bytes at the beginning of a file as @a use needs: it throws VdbEnds if there are too few.
template <class Use>
auto withBeginning(const std::filesystem::path& path, const Use& use) {
  std::ifstream file = openToRead(path);
  std::string bytes;
  for (std::size_t wanted = std::size_t{1} << 16;; wanted *= 4) {
    const std::size_t had = bytes.size();
    bytes.resize(wanted);
    file.read(bytes.data() + had, static_cast<std::streamsize>(wanted - had));
    if (file.bad()) throw IoError("reading '" + inOneLine(path.string()) + "' broke off");
    bytes.resize(had + static_cast<std::size_t>(file.gcount()));
    try {
      return use(bytes);
    } catch (const VdbEnds&) {
      if (bytes.size() < wanted) throw;
    }
  }
}

}  // namespace

std::vector<std::string> textsOf(const std::vector<ClampedGrid>& grids) {
  std::vector<std::string> texts;
  for (const ClampedGrid& grid : grids)
    texts.push_back(std::to_string(grid.values) + (grid.values == 1 ? " value" : " values") + " of the grid " +
                    inOneLine(grid.name) + (grid.values == 1 ? " is" : " are") +
                    " beyond what 16 bits hold, and stored as 65504 or -65504; 32 bits hold them");
  return texts;
}

void requireVdbVoxel(double voxelSize, std::string_view wayOut) {
  if (isOrdinaryScale(openvdb::Vec3d(voxelSize))) return;
  std::ostringstream text;
  text << "a VDB cannot hold voxels of " << voxelSize << ", as OpenVDB makes no transform for voxels below 1.45e-05; "
       << (wayOut.empty() ? "write a mesh instead, choose a --voxel-size of 1.45e-05 or more or a lower --resolution"
                          : wayOut)
       << ", or give the shape in smaller units, such as millimetres";
  throw std::invalid_argument(text.str());
}

std::vector<openvdb::GridBase::Ptr> renamed(const std::vector<openvdb::GridBase::Ptr>& grids,
                                            const std::map<std::string, std::string>& names) {
  std::vector<openvdb::GridBase::Ptr> result = grids;
  for (openvdb::GridBase::Ptr& grid : result)
    if (const auto found = names.find(grid->getName()); found != names.end()) {
      grid = std::const_pointer_cast<openvdb::GridBase>(std::as_const(*grid).copyGrid());
      grid->setName(found->second);
    }
  return result;
}

std::string encodeVdb(const std::vector<openvdb::GridBase::Ptr>& given, const VdbWriteOptions& options) {
  std::vector<openvdb::GridBase::Ptr> grids = renamed(given, options.names);
  requireDistinctNames(grids);
  if (options.half)
    for (openvdb::GridBase::Ptr& grid : grids) limitToHalf(grid, options.clamped);
  openvdb::MetaMap metadata;
  for (const auto& [key, value] : options.metadata) metadata.insertMeta(key, openvdb::StringMetadata(value));
  if (options.up)
    metadata.insertMeta(openvdb::GridBase::META_GRID_CREATOR, openvdb::StringMetadata(creatorText(options.up)));
  openvdb::GridCPtrVec out;
  for (const auto& grid : grids) out.push_back(filed(*grid, options));
  std::ostringstream stream(std::ios::binary);
  SeekableArchive archive;
  archive.setCompression(writtenCompression());
  archive.setGridStatsMetadataEnabled(false);  // they are in the grids
  archive.writeTo(stream, out, metadata);
  std::string bytes = std::move(stream).str();
  if (!looksLikeIdentifier(std::string_view(bytes).substr(kIdentifierOffset, kIdentifierLength)))
    throw std::logic_error("the VDB header holds no identifier where it was expected");
  writeAsOldestFormat(bytes);
  bytes.replace(kIdentifierOffset, kIdentifierLength, kIdentifierLength, '0');
  bytes.replace(kIdentifierOffset, kIdentifierLength, identifierOf(bytes));
  return bytes;
}

VdbFile decodeVdb(std::string bytes) {
  return readingVdb([&] {
    const VdbContents contents = checkVdb(bytes);
    // OpenVDB 10 to 12 warn of a format that is newer than theirs, on stderr. Grids of types that they do not know are
    // passed over in any case.
    if (headNumber(bytes, kFormatOffset) > openvdb::OPENVDB_FILE_VERSION)
      setHeadNumber(bytes, kFormatOffset, openvdb::OPENVDB_FILE_VERSION);
    CheckedArchive archive(bytes, contents);
    VdbFile file;
    file.metadata = archive.metadata();
    file.grids = archive.grids();
    std::string list;
    for (const VdbGridEntry& entry : contents.grids)
      if (entry.content == VdbContent::Nothing) {
        file.unread.push_back({openvdb::io::GridDescriptor::nameAsString(entry.name), entry.type});
        list += (list.empty() ? "" : ", ") + ("'" + file.unread.back().name + "' (" + entry.type + ")");
      }
    if (file.grids.empty())
      throw DataError(list.empty() ? "it holds no grid"
                                   : "it holds only grids of types that are not known: " + inOneLine(list));
    return file;
  });
}

VdbFile readVdb(const std::filesystem::path& path) {
  std::string bytes = readWholeFile(path);
  return readingVdb(path, [&] { return decodeVdb(std::move(bytes)); });
}

std::map<std::string, std::string> readVdbMetadata(const std::filesystem::path& path) {
  return readingVdb(path, [&] {
    return withBeginning(path, [](std::string& bytes) {
      const VdbContents contents = checkVdbHead(bytes);
      return CheckedArchive(bytes, contents).metadata();
    });
  });
}

std::vector<std::string> distanceGrids(const std::map<std::string, std::string>& metadata) {
  std::vector<std::string> names;
  if (const auto recorded = metadata.find(kDistanceGrid); recorded != metadata.end()) names.push_back(recorded->second);
  names.insert(names.end(), {"surface", "phi"});
  return names;
}

std::vector<std::string> gridLabels(const VdbFile& file) {
  std::map<std::string, std::size_t> count, seen;
  for (const auto& grid : file.grids) ++count[grid->getName()];
  std::vector<std::string> labels;
  for (const auto& grid : file.grids) {
    const std::string name = grid->getName();
    labels.push_back(count[name] == 1 ? name : name + "[" + std::to_string(seen[name]++) + "]");
  }
  return labels;
}

namespace {

/// @tparam Grid  the type of the grids that are chosen from
template <class Grid>
std::vector<typename Grid::Ptr> gridsNamed(const VdbFile& file, const std::string& name) {
  const std::vector<std::string> labels = gridLabels(file);
  std::vector<typename Grid::Ptr> found;
  for (std::size_t i = 0; i < labels.size(); ++i)
    if (const auto grid = openvdb::gridPtrCast<Grid>(file.grids[i]))
      if (name.empty() || labels[i] == name || grid->getName() == name) found.push_back(grid);
  return found;
}

}  // namespace

openvdb::FloatGrid::Ptr chooseFloatGrid(const VdbFile& file, const std::string& name,
                                        const std::filesystem::path& path) {
  const std::vector<std::string> labels = gridLabels(file);
  std::vector<openvdb::FloatGrid::Ptr> candidates = gridsNamed<openvdb::FloatGrid>(file, name);
  if (candidates.empty())
    if (const auto doubles = gridsNamed<openvdb::DoubleGrid>(file, name); doubles.size() == 1)
      return std::make_shared<openvdb::FloatGrid>(*doubles.front());
  std::string list;
  for (std::size_t i = 0; i < labels.size(); ++i)
    list += (list.empty() ? "" : ", ") + ("'" + labels[i] + "' (" + file.grids[i]->valueType() + ")");
  if (candidates.size() > 1 && name.empty())
    for (const std::string& preferred : distanceGrids(file.metadata))
      for (const auto& candidate : candidates)
        if (candidate->getName() == preferred) return candidate;
  if (candidates.size() != 1)
    throw DataError("'" + path.string() + "' has " +
                    (candidates.empty() ? "no float grid" : "more than one float grid") +
                    (name.empty() ? "" : " called '" + name + "'") + "; name one of its grids: " + inOneLine(list));
  return candidates.front();
}

std::vector<NvdbWritten> writeVdbGrids(std::ostream& stream, const std::vector<openvdb::GridBase::Ptr>& grids,
                                       const VdbWriteOptions& options, NvdbValues) {
  stream << encodeVdb(grids, options);
  return {};
}

}  // namespace vdbtools
