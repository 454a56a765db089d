// SPDX-License-Identifier: Apache-2.0
// A vertex attribute of the target's mesh, or of another one, extended off the surface.
#include "control/control_kinds.h"
#include "control/control_lattice.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/mesh_files/mesh_reader.h"

namespace vdbtools {
namespace {

constexpr const char* kPaintForm =
    "paint:NAME[@FILE] or paint:NAME[@FILE]:LOW:HIGH, with a vertex attribute's name, a mesh whose path has no ':' in "
    "it, and two finite numbers, such as paint:red:20:300";

/// The values that 0 and 1 become.
struct Scale {
  double low = 0, high = 1;
  double operator()(double value) const { return low + (high - low) * value; }
};

class PaintSource final : public ControlSource {
 public:
  PaintSource(std::string name, std::optional<NamedFile> file, std::optional<Scale> scale, std::string text)
      : mName(std::move(name)), mFile(std::move(file)), mScale(scale), mText(std::move(text)) {}
  std::string text() const override { return mText; }
  std::vector<NamedFile> files() const override {
    return mFile ? std::vector<NamedFile>{*mFile} : std::vector<NamedFile>();
  }

  Control bind(const ControlContext& context) const override {
    if (!mFile && !context.mesh)
      throw DataError("'" + mText +
                      "' cannot be used: the target is a VDB, which has no vertex attributes; name the "
                      "mesh that is painted: paint:" +
                      mName + "@FILE");
    const Mesh other = mFile ? readMesh(mFile->path) : Mesh();
    const Mesh& mesh = mFile ? other : *context.mesh;
    const std::string whose = mFile ? "'" + mFile->path.string() + "'" : "the target's mesh";
    const VertexAttribute* attribute = &requireAttribute(mesh, mName, whose);
    const ControlLattice lattice = controlLattice(context);
    std::vector<float> values = std::move(extended(lattice, mesh, {&attribute, 1})[0]);
    smooth(lattice, values);
    if (mScale)
      for (float& value : values) value = static_cast<float>((*mScale)(value));
    return Control(latticeField(lattice, std::move(values)));
  }

 private:
  std::string mName;
  std::optional<NamedFile> mFile;  ///< the file of the mesh; empty: the target's mesh
  std::optional<Scale> mScale;
  std::string mText;
};

}  // namespace

ControlSourcePtr parsePaintControl(const RecipeReader& reader, const std::string& option) {
  const std::string text = reader.text(option);
  const std::optional<std::string> rest = afterPrefix(text, "paint:");
  if (!rest) return nullptr;
  const std::vector<std::string> parts = split(*rest, ':');
  if (parts.size() != 1 && parts.size() != 3) reader.refuse(option, kPaintForm);
  const std::size_t at = parts[0].find('@');
  const std::string name = parts[0].substr(0, at);
  std::optional<NamedFile> file;
  if (at != std::string::npos) file = reader.file(option, parts[0].substr(at + 1));
  std::optional<Scale> scale;
  if (parts.size() == 3) {
    const std::optional<double> low = finiteNumber(parts[1]), high = finiteNumber(parts[2]);
    if (!low || !high) reader.refuse(option, kPaintForm);
    scale = {*low, *high};
  }
  if (name.empty() || (file && file->path.empty())) reader.refuse(option, kPaintForm);
  return std::make_shared<PaintSource>(name, file, scale, text);
}

}  // namespace vdbtools
