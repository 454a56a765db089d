// SPDX-License-Identifier: Apache-2.0
// FBX, DAE, 3DS and X3D by Assimp. Its importers parse the bytes; all else is done here, with the checks of the other
// readers, and none of Assimp's processing steps is used.
#include "mesh_files/mesh_formats.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/mesh_files/mesh_reader.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <string>
#include <string_view>

#ifdef VDBTOOLS_ASSIMP
#include "mesh/polygon.h"
#include "mesh_files/gltf_pose.h"
#include "mesh_files/usable_points.h"
#include "vdbtools/base/memory.h"
#include "vdbtools/base/units.h"
#include "vdbtools/files/file_bytes.h"

#include <assimp/scene.h>
#include <assimp/IOSystem.hpp>
#include <assimp/Importer.hpp>

#include <cmath>
#include <exception>
#include <istream>
#include <iterator>
#include <limits>
#include <new>
#include <utility>
#include <vector>
#endif

namespace vdbtools {
namespace {

constexpr const char* kConversion = "convert it to .glb, for example with Blender";

std::atomic<bool> theImporterIsTrusted = false;

/// "FBX" for "a.fbx".
std::string formatCalled(const std::filesystem::path& path) {
  std::string format = path.extension().string().substr(1);
  for (char& c : format)
    if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
  return format;
}

}  // namespace

void trustImporter(bool isTrusted) { theImporterIsTrusted = isTrusted; }

bool isImporterTrusted() { return theImporterIsTrusted; }

#ifndef VDBTOOLS_ASSIMP

bool canImport() { return false; }

Mesh readImported(const std::filesystem::path& path, std::string_view) {
  throw DataError(path.string() + ": this program was built without reading " + formatCalled(path) +
                  ": " VDBTOOLS_NO_ASSIMP "; " + kConversion);
}

FileTexts unitTextOfFbx(std::istream&) { return {}; }

FileTexts unitTextOfDae(std::istream&) { return {}; }

#else

namespace {

using openvdb::Vec3d;

/// As in glTF, meshes that occur several times count each time, and a small file must not become a mesh that fills the
/// memory.
constexpr std::uint64_t kMostRepeatedImport = 10'000'000;

[[noreturn]] void failImport(const std::filesystem::path& path, const std::string& what) {
  throw DataError(path.string() + ": " + what);
}

/// Files may name others, which are not opened.
class NoOtherFiles final : public Assimp::IOSystem {
 public:
  bool Exists(const char*) const override { return false; }
  char getOsSeparator() const override { return '/'; }
  Assimp::IOStream* Open(const char*, const char*) override { return nullptr; }
  void Close(Assimp::IOStream*) override {}
};

/// @return what the importer owns
/// @throw DataError  no trust, or Assimp cannot read it
const aiScene& importScene(const std::filesystem::path& path, std::string_view contents, Assimp::Importer& importer) {
  const std::string format = formatCalled(path);
  if (!isImporterTrusted())
    failImport(path, format +
                         " is read by the library Assimp, which is not safe against files made to do harm; give "
                         "--trust-importer if you trust this one, or " +
                         kConversion);
  const std::string extension = lowerExtension(path);
  if (!importer.IsExtensionSupported(extension))
    failImport(path, "this program's Assimp cannot read " + format + "; " + kConversion);
  importer.SetIOHandler(new NoOtherFiles);  // which the importer deletes
  const aiScene* scene = nullptr;
  std::string problem;
  try {
    scene = importer.ReadFileFromMemory(contents.data(), contents.size(), 0, extension.c_str() + 1);
    problem = importer.GetErrorString();
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    problem = error.what();
  }
  if (!scene || !scene->mRootNode)
    failImport(path,
               "Assimp cannot read this " + format + " (" + inOneLine(problem) + "); export it again, or as .glb");
  return *scene;
}

/// A number of a scene's metadata, whatever type this version of Assimp gives it.
double importedNumber(const aiScene& scene, const char* name, double otherwise) {
  double number = otherwise;
  float single = 0;
  std::int32_t whole = 0;
  if (!scene.mMetaData || scene.mMetaData->Get(name, number)) return number;
  if (scene.mMetaData->Get(name, single)) return static_cast<double>(single);
  return scene.mMetaData->Get(name, whole) ? whole : otherwise;
}

Placement placementOf(const aiMatrix4x4& m) {
  return {{Vec3d(m.a1, m.b1, m.c1), Vec3d(m.a2, m.b2, m.c2), Vec3d(m.a3, m.b3, m.c3), Vec3d(m.a4, m.b4, m.c4)}};
}

/// The axes of the file, which are turned such that Y points up, and its unit.
struct ImportedSpace {
  Placement turn{};
  double metres = 0;  ///< the length of its unit; 0: it does not say
};

ImportedSpace spaceOfFbx(const aiScene& scene) {
  constexpr double kMetresOfUnit = 0.01;
  ImportedSpace space{.metres = kMetresOfUnit * importedNumber(scene, "UnitScaleFactor", 1)};
  const std::array<const char*, 3> names = {"CoordAxis", "UpAxis", "FrontAxis"};
  Placement turn{{Vec3d(0), Vec3d(0), Vec3d(0), Vec3d(0)}};
  for (int to = 0; to < 3; ++to) {
    const std::string name = names[static_cast<std::size_t>(to)];
    const double from = importedNumber(scene, name.c_str(), to);
    const double sign = importedNumber(scene, (name + "Sign").c_str(), 1);
    if (from == 0 || from == 1 || from == 2) turn.columns[static_cast<std::size_t>(from)][to] = sign < 0 ? -1 : 1;
  }
  // Otherwise an axis occurs twice, and the file says nothing of use.
  const double volume = turn.columns[0].cross(turn.columns[1]).dot(turn.columns[2]);
  if (volume != 0) space.turn = turn;
  return space;
}

/// Of a DAE and a 3DS, Assimp puts the turn into the root, and the metres of a DAE's unit as a scale. Otherwise, and in
/// FBX and X3D, the root is no node of the file.
ImportedSpace spaceOf(const aiScene& scene, const std::string& extension) {
  if (extension == ".fbx") return spaceOfFbx(scene);
  ImportedSpace space{.turn = placementOf(scene.mRootNode->mTransformation)};
  if (extension != ".dae") return space;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    Vec3d& column = space.turn.columns[axis];
    space.metres = std::max({std::abs(column[0]), std::abs(column[1]), std::abs(column[2])});
    column /= space.metres;
  }
  return space;
}

/// Joins what the nodes of a scene show.
class ImportedMesh {
 public:
  ImportedMesh(const std::filesystem::path& path, const aiScene& scene) : mPath(path), mScene(scene) {
    for (unsigned i = 0; i < scene.mNumMeshes; ++i) {
      mHasColours = mHasColours || scene.mMeshes[i]->HasVertexColors(0);
      mMost += scene.mMeshes[i]->mNumVertices;
    }
    mMost = std::min<std::uint64_t>(mMost + kMostRepeatedImport, std::numeric_limits<std::uint32_t>::max());
    if (mHasColours)
      for (const char* const name : {"red", "green", "blue", "alpha"}) mMesh.attributes.push_back({name, {}});
  }

  Mesh join(const Placement& root) {
    std::vector<std::pair<const aiNode*, Placement> > open{{mScene.mRootNode, root}};
    while (!open.empty()) {
      const auto [node, placement] = open.back();
      open.pop_back();
      for (unsigned i = 0; i < node->mNumMeshes; ++i) add(node->mMeshes[i], placement);
      for (unsigned i = node->mNumChildren; i-- > 0;)
        open.emplace_back(node->mChildren[i], placement.after(placementOf(node->mChildren[i]->mTransformation)));
    }
    leaveOutUnusable(mPath, mMesh);
    return weldMesh(withoutEmptyAlpha());
  }

 private:
  void add(unsigned index, const Placement& placement) {
    if (index >= mScene.mNumMeshes)
      failImport(mPath, "a node shows mesh " + std::to_string(index) + " of " + std::to_string(mScene.mNumMeshes) +
                            "; export it again");
    const aiMesh& mesh = *mScene.mMeshes[index];
    const std::uint64_t first = mMesh.points.size();
    if (first + mesh.mNumVertices > mMost || mMesh.triangles.size() > mMost)
      failImport(mPath, "it has its meshes so often that they are too large together; export one of each");
    requireMemory(static_cast<double>(mesh.mNumVertices) * sizeof(Vec3d), MemoryUse::File, "the mesh of the file");
    for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
      const aiVector3D& p = mesh.mVertices[i];
      mMesh.points.push_back(placement.point(Vec3d(p.x, p.y, p.z)));
    }
    addColours(mesh);
    std::vector<std::uint32_t> corners;
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
      const aiFace& face = mesh.mFaces[f];
      if (face.mNumIndices < 3) continue;
      corners.clear();
      for (unsigned i = 0; i < face.mNumIndices; ++i) {
        if (face.mIndices[i] >= mesh.mNumVertices)
          failImport(mPath, "a face refers to vertex " + std::to_string(face.mIndices[i]) + ", but there are only " +
                                std::to_string(mesh.mNumVertices) + "; export it again");
        corners.push_back(static_cast<std::uint32_t>(first + face.mIndices[i]));
      }
      if (placement.mirrors()) std::reverse(corners.begin(), corners.end());
      triangulatePolygon(corners, mMesh.points, mMesh.triangles);
    }
  }

  /// White where a mesh has none and others have.
  void addColours(const aiMesh& mesh) {
    if (!mHasColours) return;
    for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
      const aiColor4D colour = mesh.HasVertexColors(0) ? mesh.mColors[0][i] : aiColor4D(1, 1, 1, 1);
      for (unsigned channel = 0; channel < 4; ++channel)
        mMesh.attributes[channel].values.push_back(static_cast<float>(colour[channel]));
    }
  }

  /// Assimp gives every colour an alpha.
  Mesh withoutEmptyAlpha() {
    if (mHasColours) {
      const std::vector<float>& alpha = mMesh.attributes.back().values;
      if (std::all_of(alpha.begin(), alpha.end(), [](float value) { return value == 1; })) mMesh.attributes.pop_back();
    }
    return std::move(mMesh);
  }

  const std::filesystem::path& mPath;
  const aiScene& mScene;
  std::uint64_t mMost = 0;  ///< points, and triangles
  bool mHasColours = false;
  Mesh mMesh;
};

/// @param path  has the extension of the format
FileTexts unitTextOf(const std::filesystem::path& path, std::istream& stream) {
  constexpr double kNearlyEqual = 1e-5;  // relative; Assimp has floats
  if (!isImporterTrusted()) return {};
  const std::string contents(std::istreambuf_iterator<char>(stream), {});
  try {
    Assimp::Importer importer;
    const double metres = spaceOf(importScene(path, contents, importer), lowerExtension(path)).metres;
    for (const LengthUnit unit : kLengthUnits)
      if (std::abs(metres / metresOf(unit) - 1) < kNearlyEqual) return {{kLengthUnit, nameOf(unit)}};
  } catch (const DataError&) {
    // readMesh() will say that the file is broken.
  }
  return {};
}

}  // namespace

bool canImport() { return true; }

Mesh readImported(const std::filesystem::path& path, std::string_view contents) {
  Assimp::Importer importer;
  const aiScene& scene = importScene(path, contents, importer);
  return ImportedMesh(path, scene).join(spaceOf(scene, lowerExtension(path)).turn);
}

FileTexts unitTextOfFbx(std::istream& stream) { return unitTextOf("a.fbx", stream); }

FileTexts unitTextOfDae(std::istream& stream) { return unitTextOf("a.dae", stream); }

#endif

}  // namespace vdbtools
