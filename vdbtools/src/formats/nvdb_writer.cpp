// SPDX-License-Identifier: Apache-2.0
#include "formats/grid_formats.h"
#include "formats/nvdb_layout.h"
#include "formats/turn_matrix.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/formats/nvdb_file.h"

#include <ostream>
#include <set>
#include <stdexcept>

#ifdef VDBTOOLS_NANOVDB
#include "formats/nanovdb.h"
#endif

namespace vdbtools {

#ifndef VDBTOOLS_NANOVDB

bool canWriteNvdb() { return false; }

std::vector<NvdbWritten> writeNvdb(std::ostream&, const std::vector<openvdb::GridBase::Ptr>&, const NvdbWriteOptions&) {
  throw std::invalid_argument("this build of the program cannot write NanoVDB: when it was built, " VDBTOOLS_NO_NANOVDB
                              "; write a .vdb instead");
}

#else

namespace {

// The reader goes by these.
static_assert(NANOVDB_MAJOR_VERSION_NUMBER == nvdb::kMajorVersion);
static_assert(sizeof(nano::FileHead) == sizeof(nvdb::FileHead));
static_assert(sizeof(nano::GridHead) == sizeof(nvdb::GridHead));
static_assert(sizeof(nanovdb::GridData) == sizeof(nvdb::GridData));
static_assert(sizeof(nano::TreeData) == sizeof(nvdb::TreeData));
static_assert(sizeof(nanovdb::GridBlindMetaData) == sizeof(nvdb::BlindData));
template <class Value>
constexpr bool isLaidOut(nanovdb::GridType number) {
  using Root = typename nanovdb::NanoRoot<Value>::DataType;
  using Upper = typename nanovdb::NanoUpper<Value>::DataType;
  using Lower = typename nanovdb::NanoLower<Value>::DataType;
  for (const nvdb::Type& type : nvdb::kTypes)
    if (type.number == static_cast<std::uint32_t>(number))
      return sizeof(Root) == type.root && sizeof(typename Root::Tile) == type.tile && sizeof(Upper) == type.upper &&
             sizeof(Lower) == type.lower && sizeof(nanovdb::NanoLeaf<Value>) == type.leaf &&
             sizeof(Upper) - sizeof(Upper::mTable) == type.upperTable &&
             sizeof(Lower) - sizeof(Lower::mTable) == type.lowerTable && sizeof(typename Upper::Tile) == type.entry;
  return false;
}
using nanovdb::GridType;
static_assert(isLaidOut<float>(GridType::Float) && isLaidOut<double>(GridType::Double));
static_assert(isLaidOut<std::int32_t>(GridType::Int32) && isLaidOut<std::int64_t>(GridType::Int64));
static_assert(isLaidOut<nanovdb::Vec3f>(GridType::Vec3f) && isLaidOut<bool>(GridType::Boolean));
static_assert(isLaidOut<nanovdb::Fp4>(GridType::Fp4) && isLaidOut<nanovdb::Fp8>(GridType::Fp8));
static_assert(isLaidOut<nanovdb::Fp16>(GridType::Fp16) && isLaidOut<nanovdb::FpN>(GridType::FpN));
static_assert(isLaidOut<std::int16_t>(GridType::Int16) && isLaidOut<std::uint32_t>(GridType::UInt32));
static_assert(isLaidOut<nanovdb::Vec3d>(GridType::Vec3d) && isLaidOut<nano::Rgba8>(GridType::RGBA8));
static_assert(isLaidOut<nanovdb::Vec4f>(GridType::Vec4f) && isLaidOut<nanovdb::Vec4d>(GridType::Vec4d));
static_assert(isLaidOut<nanovdb::ValueMask>(GridType::Mask) && isLaidOut<nanovdb::ValueIndex>(GridType::Index));

/// The memory of a grid. NanoVDB leaves gaps in it as they are, and the same grids are to give the same bytes: it is
/// zero at first.
class ZeroBuffer {
 public:
  ZeroBuffer() = default;
  static ZeroBuffer create(std::uint64_t size, const ZeroBuffer* /*pool*/ = nullptr) {
    ZeroBuffer buffer;
    buffer.mBlocks.resize((size + sizeof(Block) - 1) / sizeof(Block));
    buffer.mSize = size;
    return buffer;
  }
  const std::uint8_t* data() const { return reinterpret_cast<const std::uint8_t*>(mBlocks.data()); }
  std::uint8_t* data() { return reinterpret_cast<std::uint8_t*>(mBlocks.data()); }
  std::uint64_t size() const { return mSize; }
  bool empty() const { return mSize == 0; }
  void clear() {
    mBlocks.clear();
    mSize = 0;
  }

 private:
  struct alignas(nvdb::kAlignment) Block {
    std::uint8_t bytes[nvdb::kAlignment];
  };
  std::vector<Block> mBlocks;
  std::uint64_t mSize = 0;
};

using Handle = nanovdb::GridHandle<ZeroBuffer>;

/// NanoVDB allows some classes for some types only.
openvdb::GridClass classFor(const openvdb::GridBase& grid) {
  const openvdb::GridClass gridClass = grid.getGridClass();
  const bool isReal = grid.isType<openvdb::FloatGrid>() || grid.isType<openvdb::DoubleGrid>();
  switch (gridClass) {
    case openvdb::GRID_LEVEL_SET:
    case openvdb::GRID_FOG_VOLUME: return isReal ? gridClass : openvdb::GRID_UNKNOWN;
    case openvdb::GRID_STAGGERED: return grid.isType<openvdb::Vec3SGrid>() ? gridClass : openvdb::GRID_UNKNOWN;
    default: return openvdb::GRID_UNKNOWN;
  }
}

/// The greatest difference of an active voxel.
template <class Grid, class NanoGrid>
double greatestDifference(const Grid& grid, const NanoGrid& nano) {
  double greatest = 0;
  const auto accessor = nano.getAccessor();
  for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf)
    for (auto value = leaf->cbeginValueOn(); value; ++value) {
      const openvdb::Coord at = value.getCoord();
      const double difference =
          std::abs(double(accessor.getValue(nanovdb::Coord(at[0], at[1], at[2]))) - double(*value));
      // What is not finite comes back as anything.
      if (difference > greatest) greatest = difference;
    }
  return greatest;
}

/// Converts grids one by one.
class NanoConverter {
 public:
  explicit NanoConverter(const NvdbWriteOptions& options) : mOptions(options) {}

  Handle convert(const openvdb::GridBase& source, NvdbWritten& written) const {
    const openvdb::GridBase::Ptr grid = std::const_pointer_cast<openvdb::GridBase>(source.copyGrid());
    grid->setGridClass(classFor(source));
    turnGrid(*grid, mOptions.turn);
    written.name = grid->getName();
    written.levelSet = grid->getGridClass() == openvdb::GRID_LEVEL_SET;
    written.voxelSize = grid->voxelSize()[0];
    if (!grid->transform().isLinear())
      throw DataError("the grid '" + inOneLine(written.name) +
                      "' has a transform that is not linear, which NanoVDB does not have");
    Handle handle;
    // Each type costs seconds of compile time.
    const bool isKnown =
        tryAs<openvdb::FloatGrid>(*grid, written, handle) || tryAs<openvdb::Vec3SGrid>(*grid, written, handle) ||
        tryAs<openvdb::Int32Grid>(*grid, written, handle) || tryAs<openvdb::DoubleGrid>(*grid, written, handle);
    if (!isKnown)
      throw DataError("the grid '" + inOneLine(written.name) + "' holds values of type " +
                      inOneLine(grid->valueType()) +
                      "; a NanoVDB file is made of grids of float, double, int32 and vec3s");
    return handle;
  }

 private:
  template <class Grid>
  bool tryAs(const openvdb::GridBase& grid, NvdbWritten& written, Handle& handle) const {
    const auto* typed = dynamic_cast<const Grid*>(&grid);
    if (!typed) return false;
    // NanoVDB complains on the terminal about trees of inactive tiles alone.
    typename Grid::Ptr empty;
    if (typed->tree().empty() || typed->activeVoxelCount() == 0) {
      empty = typed->copyWithNewTree();
      typed = empty.get();
    }
    if constexpr (std::is_same_v<Grid, openvdb::FloatGrid>) {
      // FpN asks for a leaf.
      const bool hasLeaves = typed->tree().leafCount() > 0;
      switch (mOptions.values) {
        case NvdbValues::Full: break;
        case NvdbValues::Fp16: handle = quantized<nanovdb::Fp16>(*typed, "Fp16", written); return true;
        case NvdbValues::Fp8: handle = quantized<nanovdb::Fp8>(*typed, "Fp8", written); return true;
        case NvdbValues::Variable:
          handle = hasLeaves ? quantized<nanovdb::FpN>(*typed, "FpN", written)
                             : quantized<nanovdb::Fp16>(*typed, "Fp16", written);
          return true;
      }
    }
    handle = nano::converted<nano::ValueOf<Grid>, ZeroBuffer>(*typed);
    written.type = typed->valueType();
    return true;
  }

  template <class Nano>
  static Handle quantized(const openvdb::FloatGrid& grid, const char* type, NvdbWritten& written) {
    Handle handle = nano::converted<Nano, ZeroBuffer>(grid);
    written.type = type;
    written.quantized = true;
    written.greatestError = greatestDifference(grid, *handle.grid<Nano>());
    return handle;
  }

  NvdbWriteOptions mOptions;
};

}  // namespace

bool canWriteNvdb() { return true; }

std::vector<NvdbWritten> writeNvdb(std::ostream& stream, const std::vector<openvdb::GridBase::Ptr>& grids,
                                   const NvdbWriteOptions& options) {
  std::set<std::string> names;
  for (const auto& grid : grids)
    if (!names.insert(grid->getName()).second)
      throw std::invalid_argument("two grids are called '" + inOneLine(grid->getName()) + "'; ask for each once");
  const NanoConverter converter(options);
  std::vector<NvdbWritten> report;
  std::vector<Handle> handles;
  // One segment for all grids: some readers look at the first one only.
  nanovdb::io::Segment segment(nanovdb::io::Codec::NONE);
  for (const auto& grid : grids) {
    handles.push_back(converter.convert(*grid, report.emplace_back()));
    segment.add(handles.back());
    segment.meta.back().fileSize = handles.back().buffer().size();
  }
  segment.write(stream);
  for (const Handle& handle : handles)
    stream.write(reinterpret_cast<const char*>(handle.buffer().data()),
                 static_cast<std::streamsize>(handle.buffer().size()));
  return report;
}

#endif

std::vector<NvdbWritten> writeNvdbGrids(std::ostream& stream, const std::vector<openvdb::GridBase::Ptr>& grids,
                                        const VdbWriteOptions& options, NvdbValues values) {
  return writeNvdb(stream, renamed(grids, options.names), {.values = values, .turn = options.turn});
}

}  // namespace vdbtools
