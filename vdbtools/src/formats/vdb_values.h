// SPDX-License-Identifier: Apache-2.0
/// @file vdb_values.h
/// The values of a node of a VDB, as they are stored in the file: a byte that says how to reconstruct inactive values,
/// up to two of these values, a mask that chooses between them, and the rest, which may be compressed.
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
  /// Bytes if the grid is stored with half precision; equal to size for types that are not real numbers.
  std::size_t halfSize = 0;
  bool truth = false;  ///< a bool, which must be 0 or 1
  bool isReal() const { return halfSize != size; }
  bool isInteger() const { return !isReal() && !truth; }
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
  /// @throw DataError  an unknown kind of compression
  VdbValueWalk(VdbCursor& cursor, const VdbValueType& type, const VdbStorage& storage);

  enum class Payload {
    Measure,  ///< sizes and headers of compressed data are checked
    Decode    ///< in addition, the data are decompressed
  };

  /// Walks over the values of a node.
  /// @param active  the node's mask of active values, a multiple of 8 bytes
  /// @param count   number of values
  /// @throw DataError  OpenVDB cannot read these as @a count values. With Payload::Measure, the decompressor may still
  ///                   find errors in them, but will neither read nor write past their ends.
  void node(std::string_view active, std::size_t count, Payload payload);

  /// Walks over one uncompressed value.
  void value() { requireTruth(mCursor.bytes(mType.size)); }

  /// Walks over the background value, whose negative OpenVDB computes.
  void background();

 private:
  void stored(std::size_t count, Payload payload);
  void requireTruth(std::string_view values) const;
  void requireBlosc(std::string_view chunk, std::size_t size) const;
  std::string decoded(std::string_view chunk, std::size_t size) const;

  VdbCursor& mCursor;
  const VdbValueType& mType;
  VdbStorage mStorage;
};

/// The number of set bits. @param mask  a multiple of 8 bytes
std::size_t countOn(std::string_view mask);

}  // namespace vdbtools
