// SPDX-License-Identifier: Apache-2.0
#include "formats/vdb_tree.h"

#include <algorithm>

namespace vdbtools {
namespace {

using openvdb::Coord;

// The tree's three levels below the root.
constexpr int kUpperLog2 = 5, kLowerLog2 = 4, kLeafLog2 = 3;
constexpr int kLeafDim = 1 << kLeafLog2, kLowerDim = kLeafDim << kLowerLog2, kUpperDim = kLowerDim << kUpperLog2;
constexpr std::size_t kLeafSize = std::size_t{1} << (3 * kLeafLog2), kLeafMask = kLeafSize / 8;

/// The limit for the origins of nodes in voxels, along each axis. Sizes of boxes of such coordinates are far from
/// overflow.
constexpr std::int32_t kFarthest = 1 << 29;

std::string numbers(const Coord& at) {
  return std::to_string(at[0]) + ", " + std::to_string(at[1]) + ", " + std::to_string(at[2]);
}

/// The origin of child number @a n in a node of 2^log2Dim children a side, which are @a childDim wide.
Coord childOrigin(const Coord& origin, std::size_t n, int log2Dim, int childDim) {
  const int i = static_cast<int>(n), low = (1 << log2Dim) - 1;
  return origin.offsetBy((i >> 2 * log2Dim) * childDim, (i >> log2Dim & low) * childDim, (i & low) * childDim);
}

/// Calls use(n) for each set bit n.
template <class Use>
void forEachOn(std::string_view mask, const Use& use) {
  constexpr std::size_t kBits = 64;
  for (std::size_t i = 0; i < mask.size() / sizeof(std::uint64_t); ++i) {
    std::uint64_t word;
    std::memcpy(&word, mask.data() + i * sizeof word, sizeof word);
    for (; word != 0; word &= word - 1) use(i * kBits + static_cast<std::size_t>(std::countr_zero(word)));
  }
}

}  // namespace

VdbTreeWalk::VdbTreeWalk(VdbCursor& cursor, const VdbValueType& type, VdbLeaf leaf, const VdbStorage& storage)
    : mCursor(cursor), mLeaf(leaf), mValues(cursor, type, storage), mValueSize(type.size) {}

Coord VdbTreeWalk::origin() {
  Coord at;
  for (int axis = 0; axis < 3; ++axis) at[axis] = mCursor.number<std::int32_t>();
  for (int axis = 0; axis < 3; ++axis) {
    if (at[axis] % kUpperDim != 0) mCursor.refuse("has a node at " + numbers(at) + ", where there can be none");
    if (at[axis] < -kFarthest || at[axis] >= kFarthest)
      mCursor.refuse("has a node at " + numbers(at) + ", which is too far from the origin");
  }
  return at;
}

void VdbTreeWalk::topology() {
  if (const auto buffers = mCursor.number<std::int32_t>(); buffers != 1)
    mCursor.refuse("has " + std::to_string(buffers) + " buffers a leaf; 1 is the only number that can be read");
  mValues.background();
  const auto tiles = mCursor.number<std::uint32_t>(), children = mCursor.number<std::uint32_t>();
  const auto requireOrder = [&](const Coord& before, const Coord& at) {
    // OpenVDB reads buffers in spatial order, and leaks a node that another one replaces at the same place.
    if (!(before < at)) mCursor.refuse("has nodes out of order, at " + numbers(before) + " and " + numbers(at));
  };
  std::vector<Coord> taken;
  for (std::uint32_t i = 0; i < tiles; ++i) {
    const Coord at = origin();
    if (i > 0) requireOrder(taken.back(), at);
    taken.push_back(at);
    mValues.value();
    if (mCursor.number<std::uint8_t>() > 1) mCursor.refuse("has a tile that is neither active nor inactive");
  }
  Coord before;
  for (std::uint32_t i = 0; i < children; ++i) {
    const Coord at = origin();
    if (i > 0) requireOrder(before, at);
    if (std::binary_search(taken.begin(), taken.end(), at))
      mCursor.refuse("has a tile and a node at one place, " + numbers(at));
    before = at;
    upperNode(at);
  }
}

std::string_view VdbTreeWalk::internalNode(int log2Dim) {
  const std::size_t count = std::size_t{1} << (3 * log2Dim);
  const std::string_view children = mCursor.bytes(count / 8), active = mCursor.bytes(count / 8);
  for (std::size_t i = 0; i < children.size(); ++i)
    if ((children[i] & active[i]) != 0) mCursor.refuse("has an active value where there is a node");
  mValues.node(active, count, VdbValueWalk::Payload::Decode);
  // A value larger than a pointer is allocated separately.
  constexpr std::size_t kPointer = sizeof(void*), kAllocation = 32;
  mMemory += 2 * children.size() + count * (kPointer + (mValueSize > kPointer ? kAllocation : 0));
  return children;
}

void VdbTreeWalk::upperNode(const Coord& origin) {
  forEachOn(internalNode(kUpperLog2), [&](std::size_t n) { lowerNode(childOrigin(origin, n, kUpperLog2, kLowerDim)); });
}

void VdbTreeWalk::lowerNode(const Coord& origin) {
  const std::string_view children = internalNode(kLowerLog2);
  const std::size_t leaves = countOn(children);
  mCursor.bytes(leaves * kLeafMask);
  mLeaves += leaves;
  const bool bits = mLeaf == VdbLeaf::Bits || mLeaf == VdbLeaf::Mask;
  constexpr std::size_t kLeafObject = 128;
  mMemory += leaves * (kLeafObject + (bits ? 0 : kLeafSize * mValueSize));
  if (bits)
    forEachOn(children, [&](std::size_t n) { mOrigins.push_back(childOrigin(origin, n, kLowerLog2, kLeafDim)); });
}

void VdbTreeWalk::buffers() {
  if (mLeaf == VdbLeaf::Values) {
    for (std::uint64_t i = 0; i < mLeaves; ++i)
      mValues.node(mCursor.bytes(kLeafMask), kLeafSize, VdbValueWalk::Payload::Measure);
    return;
  }
  for (const Coord& origin : mOrigins) {
    mCursor.bytes(kLeafMask);
    for (int axis = 0; axis < 3; ++axis)
      if (mCursor.number<std::int32_t>() != origin[axis])
        mCursor.refuse("has a leaf at " + numbers(origin) + " that is said to be elsewhere");
    if (mLeaf == VdbLeaf::Bits) mCursor.bytes(kLeafMask);
  }
}

}  // namespace vdbtools
