// SPDX-License-Identifier: Apache-2.0
#include "formats/vdb_check.h"

#include "formats/vdb_head.h"
#include "formats/vdb_transform.h"
#include "formats/vdb_tree.h"
#include "vdbtools/base/memory.h"
#include "vdbtools/files/file_bytes.h"

#include <openvdb/io/GridDescriptor.h>

#include <algorithm>
#include <iterator>
#include <optional>

namespace vdbtools {
namespace {

struct GridType {
  std::string_view name;
  VdbValueType value;
  VdbLeaf leaf;
};

constexpr GridType kGridTypes[] = {
    {"Tree_float_5_4_3", {4, 2}, VdbLeaf::Values},    {"Tree_double_5_4_3", {8, 2}, VdbLeaf::Values},
    {"Tree_int32_5_4_3", {4, 4}, VdbLeaf::Values},    {"Tree_int64_5_4_3", {8, 8}, VdbLeaf::Values},
    {"Tree_vec3s_5_4_3", {12, 6}, VdbLeaf::Values},   {"Tree_vec3d_5_4_3", {24, 6}, VdbLeaf::Values},
    {"Tree_vec3i_5_4_3", {12, 12}, VdbLeaf::Values},  {"Tree_bool_5_4_3", {1, 1, true}, VdbLeaf::Bits},
    {"Tree_mask_5_4_3", {1, 1, true}, VdbLeaf::Mask}, {"Tree_ptdataidx32_5_4_3", {4, 4}, VdbLeaf::Points},
};

const GridType* typeNamed(std::string_view name) {
  const auto found = std::find_if(std::begin(kGridTypes), std::end(kGridTypes),
                                  [&](const GridType& type) { return type.name == name; });
  return found == std::end(kGridTypes) ? nullptr : found;
}

/// The size of a metadata value, which OpenVDB reads whatever size the file states; 0 for a text.
std::optional<std::size_t> metadataSize(std::string_view type) {
  constexpr std::pair<std::string_view, std::size_t> kSizes[] = {
      {"string", 0}, {"bool", 1},   {"int32", 4},  {"float", 4},  {"int64", 8},  {"double", 8},
      {"vec2i", 8},  {"vec2s", 8},  {"vec2d", 16}, {"vec3i", 12}, {"vec3s", 12}, {"vec3d", 24},
      {"vec4i", 16}, {"vec4s", 16}, {"vec4d", 32}, {"mat4s", 64}, {"mat4d", 128}};
  for (const auto& [name, size] : kSizes)
    if (name == type) return size;
  return std::nullopt;
}

class FileWalk {
 public:
  explicit FileWalk(std::string& bytes) : mBytes(bytes), mCursor(bytes) {}

  VdbContents head() {
    VdbContents contents;
    mHead = readVdbHead(mCursor);
    contents.metadataBegin = mCursor.position();
    mCursor.enter("its metadata");
    metadata();
    contents.metadataEnd = mCursor.position();
    return contents;
  }

  VdbContents whole() {
    VdbContents contents = head();
    mCursor.enter("its list of grids");
    const auto count = mCursor.number<std::int32_t>();
    if (count < 0) mCursor.refuse("says that there are " + std::to_string(count));
    for (std::int32_t i = 0; i < count; ++i) {
      contents.grids.push_back(grid());
      mCursor.enter("its list of grids");
    }
    return contents;
  }

 private:
  /// @return whether values are declared to be stored with half precision
  bool metadata() {
    bool half = false;
    const auto count = mCursor.number<std::uint32_t>();
    for (std::uint32_t i = 0; i < count; ++i) {
      const VdbMetaEntry entry = readVdbMetaEntry(mCursor);
      const std::optional<std::size_t> size = metadataSize(entry.type);
      if (entry.name.empty()) mCursor.refuse("has an entry of metadata without a name");
      if (size && *size != 0 && *size != entry.value.size())
        mCursor.refuse("has metadata '" + inOneLine(entry.name) + "' of a wrong size");
      if (entry.type == "bool" && static_cast<unsigned char>(entry.value[0]) > 1)
        mCursor.refuse("has metadata '" + inOneLine(entry.name) + "' that is neither true nor false");
      if (entry.name == openvdb::GridBase::META_SAVE_HALF_FLOAT) {
        if (entry.type != "bool") mCursor.refuse("does not say clearly whether it is stored with half precision");
        half = entry.value[0] != 0;
      }
      if (!size && openvdb::Metadata::isRegisteredType(std::string(entry.type)))
        mBytes.replace(static_cast<std::size_t>(entry.type.data() - mBytes.data()), entry.type.size(),
                       entry.type.size(), '?');
    }
    return half;
  }

  VdbGridEntry grid() {
    VdbGridEntry entry;
    entry.name = mCursor.text();
    entry.type = mCursor.text();
    entry.parent = mCursor.text();
    mCursor.enter("its grid '" + inOneLine(openvdb::io::GridDescriptor::nameAsString(entry.name)) + "'");
    constexpr std::string_view kHalf = "_HalfFloat";
    entry.half = entry.type.ends_with(kHalf);
    if (entry.half) entry.type.resize(entry.type.size() - kHalf.size());
    mCursor.number<std::int64_t>();  // beginning of the grid: here
    mCursor.number<std::int64_t>();  // beginning of the leaves' values
    const auto end = mCursor.number<std::int64_t>();
    entry.begin = mCursor.position();
    if (const GridType* type = typeNamed(entry.type)) body(*type, entry);
    entry.end = mCursor.position();
    if (entry.content == VdbContent::Nothing || entry.content == VdbContent::Places) skipTo(end, entry);
    return entry;
  }

  void body(const GridType& type, VdbGridEntry& entry) {
    const auto compression = mCursor.number<std::uint32_t>();
    if (metadata() != entry.half) mCursor.refuse("does not say clearly whether it is stored with half precision");
    walkOverVdbTransform(mCursor);
    if (!entry.parent.empty()) {
      entry.content = VdbContent::Instance;
      return;
    }
    VdbTreeWalk tree(mCursor, type.value, type.leaf, {compression, entry.half});
    tree.topology();
    mMemory += tree.memory();
    requireMemory();
    entry.content = type.leaf == VdbLeaf::Points ? VdbContent::Places : VdbContent::Whole;
    if (entry.content == VdbContent::Whole) tree.buffers();
  }

  void requireMemory() const {
    const auto needed = static_cast<double>(mMemory);
    if (needed > machineMemory())
      mCursor.refuse("would take " + memoryText(needed) + " of memory, of which this machine has " +
                     memoryText(machineMemory()));
  }

  /// Skips to the end of a grid that is not read completely.
  void skipTo(std::int64_t end, const VdbGridEntry& entry) {
    if (!mHead.hasOffsets)
      mCursor.refuse("is of the type " + inOneLine(entry.type) + ", which cannot be skipped in a file without offsets");
    const auto here = static_cast<std::int64_t>(mCursor.position());
    if (end < here) mCursor.refuse("is said to end before it begins");
    mCursor.bytes(static_cast<std::uint64_t>(end - here));
  }

  std::string& mBytes;
  VdbCursor mCursor;
  VdbHead mHead;
  std::uint64_t mMemory = 0;
};

}  // namespace

VdbContents checkVdbHead(std::string& bytes) { return FileWalk(bytes).head(); }

VdbContents checkVdb(std::string& bytes) { return FileWalk(bytes).whole(); }

}  // namespace vdbtools
