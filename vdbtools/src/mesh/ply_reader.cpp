// SPDX-License-Identifier: Apache-2.0
#include "mesh/format_readers.h"
#include "mesh/polygon.h"
#include "mesh/text_scan.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/base/number_text.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
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

struct Header {
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

Header readHeader(const std::filesystem::path& path, std::string_view contents) {
  Header header;
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

/// The numbers of the body, one after the other, text or binary.
class BodyReader {
 public:
  BodyReader(const std::filesystem::path& path, const Header& header)
      : mPath(path), mFormat(header.format), mRest(header.body) {}

  /// What is being read, for the error's text.
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

  /// A count or an index: whole and not negative.
  std::uint64_t nextWhole(Scalar type, const char* what) {
    const double value = next(type);
    if (!(value >= 0 && value < 4294967296.0 && value == std::floor(value))) {
      fail(std::string(what) + " is " + std::to_string(value) + "; export the mesh again");
    }
    return static_cast<std::uint64_t>(value);
  }

  /// The length of a list, which must fit what is left of the file.
  std::uint64_t nextLength(const Property& list) {
    const std::uint64_t length = nextWhole(*list.countType, "the length of a list");
    if (length * (mFormat == Format::kAscii ? 2 : sizeOf(list.type)) > mRest.size() + 1) truncated();
    return length;
  }

  /// The fewest bytes that @a element takes in the file.
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

void readVertices(BodyReader& body, const Element& element, Mesh& mesh) {
  std::array<int, 3> found{};
  for (const Property& p : element.properties)
    if (const int axis = axisOf(p); axis >= 0) ++found[static_cast<std::size_t>(axis)];
  if (found != std::array{1, 1, 1}) {
    body.fail("vertices need the properties x, y and z, exactly once each; export the mesh again");
  }
  mesh.points.reserve(element.count);  // leastBytes() was checked
  for (std::uint64_t i = 0; i < element.count; ++i) {
    body.setIndex(i);
    openvdb::Vec3d point;
    for (const Property& p : element.properties) {
      const int axis = axisOf(p);
      if (axis < 0) {
        body.skip(p.type, p.countType ? body.nextLength(p) : 1);
        continue;
      }
      point[axis] = body.next(p.type);
      if (!std::isfinite(point[axis])) {
        body.fail("the coordinate " + p.name + " is " + std::to_string(point[axis]) +
                  "; repair the mesh and export it again");
      }
    }
    mesh.points.push_back(point);
  }
}

void readFaces(BodyReader& body, const Element& element, std::uint64_t points, Polygons& polygons) {
  if (std::count_if(element.properties.begin(), element.properties.end(), isIndexList) != 1) {
    body.fail("faces need the list 'vertex_indices', exactly once; export the mesh again");
  }
  std::vector<std::uint32_t> corners;
  for (std::uint64_t i = 0; i < element.count; ++i) {
    body.setIndex(i);
    for (const Property& p : element.properties) {
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
      polygons.add(corners);
    }
  }
}

}  // namespace

Mesh readPly(const std::filesystem::path& path, std::string_view contents) {
  const Header header = readHeader(path, contents);
  BodyReader body(path, header);
  std::uint64_t points = 0;
  std::uint64_t bytes = 0;
  bool hasStrips = false;
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
    hasStrips = hasStrips || element.name == "tristrips";
  }
  if (bytes > header.body.size() + 1) {
    throw DataError(path.string() + ": the header announces at least " + std::to_string(bytes) + " bytes, but " +
                    std::to_string(header.body.size()) + " follow; the file is truncated: export it again");
  }

  Mesh mesh;
  Polygons polygons;
  for (const Element& element : header.elements) {
    body.setElement(element);
    body.setIndex(0);
    if (element.name == "vertex") {
      readVertices(body, element, mesh);
    } else if (element.name == "face" && element.count > 0) {
      readFaces(body, element, points, polygons);
    } else if (!element.properties.empty()) {
      for (std::uint64_t i = 0; i < element.count; ++i) {
        body.setIndex(i);
        for (const Property& p : element.properties) body.skip(p.type, p.countType ? body.nextLength(p) : 1);
      }
    }
  }
  if (polygons.empty() && hasStrips) {
    throw DataError(path.string() + ": triangle strips cannot be read; export the mesh with faces");
  }
  polygons.triangulate(mesh);
  return mesh;
}

}  // namespace vdbtools
