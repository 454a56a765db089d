// SPDX-License-Identifier: Apache-2.0
/// @file triangle_kernels.h
/// The loops of TriangleTree, compiled once for each instruction set; all give the same bits. This header has plain
/// data only: code that other files share must not be compiled for a processor that may be absent.
#pragma once

#include <cstddef>
#include <cstdint>

namespace vdbtools::kernels {

inline constexpr unsigned kPack = 8;         ///< triangles of a pack, children of a node
inline constexpr float kFarAway = 1e15F;     ///< where the boxes of missing children are
inline constexpr unsigned kMostLevels = 11;  ///< 8^11 packs hold more triangles than 32 bits can count

/// The corners of eight triangles; missing ones are copies of the first.
struct TrianglePack {
  float corner[3][3][kPack];  ///< by corner, then axis; relative to the origin
  double origin[3];
};

inline constexpr unsigned kFrameArrays = 14;

/// The numbers of the same triangles in the mesh.
struct PackNumbers {
  std::uint32_t triangle[kPack];
};

/// The frames of the same triangles, which do not depend on a position: in the order of Triangle, without its corner.
struct PackFrames {
  double corner[3][kPack];
  float frame[kFrameArrays][kPack];
  float slack[kPack];
};

/// The boxes of eight children, relative to the tree's centre; missing ones are far away.
struct BoxNode {
  float low[3][kPack];
  float high[3][kPack];
};

/// A TriangleTree as plain data. Node i of level l has the nodes 8 i to 8 i + 7 of level l - 1 as children, or those
/// packs if l is 0.
struct TreeView {
  const TrianglePack* packs;  ///< for nearest() and collect()
  const PackNumbers* numbers;
  const PackFrames* frames;  ///< null: they are computed again for each block
  const BoxNode* levels[kMostLevels];
  unsigned levelCount;
  double centre[3];
  float boxSlack;                  ///< error bound of boxes, and of positions relative to them
  const double* points;            ///< relative to the origin, three coordinates each
  const std::uint32_t* triangles;  ///< three points each
};

/// A triangle by its place in the tree.
struct Place {
  std::uint32_t pack;
  std::uint32_t lane;
};

inline constexpr std::uint32_t kNoPack = 0xffffffff;

/// Memory for the candidates of a block: the constants below give the bytes for each of @a capacity packs, and there is
/// room for one vector more. Aligned to 64 bytes.
struct Scratch {
  std::uint32_t capacity;
  void* candidates[2];
  void* found;
  void* boxes;
  std::uint32_t* list[2];  ///< eight numbers
};
inline constexpr std::size_t kCandidateBytes = 24 * 4 * kPack, kFoundBytes = 4 * 4 * kPack, kBoxBytes = 6 * 4;

/// The nodes of a block, x slowest.
inline constexpr unsigned kBlockNodes = 512;

struct Kernels {
  /// Finds the triangle nearest to a position, up to the rounding of floats. @a squared is the squared search radius on
  /// entry and receives the squared distance. Returns false if there is none within the radius.
  /// @param first  the pack to look at first, or kNoPack; one that is near spares most others
  bool (*nearest)(const TreeView&, const double position[3], std::uint32_t first, float& squared, Place& place);

  /// Collects the packs that may hold the triangle nearest to some point of a cube.
  /// @param half  half of the cube's side
  /// @param best  a triangle near the middle, the nearer the better
  /// @return their number; those beyond @a capacity are not written
  std::uint32_t (*collect)(const TreeView&, const double middle[3], float half, Place best, std::uint32_t* packs,
                           std::uint32_t capacity);

  /// Does what collect() does for the packs below some nodes of level 0, without a tree above them, and leaves out
  /// those that are farther than @a far from the whole cube.
  std::uint32_t (*gather)(const TreeView&, const double middle[3], float half, float far, const std::uint32_t* nodes,
                          std::uint32_t nodeCount, std::uint32_t* packs, std::uint32_t capacity);

  /// Computes the frames of some packs.
  void (*makeFrames)(const TreeView&, std::uint32_t first, std::uint32_t count, PackFrames* frames);

  /// Finds the nearest triangles of the 8^3 nodes about @a middle, and their distances.
  /// @param packs  the result of collect() or gather() for half a side of 3.5
  /// @param far  nodes that are farther than this may be left unchanged
  void (*resolve)(const TreeView&, const double middle[3], const std::uint32_t* packs, std::uint32_t count, float far,
                  const Scratch& scratch, float distance[kBlockNodes], std::uint32_t triangle[kBlockNodes]);
};

extern const Kernels kPortable, kAvx2, kAvx512;

/// Those of julia::instructionSet().
const Kernels& chosen();

/// Sets the centre of a tree's boxes, and their error bound for boxes up to half of @a longestSide from it.
void setCentre(TreeView& tree, const double (&centre)[3], double longestSide);

}  // namespace vdbtools::kernels
