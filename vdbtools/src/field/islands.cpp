// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/field/islands.h"
#include "vdbtools/base/text.h"

#include "base/disjoint_sets.h"
#include "distance/mesh_conversion.h"
#include "field/island_choice.h"

#include <openvdb/tree/ValueAccessor.h>

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <map>
#include <stdexcept>
#include <unordered_map>
#include <utility>
#include <vector>

namespace vdbtools {
namespace {

using openvdb::Coord;
using openvdb::CoordBBox;
using openvdb::FloatTree;
using openvdb::Index;
using Upper = FloatTree::RootNodeType::ChildNodeType;
using Lower = Upper::ChildNodeType;
using Leaf = Lower::ChildNodeType;
// One for each leaf: these are too many to register with the tree, and its nodes do not move.
using Accessor = openvdb::tree::ValueAccessor<const FloatTree, /*IsSafe=*/false>;

constexpr std::size_t kNoPart = ~std::size_t(0);

/// The values of one node of the tree (leaf or internal) form a cube of cells: lattice nodes in a leaf, tiles
/// elsewhere.
template <class Node>
struct Cube {
  static constexpr Index kSide = 1 << Node::LOG2DIM;                          // cells
  static constexpr int kCell = static_cast<int>(Node::DIM >> Node::LOG2DIM);  // lattice nodes
  static constexpr std::array<Index, 3> kStride = {kSide * kSide, kSide, 1};  // between offsets, by axis
  static constexpr Index kRows = kSide * kSide;                               // along z
  static constexpr std::size_t kMostParts = Node::NUM_VALUES / 2;             // a chessboard pattern
  using Label = std::conditional_t<kMostParts <= 256, std::uint8_t, std::uint16_t>;
};

template <class Node>
struct Block {
  Node* node = nullptr;
  typename Node::NodeMaskType inside;              ///< cells, excluding those with a child
  std::vector<typename Cube<Node>::Label> labels;  ///< the part of each cell; empty if there is only one part
  std::size_t firstPart = 0, partCount = 0;

  std::size_t partOf(Index cell) const { return firstPart + (labels.empty() ? 0 : labels[cell]); }
};

/// A mask of @a length < 64 bits from @a begin on.
std::uint64_t bits(Index begin, Index length) { return ((std::uint64_t(1) << length) - 1) << begin; }

void findInside(Block<Leaf>& block) {
  const float* values = block.node->buffer().data();
  for (Index word = 0; word < Leaf::SIZE / 64; ++word) {
    std::uint64_t signs = 0;
    for (Index bit = 0; bit < 64; ++bit) signs |= std::uint64_t(values[64 * word + bit] < 0) << bit;
    block.inside.getWord<std::uint64_t>(word) = signs;
  }
}

template <class Node>
void findInside(Block<Node>& block) {
  for (auto value = block.node->cbeginValueAll(); value; ++value)
    if (*value < 0) block.inside.setOn(value.pos());
}

/// Calls body(row, begin, length) for every run of inside cells along z, in the order of (x, y, z).
template <class Node, class Body>
void forEachRun(const Block<Node>& block, const Body& body) {
  using C = Cube<Node>;
  for (Index row = 0; row < C::kRows; ++row) {
    const Index bit = row * C::kSide;
    const auto word = block.inside.template getWord<std::uint64_t>(bit / 64);
    std::uint64_t cells = (word >> (bit % 64)) & bits(0, C::kSide);
    while (cells) {
      const auto begin = static_cast<Index>(std::countr_zero(cells));
      const auto length = static_cast<Index>(std::countr_one(cells >> begin));
      body(row, begin, length);
      cells &= ~bits(begin, length);
    }
  }
}

/// Numbers the parts in the order of their first cells.
template <class Node>
void labelParts(Block<Node>& block) {
  using C = Cube<Node>;
  using Label = typename C::Label;
  std::array<Label, C::kMostParts> parents;  // by run
  std::array<std::uint32_t, C::kMostParts> runs;
  std::array<Index, C::kRows + 1> firstRun;  // by row
  const auto root = [&](Index run) {
    while (parents[run] != run) run = parents[run];
    return run;
  };
  Index count = 0, rows = 0;
  forEachRun(block, [&](Index row, Index begin, Index length) {
    while (rows <= row) firstRun[rows++] = count;
    parents[count] = static_cast<Label>(count);
    runs[count] = static_cast<std::uint32_t>(bits(begin, length));
    const auto joinRow = [&](Index before) {
      for (Index run = firstRun[before]; run < firstRun[before + 1]; ++run) {
        if (!(runs[run] & runs[count])) continue;
        const auto [low, high] = std::minmax({root(run), root(count)});
        parents[high] = static_cast<Label>(low);
      }
    };
    if (row % C::kSide) joinRow(row - 1);
    if (row >= C::kSide) joinRow(row - C::kSide);
    ++count;
  });
  // A parent comes before its children, so its number is known already.
  std::array<Label, C::kMostParts> numbers;
  for (Index run = 0; run < count; ++run)
    numbers[run] = parents[run] == run ? static_cast<Label>(block.partCount++) : numbers[parents[run]];
  if (block.partCount < 2) return;
  block.labels.resize(Node::NUM_VALUES);
  const Label* number = numbers.data();
  forEachRun(block, [&](Index row, Index begin, Index length) {
    std::fill_n(block.labels.begin() + row * C::kSide + begin, length, *number++);
  });
}

/// The nodes of one kind, and the index of each.
template <class Node>
struct Level {
  std::vector<Block<Node>> blocks;
  std::unordered_map<const Node*, std::size_t> index;

  explicit Level(FloatTree& tree) {
    std::vector<Node*> nodes;
    tree.getNodes(nodes);
    blocks.resize(nodes.size());
    index.reserve(nodes.size());
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      blocks[i].node = nodes[i];
      index.emplace(nodes[i], i);
    }
  }

  const Block<Node>& of(const Node* node) const { return blocks[index.at(node)]; }

  /// Runs body(block) over all blocks in threads; a cancelled run ends early.
  template <class Body>
  void forEach(const Monitor& monitor, const Body& body) {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, blocks.size(), 16), [&](const auto& range) {
      for (std::size_t i = range.begin(); i != range.end() && !monitor.cancelled(); ++i) body(blocks[i]);
    });
  }
};

/// Finds all inside cells of a tree, and which of them are connected.
class IslandFinder {
 public:
  IslandFinder(FloatTree& tree, Monitor& monitor)
      : mTree(tree), mLeaves(tree), mLowers(tree), mUppers(tree), mParts(label(monitor)), mSets(mParts.size()) {
    forEachLevel([&](auto& level) { level.forEach(monitor, [&](const auto& block) { measure(block); }); });
    forEachLevel([&](auto& level) { level.forEach(monitor, [&](const auto& block) { joinAcrossFaces(block); }); });
    joinRootTiles();
    monitor.throwIfCancelled();
    for (std::size_t i = 0; i < mParts.size(); ++i)
      if (mSets.find(i) != i) mParts[mSets.find(i)].add(mParts[i]);
  }

  std::vector<Island*> islands() {
    std::vector<Island*> result;
    for (std::size_t i = 0; i < mParts.size(); ++i)
      if (mSets.find(i) == i) result.push_back(&mParts[i]);
    return result;
  }

  /// Turns the islands that are not kept into outside.
  void drop() {
    const Monitor untilDone;  // stopping halfway would be worse than not starting
    forEachLevel([&](auto& level) { level.forEach(untilDone, [&](const auto& block) { drop(block); }); });
    for (auto tile = mTree.root().beginValueAll(); tile; ++tile)
      if (*tile < 0 && !isKept(mRootTiles.at(tile.getCoord()))) tile.setValue(-*tile);
  }

 private:
  template <class Body>
  void forEachLevel(const Body& body) {
    body(mLeaves);
    body(mLowers);
    body(mUppers);
  }

  bool isKept(std::size_t part) { return mParts[mSets.find(part)].isKept; }

  /// @return how many parts there are
  std::size_t label(Monitor& monitor) {
    monitor.begin(PhaseKind::Islands, mLeaves.blocks.size());
    std::size_t count = 0;
    forEachLevel([&](auto& level) {
      level.forEach(monitor, [&](auto& block) {
        findInside(block);
        labelParts(block);
        if (block.node->getLevel() == 0) monitor.advance(1);
      });
      for (auto& block : level.blocks) {
        block.firstPart = count;
        count += block.partCount;
      }
    });
    for (auto tile = mTree.root().cbeginValueAll(); tile; ++tile)
      if (*tile < 0) mRootTiles.emplace(tile.getCoord(), count++);
    monitor.throwIfCancelled();
    return count;
  }

  template <class Node>
  void measure(const Block<Node>& block) {
    constexpr int kCell = Cube<Node>::kCell;
    forEachRun(block, [&](Index row, Index begin, Index length) {
      const Index cell = row * Cube<Node>::kSide + begin;
      const Coord origin = block.node->offsetToGlobalCoord(cell);
      mParts[block.partOf(cell)].addBox(
          {origin, origin.offsetBy(kCell - 1, kCell - 1, kCell * static_cast<int>(length) - 1)});
    });
  }

  /// Joins each pair of neighbours from one side: cells of equal size from the first one, others from the smaller one.
  template <class Node>
  void joinAcrossFaces(const Block<Node>& block) {
    if (block.inside.isOff()) return;
    const Accessor accessor(mTree);
    for (int axis = 0; axis < 3; ++axis)
      for (const bool far : {false, true}) {
        Coord beyond = block.node->origin();
        beyond[axis] += far ? static_cast<int>(Node::DIM) : -1;
        if (const Node* neighbour = accessor.probeConstNode<Node>(beyond)) {
          if (far) joinFaces(block, levelOf(neighbour).of(neighbour), axis);
        } else if (const std::size_t part = partOfTile(accessor, beyond); part != kNoPart) {
          joinFaceToTile(block, axis, far, part);
        }
      }
  }

  template <class Node>
  void joinFaces(const Block<Node>& block, const Block<Node>& next, int axis) {
    std::pair<std::size_t, std::size_t> last(kNoPart, kNoPart);  // most cells join the same two parts
    forEachOfFace<Node>(axis, [&](Index near, Index far) {
      if (!block.inside.isOn(far) || !next.inside.isOn(near)) return;
      const std::pair parts(block.partOf(far), next.partOf(near));
      if (parts != last) mSets.join(parts.first, parts.second);
      last = parts;
    });
  }

  template <class Node>
  void joinFaceToTile(const Block<Node>& block, int axis, bool far, std::size_t tile) {
    forEachOfFace<Node>(axis, [&](Index near, Index farCell) {
      const Index cell = far ? farCell : near;
      if (block.inside.isOn(cell)) mSets.join(block.partOf(cell), tile);
    });
  }

  /// Calls body(near, far) with the offsets of two cells on opposite faces.
  template <class Node, class Body>
  static void forEachOfFace(int axis, const Body& body) {
    using C = Cube<Node>;
    const auto stride = [&](int k) { return C::kStride[static_cast<std::size_t>((axis + k) % 3)]; };
    for (Index u = 0; u < C::kSide; ++u)
      for (Index v = 0; v < C::kSide; ++v) {
        const Index near = u * stride(1) + v * stride(2);
        body(near, near + (C::kSide - 1) * stride(0));
      }
  }

  /// The part of the inside tile at @a node, if the tree has no leaf there.
  std::size_t partOfTile(const Accessor& accessor, const Coord& node) const {
    const auto in = [&](const auto& block) {
      const Index cell = block.node->coordToOffset(node);
      return block.inside.isOn(cell) ? block.partOf(cell) : kNoPart;
    };
    if (const Lower* lower = accessor.probeConstNode<Lower>(node)) return in(mLowers.of(lower));
    if (const Upper* upper = accessor.probeConstNode<Upper>(node)) return in(mUppers.of(upper));
    const auto found = mRootTiles.find(node & ~(static_cast<int>(Upper::DIM) - 1));
    return found == mRootTiles.end() ? kNoPart : found->second;
  }

  void joinRootTiles() {
    constexpr int kSide = Upper::DIM;
    for (const auto& [origin, part] : mRootTiles) {
      mParts[part].addBox(CoordBBox::createCube(origin, kSide));
      for (int axis = 0; axis < 3; ++axis) {
        Coord next = origin;
        next[axis] += kSide;
        if (const auto found = mRootTiles.find(next); found != mRootTiles.end()) mSets.join(part, found->second);
      }
    }
  }

  template <class Node>
  void drop(const Block<Node>& block) {
    std::array<bool, Cube<Node>::kMostParts> dropped;
    bool any = false;
    for (std::size_t i = 0; i < block.partCount; ++i) {
      dropped[i] = !isKept(block.firstPart + i);
      any = any || dropped[i];
    }
    if (!any) return;
    for (auto value = block.node->beginValueAll(); value; ++value)
      if (block.inside.isOn(value.pos()) && dropped[block.partOf(value.pos()) - block.firstPart])
        value.setValue(-*value);
  }

  const Level<Leaf>& levelOf(const Leaf*) const { return mLeaves; }
  const Level<Lower>& levelOf(const Lower*) const { return mLowers; }
  const Level<Upper>& levelOf(const Upper*) const { return mUppers; }

  FloatTree& mTree;
  Level<Leaf> mLeaves;
  Level<Lower> mLowers;
  Level<Upper> mUppers;
  std::map<Coord, std::size_t> mRootTiles;  ///< inside tiles by origin, each a separate part
  std::vector<Island> mParts;  ///< parts within one node of the tree; the first of those joined is the whole island
  DisjointSets<std::size_t> mSets;
};

}  // namespace

IslandReport dropIslands(FractalField& field, const IslandOptions& options, Monitor& monitor) {
  if (!(options.minSize >= 0 && std::isfinite(options.minSize)))
    throw std::invalid_argument("the smallest size of islands is " + shortText(options.minSize) +
                                "; it must be 0 or above, world units");
  IslandFinder finder(field.field->tree(), monitor);
  const IslandReport report = chooseIslands(finder.islands(), options, field.field->voxelSize()[0]);
  if (report.droppedNodes) finder.drop();
  return report;
}

}  // namespace vdbtools
