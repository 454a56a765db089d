// SPDX-License-Identifier: Apache-2.0
#include "field/undecided_blocks.h"

#include "base/in_parallel.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace vdbtools {
namespace {

using openvdb::Coord;
using openvdb::CoordBBox;
using MaskLeaf = BlockSet::LeafNodeType;

struct BlockCube {
  MaskLeaf* leaf;
  Coord corner;  // in blocks
};

/// The blocks of the leaf in a cube of @a side blocks a side.
template <class Body>
void forEachBlock(const BlockCube& cube, int blocks, const Body& body) {
  for (int x = 0; x < blocks; ++x)
    for (int y = 0; y < blocks; ++y)
      for (int z = 0; z < blocks; ++z) body(MaskLeaf::coordToOffset(cube.corner.offsetBy(x, y, z)));
}

bool holdsBlocks(const BlockCube& cube, int blocks) {
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

void addEighths(const Coord& origin, std::vector<Coord>& corners) {
  for (unsigned k = 0; k < 8; ++k) {
    const auto at = [&](unsigned bit) { return k >> bit & 1 ? kBlock / 2 : 0; };
    corners.push_back(origin.offsetBy(at(2), at(1), at(0)));
  }
}

Proofs worthwhileProofs(const BlockSet& blocks, const FieldPlan& plan, const FieldSource& source) {
  constexpr std::uint64_t kSample = 256;
  // A ball takes the time of about 12 points (docs/performance.md). A level must save slightly more than it costs,
  // because blocks with gaps are slower to evaluate.
  constexpr double kPointsPerBall = 16, kPointsOfBlock = kBlock * kBlock * kBlock;
  const std::uint64_t stride = std::max<std::uint64_t>(1, blocks.activeVoxelCount() / kSample);
  std::vector<Coord> origins, corners;
  std::uint64_t number = 0;
  for (auto leaf = blocks.cbeginLeaf(); leaf; ++leaf)
    for (auto block = leaf->cbeginValueOn(); block; ++block)
      if (number++ % stride == 0) origins.push_back(block.getCoord() << kBlockLog2);
  std::vector<julia::Decision> decisions;
  const auto decided = [&](const std::vector<Coord>& cubes, int side) {
    decideCubes(cubes, side, plan.voxelSize, plan.domain, source, decisions);
    return static_cast<double>(cubes.size()) -
           static_cast<double>(std::count(decisions.begin(), decisions.end(), julia::Decision::Undecided));
  };
  const double all = static_cast<double>(origins.size()), decidedBlocks = decided(origins, kBlock);
  for (std::size_t i = 0; i < origins.size(); ++i)
    if (decisions[i] == julia::Decision::Undecided) addEighths(origins[i], corners);
  const double fromBlocks = decidedBlocks * kPointsOfBlock - all * kPointsPerBall;
  const double eighths = static_cast<double>(corners.size());
  const double fromEighths = decided(corners, kBlock / 2) * (kPointsOfBlock / 8) - eighths * kPointsPerBall;
  if (fromEighths > 0 && fromBlocks + fromEighths > 0) return Proofs::Eighths;
  return fromBlocks > 0 ? Proofs::Blocks : Proofs::None;
}

BlockSet undecidedBlocks(const FieldPlan& plan, const FieldSource& source, Monitor& monitor) {
  BlockSet blocks(*plan.blocks);
  std::vector<MaskLeaf*> leaves;
  blocks.getNodes(leaves);
  monitor.begin(PhaseKind::Proofs, leaves.size());
  inParallel(leaves.size(), 32, monitor, [&](std::size_t begin, std::size_t end) {
    std::vector<BlockCube> cubes, rest;
    for (std::size_t i = begin; i != end; ++i) cubes.push_back({leaves[i], leaves[i]->origin()});
    std::vector<Coord> corners;
    std::vector<julia::Decision> decisions;
    for (int side = MaskLeaf::DIM; side > 1 && !cubes.empty(); side /= 2) {
      corners.clear();
      for (const BlockCube& cube : cubes) corners.push_back(cube.corner << kBlockLog2);
      decideCubes(corners, side * kBlock, plan.voxelSize, plan.domain, source, decisions);
      rest.clear();
      for (std::size_t i = 0; i < cubes.size(); ++i) {
        if (decisions[i] != julia::Decision::Undecided) {
          forEachBlock(cubes[i], side, [&](openvdb::Index at) { cubes[i].leaf->setValueOff(at); });
          continue;
        }
        const int half = side / 2;
        for (int k = 0; k < 8; ++k) {
          const BlockCube part{cubes[i].leaf,
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
