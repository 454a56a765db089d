// SPDX-License-Identifier: Apache-2.0
// 3MF as it is read: a zip of XML (3MF Core Specification 1.3), whose model may be spread over several files of the zip
// (3MF Production Extension 1.1).
#include "mesh_files/gltf_pose.h"
#include "mesh_files/mesh_formats.h"
#include "mesh_files/usable_points.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/base/units.h"
#include "vdbtools/mesh_files/mesh_writer.h"

#include <istream>
#include <iterator>
#include <string>
#include <string_view>

#ifdef VDBTOOLS_3MF_READER
#include "vdbtools/base/memory.h"
#include "vdbtools/base/text.h"
#include "vdbtools/files/file_bytes.h"

#include <expat.h>
#include <zip.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <exception>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <new>
#include <optional>
#include <set>
#include <utility>
#include <vector>
#endif

namespace vdbtools {

#ifndef VDBTOOLS_3MF_READER

bool canRead3mf() { return false; }

Mesh read3mf(const std::filesystem::path& path, std::string_view) {
  throw DataError(path.string() + ": this program was built without reading 3MF: " VDBTOOLS_NO_3MF_READER
                                  "; export the mesh as .obj");
}

std::string unitOf3mf(const std::filesystem::path&, std::string_view) { return {}; }

#else

namespace {

using openvdb::Vec3d;

constexpr std::string_view kCore3mf = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02",
                           kProduction3mf = "http://schemas.microsoft.com/3dmanufacturing/production/2015/06",
                           kMaterial3mf = "http://schemas.microsoft.com/3dmanufacturing/material/2015/02",
                           kModelRelation = "http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel";

/// Between the namespace of a name and the name itself, as expat gives them.
constexpr char kNameMark = '|';

/// How many times its size a zip may have without compression, beyond what a small one may have. Meshes come to 5
/// to 20.
constexpr std::uint64_t kMostExpansion = 200, kFreeExpansion = 64 << 20;

/// As in glTF, parts that occur several times count each time, and a small file must not become a mesh that fills the
/// memory.
constexpr std::uint64_t kMostRepeated3mf = 10'000'000, kMostObjects = 1'000'000;
constexpr int kMostComponentLevels = 64;

[[noreturn]] void fail3mf(const std::filesystem::path& path, const std::string& what) {
  throw DataError(path.string() + ": " + what);
}

/// The attributes of an element.
class XmlAttributes {
 public:
  XmlAttributes(const std::filesystem::path& path, std::string_view element, const char* const* list)
      : mPath(path), mElement(element), mList(list) {}

  std::optional<std::string_view> find(std::string_view name) const {
    for (const char* const* entry = mList; *entry; entry += 2)
      if (*entry == name) return trimmed(entry[1]);
    return std::nullopt;
  }

  std::string_view get(std::string_view name) const {
    const auto value = find(name);
    if (!value)
      fail3mf(mPath, "a '" + std::string(mElement) + "' has no '" + std::string(name) + "'; export the mesh again");
    return *value;
  }

  double number(std::string_view name) const {
    const auto value = numberFromText(get(name));
    if (!value) refuse(name, "a number");
    return *value;
  }

  std::uint32_t whole(std::string_view name) const {
    const auto value = wholeFromText<std::uint32_t>(get(name));
    if (!value) refuse(name, "a whole number");
    return *value;
  }

  /// The attribute 'transform'; rows of three numbers, the last of which is the translation.
  Placement transform() const {
    Placement result;
    std::string_view rest = find("transform").value_or("1 0 0 0 1 0 0 0 1 0 0 0");
    for (Vec3d& column : result.columns)
      for (int axis = 0; axis < 3; ++axis) {
        const std::size_t end = std::min(rest.find_first_of(kXmlBlank), rest.size());
        const auto value = numberFromText(rest.substr(0, end));
        if (!value || !std::isfinite(*value)) refuse("transform", "a list of 12 numbers");
        column[axis] = *value;
        rest = trimmed(rest.substr(end));
      }
    if (!rest.empty()) refuse("transform", "a list of 12 numbers");
    return result;
  }

 private:
  static constexpr std::string_view kXmlBlank = " \t\r\n";

  static std::string_view trimmed(std::string_view text) {
    text.remove_prefix(std::min(text.find_first_not_of(kXmlBlank), text.size()));
    return text.substr(0, text.find_last_not_of(kXmlBlank) + 1);
  }

  [[noreturn]] void refuse(std::string_view name, const std::string& what) const {
    fail3mf(mPath, "'" + std::string(name) + "' of a '" + std::string(mElement) + "' is '" + inOneLine(get(name)) +
                       "', which is not " + what + "; export the mesh again");
  }

  const std::filesystem::path& mPath;
  std::string_view mElement;
  const char* const* mList;
};

// Expat 2.9 deprecates the functions of older versions.
#if XML_MAJOR_VERSION > 2 || (XML_MAJOR_VERSION == 2 && XML_MINOR_VERSION >= 9)
std::int64_t byteOf(XML_Parser parser) { return XML_GetCurrentByteIndex64(parser); }
std::uint64_t lineOf(XML_Parser parser) { return XML_GetCurrentLineNumber64(parser); }
#else
std::int64_t byteOf(XML_Parser parser) { return XML_GetCurrentByteIndex(parser); }
std::uint64_t lineOf(XML_Parser parser) { return XML_GetCurrentLineNumber(parser); }
#endif

/// What is done with the elements of an XML file. Names of the core specification come without their namespace.
struct XmlElements {
  std::function<void(std::string_view name, const XmlAttributes& attributes)> begin;
  std::function<void(std::string_view name)> end = [](std::string_view) {};
  std::function<void(std::string_view prefix, std::string_view uri)> space = [](std::string_view, std::string_view) {};
};

/// Parses one XML file, piece by piece. It must have no document type, which 3MF forbids and which alone could declare
/// entities.
class XmlParser {
 public:
  /// @param elements, path  must outlive this
  XmlParser(const std::filesystem::path& path, const std::string& part, const XmlElements& elements)
      : mPath(path), mPart(part), mElements(elements), mParser(XML_ParserCreateNS(nullptr, kNameMark), XML_ParserFree) {
    if (!mParser) throw std::bad_alloc();
    XML_SetUserData(mParser.get(), this);
    XML_SetElementHandler(
        mParser.get(),
        [](void* self, const XML_Char* name, const XML_Char** list) {
          static_cast<XmlParser*>(self)->call([&](XmlParser& parser) {
            const std::string_view element = ownName(name);
            parser.mElements.begin(element, XmlAttributes(parser.mPath, element, list));
          });
        },
        [](void* self, const XML_Char* name) {
          static_cast<XmlParser*>(self)->call([&](XmlParser& parser) { parser.mElements.end(ownName(name)); });
        });
    XML_SetStartNamespaceDeclHandler(mParser.get(), [](void* self, const XML_Char* prefix, const XML_Char* uri) {
      static_cast<XmlParser*>(self)->call(
          [&](XmlParser& parser) { parser.mElements.space(prefix ? prefix : "", uri ? uri : ""); });
    });
    XML_SetStartDoctypeDeclHandler(
        mParser.get(), [](void* self, const XML_Char*, const XML_Char*, const XML_Char*, int) {
          static_cast<XmlParser*>(self)->call(
              [](XmlParser& parser) { parser.fail("it has a document type, which 3MF forbids"); });
        });
  }

  /// @param isLast  whether no more pieces follow
  void parse(std::string_view piece, bool isLast) {
    mGiven += static_cast<std::int64_t>(piece.size());
    if (XML_Parse(mParser.get(), piece.data(), static_cast<int>(piece.size()), isLast) == XML_STATUS_OK) {
      if (!isLast && mGiven - byteOf(mParser.get()) > kLongestTag) fail("a tag of it does not end");
      return;
    }
    if (mThrown) std::rethrow_exception(mThrown);
    const XML_Error error = XML_GetErrorCode(mParser.get());
    if (error == XML_ERROR_NO_MEMORY) throw std::bad_alloc();
    fail(std::string("it is not valid XML: ") + XML_ErrorString(error));
  }

 private:
  /// Bytes. Expat before 2.6 begins a tag anew with each piece that does not end it.
  static constexpr std::int64_t kLongestTag = 1 << 20;

  static std::string_view ownName(std::string_view name) {
    const std::size_t mark = kCore3mf.size();
    return name.starts_with(kCore3mf) && name.size() > mark && name[mark] == kNameMark ? name.substr(mark + 1) : name;
  }

  [[noreturn]] void fail(const std::string& what) const {
    fail3mf(mPath, "its '" + inOneLine(mPart) + "', line " + std::to_string(lineOf(mParser.get())) + ": " + what +
                       "; export the mesh again");
  }

  /// Keeps what is thrown from passing through expat, which is C.
  template <class Action>
  void call(const Action& action) {
    if (mThrown) return;
    try {
      action(*this);
    } catch (...) {
      mThrown = std::current_exception();
      XML_StopParser(mParser.get(), XML_FALSE);
    }
  }

  const std::filesystem::path& mPath;
  std::string mPart;
  const XmlElements& mElements;
  std::unique_ptr<XML_ParserStruct, decltype(&XML_ParserFree)> mParser;
  std::int64_t mGiven = 0;  ///< bytes
  std::exception_ptr mThrown;
};

/// The files of a zip that is held in memory.
class ZipParts {
 public:
  /// @param path, contents  must outlive this
  ZipParts(const std::filesystem::path& path, std::string_view contents)
      : mPath(path), mLeft(kMostExpansion * contents.size() + kFreeExpansion) {
    zip_error_t error;
    zip_error_init(&error);
    zip_source_t* const source = zip_source_buffer_create(contents.data(), contents.size(), 0, &error);
    if (source) {
      mZip.reset(zip_open_from_source(source, ZIP_RDONLY, &error));
      if (!mZip) zip_source_free(source);
    }
    if (mZip) return;
    const bool isMemory = zip_error_code_zip(&error) == ZIP_ER_MEMORY;
    const std::string why = zip_error_strerror(&error);
    zip_error_fini(&error);
    if (isMemory) throw std::bad_alloc();
    fail3mf(mPath, "the zip that a 3MF is cannot be read (" + why +
                       "); the file is damaged or truncated: export the mesh again");
  }

  /// Parses one of the files, until there is nothing left or @a isEnough is true.
  void parse(const std::string& part, const XmlElements& elements, const bool& isEnough) {
    const zip_int64_t index = zip_name_locate(mZip.get(), part.c_str(), ZIP_FL_NOCASE);
    if (index < 0)
      fail3mf(mPath, "there is no '" + inOneLine(part) + "' in it; it is no 3MF, or damaged: export the mesh again");
    const std::unique_ptr<zip_file_t, decltype(&zip_fclose)> file(
        zip_fopen_index(mZip.get(), static_cast<zip_uint64_t>(index), 0), zip_fclose);
    if (!file) broken(part, zip_get_error(mZip.get()));
    XmlParser parser(mPath, part, elements);
    std::vector<char> piece(kPiece);
    while (!isEnough) {
      const zip_int64_t count = zip_fread(file.get(), piece.data(), piece.size());
      if (count < 0) broken(part, zip_file_get_error(file.get()));
      const auto bytes = static_cast<std::uint64_t>(count);
      if (bytes > mLeft)
        fail3mf(mPath, "its content is more than " + std::to_string(kMostExpansion) +
                           " times as large as the file, which no mesh is; export the mesh again");
      mLeft -= bytes;
      parser.parse({piece.data(), bytes}, bytes == 0);
      if (bytes == 0) return;
    }
  }

 private:
  static constexpr std::size_t kPiece = 1 << 16;

  [[noreturn]] void broken(const std::string& part, zip_error_t* error) const {
    if (zip_error_code_zip(error) == ZIP_ER_MEMORY) throw std::bad_alloc();
    fail3mf(mPath, "its '" + inOneLine(part) + "' cannot be unpacked (" + zip_error_strerror(error) +
                       "); the file is damaged or encrypted: export the mesh again");
  }

  struct Discard {
    void operator()(zip_t* zip) const { zip_discard(zip); }
  };

  const std::filesystem::path& mPath;
  std::uint64_t mLeft;  ///< bytes that may still be unpacked
  std::unique_ptr<zip_t, Discard> mZip;
};

/// An object's name: the file of the zip that has it, and its number there.
using ObjectName = std::pair<std::string, std::uint32_t>;

struct PlacedObject {
  ObjectName name;
  Placement placement;
};

struct Object3mf {
  Mesh mesh{};
  bool isShape = true;  ///< and not a support
  std::vector<PlacedObject> components{};
};

/// A part's name as the zip has it, without the slash.
std::string partName(std::string_view name) {
  while (name.starts_with('/')) name.remove_prefix(1);
  return std::string(name);
}

/// The part of a zip that holds the model.
std::string modelPart(ZipParts& zip, const std::filesystem::path& path) {
  std::string target;
  bool isFound = false;
  const XmlElements elements{.begin = [&](std::string_view name, const XmlAttributes& attributes) {
    constexpr std::string_view kRelationship = "|Relationship";
    if (isFound || !name.ends_with(kRelationship) || attributes.find("Type") != kModelRelation) return;
    target = partName(attributes.get("Target"));
    isFound = true;
  }};
  zip.parse("_rels/.rels", elements, isFound);
  if (!isFound) fail3mf(path, "its '_rels/.rels' names no 3D model; it is no 3MF: export the mesh again");
  return target;
}

/// Reads the objects and what is built of them.
class Model3mf {
 public:
  Model3mf(const std::filesystem::path& path, std::string_view contents) : mPath(path), mZip(path, contents) {}

  Mesh read() {
    const std::string root = modelPart(mZip, mPath);
    std::vector<std::string> open{root};
    std::set<std::string> known{root};
    while (!open.empty()) {
      const std::string part = std::move(open.back());
      open.pop_back();
      readPart(part, part == root);
      for (const std::string& name : std::exchange(mNamed, {}))
        if (known.insert(name).second) open.push_back(name);
    }
    for (const PlacedObject& item : mItems) place(item, 0);
    leaveOutUnusable(mPath, mMesh);
    return std::move(mMesh);
  }

 private:
  void readPart(const std::string& part, bool isRoot) {
    std::map<std::string, std::string> spaces;  // of the root, by their prefixes
    bool isInModel = false;
    Object3mf* object = nullptr;
    const XmlElements elements{.begin =
                                   [&](std::string_view name, const XmlAttributes& attributes) {
                                     if (name == "vertex" && object) {
                                       addVertex(object->mesh, attributes);
                                     } else if (name == "triangle" && object) {
                                       addTriangle(object->mesh, attributes);
                                     } else if (name == "component" && object) {
                                       object->components.push_back(placedObject(part, attributes));
                                     } else if (name == "object") {
                                       if (object)
                                         fail3mf(mPath, "an object begins within another; export the mesh again");
                                       object = &beginObject({part, attributes.whole("id")}, attributes);
                                     } else if (name == "item" && isRoot) {
                                       mItems.push_back(placedObject(part, attributes));
                                     } else if (name == "model") {
                                       isInModel = true;
                                       requireKnown(attributes.find("requiredextensions").value_or(""), spaces);
                                     }
                                   },
                               .end =
                                   [&](std::string_view name) {
                                     if (name != "object" || !object) return;
                                     finishObject(*object);
                                     object = nullptr;
                                   },
                               .space =
                                   [&](std::string_view prefix, std::string_view uri) {
                                     if (!isInModel) spaces[std::string(prefix)] = uri;
                                   }};
    bool isEnough = false;
    mZip.parse(part, elements, isEnough);
  }

  /// Extensions that a file requires may hold a part of its shape.
  void requireKnown(std::string_view prefixes, const std::map<std::string, std::string>& spaces) const {
    while (!prefixes.empty()) {
      const std::size_t end = std::min(prefixes.find(' '), prefixes.size());
      const auto space = spaces.find(std::string(prefixes.substr(0, end)));
      prefixes.remove_prefix(std::min(end + 1, prefixes.size()));
      if (end == 0 || (space != spaces.end() && (space->second == kProduction3mf || space->second == kMaterial3mf)))
        continue;
      fail3mf(mPath, "it requires an extension of 3MF that cannot be read" +
                         (space == spaces.end() ? "" : " ('" + inOneLine(space->second) + "')") +
                         "; export the mesh without it, or as .obj");
    }
  }

  void countObject() {
    if (++mNames > kMostObjects)
      fail3mf(mPath, "it names more than " + std::to_string(kMostObjects) + " objects; export one of each");
  }

  Object3mf& beginObject(const ObjectName& name, const XmlAttributes& attributes) {
    countObject();
    const auto [entry, isNew] = mObjects.try_emplace(name);
    if (!isNew)
      fail3mf(mPath,
              "there are two objects with the number " + std::to_string(name.second) + "; export the mesh again");
    const std::string_view type = attributes.find("type").value_or("model");
    entry->second.isShape = type == "model" || type == "surface";
    return entry->second;
  }

  void addVertex(Mesh& mesh, const XmlAttributes& attributes) {
    requireRoomFor(mesh.points.size());
    mesh.points.emplace_back(attributes.number("x"), attributes.number("y"), attributes.number("z"));
  }

  void addTriangle(Mesh& mesh, const XmlAttributes& attributes) {
    requireRoomFor(mesh.triangles.size());
    mesh.triangles.emplace_back(attributes.whole("v1"), attributes.whole("v2"), attributes.whole("v3"));
  }

  /// Asks whether a list can grow to the double, when it will.
  static void requireRoomFor(std::size_t size) {
    constexpr std::size_t kLarge = 1 << 20;
    if (size >= kLarge && (size & (size - 1)) == 0)
      requireMemoryForStep(static_cast<double>(2 * size * sizeof(Vec3d)), MemoryUse::File, "the mesh of the 3MF");
  }

  void finishObject(Object3mf& object) {
    Mesh& mesh = object.mesh;
    for (const openvdb::Vec3I& t : mesh.triangles)
      for (int corner = 0; corner < 3; ++corner)
        if (t[corner] >= mesh.points.size())
          fail3mf(mPath, "a triangle refers to vertex " + std::to_string(t[corner]) + ", but there are only " +
                             std::to_string(mesh.points.size()) + "; export the mesh again");
    leaveOutUnusable(mPath, mesh);
    mMesh.pointsLeftOut += mesh.pointsLeftOut;
    mRead += mesh.points.size() + mesh.triangles.size();
  }

  PlacedObject placedObject(const std::string& part, const XmlAttributes& attributes) {
    countObject();
    const std::string otherPart = std::string(kProduction3mf) + kNameMark + "path";
    PlacedObject result{{part, attributes.whole("objectid")}, attributes.transform()};
    if (const auto other = attributes.find(otherPart)) {
      result.name.first = partName(*other);
      mNamed.push_back(result.name.first);
    }
    return result;
  }

  void place(const PlacedObject& placed, int level) {
    const auto found = mObjects.find(placed.name);
    if (found == mObjects.end())
      fail3mf(mPath,
              "object " + std::to_string(placed.name.second) + " is used, but there is none; export the mesh again");
    if (level > kMostComponentLevels)
      fail3mf(mPath, "its objects consist of each other in more than " + std::to_string(kMostComponentLevels) +
                         " levels; export the mesh again");
    const auto& [mesh, isShape, components] = found->second;
    if (!isShape) return;
    const std::uint64_t most =
        std::min<std::uint64_t>(mRead + kMostRepeated3mf, std::numeric_limits<std::uint32_t>::max());
    if (++mInstances > kMostObjects || mMesh.points.size() + mesh.points.size() > most ||
        mMesh.triangles.size() + mesh.triangles.size() > most)
      fail3mf(mPath, "it has its objects so often that they are too large together; export one of each");
    const auto first = static_cast<std::uint32_t>(mMesh.points.size());
    for (const Vec3d& point : mesh.points) mMesh.points.push_back(placed.placement.point(point));
    for (openvdb::Vec3I t : mesh.triangles) {
      if (placed.placement.mirrors()) std::swap(t[1], t[2]);
      mMesh.triangles.push_back(t + openvdb::Vec3I(first));
    }
    for (const PlacedObject& component : components)
      place({component.name, placed.placement.after(component.placement)}, level + 1);
  }

  const std::filesystem::path& mPath;
  ZipParts mZip;
  std::map<ObjectName, Object3mf> mObjects;
  std::vector<PlacedObject> mItems;
  std::vector<std::string> mNamed;  ///< files of the zip that have objects
  std::uint64_t mRead = 0;          ///< points and triangles of all objects
  std::uint64_t mNames = 0;         ///< objects, components and items
  std::uint64_t mInstances = 0;
  Mesh mMesh;
};

}  // namespace

bool canRead3mf() { return true; }

Mesh read3mf(const std::filesystem::path& path, std::string_view contents) { return Model3mf(path, contents).read(); }

std::string unitOf3mf(const std::filesystem::path& path, std::string_view contents) {
  std::string unit;
  bool isFound = false;
  const XmlElements elements{.begin = [&](std::string_view name, const XmlAttributes& attributes) {
    if (isFound || name != "model") return;
    unit = attributes.find("unit").value_or("millimeter");
    isFound = true;
  }};
  ZipParts zip(path, contents);
  zip.parse(modelPart(zip, path), elements, isFound);
  constexpr std::pair<std::string_view, LengthUnit> kUnits[] = {{"millimeter", LengthUnit::Millimetre},
                                                                {"centimeter", LengthUnit::Centimetre},
                                                                {"meter", LengthUnit::Metre},
                                                                {"inch", LengthUnit::Inch}};
  for (const auto& [name, known] : kUnits)
    if (unit == name) return nameOf(known);
  return {};
}

#endif

bool beginsAs3mf(std::string_view head, std::uintmax_t) { return head.starts_with("PK"); }

FileTexts unitTextOf3mf(std::istream& stream) {
  const std::string contents(std::istreambuf_iterator<char>(stream), {});
  try {
    if (const std::string unit = unitOf3mf({}, contents); !unit.empty()) return {{kLengthUnit, unit}};
  } catch (const DataError&) {
    // readMesh() will say that the file is broken.
  }
  return {};
}

}  // namespace vdbtools
