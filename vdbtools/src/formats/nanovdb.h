// SPDX-License-Identifier: Apache-2.0
/// @file nanovdb.h
/// NanoVDB under one set of names: versions 32.7 and later, of OpenVDB 12 and 13, have other headers and names
/// than 32.6, of OpenVDB 11, and this has others than 32.4, of OpenVDB 10. All write the layout of nvdb_layout.h.
#pragma once

#include "vdbtools/base/grids.h"

#include <type_traits>

// Its loops in TBB's threads, as many as this program may use.
#define NANOVDB_USE_TBB
#define NANOVDB_USE_OPENVDB
#if __has_include(<nanovdb/tools/CreateNanoGrid.h>)
#include <nanovdb/io/IO.h>
#include <nanovdb/tools/CreateNanoGrid.h>

namespace vdbtools::nano {
using FileHead = nanovdb::io::FileHeader;
using GridHead = nanovdb::io::FileMetaData;
using TreeData = nanovdb::TreeData;
using Rgba8 = nanovdb::math::Rgba8;
using CheckMode = nanovdb::CheckMode;
namespace tools = nanovdb::tools;
}  // namespace vdbtools::nano
#elif __has_include(<nanovdb/util/CreateNanoGrid.h>)
#include <nanovdb/util/CreateNanoGrid.h>
#include <nanovdb/util/IO.h>

namespace vdbtools::nano {
using FileHead = nanovdb::io::FileHeader;
using GridHead = nanovdb::io::FileMetaData;
using TreeData = nanovdb::TreeData;
using Rgba8 = nanovdb::Rgba8;
using CheckMode = nanovdb::ChecksumMode;
namespace tools = nanovdb;
}  // namespace vdbtools::nano
#else
#define VDBTOOLS_OPEN_TO_NANO_VDB
#include <nanovdb/util/IO.h>
#include <nanovdb/util/OpenToNanoVDB.h>

namespace vdbtools::nano {
using FileHead = nanovdb::io::Header;
using GridHead = nanovdb::io::MetaData;
using TreeData = nanovdb::TreeData<3>;
using Rgba8 = nanovdb::Rgba8;
using CheckMode = nanovdb::ChecksumMode;
namespace tools = nanovdb;
}  // namespace vdbtools::nano
#endif

namespace vdbtools::nano {

/// NanoVDB's type for the values of a grid.
#ifdef VDBTOOLS_OPEN_TO_NANO_VDB
template <class Grid>
using ValueOf = typename nanovdb::OpenToNanoType<typename Grid::TreeType::BuildType>::Type;
#else
template <class Grid>
using ValueOf = typename tools::MapToNano<typename Grid::TreeType::BuildType>::type;
#endif

/// Converts a grid, with the least and the greatest value of each node and a checksum of everything. The averages of
/// nodes would depend on the order in which threads add.
/// @tparam Value  NanoVDB's type for the values
template <class Value, class Buffer, class Grid>
nanovdb::GridHandle<Buffer> converted(const Grid& grid) {
#ifdef VDBTOOLS_OPEN_TO_NANO_VDB
  return nanovdb::openToNanoVDB<Buffer, typename Grid::TreeType, Value>(grid, nanovdb::StatsMode::MinMax,
                                                                        CheckMode::Full);
#else
  tools::CreateNanoGrid<Grid> converter(grid);
  converter.setStats(tools::StatsMode::MinMax);
  converter.setChecksum(CheckMode::Full);
  if constexpr (std::is_same_v<Value, nanovdb::FpN>)
    return converter.template getHandle<Value, tools::AbsDiff, Buffer>();
  else
    return converter.template getHandle<Value, Buffer>();
#endif
}

}  // namespace vdbtools::nano
