// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/base/text.h"
#include "vdbtools/formats/vdb_file.h"

#include "base/lattice_transform.h"

#include <openvdb/points/PointDataGrid.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <string>

namespace vdbtools {
namespace {

using openvdb::Coord;
using openvdb::Vec3d;
using openvdb::Vec3s;
using openvdb::points::AttributeSet;
using openvdb::points::AttributeWriteHandle;
using openvdb::points::PointDataGrid;
using openvdb::points::PointDataTree;
using openvdb::points::TypedAttributeArray;
using Leaf = PointDataTree::LeafNodeType;

/// A point, and the voxel that holds it.
struct Entry {
  Coord leaf;
  openvdb::Index voxel;
  std::uint32_t point;
};

std::vector<Entry> sortedEntries(const std::vector<Vec3d>& indexPositions) {
  std::vector<Entry> entries(indexPositions.size());
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const Coord voxel = Coord::round(indexPositions[i]);
    entries[i] = {voxel & ~int(Leaf::DIM - 1), Leaf::coordToOffset(voxel), static_cast<std::uint32_t>(i)};
  }
  std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
    return std::tie(a.leaf, a.voxel, a.point) < std::tie(b.leaf, b.voxel, b.point);
  });
  return entries;
}

const openvdb::NamePair& typeOf(ColumnKind kind) {
  return componentsOf(kind) == 1 ? TypedAttributeArray<float>::attributeType()
                                 : TypedAttributeArray<Vec3s>::attributeType();
}

/// Descriptors of the attributes of the points, from P alone to all of them.
std::vector<AttributeSet::Descriptor::Ptr> descriptorsOf(bool normals, const std::vector<VertexColumn>& columns) {
  const openvdb::NamePair& vector = TypedAttributeArray<Vec3s>::attributeType();
  std::vector<AttributeSet::Descriptor::Ptr> descriptors = {AttributeSet::Descriptor::create(vector)};
  const auto append = [&](const std::string& name, const openvdb::NamePair& type) {
    descriptors.push_back(descriptors.back()->duplicateAppend(name, type));
  };
  if (normals) append("N", vector);
  for (const VertexColumn& column : columns) append(column.name, typeOf(column.kind));
  return descriptors;
}

/// Writes an attribute of a leaf with the points @a entries. @param valueOf  takes the number of a point
template <class Value, class ValueOf>
void write(Leaf& leaf, const std::string& name, std::span<const Entry> entries, const ValueOf& valueOf) {
  AttributeWriteHandle<Value> handle(leaf.attributeArray(name));
  for (std::size_t i = 0; i < entries.size(); ++i)
    handle.set(static_cast<openvdb::Index>(i), valueOf(entries[i].point));
}

}  // namespace

openvdb::GridBase::Ptr pointGrid(const PointBatch& points, const std::vector<VertexColumn>& columns, double spacing) {
  openvdb::initialize();
  const std::size_t count = points.positions.size(), row = rowLength(columns);
  if (count == 0) throw std::invalid_argument("there are no points to write");
  if (!(spacing > 0) || !std::isfinite(spacing))
    throw std::invalid_argument("points were given a spacing of " + shortText(spacing) + "; it must be positive");
  if ((!points.normals.empty() && points.normals.size() != count) || points.values.size() != row * count)
    throw std::logic_error("points of a VDB come with another number of normals or values than they need");
  // Elsewhere a voxel size is chosen by an option; here it follows from the points.
  requireVdbVoxel(2 * spacing, "such points lie in voxels of twice their spacing; write a .ply instead");
  const auto transform = latticeTransform(2 * spacing);
  std::vector<Vec3d> positions;
  positions.reserve(count);
  for (const Vec3d& p : points.positions) positions.push_back(transform->worldToIndex(p));

  const std::vector<Entry> entries = sortedEntries(positions);
  std::vector<AttributeSet::Descriptor::Ptr> descriptors = descriptorsOf(!points.normals.empty(), columns);
  const auto tree = std::make_shared<PointDataTree>();
  for (auto begin = entries.begin(); begin != entries.end();) {
    const auto end = std::find_if(begin, entries.end(), [&](const Entry& entry) { return entry.leaf != begin->leaf; });
    const std::span<const Entry> some(begin, end);
    Leaf* leaf = tree->touchLeaf(begin->leaf);
    leaf->initializeAttributes(descriptors.front(), static_cast<openvdb::Index>(some.size()));
    for (std::size_t k = 1; k < descriptors.size(); ++k) leaf->appendAttribute(*descriptors[k - 1], descriptors[k], k);
    std::vector<Leaf::ValueType> ends(Leaf::SIZE);  // number of points up to and including each voxel
    std::size_t passed = 0;
    for (openvdb::Index voxel = 0; voxel < Leaf::SIZE; ++voxel) {
      while (passed < some.size() && some[passed].voxel == voxel) ++passed;
      ends[voxel] = static_cast<std::uint32_t>(passed);
    }
    leaf->setOffsets(ends);
    write<Vec3s>(*leaf, "P", some,
                 [&](std::uint32_t i) { return Vec3s(positions[i] - Coord::round(positions[i]).asVec3d()); });
    if (!points.normals.empty()) write<Vec3s>(*leaf, "N", some, [&](std::uint32_t i) { return points.normals[i]; });
    std::size_t offset = 0;
    for (const VertexColumn& column : columns) {
      const std::size_t components = componentsOf(column.kind);
      const auto value = [&](std::uint32_t i, std::size_t k) {
        return k < components ? points.values[i * row + offset + k] : 0.0F;
      };
      if (components == 1)
        write<float>(*leaf, column.name, some, [&](std::uint32_t i) { return value(i, 0); });
      else
        write<Vec3s>(*leaf, column.name, some,
                     [&](std::uint32_t i) { return Vec3s(value(i, 0), value(i, 1), value(i, 2)); });
      offset += components;
    }
    begin = end;
  }
  const PointDataGrid::Ptr grid = PointDataGrid::create(tree);
  grid->setTransform(transform);
  grid->setName("points");
  return grid;
}

}  // namespace vdbtools
