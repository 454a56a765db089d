// SPDX-License-Identifier: Apache-2.0
#include "field/undecided_blocks.h"

#include "base/in_parallel.h"

#include <cmath>
#include <span>
#include <utility>
#include <vector>

namespace vdbtools {
namespace {

using openvdb::Coord;
using openvdb::CoordBBox;
using MaskLeaf = BlockSet::LeafNodeType;

struct Cube {
  MaskLeaf* leaf;
  Coord corner;  // blocks
};

/// The blocks of the leaf in a cube of so many a side.
template <class Body>
void forEachBlock(const Cube& cube, int blocks, const Body& body) {
  for (int x = 0; x < blocks; ++x)
    for (int y = 0; y < blocks; ++y)
      for (int z = 0; z < blocks; ++z) body(MaskLeaf::coordToOffset(cube.corner.offsetBy(x, y, z)));
}

bool holdsBlocks(const Cube& cube, int blocks) {
  bool any = false;
  forEachBlock(cube, blocks, [&](openvdb::Index at) { any = any || cube.leaf->isValueOn(at); });
  return any;
}

}  // namespace

void decideCubes(std::span<const Coord> corners, int side, double voxelSize, const CoordBBox& domain,
                 const FieldSource& source, std::vector<julia::Decision>& decisions) {
  std::vector<julia::Point> centres;
  centres.reserve(corners.size());
  for (const Coord& corner : corners)
    centres.push_back(source.space.toFractal((corner.asVec3d() + openvdb::Vec3d(0.5 * (side - 1))) * voxelSize));
  const double radius = std::sqrt(3.0) * 0.5 * (side + 1) * voxelSize / source.space.scale;
  decisions.resize(corners.size());
  source.evaluator.decide(centres, radius, decisions);
  for (std::size_t i = 0; i < corners.size(); ++i)
    if (!domain.isInside(CoordBBox(corners[i].offsetBy(-1), corners[i].offsetBy(side))))
      decisions[i] = julia::Decision::Undecided;
}

BlockSet undecidedBlocks(const FieldPlan& plan, const FieldSource& source, Monitor& monitor) {
  BlockSet blocks(*plan.blocks);
  std::vector<MaskLeaf*> leaves;
  blocks.getNodes(leaves);
  monitor.begin("proofs", leaves.size());
  inParallel(leaves.size(), 32, monitor, [&](std::size_t begin, std::size_t end) {
    std::vector<Cube> cubes, rest;
    for (std::size_t i = begin; i != end; ++i) cubes.push_back({leaves[i], leaves[i]->origin()});
    std::vector<Coord> corners;
    std::vector<julia::Decision> decisions;
    for (int side = MaskLeaf::DIM; side > 1 && !cubes.empty(); side /= 2) {
      corners.clear();
      for (const Cube& cube : cubes) corners.push_back(cube.corner << kBlockLog2);
      decideCubes(corners, side * kBlock, plan.voxelSize, plan.domain, source, decisions);
      rest.clear();
      for (std::size_t i = 0; i < cubes.size(); ++i) {
        if (decisions[i] != julia::Decision::Undecided) {
          forEachBlock(cubes[i], side, [&](openvdb::Index at) { cubes[i].leaf->setValueOff(at); });
          continue;
        }
        const int half = side / 2;
        for (int k = 0; k < 8; ++k) {
          const Cube part{cubes[i].leaf,
                          cubes[i].corner.offsetBy(k & 4 ? half : 0, k & 2 ? half : 0, k & 1 ? half : 0)};
          if (holdsBlocks(part, half)) rest.push_back(part);
        }
      }
      std::swap(cubes, rest);
    }
    monitor.advance(end - begin);
  });
  return blocks;
}

}  // namespace vdbtools
