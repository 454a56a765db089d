// SPDX-License-Identifier: Apache-2.0
#include "brick_pyramid.h"

#include "loop_pragmas.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace julia {
namespace {

// The maximum number of cells along an axis that a query examines.
constexpr std::uint32_t kCellsAcross = 2;

// Values compared at a time.
constexpr std::size_t kLanes = 16;
// The resolution of distances from the origin, as a fraction of the farthest.
constexpr std::uint32_t kSteps = 256;
// The accuracy required of an inverse matrix.
constexpr double kInverseSlack = 1e-6;

using Matrix = std::array<std::array<double, 3>, 3>;

/// Inverts by cofactors. Empty for a matrix so close to a singular one that rounding matters.
std::optional<Matrix> inverted(const Matrix& m) {
  Matrix inverse;
  double determinant = 0, size = 0;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) {
      const std::size_t a = (i + 1) % 3, b = (i + 2) % 3, c = (j + 1) % 3, d = (j + 2) % 3;
      inverse[j][i] = m[a][c] * m[b][d] - m[a][d] * m[b][c];
      size = std::max(size, std::abs(m[i][j]));
    }
  for (std::size_t j = 0; j < 3; ++j) determinant += m[0][j] * inverse[j][0];
  if (!(std::abs(determinant) > 1e-3 * size * size * size)) return std::nullopt;
  for (auto& row : inverse)
    for (double& x : row) x /= determinant;
  return inverse;
}

/// Sets values[i] to the largest of values[i], values[i + stride], ... of @a width values. Entries whose window leaves
/// the brick are meaningless; those at the end of the array are not written.
void slideMaximum(std::vector<float>& values, std::size_t stride, std::uint32_t width) {
  for (std::uint32_t step = 1; step < width; ++step) {
    float* const v = values.data();
    const std::size_t end = values.size() - stride;
    JULIA_INDEPENDENT
    for (std::size_t i = 0; i < end; ++i) v[i] = v[i + stride] > v[i] ? v[i + stride] : v[i];
  }
}

/// The extremes of one brick. In a cell, a component of the slope lies between the smallest and the largest difference
/// along its axis over the nodes that the interpolant reads there. These are 2^3 nodes for the trilinear interpolant,
/// and 3^3 for the B-spline, whose derivative weights the two differences linearly and is the spline itself along the
/// other axes.
class BrickReader {
 public:
  explicit BrickReader(const Bricks& bricks)
      : mSide(bricks.side()), mSize(bricks.size()), mReads(bricks.before() + 2), mLargest(mSize), mSquares(mSize) {}

  BrickExtremes operator()(const float* values) {
    // One extreme for each position in a row: compilers vectorise this, but not a single extreme.
    float low[kLanes], high[kLanes], squares[kBrickSide] = {};
    std::copy(values, values + kLanes, low);
    std::copy(values, values + kLanes, high);
    for (std::size_t i = kLanes; i < mSize; i += kLanes) {
      const float* const row = values + std::min(i, mSize - kLanes);
      for (std::size_t k = 0; k < kLanes; ++k) {
        low[k] = row[k] < low[k] ? row[k] : low[k];
        high[k] = row[k] > high[k] ? row[k] : high[k];
      }
    }
    std::fill(mSquares.begin(), mSquares.end(), 0.f);
    const std::size_t strides[3] = {std::size_t{mSide} * mSide, mSide, 1};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::size_t along = strides[axis];
      for (std::size_t i = 0; i + along < mSize; ++i) mLargest[i] = std::abs(values[i + along] - values[i]);
      for (std::size_t other = 0; other < 3; ++other)
        slideMaximum(mLargest, strides[other], other == axis ? mReads - 1 : mReads);
      for (std::size_t i = 0; i < mSize; ++i) mSquares[i] += mLargest[i] * mLargest[i];
    }
    for (std::size_t x = 0; x < kBrickSide; ++x)
      for (std::size_t y = 0; y < kBrickSide; ++y) {
        const float* const row = mSquares.data() + x * strides[0] + y * strides[1];
        for (std::size_t z = 0; z < kBrickSide; ++z) squares[z] = row[z] > squares[z] ? row[z] : squares[z];
      }
    const float steepest = *std::max_element(squares, squares + kBrickSide);
    // Squares leave the range of floats if values are absurdly large.
    const bool usual = steepest >= 1e-30f && steepest <= 1e30f;
    const float slope = usual               ? std::sqrt(steepest) * (1 + 8 * std::numeric_limits<float>::epsilon())
                        : steepest < 1e-30f ? 1e-14f
                                            : std::numeric_limits<float>::infinity();
    return {*std::min_element(low, low + kLanes), *std::max_element(high, high + kLanes), slope};
  }

 private:
  std::uint32_t mSide;
  std::size_t mSize;
  std::uint32_t mReads;  ///< nodes that the interpolant reads along an axis
  std::vector<float> mLargest, mSquares;
};

}  // namespace

BrickPyramid::BrickPyramid(const Bricks& bricks, const BrickPlacement& placement) : mBricks(bricks) {
  BrickReader read(bricks);
  mOfBrick.resize(bricks.values.size() / bricks.size());
  for (std::size_t i = 0; i < mOfBrick.size(); ++i) mOfBrick[i] = read(bricks.values.data() + i * bricks.size());
  for (Box below = bricks.count; *std::max_element(below.begin(), below.end()) > kCellsAcross;
       below = mLevels.back().count) {
    Level level;
    for (std::size_t axis = 0; axis < 3; ++axis) level.count[axis] = (below[axis] + 1) / 2;
    level.cells.reserve(std::size_t{level.count[0]} * level.count[1] * level.count[2]);
    for (std::size_t x = 0; x < level.count[0]; ++x)
      for (std::size_t y = 0; y < level.count[1]; ++y)
        for (std::size_t z = 0; z < level.count[2]; ++z) {
          BrickExtremes cell = at(mLevels.size(), 2 * x, 2 * y, 2 * z);
          for (std::size_t k = 1; k < 8; ++k) {
            const std::size_t cx = 2 * x + (k >> 2), cy = 2 * y + (k >> 1 & 1), cz = 2 * z + (k & 1);
            if (cx < below[0] && cy < below[1] && cz < below[2]) cell.include(at(mLevels.size(), cx, cy, cz));
          }
          level.cells.push_back(cell);
        }
    mLevels.push_back(std::move(level));
  }
  for (const BrickExtremes& brick : mOfBrick)
    mLargest =
        std::max({mLargest, std::abs(static_cast<double>(brick.low)), std::abs(static_cast<double>(brick.high))});
  findLowestBeyond(placement);
}

/// A brick counts up to the distance of its farthest corner. Reads outside the placement's box return the values on its
/// faces, at any distance; therefore nodes on the faces, and those that interpolants on a face read, count everywhere.
void BrickPyramid::findLowestBeyond(const BrickPlacement& placement) {
  const std::optional<Matrix> inverse = inverted(placement.matrix);
  if (!inverse) return;
  const auto distanceOf = [&](const std::array<double, 3>& node) {
    double squared = 0;
    for (const auto& row : *inverse) {
      double x = 0;
      for (std::size_t k = 0; k < 3; ++k) x += row[k] * (node[k] - placement.offset[k]);
      squared += x * x;
    }
    return std::sqrt(squared) * (1 + kInverseSlack);
  };
  const auto farthestOf = [&](const std::array<double, 3>& low, const std::array<double, 3>& high) {
    double farthest = 0;
    for (int k = 0; k < 8; ++k)
      farthest = std::max(farthest,
                          distanceOf({k & 1 ? low[0] : high[0], k & 2 ? low[1] : high[1], k & 4 ? low[2] : high[2]}));
    return farthest;
  };
  const double farthest = farthestOf(placement.low, placement.high);
  if (!(farthest > 0 && farthest < 1e30)) return;
  mStep = farthest / kSteps;
  mLowestBeyond.assign(kSteps + 1, std::numeric_limits<float>::max());
  float& everywhere = mLowestBeyond.back();
  // The nodes that an interpolant reads are nearer than this, even after rounding of the point.
  const double reach = mBricks.before() + 1.5;
  for (std::uint32_t x = 0; x < mBricks.count[0]; ++x)
    for (std::uint32_t y = 0; y < mBricks.count[1]; ++y)
      for (std::uint32_t z = 0; z < mBricks.count[2]; ++z) {
        const std::array<double, 3> corner{x * 8., y * 8., z * 8.};
        const std::size_t place = (std::size_t{x} * mBricks.count[1] + y) * mBricks.count[2] + z;
        const BrickExtremes& extremes = mOfBrick[mBricks.brickAt[place]];
        std::array<double, 3> low{}, high{};
        bool atFace = false;
        for (std::size_t axis = 0; axis < 3; ++axis) {
          // The positions that read this brick: for the spline from half a node before it, plus half a node for
          // rounding.
          low[axis] = std::clamp(corner[axis] - 1, placement.low[axis], placement.high[axis]);
          high[axis] = std::clamp(corner[axis] + kBrickSide + 0.5, placement.low[axis], placement.high[axis]);
          atFace = atFace || corner[axis] - reach <= placement.low[axis] + reach ||
                   corner[axis] + kBrickSide + reach >= placement.high[axis] - reach;
        }
        const double step = std::min(farthestOf(low, high) / mStep, double{kSteps} - 1);
        float& beyond = mLowestBeyond[static_cast<std::size_t>(step)];
        beyond = std::min(beyond, extremes.low);
        if (atFace && extremes.low < everywhere) {
          const float* value = mBricks.values.data() + mBricks.brickAt[place] * mBricks.size();
          const auto isAtFace = [&](std::size_t axis, std::uint32_t k) {
            const double node = corner[axis] + k - mBricks.before();
            return node <= placement.low[axis] + reach || node >= placement.high[axis] - reach;
          };
          for (std::uint32_t i = 0; i < mBricks.side(); ++i)
            for (std::uint32_t j = 0; j < mBricks.side(); ++j)
              for (std::uint32_t k = 0; k < mBricks.side(); ++k, ++value)
                if (*value < everywhere && (isAtFace(0, i) || isAtFace(1, j) || isAtFace(2, k))) everywhere = *value;
        }
      }
  for (std::size_t step = kSteps; step-- > 0;)
    mLowestBeyond[step] = std::min(mLowestBeyond[step], mLowestBeyond[step + 1]);
}

double BrickPyramid::lowestBeyond(double distance) const {
  if (mStep == 0 || !(distance >= 0)) return -std::numeric_limits<double>::infinity();
  const double step = std::min(distance / mStep, double{kSteps});
  return static_cast<double>(mLowestBeyond[static_cast<std::size_t>(step)]);
}

BrickExtremes BrickPyramid::over(const Box& first, const Box& last) const {
  std::size_t level = 0;
  const auto isWide = [&](std::size_t axis) { return (last[axis] >> level) - (first[axis] >> level) >= kCellsAcross; };
  while (isWide(0) || isWide(1) || isWide(2)) ++level;
  BrickExtremes result = at(level, first[0] >> level, first[1] >> level, first[2] >> level);
  for (std::size_t x = first[0] >> level; x <= last[0] >> level; ++x)
    for (std::size_t y = first[1] >> level; y <= last[1] >> level; ++y)
      for (std::size_t z = first[2] >> level; z <= last[2] >> level; ++z) result.include(at(level, x, y, z));
  return result;
}

}  // namespace julia
