// SPDX-License-Identifier: Apache-2.0
#include "mesh_files/gltf_file.h"

#include "base/json_text.h"
#include "mesh_files/draco_decoder.h"
#include "mesh_files/glb_format.h"
#include "mesh_files/mesh_formats.h"
#include "vdbtools/base/memory.h"
#include "vdbtools/base/text.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/files/standard_streams.h"

#include <meshoptimizer.h>
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

/// The numbers of an element of an accessor; 0 if it is no vector.
int componentsOf(const Json& accessor) {
  const auto type = accessor.find("type");
  if (type == accessor.end()) return 0;
  for (const auto& [name, count] : {std::pair("SCALAR", 1), {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}})
    if (*type == name) return count;
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

/// An extension of an object under the first of some names that it has; nullptr: none.
const Json* extensionOf(const Json& object, std::initializer_list<const char*> names) {
  const auto extensions = object.find("extensions");
  if (extensions == object.end() || !extensions->is_object()) return nullptr;
  for (const char* name : names)
    if (const auto found = extensions->find(name); found != extensions->end() && found->is_object()) return &*found;
  return nullptr;
}

/// That by which meshoptimizer compresses a part of a buffer.
const Json* meshoptOf(const Json& object) {
  return extensionOf(object, {"EXT_meshopt_compression", "KHR_meshopt_compression"});
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
  for (std::uint64_t i = 0; i < sizeOf("buffers"); ++i) mBuffers.push_back(bufferOf(i));
  // A file may use the same bytes as often as it likes, but no mesh is so much smaller when it is compressed.
  constexpr std::uint64_t kMostExpansion = 64, kFree = 64 << 20;
  std::uint64_t room = kMostExpansion * bytesOfBuffers() + kFree;
  unpackViews(room);
  unpackPrimitives(room);
}

GltfFile::~GltfFile() = default;

void GltfFile::fail(const std::string& what) const { throw DataError(mPath.string() + ": " + what); }

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
  if (meshoptOf(buffer)) return {};  // a place for what is unpacked
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
  const std::uint64_t viewIndex = whole(where, "bufferView");
  const Json& view = element("bufferViews", viewIndex);
  const auto unpacked = mUnpacked.find(viewIndex);
  const std::string_view bytes = unpacked != mUnpacked.end() ? std::string_view(unpacked->second) : partOfBuffer(view);
  const std::uint64_t length = bytes.size();
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
  array.mData = bytes.data() + start;
}

std::string_view GltfFile::partOfBuffer(const Json& where) const {
  const std::uint64_t buffer = whole(where, "buffer"), offset = whole(where, "byteOffset", 0),
                      length = whole(where, "byteLength");
  if (buffer >= mBuffers.size()) fail("a part of buffer " + std::to_string(buffer) + " is used, and there is none");
  const std::string_view bytes = mBuffers[buffer];
  if (offset > bytes.size() || length > bytes.size() - offset)
    fail("a part of buffer " + std::to_string(buffer) + " does not lie within it");
  return bytes.substr(offset, length);
}

void GltfFile::unpackViews(std::uint64_t& room) {
  for (std::uint64_t i = 0; i < sizeOf("bufferViews"); ++i)
    if (const Json* const compression = meshoptOf(element("bufferViews", i)))
      mUnpacked[i] = unpacked(*compression, room);
}

void GltfFile::unpackPrimitives(std::uint64_t& room) {
  for (std::uint64_t i = 0; i < sizeOf("meshes"); ++i) {
    const auto primitives = element("meshes", i).find("primitives");
    if (primitives == element("meshes", i).end() || !primitives->is_array()) continue;  // which its reader will say
    for (const Json& primitive : *primitives)
      if (primitive.is_object())
        if (const Json* const compression = extensionOf(primitive, {"KHR_draco_mesh_compression"}))
          unpackPrimitive(primitive, *compression, room);
  }
}

void GltfFile::unpackPrimitive(const Json& primitive, const Json& compression, std::uint64_t& room) {
  const auto failHere = [this](const std::string& why) {
    fail("its geometry is compressed (KHR_draco_mesh_compression), and " + why + "; export it without compression");
  };
  constexpr std::uint64_t kTriangles = 4;
  const auto attributes = primitive.find("attributes"), ids = compression.find("attributes");
  if (whole(primitive, "mode", kTriangles) != kTriangles || attributes == primitive.end() || !attributes->is_object() ||
      ids == compression.end() || !ids->is_object() || !primitive.contains("indices"))
    failHere("its description is not that of triangles with indices and attributes");
  const std::uint64_t indices = whole(primitive, "indices");
  if (mDecoded.contains(indices)) return;  // by another primitive of the same geometry
  std::vector<DracoAttribute> wanted;
  std::vector<std::uint64_t> accessors;
  for (const auto& [name, id] : ids->items()) {
    const Json& accessor = element("accessors", whole(*attributes, name.c_str()));
    const GltfArray array = headOf(accessor, name, componentsOf(accessor));
    wanted.push_back({static_cast<std::uint32_t>(whole(*ids, name.c_str())), array.components(),
                      array.isUnsigned() && !array.mNormalized});
    accessors.push_back(whole(*attributes, name.c_str()));
  }
  const Json& view = element("bufferViews", whole(compression, "bufferView"));
  DracoShape shape = decodeDraco(partOfBuffer(view), wanted, room);
  if (!shape.problem.empty()) failHere(shape.problem);
  const auto keep = [this](std::uint64_t accessor, std::string bytes, std::uint64_t count, int components,
                           bool isWhole) {
    Decoded& decoded = mDecoded[accessor];
    decoded.bytes = std::move(bytes);
    GltfArray& array = decoded.array;
    array.mData = decoded.bytes.data();
    array.mCount = count;
    array.mComponents = components;
    array.mType = isWhole ? glb::kUnsignedInt : glb::kFloat;
    array.mStride = sizeOfType(glb::kFloat) * static_cast<std::uint64_t>(components);
  };
  for (std::size_t i = 0; i < wanted.size(); ++i)
    keep(accessors[i], std::move(shape.attributes[i]), shape.points, wanted[i].components, wanted[i].isWhole);
  keep(indices,
       std::string(reinterpret_cast<const char*>(shape.corners.data()), shape.corners.size() * sizeof(std::uint32_t)),
       shape.corners.size(), 1, true);
}

std::string GltfFile::unpacked(const Json& compression, std::uint64_t& room) const {
  constexpr std::uint64_t kMostStride = 256, kMostCount = std::numeric_limits<std::uint32_t>::max();
  const std::string_view packed = partOfBuffer(compression);
  const std::uint64_t count = whole(compression, "count"), stride = whole(compression, "byteStride");
  const auto textOf = [&](const char* name, const char* otherwise) {
    const auto found = compression.find(name);
    return found == compression.end() ? std::string(otherwise) : found->is_string() ? found->get<std::string>() : "";
  };
  const std::string mode = textOf("mode", ""), filter = textOf("filter", "NONE");
  const bool isAttribute = mode == "ATTRIBUTES", isTriangles = mode == "TRIANGLES";
  if (!isAttribute && !isTriangles && mode != "INDICES")
    fail("its geometry is compressed (meshopt) in the mode '" + inOneLine(mode) +
         "', which cannot be read; export it without compression");
  // What the decoders demand.
  const bool fits = isAttribute ? stride > 0 && stride <= kMostStride && stride % 4 == 0
                                : (stride == 2 || stride == 4) && (!isTriangles || count % 3 == 0);
  const bool canFilter =
      filter == "NONE" || (isAttribute && ((filter == "OCTAHEDRAL" && (stride == 4 || stride == 8)) ||
                                           (filter == "QUATERNION" && stride == 8) || filter == "EXPONENTIAL"));
  if (!fits || !canFilter || count > kMostCount)
    fail("its geometry is compressed (meshopt), and the description of that does not fit together; export it again");
  if (count * stride > room)
    fail("its compressed geometry is larger than the file can hold; export it without compression");
  room -= count * stride;
  requireMemory(static_cast<double>(count * stride), MemoryUse::File, mPath.string());
  std::string bytes(count * stride, '\0');
  const auto* const from = reinterpret_cast<const unsigned char*>(packed.data());
  const int result = isAttribute   ? meshopt_decodeVertexBuffer(bytes.data(), count, stride, from, packed.size())
                     : isTriangles ? meshopt_decodeIndexBuffer(bytes.data(), count, stride, from, packed.size())
                                   : meshopt_decodeIndexSequence(bytes.data(), count, stride, from, packed.size());
  if (result != 0)
    fail("its compressed geometry (meshopt) is damaged, or of a later version; export it without compression");
  if (filter == "OCTAHEDRAL") meshopt_decodeFilterOct(bytes.data(), count, stride);
  if (filter == "QUATERNION") meshopt_decodeFilterQuat(bytes.data(), count, stride);
  if (filter == "EXPONENTIAL") meshopt_decodeFilterExp(bytes.data(), count, stride);
  return bytes;
}

GltfArray GltfFile::headOf(const Json& accessor, const std::string& name, int components) const {
  GltfArray array;
  const std::uint64_t type = whole(accessor, "componentType");
  if (sizeOfType(type) == 0 || components == 0) fail(name + " is of a type that cannot be read");
  array.mType = static_cast<int>(type);
  array.mComponents = components;
  array.mNormalized = accessor.value("normalized", Json(false)) == true;
  array.mCount = whole(accessor, "count");
  return array;
}

GltfArray GltfFile::typedArray(const Json& accessor, const std::string& name, int components) const {
  GltfArray array = headOf(accessor, name, components);
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
  if (const auto decoded = mDecoded.find(index); decoded != mDecoded.end()) return decoded->second.array;
  const Json& accessor = element("accessors", index);
  return typedArray(accessor, "accessor " + std::to_string(index), componentsOf(accessor));
}

GltfArray GltfFile::matrices(std::uint64_t index) const {
  const Json& accessor = element("accessors", index);
  const std::string name = "accessor " + std::to_string(index);
  constexpr int kNumbers = 16;
  if (accessor.value("type", Json()) != "MAT4" || whole(accessor, "componentType") != glb::kFloat)
    fail(name + " is not of matrices of floats");
  return typedArray(accessor, name, kNumbers);
}

FileTexts glbTexts(std::istream& stream) {
  FileTexts texts;
  char head[glb::kFileHead + glb::kChunkHead] = {};
  if (!stream.read(head, sizeof head) || std::string_view(head, 4) != kMagic) return texts;
  const auto length = load<std::uint32_t>(head + glb::kFileHead);
  if (load<std::uint32_t>(head + glb::kFileHead + 4) != glb::kJsonChunk) return texts;
  const std::streamoff begin = stream.tellg(), left = stream.seekg(0, std::ios::end).tellg() - begin;
  if (length > left) return texts;
  std::string text(length, '\0');
  if (!stream.seekg(begin).read(text.data(), length)) return texts;
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
