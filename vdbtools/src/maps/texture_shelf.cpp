// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/maps/texture_shelf.h"

#include "base/counter_random.h"

#include "julia/root_patterns.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace vdbtools {
namespace {

using julia::Point;
using enum RootFamily;

constexpr Point kX{1, 0, 0}, kY{0, 1, 0}, kZ{0, 0, 1};

// Enough for a band of a few voxels at every usual resolution, and small against every part of a shape.
constexpr double kSurfaceReach = 0.02;

// Found by looking at many. Rings about X take one root however many they are, those about other axes two roots a ring.
std::vector<Texture> allTextures() {
  return {
      {"scales",
       "Small overlapping plates, where two systems of slanting bands cross.",
       {{.count = 11, .axis = {0.5, 0.8, 0.3}, .length = 0.8}, {.count = 11, .axis = {0.5, -0.8, 0.3}, .length = 0.8}}},
      {"woven",
       "Rows of small studs, where fine bands about X cross others about Y, like basketwork.",
       {{.count = 5, .power = 8, .length = 1}, {.count = 20, .axis = kY, .length = 0.8}}},
      {"rings", "Broad smooth rings about X, as in [SK23] Fig. 9.", {{.count = 5, .power = 6, .length = 1}}},
      {"ledges", "Thin level shelves, one above the other.", {{.count = 20, .axis = kY, .length = 0.8}}},
      {"shells",
       "Toothed ridges that wind up like those of an ammonite.",
       {{.family = Fan, .count = 20, .axis = kX, .towards = kZ, .angle = 0.15}}},
      {"brackets",
       "Saw-toothed shelves like those of a tree fungus.",
       {{.family = Fan, .count = 20, .axis = kX, .towards = kY, .angle = 0.15}}},
      {"crest",
       "A comb of blades over the back, and calm flanks.",
       {{.family = Fan, .count = 18, .axis = kY, .towards = kZ, .angle = 0.2}}},
      {"quills", "Long sharp spines in rows.", {{.repeats = 10, .axis = kY}, {.repeats = 10, .axis = kZ}}},
      {"fins",
       "A fan of thin blades over a calm body, where two systems of level bands undo each other.",
       {{.repeats = 10, .axis = kY, .shift = 0.1}, {.power = -1, .repeats = 10, .axis = kY, .shift = -0.1}}},
      {"thorns", "Few long thorns on a smooth skin.", {{.power = 3, .repeats = 5, .axis = kZ}}},
      {"flames", "Swirling sheets that end in tongues.", {{.power = 2, .repeats = 9, .axis = kY}}},
      {"feathers",
       "Rows of curved vanes with torn tips.",
       {{.count = 5, .power = 5, .length = 1}, {.power = 2, .repeats = 7, .axis = kY}}},
      {"fur", "Fine short hair in upright rows.", {{.count = 17, .power = 6, .along = kY, .length = 1}}},
      {"bark",
       "Furrows and cracks around the shape, from roots on a helix.",
       {{.family = Helix, .count = 21, .power = 3, .length = 1, .radius = 0.1, .turns = 3.4, .jitter = 0.01}}},
      {"strata",
       "Flaking layers of stone, from roots on an upright helix.",
       {{.family = Helix, .count = 20, .axis = kY, .length = 0.9, .radius = 0.12, .turns = 2, .jitter = 0.01}}},
      {"coral",
       "Crumbling knobs and twigs, from roots all over the target's own surface.",
       {{.family = Surface, .count = 36, .power = 3}}},
      {"burrs",
       "Rough lumps with hooked tips, from roots on a lattice.",
       {{.family = Lattice, .power = 2, .spacing = 0.26}}},
      {"drips",
       "Wax that has run down and set, from a circle of roots with sevenfold symmetry.",
       {{.family = Helix, .count = 7, .power = 5, .along = kZ, .radius = 0.3}}},
      {"folds",
       "Large creased folds of cloth, from a level circle of roots with sevenfold symmetry.",
       {{.family = Helix, .count = 7, .power = 2, .axis = kY, .along = Point{0, -1, 0}, .radius = 0.25}}},
  };
}

std::vector<Point> pointsOf(const Strand& strand, const TextureSite& site, std::uint64_t seed) {
  const double unit = site.longestSide;
  const Point axis = strand.along.value_or(strand.axis);
  const double shift = strand.shift * unit;
  const Point middle{shift * axis[0], shift * axis[1], shift * axis[2]};
  switch (strand.family) {
    case Line: return julia::pointsOnLine(middle, axis, strand.length * unit, strand.count);
    case Helix:
      return julia::pointsOnHelix(middle, axis, strand.radius * unit, strand.length * unit, strand.turns, strand.count);
    case Lattice: return julia::pointsOfLattice(site.boxMin, site.boxMax, strand.spacing * unit);
    case Surface:
      return julia::pointsOnSurface(site.distance, site.boxMin, site.boxMax, kSurfaceReach * unit, strand.count, seed);
    case Fan: return std::vector<Point>(static_cast<std::size_t>(strand.count), middle);
  }
  throw std::logic_error("a family of roots without points");
}

bool isOnSurface(const Strand& strand) { return strand.family == Surface; }

}  // namespace

bool Texture::varies() const {
  return std::any_of(strands.begin(), strands.end(),
                     [](const Strand& strand) { return strand.jitter > 0 || isOnSurface(strand); });
}

const std::vector<Texture>& textureShelf() {
  static const std::vector<Texture> shelf = allTextures();
  return shelf;
}

const Texture* findTexture(const std::string& name) {
  if (name.rfind("waves:", 0) == 0) {
    auto* t = new Texture{name, "trial", {}};
    std::string text = name.substr(6);
    std::size_t at = 0;
    while (at <= text.size()) {
      const std::size_t end = std::min(text.find('+', at), text.size());
      const std::string part = text.substr(at, end - at);
      at = end + 1;
      std::vector<double> n;
      for (std::size_t i = 1; i < part.size();) {
        const std::size_t e = std::min(part.find(',', i + 1), part.size());
        n.push_back(std::stod(part.substr(i + 1, e - i - 1)));
        i = e;
      }
      WaveStrand w;
      if (part[0] == 'n') {
        w.count = int(n.at(0)); w.power = int(n.at(1));
        w.stretch = {n.at(2), n.at(3), n.at(4)}; w.depth = n.at(5); w.seed = std::uint64_t(n.at(6));
      } else {
        w.count = 1; w.power = int(n.at(0)); w.stretch = {n.at(1), n.at(2), n.at(3)}; w.depth = n.at(4);
        w.turn = {n.at(5), n.at(6), n.at(7)};
      }
      t->waves.push_back(w);
    }
    return t;
  }
  for (const Texture& texture : textureShelf())
    if (texture.name == name) return &texture;
  return nullptr;
}

const Texture& defaultTexture() { return textureShelf().front(); }

double surfaceReach(const Texture& texture) {
  // Newton's steps read the distance a little beyond the points that they begin at.
  constexpr double kBeyond = 1.5;
  return std::any_of(texture.strands.begin(), texture.strands.end(), isOnSurface) ? kBeyond * kSurfaceReach : 0;
}

julia::WaveTexture wavesOf(const Texture& texture, std::uint64_t seed, const julia::Embedding& embedding) {
  julia::WaveTexture made;
  for (const WaveStrand& strand : texture.waves) {
    julia::WaveFactor factor{{}, strand.power};
    std::uint64_t counter = 0;
    const auto unit = [&] { return randomUnit(seed, strand.seed, counter++); };
    const auto normal = [&] {
      double sum = -6;
      for (int i = 0; i < 12; ++i) sum += unit();
      return sum;
    };
    const auto direction = [&] {
      julia::Quaternion<double> q{normal(), normal(), normal(), normal()};
      return q * (1 / std::sqrt(julia::normSquared(q)));
    };
    const auto placed = [&](double x, double y, double z, double w) {
      julia::Embedding e = embedding;
      e.slice = w;
      return e.quaternion<double>({x, y, z});
    };
    for (int i = 0; i < strand.count; ++i) {
      if (strand.count == 1) {
        const auto& t = strand.turn;
        factor.waves.push_back({placed(strand.stretch[0], strand.stretch[1], strand.stretch[2], strand.depth), {1, 0, 0, 0}, {0, t[0], t[1], t[2]}});
        continue;
      }
      const auto d = direction();
      const double length = 0.75 + 0.5 * unit();
      const auto c = direction();
      auto s = direction();
      const double dot = c.a * s.a + c.b * s.b + c.c * s.c + c.d * s.d;
      s = s - c * dot;
      s = s * (1 / std::sqrt(julia::normSquared(s)));
      factor.waves.push_back({placed(length * d.a * strand.stretch[0], length * d.b * strand.stretch[1], length * d.c * strand.stretch[2], length * d.d * strand.depth), c, s});
    }
    made.factors.push_back(std::move(factor));
  }
  return made;
}

julia::Rational placeTexture(const Texture& texture, const TextureSite& site, std::uint64_t seed,
                             const julia::Embedding& embedding) {
  julia::Rational rational;
  std::vector<julia::Root>& roots = rational.top.roots;
  std::uint64_t strandSeed = seed;
  for (const Strand& strand : texture.strands) {
    std::vector<Point> points = pointsOf(strand, site, strandSeed);
    if (strand.jitter > 0) points = julia::jittered(std::move(points), strand.jitter * site.longestSide, strandSeed);
    const bool isFan = strand.family == Fan;
    const std::vector<Point> axes = isFan ? julia::fanOfAxes(strand.axis, strand.towards, strand.angle, strand.count)
                                          : std::vector<Point>(points.size(), strand.axis);
    for (std::size_t i = 0; i < points.size(); ++i)
      julia::appendRings(roots, points[i], axes[i], strand.power, strand.repeats, embedding);
    // Strands of one texture are strewn differently, and by other numbers than those of the next seeds.
    strandSeed += 0x9e3779b97f4a7c15;
  }
  rational.logScale = julia::unitConstants(roots);
  return rational;
}

}  // namespace vdbtools
