// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/maps/direction_grids.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/base/fractal_space.h"
#include "vdbtools/base/memory.h"
#include "vdbtools/base/text.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/formats/vdb_file.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace vdbtools {
namespace {

using openvdb::Coord;
using openvdb::CoordBBox;
using openvdb::FloatGrid;
using openvdb::Vec3d;
using openvdb::Vec3SGrid;

/// "(1, 0.5, nan)"
std::string tupleText(const std::vector<double>& values) {
  std::string text;
  for (const double value : values) text += (text.empty() ? "(" : ", ") + shortText(value);
  return text + ")";
}

std::string placeText(const openvdb::math::Transform& transform, const Coord& node) {
  const Vec3d at = transform.indexToWorld(node);
  return "at " + tupleText({at[0], at[1], at[2]});
}

std::string gridList(const VdbFile& file) {
  std::string list;
  for (const auto& grid : file.grids)
    list += (list.empty() ? "" : ", ") + ("'" + grid->getName() + "' (" + grid->valueType() + ")");
  for (const auto& grid : file.unread) list += (list.empty() ? "" : ", ") + ("'" + grid.name + "' (" + grid.type + ")");
  return inOneLine(list);
}

/// The components of a grid of vectors, active where it is.
std::vector<FloatGrid::Ptr> componentsOf(const Vec3SGrid& vectors) {
  std::vector<FloatGrid::Ptr> components;
  for (int axis = 0; axis < 3; ++axis) {
    components.push_back(FloatGrid::create());
    components.back()->setTransform(vectors.constTransform().copy());
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    FloatGrid& component = *components[axis];
    FloatGrid::Accessor accessor = component.getAccessor();
    for (auto value = vectors.tree().cbeginValueOn(); value; ++value) {
      const float part = (*value)[static_cast<int>(axis)];
      CoordBBox box;
      if (!value.getBoundingBox(box) || box.volume() <= 1)
        accessor.setValueOn(value.getCoord(), part);
      else
        component.tree().fill(box, part, true);
    }
  }
  return components;
}

std::vector<double> valueAt(const DirectionGrids& grids, const Coord& node) {
  std::vector<double> values;
  for (const FloatGrid::Ptr& component : grids.components) values.push_back(component->tree().getValue(node));
  return values;
}

void requireFinite(const DirectionGrids& grids, const std::string& option) {
  for (const FloatGrid::Ptr& component : grids.components)
    for (auto value = component->tree().cbeginValueOn(); value; ++value)
      if (!std::isfinite(*value))
        throw DataError(option + ": " + grids.name + " is " + tupleText(valueAt(grids, value.getCoord())) + " " +
                        placeText(component->constTransform(), value.getCoord()) + "; directions must be finite");
}

bool isZero(const DirectionGrids& grids, const Coord& node) {
  return std::all_of(grids.components.begin(), grids.components.end(),
                     [&](const FloatGrid::Ptr& component) { return component->tree().getValue(node) == 0; });
}

/// Whether a node begins a cell whose corners are all 0.
bool beginsZeroCell(const DirectionGrids& grids, const Coord& node) {
  for (int x = 0; x < 2; ++x)
    for (int y = 0; y < 2; ++y)
      for (int z = 0; z < 2; ++z) {
        Coord corner = node.offsetBy(x, y, z);
        corner.minComponent(grids.nodes.max());
        if (!isZero(grids, corner)) return false;
      }
  return true;
}

void requireNoZeroCells(const DirectionGrids& grids, const CoordBBox& region, const std::string& option) {
  const FloatGrid& first = *grids.components.front();
  const auto refuse = [&](const Coord& node) {
    throw DataError(option + ": " + grids.name + " is " + tupleText(valueAt(grids, node)) + " " +
                    placeText(first.constTransform(), node) +
                    " and at its neighbours, which is no direction; only single vectors may have the length 0");
  };
  for (auto value = first.tree().cbeginValueOn(); value; ++value) {
    if (*value != 0) continue;
    CoordBBox box;
    value.getBoundingBox(box);
    box.intersect(region);
    for (auto node = box.begin(); node; ++node)
      if (isZero(grids, *node) && beginsZeroCell(grids, *node)) refuse(*node);
  }
}

/// Values on a box of nodes, some of which are known.
struct Level {
  Coord size;
  std::vector<float> values;  ///< the components of a node side by side
  std::vector<std::uint8_t> known;

  std::size_t index(int x, int y, int z) const {
    return (static_cast<std::size_t>(x) * static_cast<std::size_t>(size[1]) + static_cast<std::size_t>(y)) *
               static_cast<std::size_t>(size[2]) +
           static_cast<std::size_t>(z);
  }
};

template <class Body>
void forEachSlice(const Level& level, const Body& body) {
  tbb::parallel_for(0, level.size[0], body);
}

/// Halves the number of nodes along each axis. Each node is the mean of the known ones among the eight that it
/// replaces.
Level coarser(const Level& fine, std::size_t components) {
  Level coarse;
  for (int axis = 0; axis < 3; ++axis) coarse.size[axis] = (fine.size[axis] + 1) / 2;
  const std::size_t count = coarse.index(coarse.size[0] - 1, coarse.size[1] - 1, coarse.size[2] - 1) + 1;
  coarse.values.resize(count * components);
  coarse.known.resize(count);
  forEachSlice(coarse, [&](int x) {
    std::vector<double> sum(components);
    for (int y = 0; y < coarse.size[1]; ++y)
      for (int z = 0; z < coarse.size[2]; ++z) {
        int found = 0;
        std::fill(sum.begin(), sum.end(), 0);
        for (int corner = 0; corner < 8; ++corner) {
          const int i = 2 * x + (corner & 1), j = 2 * y + (corner >> 1 & 1), k = 2 * z + (corner >> 2);
          if (i >= fine.size[0] || j >= fine.size[1] || k >= fine.size[2]) continue;
          const std::size_t at = fine.index(i, j, k);
          if (!fine.known[at]) continue;
          ++found;
          for (std::size_t c = 0; c < components; ++c) sum[c] += double{fine.values[at * components + c]};
        }
        const std::size_t at = coarse.index(x, y, z);
        coarse.known[at] = found > 0;
        for (std::size_t c = 0; c < components; ++c)
          coarse.values[at * components + c] = found > 0 ? static_cast<float>(sum[c] / found) : 0;
      }
  });
  return coarse;
}

/// Sets nodes that are not known to the value interpolated from the coarser level.
void fill(Level& fine, const Level& coarse, std::size_t components) {
  forEachSlice(fine, [&](int x) {
    struct Place {
      int before, behind;
      double share;
    };
    const auto placeOf = [&](int node, int axis) {
      const double at = std::clamp((node - 0.5) / 2, 0., static_cast<double>(coarse.size[axis] - 1));
      const int before = static_cast<int>(at);
      return Place{before, std::min(before + 1, coarse.size[axis] - 1), at - before};
    };
    const Place px = placeOf(x, 0);
    for (int y = 0; y < fine.size[1]; ++y) {
      const Place py = placeOf(y, 1);
      for (int z = 0; z < fine.size[2]; ++z) {
        const std::size_t at = fine.index(x, y, z);
        if (fine.known[at]) continue;
        const Place pz = placeOf(z, 2);
        for (std::size_t c = 0; c < components; ++c) {
          double sum = 0;
          for (int corner = 0; corner < 8; ++corner) {
            const bool i = (corner & 1) != 0, j = (corner & 2) != 0, k = (corner & 4) != 0;
            const double weight =
                (i ? px.share : 1 - px.share) * (j ? py.share : 1 - py.share) * (k ? pz.share : 1 - pz.share);
            const std::size_t from =
                coarse.index(i ? px.behind : px.before, j ? py.behind : py.before, k ? pz.behind : pz.before);
            sum += weight * double{coarse.values[from * components + c]};
          }
          fine.values[at * components + c] = static_cast<float>(sum);
        }
      }
    }
  });
}

/// Fills in the nodes of a region that have no direction from those that have one. @return whether any have one
bool fillRegion(DirectionGrids& grids, const CoordBBox& region) {
  const std::size_t components = grids.components.size();
  constexpr double kLevels = 8. / 7;
  requireMemory(static_cast<double>(region.volume()) * (4. * static_cast<double>(components) + 1) * kLevels,
                MemoryUse::Field, "the field of directions about the target");
  std::vector<Level> levels(1);
  Level& finest = levels.front();
  finest.size = region.dim();
  finest.values.resize(region.volume() * components);
  finest.known.resize(region.volume());
  const auto nodeAt = [&](int x, int y, int z) { return region.min().offsetBy(x, y, z); };
  forEachSlice(finest, [&](int x) {
    std::vector<FloatGrid::ConstAccessor> read;
    for (const FloatGrid::Ptr& component : grids.components) read.push_back(component->getConstAccessor());
    for (int y = 0; y < finest.size[1]; ++y)
      for (int z = 0; z < finest.size[2]; ++z) {
        const std::size_t at = finest.index(x, y, z);
        for (std::size_t c = 0; c < components; ++c) {
          const Coord node = nodeAt(x, y, z);
          finest.values[at * components + c] = read[c].getValue(node);
          if (read[c].isValueOn(node)) finest.known[at] = 1;
        }
      }
  });
  if (std::none_of(finest.known.begin(), finest.known.end(), [](std::uint8_t known) { return known != 0; }))
    return false;
  const auto isWhole = [](const Level& level) {
    return std::all_of(level.known.begin(), level.known.end(), [](std::uint8_t known) { return known != 0; });
  };
  while (!isWhole(levels.back())) levels.push_back(coarser(levels.back(), components));
  for (std::size_t k = levels.size() - 1; k-- > 0;) fill(levels[k], levels[k + 1], components);
  const Level& made = levels.front();
  for (std::size_t c = 0; c < components; ++c) {
    FloatGrid::Accessor accessor = grids.components[c]->getAccessor();
    for (int x = 0; x < made.size[0]; ++x)
      for (int y = 0; y < made.size[1]; ++y)
        for (int z = 0; z < made.size[2]; ++z) {
          const std::size_t at = made.index(x, y, z);
          accessor.setValueOn(nodeAt(x, y, z), made.values[at * components + c]);
        }
  }
  return true;
}

}  // namespace

DirectionGrids readDirectionGrids(const std::filesystem::path& path, const std::vector<std::string>& names,
                                  const std::string& option) {
  const VdbFile file = readVdb(path);
  const std::string where = "'" + inOneLine(path.string()) + "'";
  const auto fail = [&](const std::string& why) {
    throw DataError(option + ": " + where + " " + why + "; its grids are " + gridList(file));
  };
  DirectionGrids result;
  if (names.size() <= 1) {
    std::vector<Vec3SGrid::ConstPtr> found;
    for (const auto& grid : file.grids)
      if (names.empty() || grid->getName() == names.front()) {
        if (const auto vectors = openvdb::gridConstPtrCast<Vec3SGrid>(grid))
          found.push_back(vectors);
        else if (!names.empty())
          fail("has the grid '" + names.front() + "' of the type " + grid->valueType() +
               ", and directions are vectors of three floats (vec3s), or three or four grids of floats");
      }
    if (found.size() != 1)
      fail((found.empty() ? "has no grid of vectors" : "has more than one grid of vectors") +
           (names.empty() ? std::string() : " called '" + names.front() + "'"));
    result.components = componentsOf(*found.front());
    result.name = "'" + inOneLine(found.front()->getName()) + "' of " + where;
  } else {
    for (const std::string& name : names) {
      result.name += (result.name.empty() ? "'" : ",") + inOneLine(name);
      const auto grid =
          std::find_if(file.grids.begin(), file.grids.end(), [&](const auto& each) { return each->getName() == name; });
      if (grid == file.grids.end()) fail("has no grid '" + name + "'");
      const FloatGrid::Ptr floats = openvdb::gridPtrCast<FloatGrid>(*grid);
      if (!floats) fail("has the grid '" + name + "' of the type " + (*grid)->valueType() + " where floats are wanted");
      if (!result.components.empty() && floats->constTransform() != result.components.front()->constTransform())
        fail("has the grids '" + names.front() + "' and '" + name + "' on different lattices");
      result.components.push_back(floats->deepCopy());
    }
    result.name += "' of " + where;
  }
  if (!result.components.front()->constTransform().isLinear()) fail("has a lattice that is not linear");
  for (const FloatGrid::Ptr& component : result.components)
    result.nodes.expand(component->evalActiveVoxelBoundingBox());
  if (result.nodes.empty()) fail("has no active voxel in " + result.name);
  requireFinite(result, option);
  return result;
}

DirectionGrids filledAbout(const DirectionGrids& grids, const openvdb::BBoxd& box, const std::string& option) {
  constexpr double kAround = 0.25;  // of the longest side
  const openvdb::math::Transform& transform = grids.components.front()->constTransform();
  openvdb::BBoxd about = box;
  about.expand(kAround * longestSide(box));
  const openvdb::BBoxd index = transform.worldToIndex(about);
  CoordBBox region(Coord::floor(index.min()), Coord::ceil(index.max()));
  region.intersect(grids.nodes);
  if (region.empty()) {
    const openvdb::BBoxd known =
        transform.indexToWorld(openvdb::BBoxd(grids.nodes.min().asVec3d(), grids.nodes.max().asVec3d()));
    throw DataError(option + ": " + grids.name + " lies beside the target: its voxels are from " +
                    tupleText({known.min()[0], known.min()[1], known.min()[2]}) + " to " +
                    tupleText({known.max()[0], known.max()[1], known.max()[2]}));
  }
  const bool isDense = std::all_of(grids.components.begin(), grids.components.end(), [&](const auto& component) {
    return component->activeVoxelCount() == grids.nodes.volume();
  });
  DirectionGrids result{{}, grids.name, grids.nodes};
  for (const FloatGrid::Ptr& component : grids.components)
    result.components.push_back(isDense ? component : component->deepCopy());
  if (!isDense) {
    if (!fillRegion(result, region))
      throw DataError(option + ": " + grids.name + " has no active voxel about the target, whose box is from " +
                      tupleText({box.min()[0], box.min()[1], box.min()[2]}) + " to " +
                      tupleText({box.max()[0], box.max()[1], box.max()[2]}));
    result.nodes = region;
  }
  requireNoZeroCells(result, region, option);
  return result;
}

}  // namespace vdbtools
