// SPDX-License-Identifier: Apache-2.0
#include "mesh/polygon.h"
#include "mesh_files/mesh_formats.h"
#include "mesh_files/text_scan.h"
#include "mesh_files/usable_points.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/base/text.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <numeric>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace vdbtools {
namespace {

enum class Format { kAscii, kLittleEndian, kBigEndian };
enum class Scalar { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat32, kFloat64 };

struct Property {
  std::string name;
  Scalar type = Scalar::kFloat32;
  std::optional<Scalar> countType;  ///< of a list
};

struct Element {
  std::string name;
  std::uint64_t count = 0;
  std::vector<Property> properties;
};

struct PlyHeader {
  Format format = Format::kAscii;
  std::vector<Element> elements;
  std::string_view body;
  std::size_t lines = 0;
};

std::size_t sizeOf(Scalar type) {
  switch (type) {
    case Scalar::kInt8:
    case Scalar::kUint8: return 1;
    case Scalar::kInt16:
    case Scalar::kUint16: return 2;
    case Scalar::kInt32:
    case Scalar::kUint32:
    case Scalar::kFloat32: return 4;
    case Scalar::kFloat64: return 8;
  }
  return 0;
}

Scalar scalarFrom(const LineScanner& lines, std::string_view word) {
  if (word == "char" || word == "int8") return Scalar::kInt8;
  if (word == "uchar" || word == "uint8") return Scalar::kUint8;
  if (word == "short" || word == "int16") return Scalar::kInt16;
  if (word == "ushort" || word == "uint16") return Scalar::kUint16;
  if (word == "int" || word == "int32") return Scalar::kInt32;
  if (word == "uint" || word == "uint32") return Scalar::kUint32;
  if (word == "float" || word == "float32") return Scalar::kFloat32;
  if (word == "double" || word == "float64") return Scalar::kFloat64;
  lines.fail("the property type " + shown(word) + " is not one of PLY's; export the mesh again");
}

PlyHeader readPlyHeader(const std::filesystem::path& path, std::string_view contents) {
  PlyHeader header;
  LineScanner lines(path, contents);
  const auto first = lines.next();
  if (!first || WordScanner(*first).next() != "ply") lines.fail("this is not PLY, whose first line is 'ply'");
  bool hasFormat = false;
  while (const auto line = lines.next()) {
    WordScanner words(*line);
    const std::string_view keyword = words.next();
    if (keyword == "format") {
      const std::string_view name = words.next();
      if (name == "ascii") {
        header.format = Format::kAscii;
      } else if (name == "binary_little_endian") {
        header.format = Format::kLittleEndian;
      } else if (name == "binary_big_endian") {
        header.format = Format::kBigEndian;
      } else {
        lines.fail("the PLY format " + shown(name) + " is not known; export the mesh again");
      }
      hasFormat = true;
    } else if (keyword == "element") {
      Element element;
      element.name = words.next();
      const long long count = lines.integer(words.next());
      if (count < 0) lines.fail("the count " + std::to_string(count) + " is negative; export the mesh again");
      element.count = static_cast<std::uint64_t>(count);
      header.elements.push_back(std::move(element));
    } else if (keyword == "property") {
      if (header.elements.empty()) lines.fail("a property stands before the first element; export the mesh again");
      Property property;
      std::string_view type = words.next();
      if (type == "list") {
        property.countType = scalarFrom(lines, words.next());
        type = words.next();
      }
      property.type = scalarFrom(lines, type);
      property.name = words.next();
      header.elements.back().properties.push_back(std::move(property));
    } else if (keyword == "end_header") {
      if (!hasFormat) lines.fail("the PLY header names no format; export the mesh again");
      header.body = lines.rest();
      header.lines = lines.lineNumber();
      return header;
    } else if (!keyword.empty() && keyword != "comment" && keyword != "obj_info") {
      lines.fail(shown(keyword) + " is not a keyword of PLY headers; export the mesh again");
    }
  }
  lines.fail("the file ends within its header; it is truncated: export it again");
}

/// Reads the numbers of the body in order, from text or binary.
class BodyReader {
 public:
  BodyReader(const std::filesystem::path& path, const PlyHeader& header)
      : mPath(path), mFormat(header.format), mRest(header.body) {}

  /// Sets the element being read, for error messages.
  void setElement(const Element& element) { mElement = &element; }
  void setIndex(std::uint64_t index) { mIndex = index; }

  double next(Scalar type) { return mFormat == Format::kAscii ? nextWord() : nextBytes(type); }

  void skip(Scalar type, std::uint64_t count) {
    if (mFormat == Format::kAscii) {
      for (std::uint64_t i = 0; i < count; ++i) word();
    } else {
      if (count > mRest.size() / sizeOf(type)) truncated();
      mRest.remove_prefix(count * sizeOf(type));
    }
  }

  /// Reads a count or an index, which must be a non-negative integer.
  std::uint64_t nextWhole(Scalar type, const char* what) { return wholeFrom(next(type), what); }

  /// Reads an index of a triangle strip; none for the -1 that ends a strip.
  std::optional<std::uint64_t> nextOfStrip(Scalar type) {
    const double value = next(type);
    if (value == -1) return std::nullopt;
    return wholeFrom(value, "the index of a point");
  }

  /// Reads the length of a list, which must fit the rest of the file.
  std::uint64_t nextLength(const Property& list) {
    const std::uint64_t length = nextWhole(*list.countType, "the length of a list");
    if (length * (mFormat == Format::kAscii ? 2 : sizeOf(list.type)) > mRest.size() + 1) truncated();
    return length;
  }

  /// The minimum number of bytes of @a element in the file.
  std::uint64_t leastBytes(const Element& element) const {
    std::uint64_t bytes = 0;
    for (const Property& p : element.properties) {
      bytes += mFormat == Format::kAscii ? 2 : sizeOf(p.countType.value_or(p.type));
    }
    return bytes;
  }

  std::size_t left() const { return mRest.size(); }

  [[noreturn]] void fail(const std::string& what) const {
    throw DataError(mPath.string() + ": " + mElement->name + " " + std::to_string(mIndex) + ": " + what);
  }

 private:
  std::uint64_t wholeFrom(double value, const char* what) const {
    if (!(value >= 0 && value < 4294967296.0 && value == std::floor(value))) {
      fail(std::string(what) + " is " + std::to_string(value) + "; export the mesh again");
    }
    return static_cast<std::uint64_t>(value);
  }

  [[noreturn]] void truncated() const {
    fail("the file ends here, though its header announces " + std::to_string(mElement->count) +
         " of these; it is truncated: export it again");
  }

  std::string_view word() {
    constexpr std::string_view kBlank = " \t\r\n\v\f";
    const std::size_t begin = mRest.find_first_not_of(kBlank);
    if (begin == std::string_view::npos) truncated();
    const std::size_t end = std::min(mRest.find_first_of(kBlank, begin), mRest.size());
    const std::string_view result = mRest.substr(begin, end - begin);
    mRest.remove_prefix(end);
    return result;
  }

  double nextWord() {
    const std::string_view text = word();
    const auto value = numberFromText(text);
    if (!value) fail(shown(text) + " stands where a number is expected; export the mesh again");
    return *value;
  }

  template <typename T>
  double nextAs() {
    if (mRest.size() < sizeof(T)) truncated();
    unsigned char bytes[sizeof(T)];
    std::memcpy(bytes, mRest.data(), sizeof(T));
    mRest.remove_prefix(sizeof(T));
    if ((mFormat == Format::kBigEndian) != (std::endian::native == std::endian::big)) {
      std::reverse(bytes, bytes + sizeof(T));
    }
    T value;
    std::memcpy(&value, bytes, sizeof(T));
    return static_cast<double>(value);
  }

  double nextBytes(Scalar type) {
    switch (type) {
      case Scalar::kInt8: return nextAs<std::int8_t>();
      case Scalar::kUint8: return nextAs<std::uint8_t>();
      case Scalar::kInt16: return nextAs<std::int16_t>();
      case Scalar::kUint16: return nextAs<std::uint16_t>();
      case Scalar::kInt32: return nextAs<std::int32_t>();
      case Scalar::kUint32: return nextAs<std::uint32_t>();
      case Scalar::kFloat32: return nextAs<float>();
      case Scalar::kFloat64: return nextAs<double>();
    }
    return 0;
  }

  const std::filesystem::path& mPath;
  Format mFormat;
  std::string_view mRest;
  const Element* mElement = nullptr;
  std::uint64_t mIndex = 0;
};

int axisOf(const Property& property) {
  return property.countType || property.name.size() != 1 ? -1
                                                         : static_cast<int>(std::string("xyz").find(property.name));
}

bool isIndexList(const Property& property) {
  return property.countType && (property.name == "vertex_indices" || property.name == "vertex_index");
}

/// The integer that represents 1 in colour channels; 1 for all other numbers.
double oneOf(const Property& property) {
  constexpr std::array<std::string_view, 4> kChannels{"red", "green", "blue", "alpha"};
  if (std::find(kChannels.begin(), kChannels.end(), property.name) == kChannels.end()) return 1;
  switch (property.type) {
    case Scalar::kInt8: return std::numeric_limits<std::int8_t>::max();
    case Scalar::kUint8: return std::numeric_limits<std::uint8_t>::max();
    case Scalar::kInt16: return std::numeric_limits<std::int16_t>::max();
    case Scalar::kUint16: return std::numeric_limits<std::uint16_t>::max();
    case Scalar::kInt32: return std::numeric_limits<std::int32_t>::max();
    case Scalar::kUint32: return std::numeric_limits<std::uint32_t>::max();
    case Scalar::kFloat32:
    case Scalar::kFloat64: break;
  }
  return 1;
}

/// The destination of a vertex's property: a coordinate, an attribute, or none.
struct Slot {
  int axis = -1;
  std::optional<std::size_t> attribute{};
  double one = 1;  ///< divisor of an attribute
};

/// @param mesh  receives the attributes that it lacks
std::vector<Slot> slotsOf(const Element& element, Mesh& mesh) {
  std::vector<Slot> slots;
  for (const Property& p : element.properties) {
    Slot& slot = slots.emplace_back(Slot{.axis = axisOf(p), .one = oneOf(p)});
    if (slot.axis >= 0 || p.countType || p.name == "nx" || p.name == "ny" || p.name == "nz") continue;
    const auto found = std::find_if(mesh.attributes.begin(), mesh.attributes.end(),
                                    [&p](const VertexAttribute& attribute) { return attribute.name == p.name; });
    const std::size_t index = static_cast<std::size_t>(found - mesh.attributes.begin());
    const bool isTaken = std::any_of(slots.begin(), slots.end(), [&](const Slot& s) { return s.attribute == index; });
    if (isTaken) continue;  // the first property of a name counts
    if (found == mesh.attributes.end()) mesh.attributes.push_back({p.name, {}});
    slot.attribute = index;
  }
  for (VertexAttribute& attribute : mesh.attributes) {
    attribute.values.resize(mesh.points.size(), kNoNumber);
    attribute.values.reserve(mesh.points.size() + element.count);
  }
  return slots;
}

void readVertices(BodyReader& body, const Element& element, Mesh& mesh) {
  std::array<int, 3> found{};
  for (const Property& p : element.properties)
    if (const int axis = axisOf(p); axis >= 0) ++found[static_cast<std::size_t>(axis)];
  if (found != std::array{1, 1, 1}) {
    body.fail("vertices need the properties x, y and z, exactly once each; export the mesh again");
  }
  mesh.points.reserve(mesh.points.size() + element.count);  // leastBytes() was checked
  const std::vector<Slot> slots = slotsOf(element, mesh);
  for (std::uint64_t i = 0; i < element.count; ++i) {
    body.setIndex(i);
    openvdb::Vec3d point;
    for (std::size_t k = 0; k < slots.size(); ++k) {
      const Property& p = element.properties[k];
      const Slot& slot = slots[k];
      if (slot.attribute) {
        mesh.attributes[*slot.attribute].values.push_back(static_cast<float>(body.next(p.type) / slot.one));
        continue;
      }
      if (slot.axis < 0) {
        body.skip(p.type, p.countType ? body.nextLength(p) : 1);
        continue;
      }
      point[slot.axis] = body.next(p.type);
    }
    mesh.points.push_back(point);
  }
  for (VertexAttribute& attribute : mesh.attributes) attribute.values.resize(mesh.points.size(), kNoNumber);
}

/// Moves the texture coordinates of the vertices, if there are any, out of the attributes.
std::vector<openvdb::Vec2s> takeVertexUvs(Mesh& mesh) {
  constexpr std::pair<std::string_view, std::string_view> kNames[] = {
      {"s", "t"}, {"u", "v"}, {"texture_u", "texture_v"}};
  std::vector<openvdb::Vec2s> uvs;
  for (const auto& [first, second] : kNames) {
    const auto find = [&mesh](std::string_view name) {
      return std::find_if(mesh.attributes.begin(), mesh.attributes.end(),
                          [name](const VertexAttribute& attribute) { return attribute.name == name; });
    };
    const auto u = find(first), v = find(second);
    if (u == mesh.attributes.end() || v == mesh.attributes.end()) continue;
    for (std::size_t p = 0; p < mesh.points.size(); ++p) uvs.emplace_back(u->values[p], v->values[p]);
    const std::string_view names[] = {first, second};
    std::erase_if(mesh.attributes, [&names](const VertexAttribute& attribute) {
      return attribute.name == names[0] || attribute.name == names[1];
    });
    break;
  }
  return uvs;
}

bool isUvList(const Property& property) { return property.countType && property.name == "texcoord"; }

/// @param uvs  receives the texture coordinates of corners, from a list u v u v ... as written by MeshLab
void readFaceUvs(BodyReader& body, const Property& list, std::vector<openvdb::Vec2s>& uvs) {
  const std::uint64_t length = body.nextLength(list);
  if (length % 2 != 0) body.fail("its texture coordinates are " + std::to_string(length) + "; export the mesh again");
  for (std::uint64_t i = 0; i < length; i += 2) {
    const double u = body.next(list.type), v = body.next(list.type);
    uvs.emplace_back(static_cast<float>(u), static_cast<float>(v));
  }
}

void readFaces(BodyReader& body, const Element& element, std::uint64_t points, Polygons& polygons,
               std::vector<openvdb::Vec2s>& uvs) {
  if (std::count_if(element.properties.begin(), element.properties.end(), isIndexList) != 1) {
    body.fail("faces need the list 'vertex_indices', exactly once; export the mesh again");
  }
  polygons.reserve(element.count);  // leastBytes() was checked
  std::vector<std::uint32_t> corners, uvIndices;
  for (std::uint64_t i = 0; i < element.count; ++i) {
    body.setIndex(i);
    const std::size_t firstUv = uvs.size();
    for (const Property& p : element.properties) {
      if (isUvList(p)) {
        readFaceUvs(body, p, uvs);
        continue;
      }
      if (!isIndexList(p)) {
        body.skip(p.type, p.countType ? body.nextLength(p) : 1);
        continue;
      }
      const std::uint64_t length = body.nextLength(p);
      if (length < 3) body.fail("it has " + std::to_string(length) + " corners; repair the mesh and export it again");
      corners.clear();
      for (std::uint64_t c = 0; c < length; ++c) {
        const std::uint64_t index = body.nextWhole(p.type, "the index of a point");
        if (index >= points) {
          body.fail("it refers to point " + std::to_string(index) + ", but there are only " + std::to_string(points) +
                    "; export the mesh again");
        }
        corners.push_back(static_cast<std::uint32_t>(index));
      }
    }
    if (uvs.size() == firstUv) {
      polygons.add(corners);
      continue;
    }
    if (uvs.size() - firstUv != corners.size()) {
      body.fail("it has " + std::to_string(corners.size()) + " corners, and texture coordinates for " +
                std::to_string(uvs.size() - firstUv) + "; export the mesh again");
    }
    uvIndices.resize(corners.size());
    std::iota(uvIndices.begin(), uvIndices.end(), static_cast<std::uint32_t>(firstUv));
    polygons.add(corners, uvIndices);
  }
}

/// Reads triangle strips, as the Stanford scans have them: lists of points, in which -1 ends a strip. Each point from
/// the third one of a strip on makes a triangle with the two before it. Every second triangle is turned round, so that
/// all of a strip have its orientation. Triangles that repeat a point only lead from one place to the next.
void readStrips(BodyReader& body, const Element& element, std::uint64_t points, Polygons& polygons) {
  constexpr std::uint32_t kNone = 0xffffffff;
  if (std::count_if(element.properties.begin(), element.properties.end(), isIndexList) != 1) {
    body.fail("triangle strips need the list 'vertex_indices', exactly once; export the mesh again");
  }
  for (std::uint64_t i = 0; i < element.count; ++i) {
    body.setIndex(i);
    for (const Property& p : element.properties) {
      const std::uint64_t length = p.countType ? body.nextLength(p) : 1;
      if (!isIndexList(p)) {
        body.skip(p.type, length);
        continue;
      }
      std::array<std::uint32_t, 2> before{kNone, kNone};
      bool isTurned = false;
      for (std::uint64_t c = 0; c < length; ++c) {
        const std::optional<std::uint64_t> index = body.nextOfStrip(p.type);
        if (!index) {
          before = {kNone, kNone};
          isTurned = false;
          continue;
        }
        if (*index >= points) {
          body.fail("it refers to point " + std::to_string(*index) + ", but there are only " + std::to_string(points) +
                    "; export the mesh again");
        }
        const auto at = static_cast<std::uint32_t>(*index);
        if (before[0] != kNone) {
          if (before[0] != before[1] && before[1] != at && at != before[0])
            polygons.add(std::array{before[isTurned ? 1 : 0], before[isTurned ? 0 : 1], at});
          isTurned = !isTurned;
        }
        before = {before[1], at};
      }
    }
  }
}

}  // namespace

bool beginsAsPly(std::string_view head, std::uintmax_t) { return head.starts_with("ply"); }

Mesh readPly(const std::filesystem::path& path, std::string_view contents) {
  const PlyHeader header = readPlyHeader(path, contents);
  BodyReader body(path, header);
  std::uint64_t points = 0;
  std::uint64_t bytes = 0;
  bool hasFaces = false;
  for (const Element& element : header.elements) {
    // Counts are compared with the file before anything is reserved or looped over.
    body.setElement(element);
    const std::uint64_t least = body.leastBytes(element);
    if (least > 0 && element.count > (header.body.size() + 1) / least) {
      throw DataError(path.string() + ": the header announces " + std::to_string(element.count) + " of element " +
                      shown(element.name) + ", which do not fit the " + std::to_string(header.body.size()) +
                      " bytes that follow; the file is damaged or truncated: export it again");
    }
    bytes += element.count * least;
    if (element.name == "vertex") points += element.count;
    hasFaces = hasFaces || (element.name == "face" && element.count > 0);
  }
  if (bytes > header.body.size() + 1) {
    throw DataError(path.string() + ": the header announces at least " + std::to_string(bytes) + " bytes, but " +
                    std::to_string(header.body.size()) + " follow; the file is truncated: export it again");
  }

  Mesh mesh;
  Polygons polygons;
  std::vector<openvdb::Vec2s> faceUvs;
  for (const Element& element : header.elements) {
    body.setElement(element);
    body.setIndex(0);
    if (element.name == "vertex") {
      readVertices(body, element, mesh);
    } else if (element.name == "face" && element.count > 0) {
      readFaces(body, element, points, polygons, faceUvs);
    } else if (element.name == "tristrips" && !hasFaces) {  // strips beside faces say the same once more
      readStrips(body, element, points, polygons);
    } else if (!element.properties.empty()) {
      for (std::uint64_t i = 0; i < element.count; ++i) {
        body.setIndex(i);
        for (const Property& p : element.properties) body.skip(p.type, p.countType ? body.nextLength(p) : 1);
      }
    }
  }
  const std::vector<openvdb::Vec2s> vertexUvs = takeVertexUvs(mesh);
  polygons.triangulate(mesh, faceUvs);
  if (faceUvs.empty() && !vertexUvs.empty()) {
    mesh.cornerUvs.reserve(3 * mesh.triangles.size());
    for (const openvdb::Vec3I& t : mesh.triangles)
      for (int c = 0; c < 3; ++c) mesh.cornerUvs.push_back(vertexUvs[t[c]]);
  }
  leaveOutUnusable(path, mesh);
  return mesh;
}

}  // namespace vdbtools
