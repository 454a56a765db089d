// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/usd/usd_file.h"

#include "vdbtools/base/text.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <ostream>
#include <set>
#include <stdexcept>

namespace vdbtools {
namespace {

using openvdb::Vec3d;

template <class Number>
std::string textOf(Number value) {
  char text[32];
  return std::string(text, std::to_chars(text, text + sizeof text, value).ptr);
}

template <class Vector>
std::string tupleOf(const Vector& v) {
  return "(" + textOf(v[0]) + ", " + textOf(v[1]) + ", " + textOf(v[2]) + ")";
}

/// A text in quotation marks.
std::string quoted(const std::string& text) {
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') result += '\\';
    result += c == '\n' || c == '\r' ? ' ' : c;
  }
  return result + '"';
}

/// A file path between the delimiters of an asset.
std::string assetOf(const std::filesystem::path& path) {
  std::string text = path.generic_string();
  // Without a leading dot, a resolver may search for it elsewhere.
  if (path.is_relative() && !text.starts_with("../")) text = "./" + text;
  const char* mark = text.find('@') == std::string::npos ? "@" : "@@@";
  return mark + text + mark;
}

std::string extentOf(const openvdb::BBoxd& box) {
  using openvdb::Vec3s;
  return "[" + tupleOf(Vec3s(box.min())) + ", " + tupleOf(Vec3s(box.max())) + "]";
}

/// An attribute that has one value, or one for each frame.
template <class ValueOf>
void writeAttribute(std::ostream& stream, const std::string& indent, const std::string& declaration,
                    const std::vector<UsdFrame>& frames, const ValueOf& valueOf) {
  if (!frames.front().number) {
    stream << indent << declaration << " = " << valueOf(frames.front()) << '\n';
    return;
  }
  stream << indent << declaration << ".timeSamples = {\n";
  for (const UsdFrame& frame : frames) stream << indent << "    " << *frame.number << ": " << valueOf(frame) << ",\n";
  stream << indent << "}\n";
}

void writeVolume(std::ostream& stream, const UsdScene& scene) {
  stream << "\n    def Volume \"volume\"\n    {\n";
  writeAttribute(stream, "        ", "float3[] extent", scene.frames,
                 [](const UsdFrame& frame) { return extentOf(frame.box); });
  std::set<std::string> names;
  for (const UsdField& field : scene.fields) {
    const std::string name = usdIdentifier(field.grid);
    if (!names.insert(name).second)
      throw std::invalid_argument("two grids are called '" + name + "' in USD; give them names that differ");
    stream << "        custom rel field:" << name << " = </fractal/volume/" << name << ">\n";
  }
  for (const UsdField& field : scene.fields) {
    stream << "\n        def OpenVDBAsset " << quoted(usdIdentifier(field.grid)) << "\n        {\n";
    writeAttribute(stream, "            ", "asset filePath", scene.frames,
                   [](const UsdFrame& frame) { return assetOf(frame.vdb); });
    stream << "            token fieldName = " << quoted(field.grid) << '\n';
    if (!field.dataType.empty()) stream << "            token fieldDataType = " << quoted(field.dataType) << '\n';
    stream << "            token fieldClass = " << quoted(field.fieldClass) << "\n        }\n";
  }
  stream << "    }\n";
}

/// Writes a list. @param breaks  whether it has several lines; the value of a frame has one, as some readers expect
template <class Write>
void writeElements(std::ostream& stream, std::size_t count, bool breaks, const Write& write) {
  constexpr std::size_t kOnALine = 16;
  stream << '[';
  for (std::size_t i = 0; i < count; ++i) {
    if (i > 0) stream << (breaks && i % kOnALine == 0 ? ",\n            " : ", ");
    write(i);
  }
  stream << ']';
}

/// An attribute of meshes: a list, or one for each frame.
/// @param writerOf  for a mesh, the function that writes the element at an index  @param details  further properties of
///                  the attribute
template <class Count, class WriterOf>
void writeMeshAttribute(std::ostream& stream, const UsdMeshes& meshes, const std::string& declaration,
                        const Count& countOf, const WriterOf& writerOf, const char* details = "") {
  const bool isStill = !meshes.frames.front();
  const auto writeList = [&](const Mesh& mesh) { writeElements(stream, countOf(mesh), isStill, writerOf(mesh)); };
  stream << "        " << declaration;
  if (isStill) {
    stream << " = ";
    writeList(meshes.at(0));
    stream << details << '\n';
    return;
  }
  if (*details != 0) stream << details << "\n        " << declaration;
  stream << ".timeSamples = {\n";
  for (std::size_t k = 0; k < meshes.frames.size(); ++k) {
    stream << "            " << *meshes.frames[k] << ": ";
    writeList(meshes.at(k));
    stream << ",\n";
  }
  stream << "        }\n";
}

const VertexAttribute* attributeOf(const Mesh& mesh, const std::string& name) {
  for (const VertexAttribute& attribute : mesh.attributes)
    if (attribute.name == name) return &attribute;
  return nullptr;
}

/// USD knows no sign of what is not a number.
std::string numberOf(float value) { return std::isnan(value) ? "nan" : textOf(value); }

void writePrimvar(std::ostream& stream, const UsdMeshes& meshes, const UsdPrimvar& primvar, const char* details) {
  writeMeshAttribute(
      stream, meshes, (primvar.parts.size() == 1 ? "float[] primvars:" : "float3[] primvars:") + primvar.name,
      [](const Mesh& mesh) { return mesh.points.size(); },
      [&](const Mesh& mesh) {
        std::vector<const std::vector<float>*> parts;
        for (const std::string& part : primvar.parts) parts.push_back(&attributeOf(mesh, part)->values);
        return [&stream, parts](std::size_t i) {
          const std::string text = joined(parts, ", ", [i](const auto* values) { return numberOf((*values)[i]); });
          stream << (parts.size() > 1 ? "(" + text + ")" : text);
        };
      },
      details);
}

/// The origin of positions: the centre of the mesh, if it lies so far from the world's origin that floats are coarse.
Vec3d centreFor(const openvdb::BBoxd& box) {
  constexpr double kFar = 8;  // in sizes of the mesh: no vertex moves by more than 1e-6 of one
  double largest = 0, size = 0;
  for (int axis = 0; axis < 3; ++axis) {
    largest = std::max({largest, -box.min()[axis], box.max()[axis]});
    size = std::max(size, box.extents()[axis]);
  }
  return largest > kFar * size ? box.getCenter() : Vec3d(0);
}

void writeMeshPrim(std::ostream& stream, const UsdMeshes& meshes) {
  constexpr const char* kVertex = " (\n            interpolation = \"vertex\"\n        )";
  openvdb::BBoxd all;
  for (const openvdb::BBoxd& box : meshes.boxes) all.expand(box);
  const Vec3d centre = centreFor(all);
  const auto extentAt = [&](std::size_t k) {
    return extentOf({meshes.boxes[k].min() - centre, meshes.boxes[k].max() - centre});
  };
  stream << "\n    def Mesh \"mesh\"\n    {\n        uniform token subdivisionScheme = \"none\"\n"
            "        uniform token orientation = \"rightHanded\"\n        float3[] extent";
  if (meshes.frames.front()) {
    stream << ".timeSamples = {\n";
    for (std::size_t k = 0; k < meshes.frames.size(); ++k)
      stream << "            " << *meshes.frames[k] << ": " << extentAt(k) << ",\n";
    stream << "        }\n";
  } else {
    stream << " = " << extentAt(0) << '\n';
  }
  const auto triangles = [](const Mesh& mesh) { return mesh.triangles.size(); };
  const auto points = [](const Mesh& mesh) { return mesh.points.size(); };
  writeMeshAttribute(stream, meshes, "int[] faceVertexCounts", triangles,
                     [&](const Mesh&) { return [&](std::size_t) { stream << 3; }; });
  writeMeshAttribute(stream, meshes, "int[] faceVertexIndices", triangles, [&](const Mesh& mesh) {
    return [&](std::size_t i) {
      const openvdb::Vec3I& t = mesh.triangles[i];
      stream << t[0] << ", " << t[1] << ", " << t[2];
    };
  });
  writeMeshAttribute(stream, meshes, "point3f[] points", points, [&](const Mesh& mesh) {
    return [&](std::size_t i) { stream << tupleOf(openvdb::Vec3s(mesh.points[i] - centre)); };
  });
  if (meshes.hasVelocities)
    writeMeshAttribute(stream, meshes, "vector3f[] velocities", points, [&](const Mesh& mesh) {
      const auto &x = attributeOf(mesh, "velocity_x")->values, &y = attributeOf(mesh, "velocity_y")->values,
                 &z = attributeOf(mesh, "velocity_z")->values;
      return [&](std::size_t i) { stream << tupleOf(openvdb::Vec3s(x[i], y[i], z[i])); };
    });
  if (meshes.hasNormals)
    writeMeshAttribute(
        stream, meshes, "normal3f[] normals", [](const Mesh& mesh) { return mesh.normals.size(); },
        [&](const Mesh& mesh) { return [&](std::size_t i) { stream << tupleOf(mesh.normals[i]); }; }, kVertex);
  if (meshes.hasColours)
    writeMeshAttribute(
        stream, meshes, "color3f[] primvars:displayColor", points,
        [&](const Mesh& mesh) {
          const auto &red = attributeOf(mesh, "red")->values, &green = attributeOf(mesh, "green")->values,
                     &blue = attributeOf(mesh, "blue")->values;
          return [&](std::size_t i) { stream << tupleOf(openvdb::Vec3s(red[i], green[i], blue[i])); };
        },
        kVertex);
  if (meshes.hasUvs)
    writeMeshAttribute(
        stream, meshes, "texCoord2f[] primvars:st", [](const Mesh& mesh) { return mesh.cornerUvs.size(); },
        [&](const Mesh& mesh) {
          return [&](std::size_t i) {
            stream << '(' << numberOf(mesh.cornerUvs[i][0]) << ", " << numberOf(mesh.cornerUvs[i][1]) << ')';
          };
        },
        " (\n            interpolation = \"faceVarying\"\n        )");
  for (const UsdPrimvar& primvar : meshes.primvars) writePrimvar(stream, meshes, primvar, kVertex);
  if (centre != Vec3d(0))
    stream << "        double3 xformOp:translate = " << tupleOf(centre)
           << "\n        uniform token[] xformOpOrder = [\"xformOp:translate\"]\n";
  stream << "    }\n";
}

}  // namespace

std::string usdIdentifier(const std::string& name) {
  std::string result;
  for (const char c : name) {
    const bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_', digit = c >= '0' && c <= '9';
    if (digit && result.empty()) result += '_';
    result += letter || digit ? c : '_';
  }
  return result.empty() ? "_" : result;
}

void writeUsda(std::ostream& stream, const UsdScene& scene) {
  if (scene.frames.empty() && !scene.mesh)
    throw std::invalid_argument("a scene needs a volume or a mesh; name a VDB, or a mesh");
  stream << "#usda 1.0\n(\n    defaultPrim = \"fractal\"\n    doc = \"Written by JuliaVDB " JULIAVDB_VERSION "\"\n";
  if (scene.range) stream << "    endTimeCode = " << scene.range->second << '\n';
  if (scene.range) stream << "    framesPerSecond = " << textOf(scene.framesPerSecond) << '\n';
  stream << "    metersPerUnit = " << textOf(scene.metersPerUnit) << '\n';
  if (scene.range) stream << "    startTimeCode = " << scene.range->first << '\n';
  if (scene.range) stream << "    timeCodesPerSecond = " << textOf(scene.framesPerSecond) << '\n';
  stream << "    upAxis = \"" << (scene.up == UpAxis::Y ? 'Y' : 'Z')
         << "\"\n)\n\ndef Xform \"fractal\" (\n    kind = \"component\"\n)\n{";
  if (!scene.frames.empty()) writeVolume(stream, scene);
  if (scene.mesh) writeMeshPrim(stream, *scene.mesh);
  stream << "}\n";
}

}  // namespace vdbtools
