// SPDX-License-Identifier: Apache-2.0
#include "search/surface_distance.h"

#include "base/in_parallel.h"

#include <openvdb/math/Proximity.h>

#include <algorithm>
#include <array>
#include <optional>

namespace vdbtools {
namespace {

using openvdb::Vec3d;
using TrianglePiece = std::array<Vec3d, 3>;

/// The maximum number of halvings of a piece: its sides are then below 1/1000 of the triangle's.
constexpr int kMostHalvings = 22;

class NearProof {
 public:
  NearProof(double limit, const Mesh& other, const SurfaceSearch& search)
      : mLimit(limit), mOther(other), mSearch(search) {}

  /// The nearest triangle of the other surface at a place where the proof fails.
  std::optional<std::uint32_t> failure(const TrianglePiece& piece, std::optional<std::uint32_t> hint,
                                       int halvings) const {
    const Vec3d middle = (piece[0] + piece[1] + piece[2]) / 3.0;
    const auto nearest = mSearch.nearest(middle, std::numeric_limits<double>::infinity(), hint);
    if (!nearest) return 0;
    if (nearest->distance > mLimit || halvings > kMostHalvings) return nearest->triangle;
    if (std::all_of(piece.begin(), piece.end(),
                    [&](const Vec3d& corner) { return distance(corner, nearest->triangle) <= mLimit; }))
      return std::nullopt;
    int longest = 0;
    double square = -1;
    for (int c = 0; c < 3; ++c) {
      const double length = (piece[at(c + 1)] - piece[at(c)]).lengthSqr();
      if (length > square) square = length, longest = c;
    }
    const Vec3d half = (piece[at(longest)] + piece[at(longest + 1)]) / 2.0;
    const TrianglePiece first = {piece[at(longest)], half, piece[at(longest + 2)]},
                        second = {half, piece[at(longest + 1)], piece[at(longest + 2)]};
    const auto found = failure(first, nearest->triangle, halvings + 1);
    return found ? found : failure(second, nearest->triangle, halvings + 1);
  }

 private:
  static std::size_t at(int corner) { return static_cast<std::size_t>(corner % 3); }

  double distance(const Vec3d& p, std::uint32_t triangle) const {
    const openvdb::Vec3I& t = mOther.triangles[triangle];
    Vec3d weights;
    const Vec3d nearest = openvdb::math::closestPointOnTriangleToPoint(mOther.points[t[0]], mOther.points[t[1]],
                                                                       mOther.points[t[2]], p, weights);
    return (p - nearest).length();
  }

  double mLimit;
  const Mesh& mOther;
  const SurfaceSearch& mSearch;
};

}  // namespace

std::vector<FarPlace> placesFartherThan(double limit, const Mesh& surface, const Mesh& other,
                                        const SurfaceSearch& search, const Monitor& monitor) {
  constexpr std::size_t kGrain = 1024;
  const NearProof proof(limit, other, search);
  constexpr std::uint32_t kProved = ~std::uint32_t{0};
  std::vector<std::uint32_t> found(surface.triangles.size(), kProved);
  inParallel(found.size(), kGrain, monitor, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const openvdb::Vec3I& t = surface.triangles[i];
      const auto far =
          proof.failure({surface.points[t[0]], surface.points[t[1]], surface.points[t[2]]}, std::nullopt, 0);
      if (far) found[i] = *far;
    }
  });
  std::vector<FarPlace> places;
  for (std::size_t i = 0; i < found.size(); ++i)
    if (found[i] != kProved) places.push_back({static_cast<std::uint32_t>(i), found[i]});
  return places;
}

}  // namespace vdbtools
