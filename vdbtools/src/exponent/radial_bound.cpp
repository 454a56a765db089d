// SPDX-License-Identifier: Apache-2.0
#include "exponent/radial_bound.h"

#include "distance/cell_corners.h"
#include "distance/leaves.h"

#include <openvdb/tree/ValueAccessor.h>

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace vdbtools {

using openvdb::Coord;
using openvdb::FloatTree;
using openvdb::Vec3d;
using Leaf = FloatTree::LeafNodeType;

/// Maxima of a growing sequence over its first elements [Fen94].
class PrefixMaximum {
 public:
  explicit PrefixMaximum(std::size_t count) : mTree(count + 1, -std::numeric_limits<double>::infinity()) {}

  std::size_t size() const { return mTree.size() - 1; }
  /// The maximum of elements 0 to @a i.
  double upTo(std::size_t i) const {
    double most = mTree[0];
    for (++i; i > 0; i &= i - 1) most = std::max(most, mTree[i]);
    return most;
  }
  void raise(std::size_t i, double value) {
    for (++i; i < mTree.size() && mTree[i] < value; i += i & (~i + 1)) mTree[i] = value;
  }

 private:
  std::vector<double> mTree;
};

namespace {

constexpr double kNone = -std::numeric_limits<double>::infinity();

/// The table has this many balls for each cell's diagonal.
constexpr double kStepsPerCell = 64;

/// Positions are rounded to floats before they are read, and a read itself is rounded: relative to a longest side of 1,
/// and to the largest of the values that are read.
constexpr double kPlaceRounding = 1e-6, kValueRounding = 1e-6;

/// The largest value of an active node; -inf if there is none.
float greatestOf(const Leaf& leaf) {
  constexpr float kNothing = -std::numeric_limits<float>::infinity();
  float most[Leaf::DIM];
  std::fill_n(most, Leaf::DIM, kNothing);
  // Bit z of a row along z, in a form that compilers vectorise.
  constexpr unsigned kBit[Leaf::DIM] = {1, 2, 4, 8, 16, 32, 64, 128};
  for (openvdb::Index row = 0; row < Leaf::DIM * Leaf::DIM; ++row) {
    const float* const values = leaf.buffer().data() + row * Leaf::DIM;
    const unsigned on = activeInRow(leaf, row);
    for (unsigned z = 0; z < Leaf::DIM; ++z) {
      const float value = on & kBit[z] ? values[z] : kNothing;
      most[z] = value > most[z] ? value : most[z];
    }
  }
  return *std::max_element(most, most + Leaf::DIM);
}

/// The nodes of a leaf and kRim layers of nodes around it.
struct Neighbourhood {
  static constexpr int kDim = static_cast<int>(Leaf::DIM), kRim = 2, kSide = kDim + 2 * kRim,
                       kCount = kSide * kSide * kSide;
  /// What is known about the value at a node.
  enum class Kind : std::uint8_t { Known, Inside, Outside };

  Neighbourhood(const Leaf& leaf, const openvdb::tree::ValueAccessor<const FloatTree>& accessor) {
    for (int n = 0; n < 27; ++n) {
      const Coord side(n / 9 - 1, n / 3 % 3 - 1, n % 3 - 1);
      const Coord origin = leaf.origin() + Coord(side[0] * kDim, side[1] * kDim, side[2] * kDim);
      const Leaf* const from = n == 13 ? &leaf : accessor.probeConstLeaf(origin);
      const Kind tile = from || !(accessor.getValue(origin) < 0) ? Kind::Outside : Kind::Inside;
      int begin[3], end[3];  // of the other leaf's nodes
      for (int axis = 0; axis < 3; ++axis) {
        begin[axis] = side[axis] < 0 ? kDim - kRim : 0;
        end[axis] = side[axis] > 0 ? kRim : kDim;
      }
      for (int x = begin[0]; x < end[0]; ++x)
        for (int y = begin[1]; y < end[1]; ++y)
          for (int z = begin[2]; z < end[2]; ++z) {
            const int at = index(x + side[0] * kDim, y + side[1] * kDim, z + side[2] * kDim);
            if (!from) {
              kind[at] = tile;
              continue;
            }
            const auto node = static_cast<openvdb::Index>((x * kDim + y) * kDim + z);
            value[at] = from->getValue(node);
            kind[at] = from->isValueOn(node) ? Kind::Known : value[at] < 0 ? Kind::Inside : Kind::Outside;
          }
    }
  }

  /// @param x, y, z  relative to the leaf's first node
  static int index(int x, int y, int z) { return ((x + kRim) * kSide + y + kRim) * kSide + z + kRim; }

  float value[kCount];
  Kind kind[kCount];
};

/// Bezier ordinates of a box, x slowest.
template <int kDegree>
struct Ordinates {
  static constexpr int kSide = kDegree + 1, kCount = kSide * kSide * kSide;
  static constexpr int kStride[3] = {kSide * kSide, kSide, 1};
  std::array<double, static_cast<std::size_t>(kCount)> value;

  double& at(int i) { return value[static_cast<std::size_t>(i)]; }
  double at(int i) const { return value[static_cast<std::size_t>(i)]; }
  double greatest() const { return *std::max_element(value.begin(), value.end()); }

  /// Makes ordinates of the values of a cell's nodes.
  void fromNodes() {
    if constexpr (kDegree == 2)
      for (const int stride : kStride)
        for (int i = 0; i < kCount; ++i) {
          if (i / stride % kSide != 1) continue;
          at(i - stride) = (at(i - stride) + at(i)) / 2;
          at(i + stride) = (at(i) + at(i + stride)) / 2;
        }
  }

  /// The ordinates of a half along an axis (P. de Casteljau, 1959).
  Ordinates half(int axis, bool upper) const {
    const int stride = kStride[axis];
    Ordinates result = *this;
    for (int i = 0; i < kCount; ++i) {
      if (i / stride % kSide != 0) continue;
      const int end = i + kDegree * stride;
      if constexpr (kDegree == 2) {
        const int between = i + stride;
        const double low = (at(i) + at(between)) / 2, high = (at(between) + at(end)) / 2, middle = (low + high) / 2;
        result.at(i) = upper ? middle : at(i);
        result.at(between) = upper ? high : low;
        result.at(end) = upper ? at(end) : middle;
      } else {
        const double middle = (at(i) + at(end)) / 2;
        result.at(upper ? i : end) = middle;
      }
    }
    return result;
  }
};

/// Adds boxes to a table. A box that is left out could not raise the table, so the table does not depend on the order
/// of the boxes.
class BoxAdder {
 public:
  /// @param axis  steps along the axes, units of fractal space
  BoxAdder(const Vec3d* axis, double diagonal, double step, PrefixMaximum& table)
      : mAxis(axis), mDiagonal(diagonal), mStep(step), mLast(static_cast<double>(table.size())), mTable(table) {}

  /// The bounds of a box before it is examined.
  struct Limits {
    double nearest = 0;                                         ///< distance from the point, steps
    double greatest = std::numeric_limits<double>::infinity();  ///< bound of E
  };

  /// The limits of a box with this middle, relative to the point. @param size  voxels
  Limits limits(const Vec3d& middle, double size, double greatest, const Limits& outer) const {
    const double nearest = (middle.length() - size * mDiagonal / 2 - kPlaceRounding) / mStep;
    return {std::max(outer.nearest, nearest), std::min(outer.greatest, greatest)};
  }
  bool raises(const Limits& limits) const {
    return limits.nearest < mLast && limits.greatest > mTable.upTo(static_cast<std::size_t>(limits.nearest));
  }
  void addAtNearest(const Limits& limits) { mTable.raise(static_cast<std::size_t>(limits.nearest), limits.greatest); }

  template <int kDegree>
  void add(const Ordinates<kDegree>& box, const Vec3d& middle, double size, const Limits& outer) {
    const Limits within = limits(middle, size, box.greatest(), outer);
    if (!raises(within)) return;
    const double distance = middle.length(), diagonal = size * mDiagonal;
    // |y| bends away from u.y by diagonal^2 / 8 distance, which may be as long as a step of the table.
    constexpr double kLeastSize = 1.0 / 64;
    if (diagonal * diagonal > 8 * distance * mStep && size > kLeastSize) {
      for (int n = 0; n < 8; ++n) {
        Vec3d there = middle;
        Ordinates<kDegree> eighth = box;
        for (int axis = 0; axis < 3; ++axis) {
          const bool upper = n >> axis & 1;
          eighth = eighth.half(axis, upper);
          there += mAxis[axis] * (upper ? size / 4 : -size / 4);
        }
        add(eighth, there, size / 2, within);
      }
      return;
    }
    if (!(distance > 0)) return addAtNearest(within);
    addFlat(box, middle, size, within);
  }

 private:
  template <int kDegree>
  void addFlat(const Ordinates<kDegree>& box, const Vec3d& middle, double size, const Limits& limits) {
    using Box = Ordinates<kDegree>;
    const double distance = middle.length();
    const Vec3d u = middle / distance;
    double along[3];  // the steps between ordinates along u
    double rise = 0, squared = 0;
    for (int axis = 0; axis < 3; ++axis) {
      along[axis] = u.dot(mAxis[axis]) * size / kDegree;
      double difference = 0;
      for (int i = 0; i < Box::kCount; ++i) {
        const int step = i / Box::kStride[axis] % Box::kSide;
        if (step == 0) difference -= box.at(i);
        if (step == kDegree) difference += box.at(i);
      }
      rise += difference / (Box::kSide * Box::kSide * kDegree) * along[axis];
      squared += along[axis] * along[axis];
    }
    const double slope = std::max(0.0, rise / squared);
    const double begin = distance - (along[0] + along[1] + along[2]) * kDegree / 2;
    double most = kNone;
    for (int i = 0; i < Box::kCount; ++i) {
      const int a = i / Box::kStride[0], b = i / Box::kStride[1] % Box::kSide, c = i % Box::kSide;
      most = std::max(most, box.at(i) - slope * (begin + a * along[0] + b * along[1] + c * along[2]));
    }
    most += kPlaceRounding * slope;
    const double farthest = std::min(mLast - 1, (distance + size * mDiagonal / 2) / mStep + 1);
    for (auto k = static_cast<std::size_t>(limits.nearest); static_cast<double>(k) <= farthest; ++k) {
      const double there = most + slope * mStep * static_cast<double>(k + 1);
      mTable.raise(k, std::min(limits.greatest, there));
      if (there >= limits.greatest) break;
    }
  }

  const Vec3d* mAxis;
  double mDiagonal, mStep, mLast;
  PrefixMaximum& mTable;
};

}  // namespace

RadialBound::RadialBound(const FloatTree& tree, const openvdb::math::Transform& transform, const Vec3d& origin,
                         double scale, julia::Interpolation interpolation, double inside, double spread,
                         Monitor& monitor)
    : mTree(tree), mInterpolation(interpolation), mInside(inside), mSpread(spread) {
  const Vec3d zero = transform.indexToWorld(Vec3d(0));
  mZero = (zero - origin) / scale;
  for (int axis = 0; axis < 3; ++axis) {
    Vec3d step(0);
    step[axis] = 1;
    mAxis[axis] = (transform.indexToWorld(step) - zero) / scale;
  }
  const auto across = [this](double along) {
    double most = 0;
    for (const double y : {-along, along})
      for (const double z : {-along, along})
        most = std::max(most, (mAxis[0] * along + mAxis[1] * y + mAxis[2] * z).length());
    return most;
  };
  mDiagonal = across(1);
  mStep = mDiagonal / kStepsPerCell;
  const std::vector<const Leaf*> leaves = leavesOf(tree);
  // The greatest value of each leaf, at a node for each leaf.
  FloatTree greatest(-std::numeric_limits<float>::infinity());
  std::vector<float> own(leaves.size());
  forEachLeaf(leaves.size(), monitor, [&](std::size_t i) { own[i] = greatestOf(*leaves[i]); });
  for (std::size_t i = 0; i < leaves.size(); ++i) greatest.setValue(leaves[i]->origin() >> Leaf::LOG2DIM, own[i]);
  // Half of a leaf, and of the cells that reach out of it on either side.
  const double radius = across(0.5 * (Leaf::DIM + 2));
  mLeaves.resize(leaves.size());
  forEachLeaf(leaves.size(), monitor, [&](std::size_t i) {
    const openvdb::tree::ValueAccessor<const FloatTree> accessor(greatest);
    const Coord at = leaves[i]->origin() >> Leaf::LOG2DIM;
    Reach& reach = mLeaves[i];
    reach.leaf = leaves[i];
    reach.greatest = own[i];
    for (int n = 0; n < 27; ++n)
      reach.greatest = std::max(reach.greatest, accessor.getValue(at.offsetBy(n / 9 - 1, n / 3 % 3 - 1, n % 3 - 1)));
    const Vec3d middle = leaves[i]->origin().asVec3d() + Vec3d(0.5 * (Leaf::DIM - 1));
    const Vec3d there = mZero + mAxis[0] * middle[0] + mAxis[1] * middle[1] + mAxis[2] * middle[2];
    reach.nearest = std::max(0.0, there.length() * (1 - kPlaceRounding) - radius);
  });
  std::sort(mLeaves.begin(), mLeaves.end(), [](const Reach& a, const Reach& b) {
    return a.nearest < b.nearest || (a.nearest == b.nearest && a.leaf->origin() < b.leaf->origin());
  });
}

template <int kDegree>
void RadialBound::addLeaf(const Reach& reach, PrefixMaximum& table) const {
  using Kind = Neighbourhood::Kind;
  constexpr int kFirst = kDegree == 2 ? -1 : 0;         // of a cell's nodes, relative to its own
  constexpr double kMiddle = kDegree == 2 ? 0.0 : 0.5;  // of a cell, likewise
  const openvdb::tree::ValueAccessor<const FloatTree> accessor(mTree);
  Neighbourhood nodes(*reach.leaf, accessor);
  for (int i = 0; i < Neighbourhood::kCount; ++i)
    if (nodes.kind[i] != Kind::Known)
      nodes.value[i] = static_cast<float>(nodes.kind[i] == Kind::Inside ? mInside : kNone);
  // The greatest node of each cell, at its first.
  float greatest[Neighbourhood::kCount];
  std::copy_n(nodes.value, Neighbourhood::kCount, greatest);
  for (const int stride : {1, Neighbourhood::kSide, Neighbourhood::kSide * Neighbourhood::kSide})
    for (int step = 0; step < kDegree; ++step)
      for (int i = 0; i + stride < Neighbourhood::kCount; ++i)
        greatest[i] = std::max(greatest[i], greatest[i + stride]);
  BoxAdder adder(mAxis, mDiagonal, mStep, table);
  const BoxAdder::Limits ofLeaf{.nearest = reach.nearest / mStep};
  // Cells whose own node has no leaf are read, too, and others at a leaf's faces twice.
  constexpr int kEnd = static_cast<int>(Leaf::DIM) + (kDegree == 2 ? 1 : 0);
  for (int x = -1; x < kEnd; ++x)
    for (int y = -1; y < kEnd; ++y)
      for (int z = -1; z < kEnd; ++z) {
        const int first = Neighbourhood::index(x + kFirst, y + kFirst, z + kFirst);
        const Vec3d index = reach.leaf->origin().asVec3d() + Vec3d(x + kMiddle, y + kMiddle, z + kMiddle);
        const Vec3d middle = mZero + mAxis[0] * index[0] + mAxis[1] * index[1] + mAxis[2] * index[2];
        const BoxAdder::Limits limits = adder.limits(middle, 1, static_cast<double>(greatest[first]), ofLeaf);
        if (!adder.raises(limits)) continue;
        Ordinates<kDegree> cell;
        bool isKnown = true;
        for (int i = 0; i < cell.kCount; ++i) {
          const int a = i / cell.kStride[0], b = i / cell.kStride[1] % cell.kSide, c = i % cell.kSide;
          const int at = first + (a * Neighbourhood::kSide + b) * Neighbourhood::kSide + c;
          isKnown &= nodes.kind[at] == Kind::Known;
          cell.at(i) = static_cast<double>(nodes.value[at]);
        }
        if (!isKnown) {
          adder.addAtNearest(limits);
          continue;
        }
        cell.fromNodes();
        adder.add(cell, middle, 1, limits);
      }
}

julia::RadialMaximum RadialBound::maximum(double atOrigin, Monitor& monitor) const {
  const auto count = static_cast<std::size_t>(std::ceil(1 / mStep));
  tbb::enumerable_thread_specific<PrefixMaximum> parts([count] { return PrefixMaximum(count); });
  forEachLeaf(mLeaves.size(), monitor, [&](std::size_t i) {
    const Reach& reach = mLeaves[i];
    const double first = reach.nearest / mStep;
    if (!(first < static_cast<double>(count))) return;
    PrefixMaximum& table = parts.local();
    // The nearest leaves come first: the others seldom add anything.
    if (std::max(static_cast<double>(reach.greatest), mInside) <= table.upTo(static_cast<std::size_t>(first))) return;
    if (mInterpolation == julia::Interpolation::Quadratic)
      addLeaf<2>(reach, table);
    else
      addLeaf<1>(reach, table);
  });
  julia::RadialMaximum result{mStep, std::vector<double>(count)};
  double running = atOrigin;
  for (std::size_t i = 0; i < count; ++i) {
    for (const PrefixMaximum& part : parts) running = std::max(running, part.upTo(i));
    const double rounding = std::isfinite(running) ? kValueRounding * (std::abs(running) + mSpread) : 0;
    result.maximum[i] = running + rounding;
  }
  return result;
}

}  // namespace vdbtools
