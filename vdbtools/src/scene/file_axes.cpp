// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/scene/file_axes.h"

#include "vdbtools/base/errors.h"

#include <utility>

namespace vdbtools {
namespace {

/// @param asTaken  what most readers of the format take for up
UpAxis axisOf(const FileAxes& axes, UpAxis asTaken) {
  switch (axes.rule) {
    case UpRule::Keep: return axes.target;
    case UpRule::Y: return UpAxis::Y;
    case UpRule::Z: return UpAxis::Z;
    case UpRule::Auto: return asTaken;
  }
  throw std::logic_error("a rule for the axis that does not exist");
}

/// An STL alone does not say which of its axes points up.
std::string idleTargetUp(const OptionRun& run) {
  if (run.makesAny({Product::Vdb, Product::Mesh, Product::Glb, Product::Picture})) return {};
  if (!run.makesAny({Product::Stl})) return "it is for a VDB, a mesh or a picture of the map; leave it out";
  return run.text("up") == "keep" ? "an STL does not say which axis points up; give --up too, or leave it out" : "";
}

std::string idleUp(const OptionRun& run) {
  if (run.makesAny({Product::Vdb, Product::Mesh, Product::Stl})) return {};
  if (!run.makesAny({Product::Glb})) return "it is for a VDB or a mesh, and this run makes none; leave it out";
  // What asks for Y up gets it.
  const std::string up = run.text("up");
  return (up == "keep" ? run.text("target-up") : up) == "z" ? "a GLB has Y up always; leave it out" : "";
}

}  // namespace

UpAxis FileAxes::ofVdb() const { return axisOf(*this, UpAxis::Y); }

UpAxis FileAxes::ofMesh(MeshFormat format) const {
  if (format == MeshFormat::Glb) return UpAxis::Y;
  return axisOf(*this, format == MeshFormat::Obj ? UpAxis::Y : UpAxis::Z);
}

std::vector<OptionSpec> fileAxesOptionSpecs() {
  return {
      {.name = "target-up",
       .argument = "y|z",
       .defaultValue = "y",
       .help = "the axis of the target that points up",
       .idle = idleTargetUp},
      {.name = "up",
       .argument = "keep|y|z|auto",
       .defaultValue = "keep",
       .help = "the axis that points up in the files: keep writes the target's coordinates, y and z turn them where "
               "needed, and auto turns each file as most programs take its format (PLY and STL: z, others: y); "
               "GLB has Y up always",
       .idle = idleUp}};
}

UpRule parseUpRule(const std::string& value) {
  return parseChoice<UpRule>("up", value,
                             {{"keep", UpRule::Keep}, {"y", UpRule::Y}, {"z", UpRule::Z}, {"auto", UpRule::Auto}});
}

FileAxes parseFileAxes(const RecipeReader& reader) {
  return {.target = reader.choice<UpAxis>("target-up", {{"y", UpAxis::Y}, {"z", UpAxis::Z}}),
          .rule = parseUpRule(reader.text("up"))};
}

UpAxis recordedUpAxis(const std::map<std::string, std::string>& metadata, UpAxis otherwise) {
  const auto entry = metadata.find(kUpAxis);
  if (entry == metadata.end()) return otherwise;
  for (const UpAxis up : {UpAxis::Y, UpAxis::Z})
    if (entry->second == nameOf(up)) return up;
  throw DataError("the file's metadata " + std::string(kUpAxis) + " is '" + entry->second + "'; it must be y or z");
}

VdbWriteOptions vdbWriteOptions(const FileAxes& axes, std::map<std::string, std::string> metadata) {
  const UpAxis up = axes.ofVdb();
  metadata[kUpAxis] = nameOf(up);
  return {.metadata = std::move(metadata), .up = up, .turn = {axes.target, up}};
}

MeshWriteOptions meshWriteOptions(MeshFormat format, const FileAxes& axes,
                                  std::map<std::string, std::string> metadata) {
  const UpAxis up = axes.ofMesh(format);
  metadata[kUpAxis] = nameOf(up);
  return {.format = format, .comments = std::move(metadata), .turn = {axes.target, up}};
}

}  // namespace vdbtools
