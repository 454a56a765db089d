// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/motion/surface_motion.h"

#include "base/elementary.h"
#include "search/surface_search.h"
#include "search/triangle_point.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/base/fractal_space.h"
#include "vdbtools/base/text.h"

#include <openvdb/math/Mat3.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>
#include <numeric>
#include <stdexcept>
#include <string>
#include <utility>

namespace vdbtools {
namespace {

using openvdb::Mat3d;
using openvdb::Vec3d;
using openvdb::Vec3I;

/// Whether corners are found by their numbers, as polygons of moved points may be cut into other triangles. Files
/// without numbers, such as STL, have the same order of triangles only.
bool haveNumbers(const Mesh& from, const Mesh& to) { return from.points.size() == to.points.size(); }

/// The corners of both surfaces, three for each triangle.
struct CornerPairs {
  std::vector<Vec3d> from, to;
  std::vector<std::uint32_t> number;  ///< the same for corners at one point of a file
};

/// @pre the meshes have the same faces
CornerPairs cornersOf(const Mesh& from, const Mesh& to) {
  const bool numbered = haveNumbers(from, to);
  CornerPairs pairs;
  for (std::size_t i = 0; i < from.triangles.size(); ++i) {
    const Vec3I &a = from.triangles[i], &b = numbered ? from.triangles[i] : to.triangles[i];
    for (int k = 0; k < 3; ++k) {
      pairs.from.push_back(from.points[a[k]]);
      pairs.to.push_back(to.points[b[k]]);
      pairs.number.push_back(numbered ? a[k] : static_cast<std::uint32_t>(pairs.number.size()));
    }
  }
  return pairs;
}

double areaOf(std::span<const Vec3d> corners) {
  double sum = 0;
  for (std::size_t i = 0; i + 2 < corners.size(); i += 3)
    sum += (corners[i + 1] - corners[i]).cross(corners[i + 2] - corners[i]).length();
  return sum / 2;
}

double volumeOf(std::span<const Vec3d> corners, const Vec3d& middle) {
  double sum = 0;
  for (std::size_t i = 0; i + 2 < corners.size(); i += 3)
    sum += (corners[i] - middle).dot((corners[i + 1] - middle).cross(corners[i + 2] - middle));
  return sum / 6;
}

/// Moments of both surfaces, weighted by the area of the first.
struct Moments {
  double area = 0;
  Vec3d from{0, 0, 0}, to{0, 0, 0};                   ///< centroids
  Mat3d across = Mat3d::zero(), own = Mat3d::zero();  ///< of the second with the first, and of the first
  double spread = 0;                                  ///< of the second surface, its units squared
};

Moments momentsOf(const CornerPairs& pairs) {
  Moments m;
  std::vector<double> areas(pairs.from.size() / 3);
  for (std::size_t i = 0; i < areas.size(); ++i) {
    const Vec3d *f = &pairs.from[3 * i], *t = &pairs.to[3 * i];
    areas[i] = (f[1] - f[0]).cross(f[2] - f[0]).length() / 2;
    m.area += areas[i];
    m.from += (f[0] + f[1] + f[2]) * (areas[i] / 3);
    m.to += (t[0] + t[1] + t[2]) * (areas[i] / 3);
  }
  if (!(m.area > 0) || !std::isfinite(m.area)) throw DataError("the mesh has no triangle with an area; check the file");
  m.from /= m.area;
  m.to /= m.area;
  for (std::size_t i = 0; i < pairs.from.size(); ++i) {
    const double weight = areas[i / 3] / (3 * m.area);
    const Vec3d f = pairs.from[i] - m.from, t = pairs.to[i] - m.to;
    m.across += openvdb::math::outerProduct(t, f) * weight;
    m.own += openvdb::math::outerProduct(f, f) * weight;
    m.spread += weight * t.lengthSqr();
  }
  return m;
}

double trace(const Mat3d& m) { return m(0, 0) + m(1, 1) + m(2, 2); }

/// The axes of a symmetric matrix, by falling eigenvalues, as columns of a rotation.
std::pair<Mat3d, Vec3d> axesOf(const Mat3d& symmetric) {
  Mat3d axes;
  Vec3d values;
  openvdb::math::diagonalizeSymmetricMatrix(symmetric, axes, values);
  std::array<int, 3> order = {0, 1, 2};
  std::sort(order.begin(), order.end(), [&](int a, int b) { return values[a] > values[b]; });
  const Vec3d first = axes.col(order[0]), second = axes.col(order[1]);
  Mat3d sorted;
  sorted.setColumns(first, second, first.cross(second));
  return {sorted, {values[order[0]], values[order[1]], values[order[2]]}};
}

/// The rotation R for which the trace of R^T m is largest (Kabsch 1976).
Mat3d nearestRotation(const Mat3d& m) {
  const Mat3d axes = axesOf(m.transpose() * m).first;
  Vec3d first = m * axes.col(0);
  if (!first.normalize(0)) return Mat3d::identity();
  Vec3d second = m * axes.col(1);
  second -= first * first.dot(second);
  if (!second.normalize(0)) second = first.getArbPerpendicular();
  Mat3d images;
  images.setColumns(first, second, first.cross(second));
  return images * axes.transpose();
}

/// The affine map that fits best. It shears only as far as the surface agrees: a surface that bends is turned, moved
/// and scaled.
AffineMap overallOf(const CornerPairs& pairs, const std::string& name) {
  const Moments m = momentsOf(pairs);
  if (!(m.spread > 0)) throw DataError(name + " has no extent; check the file");
  const Mat3d turn = nearestRotation(m.across);
  const double scale = trace(turn.transpose() * m.across) / trace(m.own);
  AffineMap map{turn * (scale > 0 ? scale : std::sqrt(m.spread / trace(m.own))), {}};

  const Vec3d extents = axesOf(m.own).second;
  constexpr double kFlat = 1e-6;  // a flat surface says nothing of what lies beside it
  if (extents[2] > kFlat * extents[0]) {
    const Mat3d free = m.across * m.own.inverse();
    const double left = m.spread - trace(free * m.across.transpose());
    const double residual = std::sqrt(std::max(0., left) / m.spread);
    constexpr double kAffine = 0.03, kBent = 0.1;
    const double t = std::clamp((kBent - residual) / (kBent - kAffine), 0., 1.);
    map.matrix += (free - map.matrix) * (t * t * (3 - 2 * t));
  }
  map.offset = m.to - map.matrix * m.from;
  return map;
}

/// @throw DataError  one of two solids is turned inside out
void requireOneSide(const CornerPairs& pairs, const AffineMap& overall, const std::string& name) {
  const double from = volumeOf(pairs.from, pairs.from.front()) * overall.matrix.det();
  const double to = volumeOf(pairs.to, pairs.to.front());
  // A surface that is no solid has a volume by chance.
  openvdb::BBoxd box;
  for (const Vec3d& corner : pairs.to) box.expand(corner);
  constexpr double kSolid = 1e-3;
  const double least = kSolid * box.extents().product();
  if (std::abs(to) > least && std::abs(from) > least && (from < 0) != (to < 0))
    throw DataError(name + " is turned inside out: its volume is " + shortText(to) + ", and the target's is " +
                    shortText(volumeOf(pairs.from, pairs.from.front())) + "; check the points");
}

/// The largest of the values, but for a part of their weights.
double usualMost(std::vector<std::pair<double, double>> weighted) {
  constexpr double kLeftOut = 0.005;
  if (weighted.empty()) return 1;
  std::sort(weighted.begin(), weighted.end());
  double left = kLeftOut * std::accumulate(weighted.begin(), weighted.end(), 0.,
                                           [](double sum, const auto& value) { return sum + value.second; });
  while (weighted.size() > 1 && left > weighted.back().second) {
    left -= weighted.back().second;
    weighted.pop_back();
  }
  return weighted.back().first;
}

}  // namespace

/// A search wants triangles of ordinary size. Its units are hundredths of the longest side of a surface, about its
/// middle.
struct SearchUnits {
  explicit SearchUnits(std::span<const Vec3d> points) {
    openvdb::BBoxd box;
    for (const Vec3d& point : points) box.expand(point);
    constexpr double kLength = 100;
    middle = box.getCenter();
    scale = kLength / longestSide(box);
  }
  Vec3d of(const Vec3d& world) const { return (world - middle) * scale; }
  Vec3d world(const Vec3d& at) const { return middle + at / scale; }

  Vec3d middle;
  double scale = 1;  ///< per world unit
};

struct SurfaceMotion::Parts {
  Parts(const CornerPairs& pairs, const std::string& name)
      : overall(overallOf(pairs, name)),
        fromUnits(pairs.from),
        toUnits(pairs.to),
        linear(overall.matrix * toUnits.scale) {}

  Image image(const Vec3I& t, const Vec3d& w, const Vec3d& at) const;

  AffineMap overall;
  SearchUnits fromUnits, toUnits;
  Mat3d linear;                 ///< of the overall map, from world units to those of the other surface's search
  std::vector<Vec3d> from, to;  ///< each in its own units
  std::vector<Vec3I> triangles;
  std::vector<Mat3d> turns;  ///< what T does after the overall map, at each vertex
  std::optional<SurfaceSearch> search;
  double size = 1, growth = 1;
};

SurfaceMotion::~SurfaceMotion() = default;

namespace {

/// @throw DataError  the surfaces are of quite different sizes
void requireOneUnit(const SearchUnits& fromUnits, const SearchUnits& toUnits, const std::string& name) {
  constexpr double kMost = 30;
  const double times = fromUnits.scale / toUnits.scale;
  if (times > kMost || times < 1 / kMost)
    throw DataError(name + " is " + shortText(times > 1 ? times : 1 / times) + " times as " +
                    (times > 1 ? "large" : "small") + " as the target; give both in the same unit");
}

}  // namespace

void requireSameCount(std::size_t triangles, std::size_t others, const FaceWords& words) {
  if (triangles != others)
    throw DataError(words.mesh + " has " + std::to_string(triangles) + " triangles, and " + words.other + " has " +
                    std::to_string(others) + "; " + words.wayOut);
}

void requireSameFaces(const Mesh& mesh, const Mesh& other, const FaceWords& words) {
  requireSameCount(mesh.triangles.size(), other.triangles.size(), words);
  if (!haveNumbers(mesh, other)) return;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Vec3I &a = mesh.triangles[i], &b = other.triangles[i];
    const auto isShared = [&](int corner) { return a[corner] == b[0] || a[corner] == b[1] || a[corner] == b[2]; };
    if (!isShared(0) && !isShared(1) && !isShared(2))
      throw DataError("triangle " + std::to_string(i + 1) + " of " + words.other +
                      " has other corners than that of the target; give meshes with the same faces, in the same order");
  }
}

SurfaceMotion::SurfaceMotion(const Mesh& from, const Mesh& to, MotionDepth depth, const std::string& name) {
  requireSameFaces(from, to, {.other = name});
  const CornerPairs pairs = cornersOf(from, to);
  mParts = std::make_unique<Parts>(pairs, name);
  Parts& parts = *mParts;
  requireOneSide(pairs, parts.overall, name);
  requireOneUnit(parts.fromUnits, parts.toUnits, name);

  // Vertices are the same if they lie together in both surfaces.
  std::map<std::array<double, 6>, std::uint32_t> vertices;
  std::vector<Vec3d> moved;  // as the overall map puts them, in the other surface's units
  parts.triangles.resize(pairs.from.size() / 3);
  constexpr auto kNone = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> known(1 + *std::max_element(pairs.number.begin(), pairs.number.end()), kNone);
  for (std::size_t i = 0; i < pairs.from.size(); ++i) {
    std::uint32_t& vertex = known[pairs.number[i]];
    if (vertex != kNone) {
      parts.triangles[i / 3][static_cast<int>(i % 3)] = vertex;
      continue;
    }
    const Vec3d &f = pairs.from[i], &t = pairs.to[i];
    const auto [found, isNew] =
        vertices.try_emplace({f[0], f[1], f[2], t[0], t[1], t[2]}, static_cast<std::uint32_t>(parts.from.size()));
    if (isNew) {
      parts.from.push_back(parts.fromUnits.of(f));
      parts.to.push_back(parts.toUnits.of(t));
      moved.push_back(parts.toUnits.of(parts.overall(f)));
    }
    parts.triangles[i / 3][static_cast<int>(i % 3)] = vertex = found->second;
  }

  // The gradient of each triangle after the overall map: its edges and its normal go to those of the other surface.
  parts.turns.assign(parts.from.size(), Mat3d::zero());
  std::vector<double> weights(parts.from.size(), 0);
  std::vector<std::pair<double, double>> growths;
  const double determinant = std::abs(parts.linear.det());
  const Mat3d back = determinant > 0 ? parts.linear.inverse() : Mat3d::identity();
  for (const Vec3I& t : parts.triangles) {
    const Vec3d a = moved[t[1]] - moved[t[0]], b = moved[t[2]] - moved[t[0]];
    const Vec3d A = parts.to[t[1]] - parts.to[t[0]], B = parts.to[t[2]] - parts.to[t[0]];
    const Vec3d normal = a.cross(b), image = A.cross(B);
    const double area = normal.length(), areaAfter = image.length();
    if (!(area > 0)) continue;
    const Vec3d n = normal / area;
    const double height =
        depth == MotionDepth::Kept ? (back * n).length() * parts.toUnits.scale : std::sqrt(areaAfter / area);
    const Vec3d up = areaAfter > 0 ? image * (height / areaAfter) : Vec3d(0);
    // A a* + B b* + up n, with the dual basis a*, b* of a, b in the plane of the triangle.
    const Vec3d dualA = b.cross(n) / area, dualB = n.cross(a) / area;
    const Mat3d gradient = openvdb::math::outerProduct(A, dualA) + openvdb::math::outerProduct(B, dualB) +
                           openvdb::math::outerProduct(up, n);
    for (int k = 0; k < 3; ++k) {
      parts.turns[t[k]] += gradient * area;
      weights[t[k]] += area;
    }
    if (up.length() > 0) growths.emplace_back(1 / up.length(), area);
  }
  for (std::size_t i = 0; i < parts.turns.size(); ++i)
    parts.turns[i] = weights[i] > 0 ? parts.turns[i] * (1 / weights[i]) : Mat3d::identity();
  const double areas[] = {areaOf(pairs.from), areaOf(pairs.to)};
  if (areas[1] > 0) parts.size = std::sqrt(areas[0] / areas[1]);
  parts.growth =
      usualMost(std::move(growths)) * (determinant > 0 ? parts.toUnits.scale / elementary::cbrt(determinant) : 1);
  parts.search.emplace(parts.from, parts.triangles);
}

const AffineMap& SurfaceMotion::overall() const { return mParts->overall; }
double SurfaceMotion::greatestGrowth() const { return mParts->growth; }
double SurfaceMotion::size() const { return mParts->size; }
const std::vector<Vec3I>& SurfaceMotion::triangles() const { return mParts->triangles; }

std::vector<Vec3d> SurfaceMotion::points() const {
  std::vector<Vec3d> points;
  points.reserve(mParts->from.size());
  for (const Vec3d& point : mParts->from) points.push_back(mParts->fromUnits.world(point));
  return points;
}

void SurfaceMotion::showOnly(const std::vector<std::uint32_t>& shown) {
  Parts& parts = *mParts;
  std::vector<Vec3I> triangles;
  triangles.reserve(shown.size());
  for (const std::uint32_t triangle : shown) triangles.push_back(parts.triangles[triangle]);
  parts.search.emplace(parts.from, triangles);
  parts.triangles = std::move(triangles);
}

SurfaceMotion::Image SurfaceMotion::Parts::image(const Vec3I& t, const Vec3d& w, const Vec3d& at) const {
  const auto mean = [&](const auto& values) { return interpolated(w, [&](int corner) { return values[t[corner]]; }); };
  const Mat3d gradient = mean(turns) * linear;
  const Vec3d beside = gradient * ((at - mean(from)) / fromUnits.scale);
  return {.at = toUnits.world(mean(to) + beside), .gradient = gradient * (1 / toUnits.scale)};
}

SurfaceMotion::Image SurfaceMotion::carry(const Vec3d& x, std::optional<std::uint32_t> hint) const {
  const Parts& parts = *mParts;
  const Vec3d at = parts.fromUnits.of(x);
  const std::optional<SurfacePoint> found = parts.search->nearest(at, std::numeric_limits<double>::infinity(), hint);
  if (!found) throw DataError("the mesh has no triangle with an area; check the file");
  Image image = parts.image(parts.triangles[found->triangle], found->weights, at);
  image.hint = found->triangle;
  return image;
}

SurfaceMotion::Image SurfaceMotion::carryBy(std::uint32_t triangle, const Vec3d& x) const {
  const Parts& parts = *mParts;
  const Vec3I& t = parts.triangles[triangle];
  const Vec3d at = parts.fromUnits.of(x);
  Vec3d weights;
  nearestOnTriangle(parts.from[t[0]], parts.from[t[1]], parts.from[t[2]], at, weights);
  return parts.image(t, weights, at);
}

SurfaceVelocity::SurfaceVelocity(const Mesh& now, std::span<const SurfaceAt> moments, MotionDepth depth) {
  for (const SurfaceAt& moment : moments) {
    if (moment.seconds == 0) continue;
    Side& side = mSides.emplace_back(Side{.seconds = moment.seconds});
    // What is exactly the same has the velocity 0 without rounding.
    if (moment.mesh->points != now.points || moment.mesh->triangles != now.triangles)
      side.motion = std::make_unique<const SurfaceMotion>(now, *moment.mesh, depth, moment.name);
  }
}

SurfaceVelocity::~SurfaceVelocity() = default;

std::vector<Vec3d> SurfaceVelocity::at(std::span<const Vec3d> points) const {
  std::vector<Vec3d> result(points.size(), Vec3d(0));
  const SurfaceMotion* search = nullptr;
  for (const Side& side : mSides)
    if (side.motion && !search) search = side.motion.get();
  if (!search) return result;
  const double seconds = mSides.back().seconds - (mSides.size() > 1 ? mSides.front().seconds : 0);
  std::optional<std::uint32_t> hint;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vec3d& x = points[i];
    // All motions begin at the same triangles, so that one search is enough.
    hint = search->carry(x, hint).hint;
    const auto placeAt = [&](const Side& side) { return side.motion ? side.motion->carryBy(*hint, x).at : x; };
    const Vec3d from = mSides.size() > 1 ? placeAt(mSides.front()) : x;
    result[i] = (placeAt(mSides.back()) - from) / seconds;
  }
  return result;
}

double SurfaceVelocity::frame() const {
  double longest = 0;
  for (const Side& side : mSides) longest = std::max(longest, std::abs(side.seconds));
  return longest;
}

}  // namespace vdbtools
