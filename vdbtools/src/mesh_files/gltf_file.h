// SPDX-License-Identifier: Apache-2.0
/// @file gltf_file.h
/// The container of glTF 2.0 (Khronos Group): JSON, buffers, and the arrays in them, each checked against the available
/// bytes before it is used.
///
/// tinygltf (2.7) is not used here: it reads up to 8 bytes past the end of a GLB whose binary chunk claims to be longer
/// than it is, follows URIs out of the file's folder, descends into nested extras without a limit, and copies every
/// buffer. The tests use it to check what is written and read here.
#pragma once

#include "vdbtools/base/errors.h"

#include <nlohmann/json_fwd.hpp>

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace vdbtools {

/// The numbers of an accessor, at most as many elements as the file has bytes.
class GltfArray {
 public:
  std::uint64_t count() const { return mCount; }
  int components() const { return mComponents; }
  bool isUnsigned() const;  ///< unsigned integers

  /// Component @a k of element @a i; normalised integers are scaled to fractions of the largest.
  double value(std::uint64_t i, int k) const;
  /// Component @a k of an integer element, not scaled.
  std::uint32_t index(std::uint64_t i, int k = 0) const;

 private:
  friend class GltfFile;
  struct Sparse;
  const char* placeOf(std::uint64_t i, int k) const;

  const char* mData = nullptr;  ///< null: zeros
  std::uint64_t mCount = 0, mStride = 0;
  int mComponents = 0, mType = 0;
  bool mNormalized = false;
  std::shared_ptr<const Sparse> mSparse{};  ///< the elements that differ from mData
};

class GltfFile {
 public:
  /// @param contents  the bytes of a .gltf or a .glb, distinguished by how they begin; must outlive this
  /// @throw DataError  the file is broken, or compressed in an unsupported way
  /// @throw MissingInputError, IoError  from reading a buffer in another file
  GltfFile(const std::filesystem::path& path, std::string_view contents);
  ~GltfFile();

  const nlohmann::json& json() const { return *mJson; }

  /// The element of one of the file's lists: "nodes", "meshes" and so on. @throw DataError  there is none
  const nlohmann::json& element(const char* list, std::uint64_t index) const;
  std::uint64_t sizeOf(const char* list) const;

  /// @throw DataError  the accessor does not exist, does not lie within its buffer, or is of matrices
  GltfArray array(std::uint64_t accessor) const;
  /// An accessor of matrices of 4 x 4 floats, column by column. @throw DataError
  GltfArray matrices(std::uint64_t accessor) const;

  /// An integer member; @a otherwise if there is none. @throw DataError
  std::uint64_t whole(const nlohmann::json& object, const char* name, std::uint64_t otherwise) const;
  /// An integer member that is required.
  std::uint64_t whole(const nlohmann::json& object, const char* name) const;
  /// A list of numbers; empty if there is none. @throw DataError  it has another length
  std::vector<double> numbers(const nlohmann::json& object, const char* name, std::size_t count) const;

  /// @throw DataError  "FILE: WHAT"
  [[noreturn]] void fail(const std::string& what) const;

 private:
  std::string_view bufferOf(std::uint64_t index);
  std::uint64_t bytesOfBuffers() const;
  /// All of an array but its bytes.
  GltfArray headOf(const nlohmann::json& accessor, const std::string& name, int components) const;
  GltfArray typedArray(const nlohmann::json& accessor, const std::string& name, int components) const;
  /// Gives an array, whose other members are set, its bytes.
  void place(GltfArray& array, const nlohmann::json& where, const std::string& name) const;
  std::string readExternal(const std::string& uri) const;
  std::string_view partOfBuffer(const nlohmann::json& where) const;
  /// Unpacks the parts of buffers that meshoptimizer compressed. @param room  as in unpacked()
  void unpackViews(std::uint64_t& room);
  /// Unpacks the primitives that Draco compressed: the arrays of their accessors.
  void unpackPrimitives(std::uint64_t& room);
  void unpackPrimitive(const nlohmann::json& primitive, const nlohmann::json& compression, std::uint64_t& room);
  /// @param room  bytes that may still be unpacked
  std::string unpacked(const nlohmann::json& compression, std::uint64_t& room) const;

  std::filesystem::path mPath;
  std::unique_ptr<nlohmann::json> mJson;
  std::string_view mBinary;                   ///< the binary chunk of a GLB
  std::map<std::uint64_t, std::string> mOwn;  ///< buffers that are not part of the contents
  std::vector<std::string_view> mBuffers;
  std::map<std::uint64_t, std::string> mUnpacked;  ///< parts of buffers by their numbers
  struct Decoded {
    std::string bytes;
    GltfArray array;  ///< in these bytes
  };
  std::map<std::uint64_t, Decoded> mDecoded;  ///< by the numbers of accessors
};

}  // namespace vdbtools
