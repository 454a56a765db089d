// SPDX-License-Identifier: Apache-2.0
/// @file vdb_values.h
/// The values of a node of a VDB, as they lie in the file: a byte that says how inactive values are made up again, up
/// to two of these values, a mask that chooses between them, and the rest, which may be compressed.
#pragma once

#include "formats/vdb_cursor.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace vdbtools {

/// A type of value in a grid.
struct VdbValueType {
  std::size_t size = 0;  ///< bytes
  std::size_t halfSize =
      0;               ///< bytes where the grid is stored with half precision; the same for what is no real number
  bool truth = false;  ///< a bool: 0 or 1, and nothing else
  bool isReal() const { return halfSize != size; }
};

/// How the values of a grid are stored.
struct VdbStorage {
  std::uint32_t compression = 0;  ///< io::COMPRESS_* of OpenVDB
  bool half = false;
};

/// Walks over values as OpenVDB reads them.
class VdbValueWalk {
 public:
  /// @param cursor, type  must outlive the walk
  /// @throw DataError  compression of a kind that is not known
  VdbValueWalk(VdbCursor& cursor, const VdbValueType& type, const VdbStorage& storage);

  enum class Payload {
    Measure,  ///< sizes and headers of what is compressed are checked
    Decode    ///< and it is decompressed
  };

  /// Walks over the values of a node.
  /// @param active  the node's mask of active values, a multiple of 8 bytes
  /// @param count   of all values
  /// @throw DataError  these are not values that OpenVDB can read into @a count places. With Payload::Measure, the
  ///                   decompressor may still find fault with them, but will neither read nor write past their ends.
  void node(std::string_view active, std::size_t count, Payload payload);

  /// One value that is not compressed.
  void value() { requireTruth(mCursor.bytes(mType.size)); }

 private:
  void stored(std::size_t count, Payload payload);
  void requireTruth(std::string_view values) const;
  void requireBlosc(std::string_view chunk, std::size_t size) const;
  std::string decoded(std::string_view chunk, std::size_t size) const;

  VdbCursor& mCursor;
  const VdbValueType& mType;
  VdbStorage mStorage;
};

/// The number of bits that are on. @param mask  a multiple of 8 bytes
std::size_t countOn(std::string_view mask);

}  // namespace vdbtools
