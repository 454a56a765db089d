// SPDX-License-Identifier: Apache-2.0
#include "farm/tile_islands.h"

#include "base/disjoint_sets.h"
#include "field/block_layers.h"
#include "field/leaf_signs.h"

#include "julia/evaluator.h"
#include "vdbtools/base/errors.h"

#include <openvdb/tree/ValueAccessor.h>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <utility>

namespace vdbtools::farm {
namespace {

using openvdb::Coord;
using openvdb::CoordBBox;
using openvdb::FloatTree;
using Leaf = FloatTree::LeafNodeType;

constexpr unsigned kAll = 0xff;

int blockStart(int node) { return node & ~(kBlock - 1); }

/// The inside nodes of a column of blocks along z.
class Column {
 public:
  /// @param nodes  the requested nodes of the column
  Column(const FloatTree& tree, const CoordBBox& nodes) : mNodes(nodes), mFirst(blockStart(nodes.min()[2])) {
    const openvdb::tree::ValueAccessor<const FloatTree> leaves(tree);
    const Coord first = nodes.min() & ~(kBlock - 1);
    for (int z = mFirst; z <= nodes.max()[2]; z += kBlock) {
      Block block;
      if (const Leaf* const leaf = leaves.probeConstLeaf(Coord(first[0], first[1], z))) {
        block.hasLeaf = true;
        block.bits = insideBits(*leaf);
      }
      mBlocks.push_back(block);
    }
    copySigns();
  }

  /// Whether no block has a leaf, so that one node has the sign of all.
  bool hasOneSign() const { return mLeaves == 0; }
  Coord anyNode() const { return mNodes.min(); }
  void setSign(bool inside) {
    for (Block& block : mBlocks) fill(block, inside);
  }

  /// The runs of all rows, ordered by x, y, z.
  std::vector<InsideRun> runs() const {
    std::vector<InsideRun> result;
    for (int x = mNodes.min()[0]; x <= mNodes.max()[0]; ++x)
      for (int y = mNodes.min()[1]; y <= mNodes.max()[1]; ++y) addRow(x, y, result);
    return result;
  }

 private:
  struct Block {
    InsideBits bits{};
    bool hasLeaf = false;
  };

  static void fill(Block& block, bool inside) { block.bits.fill(inside ? ~std::uint64_t(0) : 0); }
  static unsigned row(const Block& block, int x, int y) {
    return static_cast<unsigned>(block.bits[static_cast<std::size_t>(x & (kBlock - 1))] >>
                                 (kBlock * (y & (kBlock - 1)))) &
           kAll;
  }

  /// If a block has no leaf, the field does not change sign between it and the adjacent blocks.
  void copySigns() {
    const auto signAt = [&](const Block& block, int z) {
      return (row(block, mNodes.min()[0], mNodes.min()[1]) >> z & 1) != 0;
    };
    std::size_t first = mBlocks.size();
    for (std::size_t i = 0; i < mBlocks.size(); ++i) {
      if (mBlocks[i].hasLeaf) {
        ++mLeaves;
        first = std::min(first, i);
      } else if (mLeaves > 0) {
        fill(mBlocks[i], signAt(mBlocks[i - 1], kBlock - 1));
      }
    }
    for (std::size_t i = 0; mLeaves > 0 && i < first; ++i) fill(mBlocks[i], signAt(mBlocks[first], 0));
  }

  void addRow(int x, int y, std::vector<InsideRun>& result) const {
    constexpr int kNone = std::numeric_limits<int>::min();
    int begin = kNone;
    const auto change = [&](int z, bool inside) {
      if (inside && begin == kNone) begin = z;
      if (inside || begin == kNone) return;
      result.push_back({x, y, begin, z - 1, 0});
      begin = kNone;
    };
    const int low = mNodes.min()[2], high = mNodes.max()[2];
    int z = mFirst;
    for (const Block& block : mBlocks) {
      const unsigned bits = row(block, x, y);
      if (bits == 0 || bits == kAll) {
        change(std::max(z, low), bits != 0);
      } else {
        for (int k = std::max(0, low - z); k < kBlock && z + k <= high; ++k) change(z + k, (bits >> k & 1) != 0);
      }
      z += kBlock;
    }
    change(high + 1, false);
  }

  CoordBBox mNodes;
  int mFirst;
  std::vector<Block> mBlocks;
  std::size_t mLeaves = 0;
};

/// Calls body(a, b) for all pairs of runs with nodes of the same z.
template <class Body>
void forEachOverlap(std::span<const InsideRun> some, std::span<const InsideRun> others, const Body& body) {
  std::size_t i = 0, j = 0;
  while (i < some.size() && j < others.size()) {
    if (some[i].first <= others[j].last && others[j].first <= some[i].last) body(some[i], others[j]);
    ++(some[i].last < others[j].last ? i : j);
  }
}

}  // namespace

TileIslands::TileIslands(const FractalField& field, const FieldSource& source, const CoordBBox& box, Monitor& monitor)
    : mBox(box), mLabelled(box.min(), box.max().offsetBy(1)) {
  mLabelled.intersect(field.domain);
  findRuns(field, source, monitor);
  joinRuns(monitor);
  for (const InsideRun& run : mRuns)
    if (const std::optional<InsideRun> own = ownPart(run))
      mParts[own->part].island.addBox({{own->x, own->y, own->first}, {own->x, own->y, own->last}});
}

void TileIslands::findRuns(const FractalField& field, const FieldSource& source, Monitor& monitor) {
  const Coord low = mLabelled.min(), high = mLabelled.max();
  const auto columnCount = static_cast<std::size_t>((blockStart(high[1]) - blockStart(low[1])) / kBlock) + 1;
  monitor.begin(PhaseKind::Islands, static_cast<std::uint64_t>(high[0] - low[0]) + 1);
  for (int x = blockStart(low[0]); x <= high[0]; x += kBlock) {
    CoordBBox layer = mLabelled;
    layer.min()[0] = std::max(low[0], x);
    layer.max()[0] = std::min(high[0], x + kBlock - 1);
    std::vector<std::vector<InsideRun>> columns(columnCount);
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, columnCount), [&](const auto& range) {
      for (std::size_t i = range.begin(); i != range.end() && !monitor.cancelled(); ++i) {
        const int y = blockStart(low[1]) + kBlock * static_cast<int>(i);
        CoordBBox nodes = layer;
        nodes.min()[1] = std::max(low[1], y);
        nodes.max()[1] = std::min(high[1], y + kBlock - 1);
        Column column(field.field->tree(), nodes);
        if (column.hasOneSign()) {
          const julia::Point point = source.space.toFractal(column.anyNode().asVec3d() * field.field->voxelSize()[0]);
          double value = 0;
          source.evaluator.evaluate({&point, 1}, {&value, 1}, {});
          column.setSign(julia::storedField(value) < 0);
        }
        columns[i] = column.runs();
      }
    });
    monitor.throwIfCancelled();
    std::vector<std::size_t> next(columnCount, 0);
    for (int row = layer.min()[0]; row <= layer.max()[0]; ++row) {
      for (int y = low[1]; y <= high[1]; ++y) {
        mRows.push_back(mRuns.size());
        const auto i = static_cast<std::size_t>((blockStart(y) - blockStart(low[1])) / kBlock);
        for (; next[i] < columns[i].size() && columns[i][next[i]].x == row && columns[i][next[i]].y == y; ++next[i])
          mRuns.push_back(columns[i][next[i]]);
      }
      monitor.advance(1);
    }
  }
  mRows.push_back(mRuns.size());
  if (mRuns.size() > std::numeric_limits<std::uint32_t>::max())
    throw DataError("the tile has " + std::to_string(mRuns.size()) +
                    " runs of inside nodes, more than can be numbered; cut the fractal into more tiles");
}

void TileIslands::joinRuns(Monitor& monitor) {
  DisjointSets<std::uint32_t> sets(mRuns.size());
  const auto join = [&](const InsideRun& a, const InsideRun& b) {
    sets.join(static_cast<std::uint32_t>(&a - mRuns.data()), static_cast<std::uint32_t>(&b - mRuns.data()));
  };
  tbb::parallel_for(mLabelled.min()[0], mLabelled.max()[0] + 1, [&](int x) {
    if (monitor.cancelled()) return;
    for (int y = mLabelled.min()[1]; y <= mLabelled.max()[1]; ++y) {
      if (x > mLabelled.min()[0]) forEachOverlap(row(x - 1, y), row(x, y), join);
      if (y > mLabelled.min()[1]) forEachOverlap(row(x, y - 1), row(x, y), join);
    }
  });
  monitor.throwIfCancelled();
  // The first run of a set names it, and has its number already.
  for (std::uint32_t i = 0; i < mRuns.size(); ++i) {
    const std::uint32_t name = sets.find(i);
    mRuns[i].part = name == i ? static_cast<std::uint32_t>(mParts.size()) : mRuns[name].part;
    if (name == i) mParts.emplace_back();
  }
}

std::span<const InsideRun> TileIslands::row(int x, int y) const {
  const Coord sides = mLabelled.dim();
  const auto number = static_cast<std::size_t>(x - mLabelled.min()[0]) * static_cast<std::size_t>(sides[1]) +
                      static_cast<std::size_t>(y - mLabelled.min()[1]);
  return std::span(mRuns).subspan(mRows[number], mRows[number + 1] - mRows[number]);
}

std::optional<InsideRun> TileIslands::ownPart(const InsideRun& run) const {
  InsideRun own = run;
  own.last = std::min(run.last, mBox.max()[2]);
  if (run.x > mBox.max()[0] || run.y > mBox.max()[1] || own.last < own.first) return std::nullopt;
  return own;
}

std::optional<std::uint32_t> TileIslands::partOf(const Coord& node) const {
  if (!mLabelled.isInside(node)) return std::nullopt;
  const std::span<const InsideRun> runs = row(node[0], node[1]);
  const auto at =
      std::lower_bound(runs.begin(), runs.end(), node[2], [](const InsideRun& run, int z) { return run.last < z; });
  if (at == runs.end() || at->first > node[2]) return std::nullopt;
  return at->part;
}

std::uint32_t TileIslands::partOf(const EdgePlace& edge) const {
  Coord end = edge.node;
  ++end[edge.axis];
  const std::optional<std::uint32_t> here = partOf(edge.node), there = partOf(end);
  if (here.has_value() == there.has_value())
    throw std::logic_error("a point of the mesh lies on an edge from " + std::to_string(edge.node[0]) + ", " +
                           std::to_string(edge.node[1]) + ", " + std::to_string(edge.node[2]) +
                           " whose ends are both " + (here ? "inside" : "outside"));
  return here ? *here : *there;
}

JoinedIslands joinIslands(std::span<const TileIslandsReader> tiles, const IslandOptions& options, double voxelSize,
                          Monitor& monitor) {
  struct Run {
    Coord first;
    int last;
    std::size_t part;  // of all tiles
  };
  std::vector<Island> parts;
  std::vector<Run> faces, beyond;
  for (const TileIslandsReader& tile : tiles) {
    const auto add = [&, before = parts.size()](const std::vector<InsideRun>& from, std::vector<Run>& to) {
      for (const InsideRun& run : from) to.push_back({{run.x, run.y, run.first}, run.last, before + run.part});
    };
    add(tile.faces(), faces);
    add(tile.beyond(), beyond);
    for (const TilePart& part : tile.parts()) parts.push_back(part.island);
  }
  monitor.begin(PhaseKind::JoiningIslands, beyond.size());
  // Each node has one owner, so these do not overlap.
  std::sort(faces.begin(), faces.end(), [](const Run& a, const Run& b) { return a.first < b.first; });
  DisjointSets<std::size_t> sets(parts.size());
  for (const Run& run : beyond) {
    auto face = std::lower_bound(faces.begin(), faces.end(), run.first, [](const Run& a, const Coord& node) {
      return Coord(a.first[0], a.first[1], a.last) < node;
    });
    const auto meets = [&] {
      return face != faces.end() && face->first[0] == run.first[0] && face->first[1] == run.first[1] &&
             face->first[2] <= run.last;
    };
    int next = run.first[2];
    for (; meets() && face->first[2] <= next; ++face) {
      sets.join(run.part, face->part);
      next = face->last + 1;
    }
    if (next <= run.last)
      throw DataError("the tiles do not fit together: node " + std::to_string(run.first[0]) + ", " +
                      std::to_string(run.first[1]) + ", " + std::to_string(next) +
                      " lies inside for a tile that it is next to, and for no tile that owns it; make the tiles again");
    monitor.advance(1);
  }
  monitor.throwIfCancelled();
  std::vector<Island*> islands;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (const std::size_t name = sets.find(i); name != i)
      parts[name].add(parts[i]);
    else
      islands.push_back(&parts[i]);
  }
  JoinedIslands joined{.report = chooseIslands(islands, options, voxelSize)};
  std::size_t number = 0;
  for (const TileIslandsReader& tile : tiles) {
    std::vector<bool>& kept = joined.keptParts.emplace_back();
    for (const TilePart& part : tile.parts()) {
      kept.push_back(parts[sets.find(number++)].isKept);
      if (!kept.back()) continue;
      joined.points += part.points;
      joined.capPoints += part.capPoints;
    }
  }
  return joined;
}

}  // namespace vdbtools::farm
