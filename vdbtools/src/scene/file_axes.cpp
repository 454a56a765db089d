// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/scene/file_axes.h"

#include "recipe/option_rows.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/recipe/option_value.h"

#include <stdexcept>
#include <system_error>
#include <utility>

namespace vdbtools {
namespace {

/// @param asTaken  the axis that most readers of the format take for up
UpAxis axisOf(const FileAxes& axes, UpAxis asTaken) {
  switch (axes.rule) {
    case UpRule::Keep: return axes.target;
    case UpRule::Y: return UpAxis::Y;
    case UpRule::Z: return UpAxis::Z;
    case UpRule::Auto: return asTaken;
  }
  throw std::logic_error("a rule for the axis that does not exist");
}

/// STL is the only format that does not record which of its axes points up.
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

std::string idleUnits(const OptionRun& run) {
  if (run.makesAny({Product::Vdb, Product::Mesh, Product::Glb, Product::Stl, Product::Stack})) return {};
  return "it is for files that have room for a unit, which are VDBs, meshes and stacks of slices; leave it out";
}

const Choices<UpRule>& upRules() {
  static const Choices<UpRule> rules = {
      {"keep", UpRule::Keep}, {"y", UpRule::Y}, {"z", UpRule::Z}, {"auto", UpRule::Auto}};
  return rules;
}

Choices<LengthUnit> lengthUnits() {
  Choices<LengthUnit> units;
  for (const LengthUnit unit : kLengthUnits) units.emplace_back(nameOf(unit), unit);
  return units;
}

const OptionRows<FileAxes>& axesRows() {
  static const OptionRows<FileAxes> rows{
      {{.name = "target-up", .help = "the axis of the target that points up", .idle = idleTargetUp},
       choice<UpAxis>(&FileAxes::target, {{"y", UpAxis::Y}, {"z", UpAxis::Z}})},
      {{.name = "up",
        .help =
            "the axis that points up in the files: keep writes the target's coordinates, y and z turn them where "
            "needed, and auto turns each file as most programs take its format (PLY and STL: z, others: y); GLB has "
            "Y up always",
        .idle = idleUp},
       choice<UpRule>(&FileAxes::rule, upRules())},
      {{.name = "units",
        .help = "the unit of the target's coordinates. The files then say it, a GLB is scaled to metres, as its "
                "specification has it, and print and usd know the true size",
        .defaultNote = "as a target that this program made says, or none",
        .idle = idleUnits},
       choice<LengthUnit>(&FileAxes::unit, lengthUnits())}};
  return rows;
}

}  // namespace

UpAxis FileAxes::ofVdb() const { return of(*findFormat(".vdb")); }

UpAxis FileAxes::of(const FileFormat& format) const { return format.metresYUp ? UpAxis::Y : axisOf(*this, format.up); }

std::vector<OptionSpec> fileAxesOptionSpecs() { return axesRows().specs(); }

UpRule parseUpRule(const std::string& value) { return chosen("up", value, upRules()); }

FileAxes parseFileAxes(const RecipeReader& reader) { return axesRows().read(reader); }

LengthUnit parseLengthUnit(const std::string& value) { return chosen("units", value, lengthUnits()); }

std::optional<LengthUnit> recordedUnit(const std::map<std::string, std::string>& metadata) {
  const auto entry = metadata.find(kLengthUnit);
  if (entry == metadata.end()) return std::nullopt;
  for (const auto& [name, unit] : lengthUnits())
    if (name == entry->second) return unit;
  throw DataError("the file's metadata " + std::string(kLengthUnit) + " is '" + entry->second +
                  "'; it must be mm, cm, m or in");
}

std::optional<LengthUnit> unitOfTarget(const FileAxes& axes, const std::map<std::string, std::string>& metadata) {
  return axes.unit ? axes.unit : recordedUnit(metadata);
}

std::optional<LengthUnit> unitOfFile(const std::filesystem::path& path) {
  // The content of a pipe can be read only once.
  std::error_code ignored;
  if (std::filesystem::exists(path, ignored) && !std::filesystem::is_regular_file(path, ignored)) return std::nullopt;
  return recordedUnit(readFileTexts(path));
}

std::optional<LengthUnit> agreedUnit(std::optional<LengthUnit> asked, std::optional<LengthUnit> recorded,
                                     const std::filesystem::path& path) {
  if (asked && recorded && *asked != *recorded)
    throw std::invalid_argument("--units is '" + std::string(nameOf(*asked)) + "', but '" + path.string() +
                                "' says that its unit is " + nameOf(*recorded) +
                                "; leave --units out, or make that file again");
  return recorded ? recorded : asked;
}

UpAxis recordedUpAxis(const std::map<std::string, std::string>& metadata, UpAxis otherwise) {
  const auto entry = metadata.find(kUpAxis);
  if (entry == metadata.end()) return otherwise;
  for (const UpAxis up : {UpAxis::Y, UpAxis::Z})
    if (entry->second == nameOf(up)) return up;
  throw DataError("the file's metadata " + std::string(kUpAxis) + " is '" + entry->second + "'; it must be y or z");
}

void setUnit(MeshWriteOptions& options, LengthUnit unit) {
  const LengthUnit ofFile = options.format->metresYUp ? LengthUnit::Metre : unit;
  options.scale = metresOf(unit) / metresOf(ofFile);
  options.comments[kLengthUnit] = nameOf(ofFile);
}

VdbWriteOptions vdbWriteOptions(const FileAxes& axes, std::map<std::string, std::string> metadata) {
  const UpAxis up = axes.ofVdb();
  metadata[kUpAxis] = nameOf(up);
  if (const std::optional<LengthUnit> unit = unitOfTarget(axes, metadata)) metadata[kLengthUnit] = nameOf(*unit);
  return {.metadata = std::move(metadata), .up = up, .turn = {axes.target, up}};
}

MeshWriteOptions meshWriteOptions(const FileFormat& format, const FileAxes& axes,
                                  std::map<std::string, std::string> metadata) {
  const UpAxis up = axes.of(format);
  metadata[kUpAxis] = nameOf(up);
  const std::optional<LengthUnit> unit = unitOfTarget(axes, metadata);
  MeshWriteOptions options{.format = &format, .comments = std::move(metadata), .turn = {axes.target, up}};
  if (unit) setUnit(options, *unit);
  return options;
}

}  // namespace vdbtools
