// SPDX-License-Identifier: Apache-2.0
#include "seeds.h"

#include "farm/task_files.h"
#include "farm/tile_file.h"
#include "fuzz_plan.h"
#include "support/small_zip.h"

#include "vdbtools/base/grids.h"
#include "vdbtools/formats/nvdb_file.h"
#include "vdbtools/formats/peer_formats.h"
#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/formats/versor_file.h"
#include "vdbtools/job/sheet_job.h"
#include "vdbtools/mesh_files/mesh_writer.h"
#include "vdbtools/picture/image.h"
#include "vdbtools/records/recorded_recipe.h"
#include "vdbtools/scene/fractal_options.h"

#include <openvdb/io/Stream.h>
#include <openvdb/tools/LevelSetUtil.h>

#include <array>
#include <cstring>
#include <map>
#include <sstream>
#include <utility>

namespace fuzz {
namespace {

using namespace vdbtools;
using namespace vdbtools::farm;
using openvdb::Vec3d;

using Seeds = std::vector<Seed>;

Recipe smallRecipe() {
  return completeRecipe({{"map", "quadratic"}, {"resolution", "16"}, {"c", "-0.2,0.8,0,0"}}, fractalOptionTable());
}

std::map<std::string, std::string> smallMetadata() { return recipeToMetadata(smallRecipe(), "fractal"); }

Mesh octahedron() {
  Mesh mesh;
  mesh.points = {{1, 0, 0}, {-1, 0, 0}, {0, 1.5, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -0.75}};
  for (const int x : {0, 1})
    for (const int y : {2, 3})
      for (const int z : {4, 5}) {
        openvdb::Vec3I triangle(x, y, z);
        if ((x + y + z) % 2 != 0) std::swap(triangle[1], triangle[2]);
        mesh.triangles.push_back(triangle);
      }
  return mesh;
}

std::string written(const MeshWriteOptions& options) {
  std::ostringstream stream;
  writeMesh(stream, octahedron(), options);
  return std::move(stream).str();
}

void addMeshes(Seeds& seeds) {
  const auto add = [&](const char* harness, const char* name, std::string bytes) {
    seeds.push_back({harness, name, std::move(bytes)});
  };
  add("ply", "own", written({.format = &meshFormat(".ply"), .comments = smallMetadata()}));
  add("ply", "plain", written({.format = &meshFormat(".ply")}));
  add("ply", "text",
      "ply\nformat ascii 1.0\ncomment by hand\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\nproperty float s\nproperty float t\n"
      "element face 2\nproperty list uchar int vertex_indices\nproperty list uchar float texcoord\nelement edge 1\n"
      "property int vertex1\nproperty int vertex2\nend_header\n0 0 0 255 0 0 0 0\n1 0 0 0 255 0 1 0\n1 1 0 0 0 255 1 "
      "1\n"
      "0 1 0.5 9 9 9 0 1\n4 0 1 2 3 8 0 0 1 0 1 1 0 1\n3 0 1 2 0\n0 1\n");
  add("ply", "strips",
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement "
      "tristrips 2\n"
      "property list int int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n9 0 1 2 3 -1 3 1 1 0\n3 2 0 3\n");
  add("obj", "own", written({.format = &meshFormat(".obj"), .comments = smallMetadata()}));
  add("obj", "text",
      "# by hand\nmtllib a.mtl\no part\nv 0 0 0 1 0 0\nv 1 0 0\nv 1 1 0 1.0\nv 0 1 0\nv 0.5 0.4 0\nvt 0 0\nvt 1 0\nvt "
      "1 "
      "1 0\nvn 0 0 1\nusemtl m\ns 1\nf 1/1/1 2/2/1 3/3/1\nf -5 -4 -3 \\\n -2 -1\nf 1//1 3//1 4//1\nfo 1 2 5\nl 1 2\n");
  add("mtl", "text",
      "# by hand\nnewmtl m\nKa 0 0 0\nKd 0.5 0.25 1\nd 1\nmap_Kd a.png\nnewmtl n\nKd xyz 1 2 3\nKd spectral f.rfl "
      "1\nKd 0.5\n");
  add("obj", "names",
      "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\no one\ng a b\nusemtl m\nf 1 2 3\ng c\nusemtl n\nf 3 2 1\ng a\nf 2 1 "
      "3\n");
  add("stl", "own", written({.format = &meshFormat(".stl")}));
  add("stl", "text",
      "solid a name\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1e-1 0\nendloop\nendfacet\n"
      "endsolid a name\n");
  add("off", "text", "OFF\n# by hand\n5 2 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n0.5 0.4 0\n5 0 1 2 3 4\n3 0 1 2 255 0 0\n");
  add("off", "counts_in_first_line", "COFF 3 1 0\n0 0 0 255 0 0 255\n1 0 0 1 1 1 1\n0 1 0 0 0 0 0\n3 0 1 2\n");
  const std::string model =
      "<model unit=\"inch\" xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\" "
      "xmlns:p=\"http://schemas.microsoft.com/3dmanufacturing/production/2015/06\" requiredextensions=\"p\"><resources>"
      "<object id=\"1\"><mesh><vertices><vertex x=\"0\" y=\"0\" z=\"0\"/><vertex x=\"1\" y=\"0\" z=\"0\"/><vertex "
      "x=\"0\" "
      "y=\"1\" z=\"nan\"/><vertex x=\"0\" y=\"0\" z=\"1\"/></vertices><triangles><triangle v1=\"0\" v2=\"1\" v3=\"3\"/>"
      "</triangles></mesh></object><object id=\"2\" type=\"surface\"><components><component objectid=\"1\" "
      "transform=\"1 0 0 0 1 0 0 0 1 2 0 0\"/><component objectid=\"1\" "
      "p:path=\"/3D/3dmodel.model\"/></components></object>"
      "</resources><build><item objectid=\"2\" transform=\"0 1 0 1 0 0 0 0 1 0 0 5\"/><item "
      "objectid=\"1\"/></build></model>";
  add("three_mf_model", "components", model);
  add("three_mf", "deflated", small_zip::zipOf(small_zip::partsOf3mf(model), true));
  add("three_mf", "stored", small_zip::zipOf(small_zip::partsOf3mf(model)));
  add("gltf", "meshopt",
      R"({"asset":{"version":"2.0"},"nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":{"POSITION":0)"
      R"(},"indices":1}]}],"accessors":[{"bufferView":0,"componentType":5126,"count":8,"type":"VEC3"},{"buffe)"
      R"(rView":1,"componentType":5125,"count":36,"type":"SCALAR"}],"bufferViews":[{"buffer":1,"byteLength":9)"
      R"(6,"byteStride":12,"extensions":{"EXT_meshopt_compression":{"buffer":0,"byteLength":91,"byteStride":1)"
      R"(2,"count":8,"mode":"ATTRIBUTES","filter":"NONE"}}},{"buffer":1,"byteOffset":96,"byteLength":144,"ext)"
      R"(ensions":{"EXT_meshopt_compression":{"buffer":0,"byteOffset":91,"byteLength":39,"byteStride":4,"coun)"
      R"(t":36,"mode":"TRIANGLES"}}}],"buffers":[{"byteLength":130,"uri":"data:application/octet-stream;base6)"
      R"(4,oAAAAT//AAD/////////AT//AAB+fX59fn1+AAABDMwAAP///wEMzAAAfn1+AAABAMAAAP8BAMAAAH4AAAAAAAAAAAAAAAAAAA)"
      R"(AAAAAAAAAAAAAAAAAAAAAAAOD+H/8fcxKhD2cSlQ/wBAL/AgICAgAAAHaHVmd4qYZliWiYAWkAAA=="},{"byteLength":240,")"
      R"(extensions":{"EXT_meshopt_compression":{"fallback":true}}}]})");
  add("gltf", "draco",
      R"({"asset":{"version":"2.0"},"nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":{"POSITION":0)"
      R"(},"indices":1,"extensions":{"KHR_draco_mesh_compression":{"bufferView":0,"attributes":{"POSITION":0})"
      R"(}}}]}],"accessors":[{"componentType":5126,"count":8,"type":"VEC3"},{"componentType":5125,"count":36,)"
      R"("type":"SCALAR"}],"bufferViews":[{"buffer":0,"byteLength":80}],"buffers":[{"byteLength":80,"uri":"da)"
      R"(ta:application/octet-stream;base64,RFJBQ08CAgEBAAAACAwACwEAA68+CgEBEAH/AAABAAkDAAACAQEBAAMDASgBGAMAh)"
      R"(LAHJSAEAAAAAAD/AwAAAAAAAAAAAAAAAAAAAACAPwo="}]})");
  add("draco", "sequential",
      std::string("\104\122\101\103\117\002\002\001\000\000\000\014\010\001\000\001\002\002\001\003\004\005\006\005\007"
                  "\006\000\002"
                  "\004\002\005\004\001\006\003\003\006\007\000\004\001\001\004\006\002\003\005\003\007\005\001\001\000"
                  "\011\003\000"
                  "\000\002\000\001\001\000\003\003\001\050\001\030\003\000\110\261\120\042\055\106\000\000\000\000\000"
                  "\377\003\000"
                  "\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\200\077\012",
                  102));
  add("draco", "edgebreaker",
      std::string("\104\122\101\103\117\002\002\001\001\000\000\000\010\014\000\013\001\000\003\257\076\012\001\001\020"
                  "\001\377\000"
                  "\000\001\000\011\003\000\000\002\001\001\001\000\003\003\001\050\001\030\003\000\204\260\007\045\040"
                  "\004\000\000"
                  "\000\000\000\377\003\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\000\200\077\012",
                  80));
  add("glb", "own", written({.format = &meshFormat(".glb"), .comments = smallMetadata()}));
  add("glb", "levels", written({.format = &meshFormat(".glb"), .levels = {0.5}}));
  add("gltf", "data_uri",
      R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0,1]}],"nodes":[{"mesh":0,"rotation":[0,0,0.7,0.7],)"
      R"("scale":[1,2,-1],"translation":[1,0,0],"children":[2]},{"mesh":0,"matrix":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]},)"
      R"({"mesh":1}],"meshes":[{"primitives":[{"attributes":{"POSITION":0,"COLOR_0":2,"_W":3},"indices":1}]},)"
      R"({"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":4},"mode":5}]}],"accessors":[)"
      R"({"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"},)"
      R"({"bufferView":1,"componentType":5123,"count":3,"type":"SCALAR"},)"
      R"({"bufferView":0,"componentType":5121,"count":3,"type":"VEC4","normalized":true},)"
      R"({"bufferView":0,"componentType":5126,"count":3,"type":"SCALAR","byteOffset":4},)"
      R"({"bufferView":0,"componentType":5126,"count":3,"type":"VEC2"}],)"
      R"("bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":6}],"buffers":[)"
      R"({"byteLength":42,"uri":"data:application/octet-stream;base64,)"
      R"(AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAABAAIA"}]})");
  add("gltf", "animated",
      R"({"asset":{"version":"2.0"},"nodes":[{"mesh":0,"skin":0,"children":[1]},{"children":[2]},{},{"mesh":0,"sc)"
      R"(ale":[1,1,1]}],"meshes":[{"primitives":[{"attributes":{"POSITION":0,"JOINTS_0":2,"WEIGHTS_0":3},"indices)"
      R"(":1,"targets":[{"POSITION":10}]}],"weights":[0.5]}],"skins":[{"joints":[1,2],"inverseBindMatrices":4}],")"
      R"(animations":[{"name":"a","channels":[{"sampler":0,"target":{"node":1,"path":"translation"}},{"sampler":1)"
      R"(,"target":{"node":2,"path":"rotation"}},{"sampler":2,"target":{"node":3,"path":"scale"}},{"sampler":3,"t)"
      R"(arget":{"node":3,"path":"weights"}}],"samplers":[{"input":5,"output":6},{"input":5,"output":7,"interpola)"
      R"(tion":"LINEAR"},{"input":5,"output":8,"interpolation":"CUBICSPLINE"},{"input":5,"output":9,"interpolatio)"
      R"(n":"STEP"}]}],"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"},{"bufferView":1)"
      R"(,"componentType":5123,"count":3,"type":"SCALAR"},{"bufferView":2,"componentType":5121,"count":3,"type":")"
      R"(VEC4"},{"bufferView":3,"componentType":5126,"count":3,"type":"VEC4"},{"bufferView":4,"componentType":512)"
      R"(6,"count":2,"type":"MAT4"},{"bufferView":5,"componentType":5126,"count":2,"type":"SCALAR"},{"bufferView")"
      R"(:6,"componentType":5126,"count":2,"type":"VEC3"},{"bufferView":7,"componentType":5126,"count":2,"type":")"
      R"(VEC4"},{"bufferView":8,"componentType":5126,"count":6,"type":"VEC3"},{"bufferView":9,"componentType":512)"
      R"(6,"count":2,"type":"SCALAR"},{"componentType":5126,"count":3,"type":"VEC3","sparse":{"count":1,"indices")"
      R"(:{"bufferView":11,"componentType":5123},"values":{"bufferView":10}}}],"bufferViews":[{"buffer":0,"byteOf)"
      R"(fset":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":6},{"buffer":0,"byteOffset":44,"byteLe)"
      R"(ngth":12},{"buffer":0,"byteOffset":56,"byteLength":48},{"buffer":0,"byteOffset":104,"byteLength":128},{")"
      R"(buffer":0,"byteOffset":232,"byteLength":8},{"buffer":0,"byteOffset":240,"byteLength":24},{"buffer":0,"by)"
      R"(teOffset":264,"byteLength":32},{"buffer":0,"byteOffset":296,"byteLength":72},{"buffer":0,"byteOffset":36)"
      R"(8,"byteLength":8},{"buffer":0,"byteOffset":376,"byteLength":12},{"buffer":0,"byteOffset":388,"byteLength)"
      R"(":2}],"buffers":[{"byteLength":390,"uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAA)"
      R"(AAAAAAAAAAAAAAAgD8AAAAAAAABAAIAAAAAAQAAAAEAAAABAAAAAIA/AAAAAAAAAAAAAAAAAAAAPwAAAD8AAAAAAAAAAAAAAAAAAIA/A)"
      R"(AAAAAAAAAAAAIA/AAAAAAAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAAAAAAIA/AACAPwAAA)"
      R"(AAAAAAAAAAAAAAAAAAAAIA/AAAAAAAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAAAAAAAAAAACAPwAAAAAAAIA/AAAAAAAAAAAAAAAAA)"
      R"(ACAPwAAAEAAAEBAAAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAmpkZP83MTD8AAAAAAAAAAAAAAAAAAIA/AACAPwAAgD8AAAAAAAAAAAAAA)"
      R"(AAAAAAAAAAAAAAAAAAAAABAAAAAQAAAAEAAAAAAAAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAACAPwIA"}]})");
}

/// In few leaves, so that the file is small: its lowest corner is at the origin.
openvdb::FloatGrid::Ptr ball(int radius) {
  const openvdb::FloatGrid::Ptr grid = openvdb::FloatGrid::create(2);
  const int middle = radius + 2;
  for (int x = 0; x <= 2 * middle; ++x)
    for (int y = 0; y <= 2 * middle; ++y)
      for (int z = 0; z <= 2 * middle; ++z) {
        const double distance = Vec3d(x - middle, y - middle, z - middle).length() - radius;
        if (std::abs(distance) < 2)
          grid->tree().setValueOn({x, y, z}, static_cast<float>(distance));
        else if (distance < 0)
          grid->tree().setValueOff({x, y, z}, -2);
      }
  grid->setGridClass(openvdb::GRID_LEVEL_SET);
  grid->setName("surface");
  return grid;
}

template <class Grid>
openvdb::GridBase::Ptr few(const char* name, const typename Grid::ValueType& background,
                           const typename Grid::ValueType& value) {
  const typename Grid::Ptr grid = Grid::create(background);
  grid->setName(name);
  for (int i = 0; i < 20; ++i) grid->tree().setValueOn({i * 3, i % 5, -i}, value);
  return grid;
}

std::string encoded(const openvdb::GridPtrVec& grids, std::uint32_t compression) {
  std::ostringstream stream(std::ios::binary);
  openvdb::io::Stream archive(stream);
  archive.setCompression(compression);
  openvdb::MetaMap metadata;
  metadata.insertMeta("creator", openvdb::StringMetadata("fuzz"));
  metadata.insertMeta("number", openvdb::Int32Metadata(7));
  archive.write(grids, metadata);
  return std::move(stream).str();
}

void addVdbs(Seeds& seeds) {
  openvdb::initialize();
  std::map<std::string, std::string> files;
  const openvdb::FloatGrid::Ptr surface = ball(3);
  files["own"] = encodeVdb({surface}, {.metadata = smallMetadata(), .up = UpAxis::Y});
  files["half"] = encodeVdb({surface}, {.half = true});
  // Without the mask, the nodes alone take 150 KB.
  using namespace openvdb::io;
  files["mask"] = encoded({surface}, COMPRESS_ACTIVE_MASK);
  files["zip"] = encoded({surface}, COMPRESS_ZIP | COMPRESS_ACTIVE_MASK);
  files["blosc"] = encoded({surface}, COMPRESS_BLOSC | COMPRESS_ACTIVE_MASK);
  const openvdb::FloatGrid::Ptr tiles = openvdb::FloatGrid::create(1);
  tiles->setName("density");
  tiles->setGridClass(openvdb::GRID_FOG_VOLUME);
  tiles->tree().addTile(1, {0, 0, 0}, 0.5f, true);
  tiles->tree().addTile(2, {128, 0, 0}, 0.25f, true);
  tiles->tree().addTile(3, {4096, 0, 0}, 0, false);
  files["tiles"] = encoded({tiles}, COMPRESS_ACTIVE_MASK);
  const openvdb::FloatGrid::Ptr fog = surface->deepCopy();
  openvdb::tools::sdfToFogVolume(*fog);
  fog->setName("density");
  files["fog"] = encoded({fog}, COMPRESS_ACTIVE_MASK);
  const openvdb::FloatGrid::Ptr unequal = surface->copy();
  unequal->setTransform(openvdb::math::Transform::createLinearTransform(1.0));
  unequal->transform().preScale(Vec3d(0.1, 0.2, 0.3));
  files["unequal"] = encoded({unequal}, COMPRESS_ACTIVE_MASK);
  openvdb::math::Mat4d turned = openvdb::math::Mat4d::identity();
  turned.setToRotation(Vec3d(1, 2, 3), 0.5);
  const openvdb::FloatGrid::Ptr placed = surface->copy();
  placed->setTransform(openvdb::math::Transform::createLinearTransform(turned));
  placed->transform().preScale(Vec3d(0.1, 0.2, 0.3));
  files["affine"] = encoded({placed}, COMPRESS_ACTIVE_MASK);
  const openvdb::FloatGrid::Ptr wide = openvdb::FloatGrid::create(1);
  wide->tree().setValueOn({0, 0, 0}, 2);
  wide->setTransform(openvdb::math::Transform::createFrustumTransform(openvdb::BBoxd(Vec3d(0), Vec3d(10)),
                                                                      /*taper=*/0.5, /*depth=*/2, /*x_spacing=*/0.1));
  files["frustum"] = encoded({wide}, COMPRESS_ACTIVE_MASK);
  const openvdb::GridPtrVec others = {few<openvdb::Int32Grid>("int", 0, 5), few<openvdb::BoolGrid>("bool", false, true),
                                      few<openvdb::Vec3SGrid>("vector", openvdb::Vec3s(0), openvdb::Vec3s(1, 2, 3)),
                                      few<openvdb::DoubleGrid>("double", 0, 0.25),
                                      few<openvdb::FloatGrid>("phi", 0, 1)};
  files["types"] = encoded(others, COMPRESS_ACTIVE_MASK);
  files["types_zip"] = encoded(others, COMPRESS_ZIP | COMPRESS_ACTIVE_MASK);
  // A grid that shares the tree of another.
  const openvdb::GridBase::Ptr shared = surface->copyGrid();
  shared->setName("again");
  files["instance"] = encoded({surface, shared}, COMPRESS_ACTIVE_MASK);
  const std::vector<Vec3d> positions = octahedron().points;
  files["points"] = encoded({pointGrid({.positions = positions}, {}, 0.5)}, COMPRESS_ACTIVE_MASK);
  for (const auto& [name, bytes] : files)
    for (const char* harness : {"vdb", "vdb_target", "vdb_head"}) seeds.push_back({harness, name, bytes});
}

/// The other way round than the harness: each run of zeros is a zero and its length.
std::string withoutZeros(const std::string& bytes) {
  std::string result;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    result += bytes[i];
    if (bytes[i] != '\0') continue;
    std::uint16_t count = 1;
    while (i + 1 < bytes.size() && bytes[i + 1] == '\0' && count < 0xffff) ++count, ++i;
    result.append(reinterpret_cast<const char*>(&count), sizeof count);
  }
  return result;
}

void addNvdbs(Seeds& seeds) {
  seeds.push_back({"nvdb", "head", "0NanoVDB0"});
  if (!canWriteNvdb()) return;
  const openvdb::FloatGrid::Ptr tile = openvdb::FloatGrid::create(1);
  tile->setName("density");
  tile->tree().addTile(3, {0, 0, 0}, 0.5f, true);
  const openvdb::GridPtrVec others = {few<openvdb::Int32Grid>("int", 0, 5),
                                      few<openvdb::Vec3SGrid>("vector", openvdb::Vec3s(0), openvdb::Vec3s(1, 2, 3))};
  for (const auto& [name, grids, values] : {std::tuple("tile", openvdb::GridPtrVec{tile}, NvdbValues::Full),
                                            {"surface", {ball(3)}, NvdbValues::Full},
                                            {"bits", {ball(3)}, NvdbValues::Variable},
                                            {"types", others, NvdbValues::Full}}) {
    std::ostringstream stream;
    writeNvdb(stream, grids, {.values = values});
    std::string bytes = std::move(stream).str();
    seeds.push_back({"nvdb", name, '1' + withoutZeros(bytes)});
    // Without checksums, which refuse nearly everything: behind the heads and the names are the grids.
    if (grids.size() > 1) continue;
    constexpr std::size_t kHeads = 16 + 176, kChecksums = 8;
    const std::size_t at = kHeads + grids.front()->getName().size() + 1 + kChecksums;
    bytes.replace(at, 8, 8, '\xff');
    seeds.push_back({"nvdb", std::string(name) + "_unsigned", '1' + withoutZeros(bytes)});
  }
}

void addRationals(Seeds& seeds) {
  julia::Rational rational;
  rational.logScale = 0.25;
  rational.top.roots = {{{0.5, 0, -1, 0}, 2}, {{0, 0.25, 0, 0}, 1}};
  rational.bottom.roots = {{{0, 0, 0, 0.125}, 1}};
  seeds.push_back({"rational", "plain", rationalToJson(rational)});
  const FittedTo target{{Vec3d(1, 2, 3), 4}, openvdb::BBoxd(Vec3d(-1), Vec3d(1))};
  seeds.push_back({"rational", "fitted", rationalToJson(rational, "a note", target)});
  seeds.push_back(
      {"waves", "plain", wavesToJson({{{{{{0.5, 0, -1, 0}, {1, 0, 0, 0}, {0, 1, 0, 0}}}, 2}}, {}}, "a note")});
  seeds.push_back({"p4d", "own", rationalToP4d(rational.top)});
  const OptimisedShape shape{.resolutions = {2, 1, 1}, .lengths = {1, 1, 1}, .rational = rational};
  const std::vector<double> field = {0.5, -0.25};
  seeds.push_back({"o3d", "own", optimisedShapeToO3d(shape, field, field, field)});
}

template <class Value>
void append(std::string& bytes, const Value& value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

/// An uncompressed grey picture of 2 x 1 pixels.
std::string smallTiff() {
  // Tag, kind (3: 2 bytes, 4: 4 bytes) and value: width, height, bits, compression, white is 1, offset, samples, rows,
  // bytes.
  constexpr std::array<std::array<std::uint32_t, 3>, 9> kEntries = {{{256, 3, 2},
                                                                     {257, 3, 1},
                                                                     {258, 3, 8},
                                                                     {259, 3, 1},
                                                                     {262, 3, 1},
                                                                     {273, 4, 8 + 2 + 9 * 12 + 4},
                                                                     {277, 3, 1},
                                                                     {278, 3, 1},
                                                                     {279, 4, 2}}};
  std::string bytes("II*\0\x08\0\0\0\x09\0", 10);
  for (const auto& [tag, kind, value] : kEntries) {
    append(bytes, static_cast<std::uint16_t>(tag));
    append(bytes, static_cast<std::uint16_t>(kind));
    append(bytes, std::uint32_t{1});
    append(bytes, value);
  }
  return bytes + std::string(4, '\0') + "ab";
}

/// A grey block of 8 x 8 pixels, with codes for nothing else.
std::string smallJpeg() {
  const std::string oneCode = "\1" + std::string(16, '\0');
  return "\xff\xd8\xff\xdb" + std::string("\0\x43\0", 3) + std::string(64, '\1') + "\xff\xc0" +
         std::string("\0\x0b\x08\0\x08\0\x08\1\1\x11\0", 11) + "\xff\xc4" + std::string("\0\x14\0", 3) + oneCode +
         "\xff\xc4" + std::string("\0\x14\x10", 3) + oneCode + "\xff\xda" + std::string("\0\x08\1\1\0\0\x3f\0", 8) +
         "\x3f\xff\xd9";
}

void addPictures(Seeds& seeds) {
  Image image(2, 1);
  image.pixels = {{0.5F, 1, 0}, {0.25F, 0, 1}};
  seeds.push_back({"picture", "png", encodeImage(image, "png")});
  seeds.push_back({"picture", "exr", encodeImage(image, "exr")});
  seeds.push_back({"picture", "tiff", smallTiff()});
  seeds.push_back({"picture", "jpeg", smallJpeg()});
}

void addTexts(Seeds& seeds) {
  for (const char* text :
       {"x*x - y^2 + sin(z)*exp(-phi)", "x > 0 ? min(x, y, 2) : atan2(y, x)", "1e-3*pi + e - abs(-z)", "(((x)))"})
    seeds.push_back({"expression", std::to_string(seeds.size()), text});
  seeds.push_back({"pair", "own", "x*x, y*y, z*z\ncos(x), r*sin2phi, cos2theta"});
  for (const char* text :
       {"40", "x:10:300:smooth", "y:10@0.2:300@0.8", "paint.vdb:mask", "paint:red:1:20", "paint:red@other.ply",
        "texture:a.png:luminance:1:30", "near:other.obj:0.1:2:3", "expr:40 + 100*hy*(nx > 0)", "expr:x*red+curvature"})
    seeds.push_back({"control", std::to_string(seeds.size()), text});
  const std::map<std::string, std::string> options = {
      {"own", "map = quadratic\n"},
      {"shape", "input=a.obj\nmap=shape-modulus\nalpha=40\nbeta=0.5\nversor=random\nversor-seed=7\nresolution=64"},
      {"shell", "input=a.vdb\ngrid=phi\ndetail=x:0.1:0.6\noutward=0.2\nmask=0.5\nsampling=quadratic\nmesh-normals"},
      {"cross", "map=cross\nf=x*x,y*y,z*z\ng=cos(x),cos(y),cos(z)\nbox=-1,-1,-1,1,1,1\nvoxel-size=0.1"},
      {"mandelbulb", "map=mandelbulb\npower=8\niterations=12\nradius=2\nisland-size=5"}};
  for (const auto& [name, text] : options) seeds.push_back({"options", name, "0" + text});
  std::string complete = "0";
  for (const auto& [name, value] : smallRecipe()) complete += name + "=" + value + "\n";
  seeds.push_back({"options", "complete", complete});
  seeds.push_back({"options", "sdf", "1input=a.obj\nresolution=50\nband=4\nhalf\nrepair\nup=z"});
  seeds.push_back({"config", "own", complete});
  seeds.push_back({"config", "by_hand",
                   "0# by hand\nmap = shape-modulus\nalpha= x:10:300:smooth   # a ramp\n\n beta =0.5\n"
                   "mesh-normals = true\ngrids = logmodulus,iterations\n"});
  seeds.push_back({"config", "sdf", "1resolution = 50\nhalf = true\nrepair=\nup = z\n"});
  seeds.push_back({"keys", "frames", "01-48x8,1-48,7"});
  seeds.push_back({"keys", "varied", "1alpha=10:40:10,50"});
  seeds.push_back({"keys", "varied_list", "1origin=0,0,0;0.1,0,0;"});
  seeds.push_back({"keys", "keys", "2alpha@1=10\nalpha@48=120\nc@1=0,1,-2,0\nc@9=1,1,-2,0"});
}

void addFarm(Seeds& seeds) {
  Manifest manifest = plan();
  seeds.push_back({"plan", "frames", "0" + encodeManifest(manifest)});
  seeds.push_back({"plan", "as_written", "1" + encodeManifest(manifest)});
  manifest.kind = PlanKind::Tiles;
  manifest.metadata = {{"source", "x"}};
  const openvdb::CoordBBox box(openvdb::Coord(-8), openvdb::Coord(7));
  manifest.lattice = TileLattice{box, true, 0.125};
  manifest.tasks = {{.recipe = {}, .box = box, .writes = {"tiles/0001.vdb"}}};
  seeds.push_back({"plan", "tiles", "0" + encodeManifest(manifest)});

  const std::string hash = taskHash(plan(), 1);
  TaskRecord record{.hash = hash, .files = {{.name = "out.0001.vdb", .bytes = 3, .sha256 = sha256Hex("abc")}}};
  record.counts = {{"triangles", 5}};
  seeds.push_back({"side_car", "record", "0" + encodeRecord(1, record)});
  seeds.push_back({"side_car", "running", "1" + encodeRunning(1)});
  seeds.push_back({"side_car", "failed", "2" + encodeFailure(1, hash, 65, "it is empty")});

  TileLayer layer{.x = 8, .blocks = {{0, 8, 2, 1}, {8, 0, 1, 0}}, .edges = {3, 7, 9 | kGuest}};
  layer.positions.assign(3, Vec3d(1, 2, 3));
  layer.normals.assign(3, openvdb::Vec3s(0, 0, 1));
  layer.triangles = {{0, 3, 7, 9}};
  for (const bool doubles : {false, true})
    for (const bool parts : {false, true}) {
      if (parts) layer.pointParts = {0, 2, 0}, layer.triangleParts = {2};
      std::ostringstream stream(std::ios::binary);
      TileEncoder tile(doubles);
      tile.add(layer);
      tile.add(layer);
      tile.write(stream);
      seeds.push_back({"tile", std::to_string(2 * doubles + parts), std::move(stream).str()});
      layer.pointParts.clear();
      layer.triangleParts.clear();
    }
  std::string islands = "JVDBISLE";
  for (const std::uint32_t number : {1u, 0u}) append(islands, number);
  for (const std::uint64_t count : {1u, 1u, 0u, 2u}) append(islands, count);
  islands.resize(islands.size() + 64, '\1');          // a part
  islands.resize(islands.size() + 3 * 20 - 4, '\0');  // runs of part 0
  islands.resize(islands.size() + 4, '\0');
  seeds.push_back({"tile_islands", "own", islands});

  Sheet sheet{.rows = 1, .columns = 2};
  sheet.varied = {{"c", {"0,1,0,0", "0,0,1,0"}}};
  sheet.cells = {{{{"c", "0,1,0,0"}}, smallRecipe(), ""}, {{{"c", "0,0,1,0"}}, smallRecipe(), "it is empty"}};
  seeds.push_back({"sheet", "own", encodeSheet(sheet)});
  seeds.push_back({"recipe_file", "own", encodeRecipe({"fractal", smallRecipe()})});
  seeds.push_back({"job_template", "all",
                   "#!/bin/sh\n# @{name} @{count} @{jobs} @{threads} @{batch} @@{no field}\n@{program:shell} "
                   "@{task-arguments:json} @{tasks}\n@{if tasks}\n@{folder:json}\n@{end}\n@{if merge}\n"
                   "@{merge-arguments} @{arguments:shell}\n@{end}\n@{each task}\n@{task}\n@{end}\n"});
}

void addExplore(Seeds& seeds) {
  const std::string look = R"({"recipe":{"map":"quadratic","c":"0,1,0,0","resolution":"16"})";
  const std::pair<const char*, std::string> requests[] = {
      {"start", "GET start\n"},
      {"jobs", "GET jobs\n"},
      {"volume", "GET volume/0123\n"},
      {"target", "GET target\n"},
      {"cancel", "DELETE jobs/1\n"},
      {"scene", "POST scene\n" + look + R"(,"wait":true})"},
      {"picture", "POST picture\n" + look +
                      R"(,"view":{"eye":[1,2,3],"lookAt":[0,0,0],"up":[0,1,0],"fov":40},"width":8,"height":8,)"
                      R"("samples":1,"colour":"iterations"})"},
      {"make", "POST make\n" + look + R"(,"name":"look","formats":["vdb","ply"],"resolution":20,"overwrite":false})"},
      {"command", "POST command\n" + look + R"(,"name":"look","formats":["vdb","glb"],"resolution":[20]})"},
      {"export", "POST export\n" + look + R"(,"look":{"azimuth":1}})"},
      {"recipe", "POST recipe look.txt\nmap = quadratic\n# c\nc = 0,1,0,0\n"}};
  for (const auto& [name, text] : requests) seeds.push_back({"request", name, text});
  const std::string ply = written({.format = &meshFormat(".ply"), .comments = smallMetadata()});
  const std::string obj = written({.format = &meshFormat(".obj"), .comments = smallMetadata()});
  const std::string glb = written({.format = &meshFormat(".glb"), .comments = smallMetadata()});
  const std::string vdb = encodeVdb({ball(2)}, {.metadata = smallMetadata()});
  for (const auto& [name, page, file, bytes] :
       {std::tuple("vdb", '0', '5', vdb), {"ply", '1', '6', ply}, {"obj", '2', '7', obj}, {"glb", '3', '8', glb}}) {
    seeds.push_back({"made_file", std::string(name) + "_dropped", page + bytes});
    seeds.push_back({"made_file", std::string(name) + "_config", file + bytes});
  }
  seeds.push_back({"made_file", "text", "4map = quadratic\n# how it turns\nc = 0,1,0,0\nhalf =\n"});
  seeds.push_back({"http_head", "post",
                   "POST /key/scene HTTP/1.1\r\nHost: localhost:8080\r\nContent-Length: 12\r\nContent-Type: "
                   "application/json\r\nCookie: a=b\r\nOrigin: http://localhost:8080\r\n\r\n"});
}

}  // namespace

std::vector<Seed> seeds() {
  Seeds all;
  addMeshes(all);
  addVdbs(all);
  addNvdbs(all);
  addRationals(all);
  addPictures(all);
  addTexts(all);
  addFarm(all);
  addExplore(all);
  return all;
}

}  // namespace fuzz
