// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/scene/attribute_options.h"

#include "recipe/option_rows.h"

#include <algorithm>
#include <array>
#include <set>
#include <utility>

namespace vdbtools {
namespace {

struct Known {
  PointAttribute attribute;
  VertexColumn column;
};

const std::array<Known, 8>& known() {
  static const std::array<Known, 8> all = {{
      {PointAttribute::Cd, {"Cd", ColumnKind::LinearRgb}},
      {PointAttribute::Direction, {"direction", ColumnKind::Vector}},
      {PointAttribute::Trap, {"trap", ColumnKind::Number}},
      {PointAttribute::Iterations, {"iterations", ColumnKind::Number}},
      {PointAttribute::Depth, {"depth", ColumnKind::Number}},
      {PointAttribute::Tau, {"tau", ColumnKind::Number}},
      {PointAttribute::Mask, {"mask", ColumnKind::Number}},
      {PointAttribute::Velocity, {"velocity", ColumnKind::WorldVector}},
  }};
  return all;
}

Choices<PointAttribute> attributeNames() {
  Choices<PointAttribute> names;
  for (const Known& one : known()) names.emplace_back(one.column.name, one.attribute);
  return names;
}

VertexColumn transferredColumn(const std::string& name) {
  if (name == "uv") return {name, ColumnKind::TextureCoordinate};
  if (name == "Cd") return {name, ColumnKind::LinearRgb};
  return {name, ColumnKind::Number};
}

void parseTransferred(const RecipeReader& reader, const std::string& option, AttributeOptions& options) {
  for (const std::string& name : split(reader.text(option), ',')) {
    std::vector<std::string>& names = options.transferred;
    if (name.empty() || std::find(names.begin(), names.end(), name) != names.end())
      reader.refuse(option, "a list of uv, Cd and names of the target's vertex attributes, in which none occurs twice");
    names.push_back(name);
  }
}

/// The names that a column has in files.
std::vector<std::string> namesInFiles(const VertexColumn& column) {
  switch (column.kind) {
    case ColumnKind::Number: return {column.name};
    case ColumnKind::Vector:
    case ColumnKind::WorldVector: return {column.name, column.name + "_x", column.name + "_y", column.name + "_z"};
    case ColumnKind::LinearRgb: return {column.name, "red", "green", "blue"};
    case ColumnKind::TextureCoordinate: return {column.name, "s", "t"};
  }
  return {};
}

void requireDistinct(const RecipeReader& reader, const AttributeOptions& options) {
  std::set<std::string> taken = {"x", "y", "z", "nx", "ny", "nz"};
  const std::vector<std::string> grids = split(reader.text("grids"), ',');
  for (const VertexColumn& column : meshColumns(options)) {
    const bool isTransferred =
        std::find(options.transferred.begin(), options.transferred.end(), column.name) != options.transferred.end();
    const std::string option = isTransferred ? "transfer" : "attributes";
    if (std::find(grids.begin(), grids.end(), column.name) != grids.end())
      reader.refuse(option, "without '" + column.name + "', as --grids has a grid of that name; leave out one of them");
    for (const std::string& name : namesInFiles(column))
      if (!taken.insert(name).second)
        reader.refuse(option, "without '" + column.name + "', as a file would have '" + name +
                                  "' twice; leave it out, or rename it in the target");
  }
}

bool isListed(const std::string& list, const char* name) {
  const std::vector<std::string> names = split(list, ',');
  return std::find(names.begin(), names.end(), name) != names.end();
}

/// The target's own colour stands in the place of a computed one, but in pictures.
std::string idleColour(const OptionRun& run) {
  const bool carried = isListed(run.text("transfer"), "Cd") && !isListed(run.text("attributes"), "Cd");
  return carried && !run.makesAny({Product::Picture})
             ? "--transfer carries over the target's own colour; leave one of them out"
             : "";
}

const OptionRows<AttributeOptions>& attributeRows() {
  // An STL has room for none, which is said after the run.
  const IdleRule noPoints =
      idleWithout({Product::Vdb, Product::Mesh, Product::Stl, Product::Glb}, "the points of a mesh or a VDB");
  OptionSpec colour = colourOptionSpec();
  colour.idle = idleByAny({idleWithout({Product::Vdb, Product::Mesh, Product::Stl, Product::Glb, Product::Picture},
                                       "the points of a mesh or a VDB, or a picture of the map"),
                           idleColour});
  static const OptionRows<AttributeOptions> rows{
      {{.name = "attributes",
        .argument = "LIST",
        .help = "what the vertices of the mesh carry and, by the same names, the voxels of the VDB: a list of " +
                joined(wordsOf(attributeNames())) + " (docs/attributes.md)",
        .idle = noPoints},
       withoutDefault(list<PointAttribute>(&AttributeOptions::computed, attributeNames()))},
      {colour, parsed(&AttributeOptions::colour,
                      [](const RecipeReader& reader, const std::string&) { return parseColour(reader); })},
      {{.name = "transfer",
        .argument = "LIST",
        .help = "what is carried over from the target's nearest point: a list of uv (texture coordinates), Cd (painted "
                "colour) and names of vertex attributes",
        .idle = noPoints},
       parsedBy(parseTransferred)}};
  return rows;
}

}  // namespace

bool AttributeOptions::has(PointAttribute attribute) const {
  return std::find(computed.begin(), computed.end(), attribute) != computed.end();
}

std::vector<OptionSpec> attributeOptionSpecs() { return attributeRows().specs(); }

AttributeOptions parseAttributeOptions(const RecipeReader& reader) {
  AttributeOptions options = attributeRows().read(reader);
  // A colour is chosen to be seen, unless the files have another one.
  const std::vector<std::string>& names = options.transferred;
  if (options.colour && !options.has(PointAttribute::Cd) && std::find(names.begin(), names.end(), "Cd") == names.end())
    options.computed.insert(options.computed.begin(), PointAttribute::Cd);
  requireDistinct(reader, options);
  return options;
}

std::vector<VertexColumn> meshColumns(const AttributeOptions& options) {
  std::vector<VertexColumn> columns;
  for (const PointAttribute attribute : options.computed)
    for (const Known& one : known())
      if (one.attribute == attribute) columns.push_back(one.column);
  for (const std::string& name : options.transferred) columns.push_back(transferredColumn(name));
  return columns;
}

}  // namespace vdbtools
