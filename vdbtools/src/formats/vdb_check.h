// SPDX-License-Identifier: Apache-2.0
/// @file vdb_check.h
/// The structure of a whole VDB, from bytes that nobody vouches for.
///
/// OpenVDB's reader trusts a file: it allocates what a count in it says, reads past buffers where a size in it is
/// wrong, and does not see that a file has ended. So this check walks over all that OpenVDB will read, as it will read
/// it, and refuses what it could not read safely. Values of leaves are not decompressed, so the walk takes a small part
/// of the time of the reading itself; that their decompressor may still find them broken is safe, because it knows the
/// sizes of its input and its output.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace vdbtools {

/// The parts of a grid that can be read.
enum class VdbContent {
  Whole,
  Instance,  ///< metadata and transform; the tree is another grid's
  Places,    ///< all but the values of leaves: of grids of points
  Nothing,   ///< the type of grid is not known
};

/// A grid in a file.
struct VdbGridEntry {
  std::string name;  ///< unique in the file: with a suffix where several have one name, see io::GridDescriptor
  std::string type;  ///< as OpenVDB registers it, "Tree_float_5_4_3"
  bool half = false;
  std::string parent;  ///< the name of the grid whose tree this one shares, or none
  VdbContent content = VdbContent::Nothing;
  std::size_t begin = 0, end = 0;  ///< the bytes after the descriptor, for a grid of points as far as they are read
};

struct VdbContents {
  std::size_t metadataBegin = 0, metadataEnd = 0;  ///< of the file
  std::vector<VdbGridEntry> grids;
};

/// The bytes of the metadata of the file, which the beginning of a file is enough for. OpenVDB must be initialised.
/// @param bytes  is changed so far: metadata of types that OpenVDB registers for itself become metadata of an unknown
/// type,
///               which it skips. They are for delayed loading, and are read without a check.
/// @throw VdbEnds    the bytes end within it
/// @throw DataError  it cannot be read safely
VdbContents checkVdbHead(std::string& bytes);

/// All of a file. OpenVDB must be initialised.
/// @param bytes  as above
/// @throw DataError  it cannot be read safely, or would take more memory than this machine has; the text says what is
///                   wrong, and begins with the part of the file, "its grid 'surface' ..."
VdbContents checkVdb(std::string& bytes);

}  // namespace vdbtools
