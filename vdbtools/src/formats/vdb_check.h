// SPDX-License-Identifier: Apache-2.0
/// @file vdb_check.h
/// Checks the structure of a whole VDB from untrusted bytes.
///
/// OpenVDB's reader trusts a file: it allocates as much as a count in it states, reads past buffers if a size in it is
/// wrong, and does not notice the end of the file. Therefore this check walks over everything that OpenVDB will read,
/// in the same way, and refuses whatever OpenVDB could not read safely. It does not decompress values of leaves, so it
/// takes a small part of the time of the reading itself. It is safe that the decompressor may still find broken values,
/// because it knows the sizes of its input and its output.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace vdbtools {

/// The readable parts of a grid.
enum class VdbContent {
  Whole,
  Instance,  ///< metadata and transform; the tree is another grid's
  Places,    ///< all but the values of leaves, for grids of points
  Nothing,   ///< unknown grid type
};

/// A grid in a file.
struct VdbGridEntry {
  std::string name;  ///< unique in the file: with a suffix if several grids have one name, see io::GridDescriptor
  std::string type;  ///< the name registered with OpenVDB, "Tree_float_5_4_3"
  bool half = false;
  std::string parent;  ///< the name of the grid whose tree this one shares, or empty
  VdbContent content = VdbContent::Nothing;
  std::size_t begin = 0, end = 0;  ///< the bytes after the descriptor; of points, those that are read
};

struct VdbContents {
  std::size_t metadataBegin = 0, metadataEnd = 0;  ///< metadata of the file
  std::vector<VdbGridEntry> grids;
};

/// Checks the metadata of a file, for which its beginning suffices. OpenVDB must be initialised.
/// @param bytes  metadata of types that OpenVDB registers for itself are changed to an unknown type, which OpenVDB
///               skips. They are for delayed loading, and OpenVDB reads them without a check.
/// @throw VdbEnds    the bytes end within the metadata
/// @throw DataError  the metadata cannot be read safely
VdbContents checkVdbHead(std::string& bytes);

/// Checks a whole file. OpenVDB must be initialised.
/// @param bytes  as in checkVdbHead()
/// @throw DataError  the file cannot be read safely, or would take more memory than this machine has; the message
///                   begins with the part of the file, "its grid 'surface' ...", and says what is wrong
VdbContents checkVdb(std::string& bytes);

}  // namespace vdbtools
