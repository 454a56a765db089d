// SPDX-License-Identifier: Apache-2.0
// Meshes: what the readers give must be a mesh that the program can work with.
#include "harness.h"
#include "mesh_files/draco_decoder.h"
#include "mesh_files/face_names.h"
#include "mesh_files/mesh_formats.h"
#include "support/small_zip.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/mesh/mesh.h"
#include "vdbtools/mesh_files/mesh_reader.h"

#include <array>
#include <cstring>
#include <random>
#include <stdexcept>

namespace fuzz {
namespace {

using vdbtools::Mesh;

void require(bool holds, const char* what) {
  if (!holds) throw std::logic_error(what);
}

/// What mesh.h says of every mesh.
void requireWhole(const Mesh& mesh) {
  for (const openvdb::Vec3d& point : mesh.points) require(point.isFinite(), "a coordinate is not finite");
  for (const openvdb::Vec3I& triangle : mesh.triangles)
    for (int corner = 0; corner < 3; ++corner)
      require(triangle[corner] < mesh.points.size(), "an index is out of range");
  for (const vdbtools::VertexAttribute& attribute : mesh.attributes)
    require(attribute.values.size() == mesh.points.size(), "an attribute has not one value a point");
  require(mesh.normals.empty() || mesh.normals.size() == mesh.points.size(), "there is not one normal a point");
  require(mesh.cornerUvs.empty() || mesh.cornerUvs.size() == 3 * mesh.triangles.size(),
          "there are not three texture coordinates a triangle");
}

using Reader = Mesh (*)(const std::filesystem::path&, std::string_view);

/// As readMesh() does it.
template <Reader read, bool welds>
void readMesh(const char* name, std::string_view bytes) {
  if (bytes.empty()) return;
  Mesh mesh = read(scratchFolder() / name, bytes);
  requireWhole(mesh);
  if (welds) mesh = vdbtools::weldMesh(mesh);
  requireWhole(mesh);
  vdbtools::reportMesh(mesh);
  requireWhole(vdbtools::asPoints(std::move(mesh)));
}

Mesh readStill(const std::filesystem::path& path, std::string_view bytes) { return vdbtools::readGltf(path, bytes); }

Mesh readPlayed(const std::filesystem::path& path, std::string_view bytes) {
  return vdbtools::readGltf(path, bytes, vdbtools::MeshMoment{.seconds = 0.5, .animation = "all"});
}

void readGltf(const char* name, std::string_view bytes) {
  try {
    try {
      vdbtools::readAnimations(scratchFile(name, bytes));
      readMesh<readPlayed, true>(name, bytes);
    } catch (const vdbtools::DataError&) {  // it may still be read without an animation
    }
    readMesh<readStill, true>(name, bytes);
  } catch (const vdbtools::MissingInputError&) {  // a buffer that it names
  }
}

/// The XML of a model, in a zip that is whole.
void read3mfModel(std::string_view xml) {
  const std::string bytes = small_zip::zipOf(small_zip::partsOf3mf(std::string(xml)));
  readMesh<vdbtools::read3mf, false>("mesh.3mf", bytes);
}

/// What glTF takes from it, without glTF.
void readDraco(std::string_view bytes) {
  constexpr std::array<vdbtools::DracoAttribute, 2> kWanted = {{{.id = 0, .components = 3}, {1, 4, true}}};
  constexpr std::uint64_t kRoom = std::uint64_t{64} << 20;
  for (const std::size_t wanted : {std::size_t{1}, kWanted.size()}) {
    std::uint64_t room = kRoom;
    const vdbtools::DracoShape shape = vdbtools::decodeDraco(bytes, std::span(kWanted).first(wanted), room);
    if (!shape.problem.empty()) continue;
    require(shape.corners.size() % 3 == 0, "there are not three corners a triangle");
    require(shape.attributes.at(0).size() == 12 * shape.points, "there are not three numbers a point");
  }
}

/// A library by itself, and as that of a mesh.
void readMtl(std::string_view bytes) {
  vdbtools::readMaterialColours("library.mtl", bytes);
  scratchFile("library.mtl", bytes);
  const std::string_view obj = "mtllib library.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\nusemtl n\nf 3 2 1\n";
  readMesh<vdbtools::readObj, false>("mesh.obj", obj);
}

void put32(std::span<std::uint8_t> bytes, std::size_t at, std::size_t value) {
  for (std::size_t i = 0; i < 4; ++i) bytes[at + i] = static_cast<std::uint8_t>(value >> (8 * i));
}

std::size_t get32(std::span<const std::uint8_t> bytes, std::size_t at) {
  std::size_t value = 0;
  for (std::size_t i = 4; i-- > 0;) value = value << 8 | bytes[at + i];
  return value;
}

}  // namespace

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* bytes, std::size_t size, std::size_t capacity)
    __attribute__((weak));

namespace {

/// Changes the JSON or the binary chunk of a GLB, and the lengths with them.
std::size_t mutateGlb(std::span<std::uint8_t> bytes, std::size_t size, unsigned seed) {
  constexpr std::size_t kHead = 12, kChunkHead = 8, kJson = kHead + kChunkHead;
  if (!LLVMFuzzerMutate || size < kJson || std::memcmp(bytes.data(), "glTF", 4) != 0 ||
      get32(bytes, kHead) > size - kJson)
    return LLVMFuzzerMutate ? LLVMFuzzerMutate(bytes.data(), size, bytes.size()) : size;
  const std::size_t json = get32(bytes, kHead);
  const bool changesJson = seed % 3 != 0 || size < kJson + json + kChunkHead;
  const std::size_t begin = changesJson ? kJson : kJson + json + kChunkHead;
  const std::size_t length = changesJson ? json : size - begin;
  // What follows the changed part is kept aside while it changes its length.
  const std::basic_string<char> rest(reinterpret_cast<const char*>(bytes.data() + begin + length),
                                     size - begin - length);
  if (bytes.size() < begin + rest.size() + length + 1) return size;
  const std::size_t changed = LLVMFuzzerMutate(bytes.data() + begin, length, bytes.size() - begin - rest.size());
  if (!rest.empty()) std::memcpy(bytes.data() + begin + changed, rest.data(), rest.size());
  put32(bytes, begin - kChunkHead, changed);
  const std::size_t whole = begin + changed + rest.size();
  put32(bytes, 8, whole);
  return whole;
}

constexpr std::array<Harness, 10> kMeshHarnesses = {{
    {"ply", [](std::string_view bytes) { readMesh<vdbtools::readPly, false>("mesh.ply", bytes); }},
    {"obj", [](std::string_view bytes) { readMesh<vdbtools::readObj, false>("mesh.obj", bytes); }},
    {"mtl", readMtl},
    {"stl", [](std::string_view bytes) { readMesh<vdbtools::readStl, true>("mesh.stl", bytes); }},
    {"off", [](std::string_view bytes) { readMesh<vdbtools::readOff, false>("mesh.off", bytes); }},
    {"three_mf", [](std::string_view bytes) { readMesh<vdbtools::read3mf, false>("mesh.3mf", bytes); }},
    {"three_mf_model", read3mfModel},
    {"draco", readDraco},
    {"glb", [](std::string_view bytes) { readGltf("mesh.glb", bytes); }, Refusal::Data, mutateGlb},
    {"gltf", [](std::string_view bytes) { readGltf("mesh.gltf", bytes); }},
}};

}  // namespace

std::span<const Harness> meshHarnesses() { return kMeshHarnesses; }

}  // namespace fuzz
