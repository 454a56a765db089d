// SPDX-License-Identifier: Apache-2.0
#include "mesh_files/gltf_file.h"

#include "base/json_text.h"
#include "base/percent_decoded.h"
#include "mesh_files/glb_format.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/files/standard_streams.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <optional>

namespace vdbtools {
namespace {

using Json = nlohmann::json;

constexpr std::string_view kMagic = "glTF";

std::size_t sizeOfType(std::uint64_t type) {
  switch (type) {
    case glb::kByte:
    case glb::kUnsignedByte: return 1;
    case glb::kShort:
    case glb::kUnsignedShort: return 2;
    case glb::kUnsignedInt:
    case glb::kFloat: return 4;
    default: return 0;
  }
}

int componentsOf(const std::string& type) {
  for (const auto& [name, count] : {std::pair("SCALAR", 1), {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}})
    if (type == name) return count;
  return 0;
}

template <class Number>
Number load(const char* from) {
  Number value;
  std::memcpy(&value, from, sizeof value);
  return value;
}

std::optional<std::string> base64Decoded(std::string_view text) {
  static constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  static const std::array<int, 256> values = [] {
    std::array<int, 256> table;
    table.fill(-1);
    for (std::size_t i = 0; i < kDigits.size(); ++i)
      table[static_cast<unsigned char>(kDigits[i])] = static_cast<int>(i);
    return table;
  }();
  while (text.ends_with('=')) text.remove_suffix(1);
  std::string bytes;
  bytes.reserve(text.size() / 4 * 3 + 3);
  std::uint32_t bits = 0;
  int count = 0;
  for (const char c : text) {
    const int value = values[static_cast<unsigned char>(c)];
    if (value < 0) return std::nullopt;
    bits = bits << 6 | static_cast<std::uint32_t>(value);
    count += 6;
    if (count < 8) continue;
    count -= 8;
    bytes += static_cast<char>(bits >> count & 0xff);
  }
  return bytes;
}

}  // namespace

/// The elements of a sparse accessor that are given.
struct GltfArray::Sparse {
  GltfArray numbers, values;
};

bool GltfArray::isUnsigned() const {
  return mType == glb::kUnsignedByte || mType == glb::kUnsignedShort || mType == glb::kUnsignedInt;
}

const char* GltfArray::placeOf(std::uint64_t i, int k) const {
  if (mSparse) {
    std::uint64_t low = 0, high = mSparse->numbers.count();
    while (low < high) {
      const std::uint64_t middle = low + (high - low) / 2;
      if (mSparse->numbers.index(middle) < i)
        low = middle + 1;
      else
        high = middle;
    }
    if (low < mSparse->numbers.count() && mSparse->numbers.index(low) == i) return mSparse->values.placeOf(low, k);
  }
  static constexpr char kZeros[sizeof(double)] = {};
  if (!mData) return kZeros;
  return mData + i * mStride + static_cast<std::uint64_t>(k) * sizeOfType(static_cast<std::uint64_t>(mType));
}

double GltfArray::value(std::uint64_t i, int k) const {
  const char* at = placeOf(i, k);
  const auto share = [&](double number, double largest) {
    return mNormalized ? std::max(number / largest, -1.0) : number;
  };
  switch (mType) {
    case glb::kByte: return share(load<std::int8_t>(at), 127);
    case glb::kUnsignedByte: return share(load<std::uint8_t>(at), 255);
    case glb::kShort: return share(load<std::int16_t>(at), 32767);
    case glb::kUnsignedShort: return share(load<std::uint16_t>(at), 65535);
    case glb::kUnsignedInt: return share(load<std::uint32_t>(at), 4294967295.0);
    default: return static_cast<double>(load<float>(at));
  }
}

std::uint32_t GltfArray::index(std::uint64_t i, int k) const {
  const char* at = placeOf(i, k);
  switch (mType) {
    case glb::kUnsignedByte: return load<std::uint8_t>(at);
    case glb::kUnsignedShort: return load<std::uint16_t>(at);
    default: return load<std::uint32_t>(at);
  }
}

GltfFile::GltfFile(const std::filesystem::path& path, std::string_view contents) : mPath(path) {
  std::string_view text = contents;
  if (contents.starts_with(kMagic)) {
    if (contents.size() < glb::kFileHead + glb::kChunkHead) fail("the file is truncated");
    if (const auto version = load<std::uint32_t>(contents.data() + 4); version != 2)
      fail("it is glTF of version " + std::to_string(version) + "; only version 2 can be read");
    if (const std::uint64_t length = load<std::uint32_t>(contents.data() + 8); length > contents.size())
      fail("it should have " + std::to_string(length) + " bytes and has " + std::to_string(contents.size()) +
           "; it is truncated");
    text = {};
    for (std::size_t at = glb::kFileHead; contents.size() - at >= glb::kChunkHead;) {
      const std::uint64_t size = load<std::uint32_t>(contents.data() + at);
      const auto kind = load<std::uint32_t>(contents.data() + at + 4);
      at += glb::kChunkHead;
      if (size > contents.size() - at) fail("a chunk of " + std::to_string(size) + " bytes does not fit into the file");
      if (kind == glb::kJsonChunk && text.empty()) text = contents.substr(at, size);
      if (kind == glb::kBinaryChunk && mBinary.data() == nullptr) mBinary = contents.substr(at, size);
      at += size;
    }
    if (text.empty()) fail("it has no JSON chunk");
  }
  if (nestsTooDeep(text)) fail("its JSON has more than " + std::to_string(kMostJsonDepth) + " levels; export it again");
  try {
    mJson = std::make_unique<Json>(Json::parse(text));
  } catch (const Json::exception& error) {
    fail("it is not valid JSON: " + inOneLine(error.what()));
  }
  if (!mJson->is_object() || !mJson->contains("asset")) fail("it is not glTF: its JSON has no 'asset'");
  refuseCompression();
  for (std::uint64_t i = 0; i < sizeOf("buffers"); ++i) mBuffers.push_back(bufferOf(i));
}

GltfFile::~GltfFile() = default;

void GltfFile::fail(const std::string& what) const { throw DataError(mPath.string() + ": " + what); }

void GltfFile::refuseCompression() const {
  const auto required = mJson->find("extensionsRequired");
  if (required == mJson->end() || !required->is_array()) return;
  for (const Json& extension : *required)
    if (extension == "KHR_draco_mesh_compression" || extension == "EXT_meshopt_compression" ||
        extension == "KHR_meshopt_compression")
      fail("its geometry is compressed (" + extension.get<std::string>() +
           "), which cannot be read; export it without compression");
}

std::uint64_t GltfFile::sizeOf(const char* list) const {
  const auto found = mJson->find(list);
  if (found == mJson->end()) return 0;
  if (!found->is_array()) fail("'" + std::string(list) + "' is not a list");
  return found->size();
}

const Json& GltfFile::element(const char* list, std::uint64_t index) const {
  const std::uint64_t size = sizeOf(list);
  if (index >= size)
    fail("element " + std::to_string(index) + " of '" + list + "' is referred to, and there are " +
         std::to_string(size));
  const Json& element = (*mJson)[list][index];
  if (!element.is_object()) fail("element " + std::to_string(index) + " of '" + list + "' is not an object");
  return element;
}

std::uint64_t GltfFile::whole(const Json& object, const char* name, std::uint64_t otherwise) const {
  const auto found = object.find(name);
  if (found == object.end()) return otherwise;
  if (found->is_number_unsigned()) return found->get<std::uint64_t>();
  constexpr double kMost = 9007199254740992.0;  // 2^53
  if (found->is_number_float())
    if (const double value = found->get<double>(); value >= 0 && value <= kMost && value == std::floor(value))
      return static_cast<std::uint64_t>(value);
  fail("'" + std::string(name) + "' is " + inOneLine(found->dump(-1, ' ', true, Json::error_handler_t::replace)) +
       " and not a whole number");
}

std::uint64_t GltfFile::whole(const Json& object, const char* name) const {
  if (!object.contains(name)) fail("'" + std::string(name) + "' is missing");
  return whole(object, name, 0);
}

std::vector<double> GltfFile::numbers(const Json& object, const char* name, std::size_t count) const {
  const auto found = object.find(name);
  if (found == object.end()) return {};
  std::vector<double> values;
  if (found->is_array() && found->size() == count)
    for (const Json& value : *found)
      if (value.is_number() && std::isfinite(value.get<double>())) values.push_back(value.get<double>());
  if (values.size() != count)
    fail("'" + std::string(name) + "' is not a list of " + std::to_string(count) + " numbers");
  return values;
}

std::string GltfFile::readExternal(const std::string& uri) const {
  const std::filesystem::path name = percentDecoded(uri);
  bool inside = name.is_relative() && uri.find("://") == std::string::npos;
  for (const std::filesystem::path& part : name) inside = inside && part != "..";
  if (!inside || name.empty() || name.native().find('\0') != std::string::npos)
    fail("a buffer is in '" + inOneLine(uri) + "'; only files beside it, or in folders there, are read");
  if (isStandardInput(mPath))
    fail("its buffer '" + inOneLine(uri) + "' is another file, which a pipe does not bring; send a .glb");
  const std::filesystem::path file = mPath.parent_path() / name;
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error))
    throw MissingInputError(mPath.string() + ": its buffer '" + inOneLine(file.string()) +
                            "' is not there; keep the two files together, or export a .glb");
  return readWholeFile(file);
}

std::uint64_t GltfFile::bytesOfBuffers() const {
  std::uint64_t sum = 0;
  for (const std::string_view& buffer : mBuffers) sum += buffer.size();
  return sum;
}

std::string_view GltfFile::bufferOf(std::uint64_t index) {
  const Json& buffer = element("buffers", index);
  const std::uint64_t length = whole(buffer, "byteLength");
  std::string_view bytes;
  const auto uri = buffer.find("uri");
  if (uri == buffer.end()) {
    if (index > 0 || mBinary.data() == nullptr) fail("buffer " + std::to_string(index) + " has no content");
    bytes = mBinary;
  } else {
    if (!uri->is_string()) fail("the uri of a buffer is not a text");
    const std::string& name = uri->get_ref<const std::string&>();
    if (name.starts_with("data:")) {
      const std::size_t comma = name.find(";base64,");
      std::optional<std::string> decoded;
      if (comma != std::string::npos) decoded = base64Decoded(std::string_view(name).substr(comma + 8));
      if (!decoded) fail("a buffer is not valid base64");
      bytes = mOwn[index] = std::move(*decoded);
    } else {
      bytes = mOwn[index] = readExternal(name);
    }
  }
  if (bytes.size() < length)
    fail("buffer " + std::to_string(index) + " should have " + std::to_string(length) + " bytes and has " +
         std::to_string(bytes.size()));
  return bytes.substr(0, length);
}

void GltfFile::place(GltfArray& array, const Json& where, const std::string& name) const {
  const Json& view = element("bufferViews", whole(where, "bufferView"));
  if (const auto extensions = view.find("extensions");
      extensions != view.end() && extensions->is_object() &&
      (extensions->contains("EXT_meshopt_compression") || extensions->contains("KHR_meshopt_compression")))
    fail("its geometry is compressed (meshopt), which cannot be read; export it without compression");
  const std::uint64_t buffer = whole(view, "buffer"), offset = whole(view, "byteOffset", 0),
                      length = whole(view, "byteLength");
  if (buffer >= mBuffers.size()) fail("a part of buffer " + std::to_string(buffer) + " is used, and there is none");
  const std::string_view bytes = mBuffers[buffer];
  if (offset > bytes.size() || length > bytes.size() - offset)
    fail("a part of buffer " + std::to_string(buffer) + " does not lie within it");
  const std::uint64_t size =
      sizeOfType(static_cast<std::uint64_t>(array.mType)) * static_cast<std::uint64_t>(array.mComponents);
  array.mStride = whole(view, "byteStride", 0);
  if (array.mStride == 0) array.mStride = size;
  const std::uint64_t start = whole(where, "byteOffset", 0);
  // Written so that nothing can overflow: the last element must end within the part.
  const bool fits =
      start <= length && array.mStride >= size &&
      (array.mCount == 0 || (size <= length - start && array.mCount - 1 <= (length - start - size) / array.mStride));
  if (!fits) fail(name + " does not lie within its part of the buffer");
  array.mData = bytes.data() + offset + start;
}

GltfArray GltfFile::typedArray(const Json& accessor, const std::string& name, int components) const {
  GltfArray array;
  const std::uint64_t type = whole(accessor, "componentType");
  if (sizeOfType(type) == 0 || components == 0) fail(name + " is of a type that cannot be read");
  array.mType = static_cast<int>(type);
  array.mComponents = components;
  array.mNormalized = accessor.value("normalized", Json(false)) == true;
  array.mCount = whole(accessor, "count");
  const auto sparse = accessor.find("sparse");
  if (sparse == accessor.end()) {
    if (!accessor.contains("bufferView")) fail(name + " has no data");
    place(array, accessor, name);
    return array;
  }
  if (accessor.contains("bufferView"))
    place(array, accessor, name);
  else if (array.mCount > bytesOfBuffers())
    fail(name + " is sparse, and has more elements than the file has bytes");
  const auto part = [&](const char* member) -> const Json& {
    if (!sparse->is_object() || !sparse->contains(member) || !(*sparse)[member].is_object())
      fail(name + " is sparse, and has no '" + member + "'");
    return (*sparse)[member];
  };
  const Json &indices = part("indices"), &values = part("values");
  const auto found = std::make_shared<GltfArray::Sparse>();
  found->values = array;
  found->values.mCount = found->numbers.mCount = whole(*sparse, "count");
  place(found->values, values, name);
  const std::uint64_t numbers = whole(indices, "componentType");
  found->numbers.mComponents = 1;
  found->numbers.mType = sizeOfType(numbers) == 0 ? 0 : static_cast<int>(numbers);
  if (!found->numbers.isUnsigned()) fail(name + " is sparse, and its indices are not whole numbers");
  place(found->numbers, indices, name);
  for (std::uint64_t i = 0; i < found->numbers.mCount; ++i)
    if (found->numbers.index(i) >= array.mCount || (i > 0 && found->numbers.index(i) <= found->numbers.index(i - 1)))
      fail(name + " is sparse, and its indices do not increase or are too large");
  array.mSparse = found;
  return array;
}

GltfArray GltfFile::array(std::uint64_t index) const {
  const Json& accessor = element("accessors", index);
  const auto shape = accessor.find("type");
  return typedArray(accessor, "accessor " + std::to_string(index),
                    shape != accessor.end() && shape->is_string() ? componentsOf(shape->get<std::string>()) : 0);
}

GltfArray GltfFile::matrices(std::uint64_t index) const {
  const Json& accessor = element("accessors", index);
  const std::string name = "accessor " + std::to_string(index);
  constexpr int kNumbers = 16;
  if (accessor.value("type", Json()) != "MAT4" || whole(accessor, "componentType") != glb::kFloat)
    fail(name + " is not of matrices of floats");
  return typedArray(accessor, name, kNumbers);
}

std::map<std::string, std::string> readGltfExtras(const std::filesystem::path& path) {
  std::ifstream file = openToRead(path);
  std::map<std::string, std::string> texts;
  char head[glb::kFileHead + glb::kChunkHead] = {};
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(pathToOpen(path), error);
  const auto read = [&](char* to, std::size_t bytes) {
    file.read(to, static_cast<std::streamsize>(bytes));
    if (file.bad()) throw IoError("reading '" + path.string() + "' broke off");
    return bool(file);
  };
  if (error || !read(head, sizeof head) || std::string_view(head, 4) != kMagic) return texts;
  const auto length = load<std::uint32_t>(head + glb::kFileHead);
  if (length > size || load<std::uint32_t>(head + glb::kFileHead + 4) != glb::kJsonChunk) return texts;
  std::string text(length, '\0');
  if (!read(text.data(), length)) return texts;
  const Json json = parsedJson<Json>(text);
  if (!json.is_object() || !json.contains("asset") || !json["asset"].is_object()) return texts;
  const Json& asset = json["asset"];
  const auto generator = asset.find("generator"), extras = asset.find("extras");
  const bool ours = generator != asset.end() && generator->is_string() &&
                    generator->get_ref<const std::string&>().starts_with("JuliaVDB ");
  if (!ours || extras == asset.end() || !extras->is_object()) return texts;
  for (const auto& [key, value] : extras->items())
    if (value.is_string()) texts[key] = value.get<std::string>();
  return texts;
}

}  // namespace vdbtools
