// SPDX-License-Identifier: Apache-2.0
#include "mesh/mesh_file_check.h"
#include "mesh/ply_reader.h"
#include "mesh/polygon.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/mesh/mesh.h"

#include <OpenMesh/Core/IO/IOManager.hh>
#include <OpenMesh/Core/IO/Options.hh>
#include <OpenMesh/Core/IO/reader/OBJReader.hh>
#include <OpenMesh/Core/IO/reader/OFFReader.hh>
#include <OpenMesh/Core/IO/reader/STLReader.hh>
#include <OpenMesh/Core/System/omstream.hh>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iostream>
#include <limits>
#include <mutex>
#include <span>
#include <sstream>

namespace vdbtools {
namespace {

namespace om = OpenMesh;

/// Takes points and polygons as they come. OpenMesh's own importer builds half-edges, and to do so it gives the faces
/// of a non-manifold edge points of their own, or drops them: the report would then be about another mesh.
class PolygonImporter final : public om::IO::BaseImporter {
 public:
  using om::IO::BaseImporter::add_vertex;

  om::VertexHandle add_vertex(const om::Vec3f& p) override { return add_vertex(om::Vec3d(p[0], p[1], p[2])); }
  om::VertexHandle add_vertex(const om::Vec3d& p) override {
    points.emplace_back(p[0], p[1], p[2]);
    return om::VertexHandle(static_cast<int>(points.size() - 1));
  }
  om::VertexHandle add_vertex() override { return add_vertex(om::Vec3d(0, 0, 0)); }
  om::FaceHandle add_face(const VHandles& polygon) override {
    for (const om::VertexHandle corner : polygon) corners.push_back(static_cast<std::uint32_t>(corner.idx()));
    ends.push_back(corners.size());
    return om::FaceHandle(static_cast<int>(ends.size() - 1));
  }
  void set_point(om::VertexHandle v, const om::Vec3f& p) override {
    points.at(static_cast<std::size_t>(v.idx())) = openvdb::Vec3d(p[0], p[1], p[2]);
  }
  std::size_t n_vertices() const override { return points.size(); }
  std::size_t n_faces() const override { return ends.size(); }
  std::size_t n_edges() const override { return 0; }

  // Half-edges and attributes are of no use here.
  om::HalfedgeHandle add_edge(om::VertexHandle, om::VertexHandle) override { return om::HalfedgeHandle(); }
  om::FaceHandle add_face(om::HalfedgeHandle) override { return om::FaceHandle(); }
  void add_face_texcoords(om::FaceHandle, om::VertexHandle, const std::vector<om::Vec2f>&) override {}
  void add_face_texcoords(om::FaceHandle, om::VertexHandle, const std::vector<om::Vec3f>&) override {}
  void set_face_texindex(om::FaceHandle, int) override {}
  void set_halfedge(om::VertexHandle, om::HalfedgeHandle) override {}
  void set_normal(om::VertexHandle, const om::Vec3f&) override {}
  void set_normal(om::VertexHandle, const om::Vec3d&) override {}
  void set_color(om::VertexHandle, const om::Vec3uc&) override {}
  void set_color(om::VertexHandle, const om::Vec4uc&) override {}
  void set_color(om::VertexHandle, const om::Vec3f&) override {}
  void set_color(om::VertexHandle, const om::Vec4f&) override {}
  void set_texcoord(om::VertexHandle, const om::Vec2f&) override {}
  void set_status(om::VertexHandle, const om::Attributes::StatusInfo&) override {}
  void set_next(om::HalfedgeHandle, om::HalfedgeHandle) override {}
  void set_face(om::HalfedgeHandle, om::FaceHandle) override {}
  void request_face_texcoords2D() override {}
  void set_texcoord(om::HalfedgeHandle, const om::Vec2f&) override {}
  void set_texcoord(om::VertexHandle, const om::Vec3f&) override {}
  void set_texcoord(om::HalfedgeHandle, const om::Vec3f&) override {}
  void set_status(om::HalfedgeHandle, const om::Attributes::StatusInfo&) override {}
  void set_color(om::EdgeHandle, const om::Vec3uc&) override {}
  void set_color(om::EdgeHandle, const om::Vec4uc&) override {}
  void set_color(om::EdgeHandle, const om::Vec3f&) override {}
  void set_color(om::EdgeHandle, const om::Vec4f&) override {}
  void set_status(om::EdgeHandle, const om::Attributes::StatusInfo&) override {}
  void set_normal(om::FaceHandle, const om::Vec3f&) override {}
  void set_normal(om::FaceHandle, const om::Vec3d&) override {}
  void set_color(om::FaceHandle, const om::Vec3uc&) override {}
  void set_color(om::FaceHandle, const om::Vec4uc&) override {}
  void set_color(om::FaceHandle, const om::Vec3f&) override {}
  void set_color(om::FaceHandle, const om::Vec4f&) override {}
  void set_status(om::FaceHandle, const om::Attributes::StatusInfo&) override {}
  void add_texture_information(int, std::string) override {}

  std::vector<openvdb::Vec3d> points;
  std::vector<std::uint32_t> corners;
  std::vector<std::uint64_t> ends;  ///< of each polygon in corners
};

/// Catches what OpenMesh would print, for as long as it lives.
class CapturedMessages {
 public:
  CapturedMessages() : mHadErr(omerr().disconnect(std::cerr)), mHadLog(omlog().disconnect(std::clog)) {
    omerr().connect(mText);
    omlog().connect(mText);
  }
  CapturedMessages(const CapturedMessages&) = delete;
  CapturedMessages& operator=(const CapturedMessages&) = delete;
  ~CapturedMessages() {
    omerr().disconnect(mText);
    omlog().disconnect(mText);
    if (mHadErr) omerr().connect(std::cerr);
    if (mHadLog) omlog().connect(std::clog);
  }

  std::string firstLine() const {
    const std::string text = mText.str();
    return text.substr(0, text.find('\n'));
  }

 private:
  bool mHadErr;  ///< an application may have unplugged them itself
  bool mHadLog;
  std::ostringstream mText;
};

Mesh readThroughOpenMesh(const std::filesystem::path& path, const std::string& extension, const CheckedFile& file) {
  if (file.points.size() > std::numeric_limits<std::int32_t>::max()) {
    throw DataError(path.string() + ": " + std::to_string(file.points.size()) +
                    " points are more than can be indexed; decimate the mesh");
  }
  // Its readers, and the streams that it prints to, are global objects with state.
  static std::mutex mutex;
  const std::scoped_lock lock(mutex);
  PolygonImporter importer;
  {
    const CapturedMessages messages;
    om::IO::OBJReader();  // a mention each, so that a static library keeps its readers
    om::IO::OFFReader();
    om::IO::STLReader();
    om::IO::Options options = file.binary ? om::IO::Options::Binary : om::IO::Options::Default;
    std::istringstream stream(file.text);
    if (!om::IO::IOManager().read(stream, extension, importer, options)) {
      throw DataError(path.string() + ": OpenMesh does not read it (" + messages.firstLine() +
                      "); export the mesh again");
    }
  }
  Mesh mesh;
  mesh.points = file.points.empty() ? std::move(importer.points) : file.points;
  if (!file.points.empty() && importer.points.size() != file.points.size()) {
    throw std::logic_error("OpenMesh read " + std::to_string(importer.points.size()) + " of " +
                           std::to_string(file.points.size()) + " points");
  }
  std::uint64_t begin = 0;
  for (const std::uint64_t end : importer.ends) {
    const auto corners = std::span(importer.corners).subspan(begin, end - begin);
    begin = end;
    if (std::any_of(corners.begin(), corners.end(), [&mesh](std::uint32_t c) { return c >= mesh.points.size(); })) {
      throw std::logic_error("OpenMesh made up an index that was not in " + path.string());
    }
    if (corners.size() >= 3) triangulatePolygon(corners, mesh.points, mesh.triangles);
  }
  return mesh;
}

std::string loadFile(const std::filesystem::path& path) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) throw MissingInputError(path.string() + ": no such file; check its name");
  if (!std::filesystem::is_regular_file(status)) {
    throw MissingInputError(path.string() + ": this is " +
                            (std::filesystem::is_directory(status) ? "a folder" : "no ordinary file") +
                            "; name a mesh file");
  }
  errno = 0;
  std::ifstream stream(path, std::ios::binary);
  if (!stream) {
    throw MissingInputError(path.string() + ": cannot be opened (" + std::strerror(errno) + "); check its permissions");
  }
  std::string contents(std::filesystem::file_size(path), '\0');
  stream.read(contents.data(), static_cast<std::streamsize>(contents.size()));
  if (static_cast<std::size_t>(stream.gcount()) != contents.size()) {
    throw MissingInputError(path.string() + ": reading broke off after " + std::to_string(stream.gcount()) + " of " +
                            std::to_string(contents.size()) + " bytes; copy the file again");
  }
  return contents;
}

}  // namespace

Mesh readMesh(const std::filesystem::path& path) {
  const std::string contents = loadFile(path);
  const std::string extension = lowerExtension(path);
  if (extension != ".obj" && extension != ".ply" && extension != ".stl" && extension != ".off") {
    throw DataError(path.string() + ": the format '" + extension +
                    "' is not read; name a file that ends in .obj, .ply, .stl or .off");
  }
  if (contents.empty()) throw DataError(path.string() + ": the file is empty (0 bytes); export the mesh again");

  Mesh mesh;
  if (extension == ".ply") {
    mesh = readPly(path, contents);
  } else if (extension == ".obj") {
    mesh = readThroughOpenMesh(path, "obj", checkObj(path, contents));
  } else if (extension == ".off") {
    mesh = readThroughOpenMesh(path, "off", checkOff(path, contents));
  } else {
    mesh = weldMesh(readThroughOpenMesh(path, "stl", checkStl(path, contents)));
  }
  if (mesh.triangles.empty()) {
    throw DataError(path.string() + ": it has " + std::to_string(mesh.points.size()) +
                    " points, but no triangle; export the mesh with its faces");
  }
  return mesh;
}

}  // namespace vdbtools
