// SPDX-License-Identifier: Apache-2.0
// How often float and double misjudge a node, and how far they move a vertex, beside the reference in 128 bits: the
// table of docs/precision.md. The same options give the same numbers for any number of threads.
#include "julia/evaluator.h"
#include "julia/random_roots.h"
#include "julia/rational_map.h"
#include "julia/shape_modulus.h"
#include "julia/wave_versor.h"
#include "support/reference.h"
#include "support/reference_waves.h"

#include <boost/multiprecision/float128.hpp>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <functional>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <thread>
#include <vector>

namespace {

namespace reference = julia::reference;
using julia::Point;
using julia::Quaternion;
using julia::Rational;
using Wide = boost::multiprecision::float128;

constexpr double kEscape = 20;
constexpr double kAlpha = 40;
constexpr int kBisections = 24;  // to 6e-8 of an edge
constexpr std::size_t kBlock = 1024;
constexpr std::size_t kWideBlock = 16;

// Work is counted in powers of quaternions. Rows that would need more than this compare fewer points.
constexpr double kFastWork = 1.5e8;    // nodes in float and double
constexpr double kWideWork = 2e7;      // nodes in 128 bits
constexpr double kWideEdgeWork = 1e6;  // vertices in 128 bits
constexpr double kDefaultPoints = 1e6;
constexpr double kWideShare = 0.02;    // of the points: 20 000 of a million
constexpr std::size_t kJudged = 1000;  // disagreements of float and double that 128 bits decide, at most

/// The standard fixes the engine but not its distributions.
class Random {
 public:
  explicit Random(std::uint64_t seed) : mEngine(seed) {}
  double unit() { return static_cast<double>(mEngine() >> 11) * 0x1p-53; }
  double between(double low, double high) { return low + (high - low) * unit(); }

 private:
  std::mt19937_64 mEngine;
};

/// work(first, last) for blocks of [0, count), on all cores.
void inBlocks(std::size_t count, std::size_t block, const std::function<void(std::size_t, std::size_t)>& work) {
  std::atomic<std::size_t> next{0};
  const auto run = [&] {
    for (std::size_t first; (first = next.fetch_add(block)) < count;) work(first, std::min(first + block, count));
  };
  std::vector<std::jthread> threads;
  for (unsigned i = 1; i < std::max(1u, std::thread::hardware_concurrency()); ++i) threads.emplace_back(run);
  run();
}

/// E: alpha times about the distance to a ball whose surface is 0.37 to 0.56 from the origin; the bumps fade far away.
template <class T>
T exponent(const T& x, const T& y, const T& z) {
  using std::sqrt;
  const T squared = x * x + y * y + z * z, fade = T(1) + squared;
  return T(kAlpha) * (sqrt(squared) - T(0.42) - T(7) * x * y * z / (fade * fade));
}

template <class Real>
class BumpyBall final : public julia::ScalarField<Real> {
 public:
  void sample(std::span<const Real> x, std::span<const Real> y, std::span<const Real> z,
              std::span<Real> out) const override {
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = exponent(x[i], y[i], z[i]);
  }
};

/// The octave of textures of waves: some 10 of them across the ball, and twice as many on one side as on the other.
template <class T>
T octave(const T& x, const T& y, const T& z) {
  return T(3.5) + x + T(0.25) * y * z;
}

template <class Real>
class OctaveField final : public julia::ScalarField<Real> {
 public:
  void sample(std::span<const Real> x, std::span<const Real> y, std::span<const Real> z,
              std::span<Real> out) const override {
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = octave(x[i], y[i], z[i]);
  }
};

struct Scene {
  std::string map, roots, powers;
  Rational rational;
  std::optional<julia::WaveTexture> waves{};  ///< instead, for a shape modulus
  int iterations = 3;
  bool isShapeModulus = true;
  double side = 1;  ///< what is divided into N voxels

  /// Powers of quaternions that a point costs at most. The shape modulus needs none in its last step.
  double cost() const {
    double count = static_cast<double>(rational.top.roots.size() + rational.bottom.roots.size());
    if (waves)
      for (const julia::WaveFactor& factor : waves->factors) count += 2 * static_cast<double>(factor.waves.size());
    return count * std::max(isShapeModulus ? iterations - 1 : iterations, 1);
  }
  double summed() const { return summedPowers(rational.top) + summedPowers(rational.bottom); }
};

template <class Real>
std::unique_ptr<julia::FieldEvaluator> evaluatorOf(const Scene& scene) {
  std::shared_ptr<const julia::Map<Real>> map;
  if (scene.waves)
    map = std::make_shared<julia::ShapeModulus<Real>>(
        std::make_shared<BumpyBall<Real>>(),
        std::make_shared<julia::WaveVersor<Real>>(*scene.waves, std::make_shared<OctaveField<Real>>(),
                                                  julia::DropAxis::K),
        julia::DropAxis::K);
  else if (scene.isShapeModulus)
    map = std::make_shared<julia::ShapeModulus<Real>>(std::make_shared<BumpyBall<Real>>(), scene.rational,
                                                      julia::DropAxis::K);
  else
    map = std::make_shared<julia::RationalMap<Real>>(scene.rational);
  return julia::makeFieldEvaluator<Real>(map, {}, {.maxIterations = scene.iterations, .escapeRadius = kEscape});
}

using Field = std::function<void(std::span<const Point>, std::span<double>)>;

Field fieldOf(const julia::FieldEvaluator& evaluator) {
  return
      [&evaluator](std::span<const Point> points, std::span<double> field) { evaluator.evaluate(points, field, {}); };
}

/// The reference. Its shape modulus need not ask for the versor of a last step, for |f| = e^E.
Field wideField(const Scene& scene) {
  if (!scene.isShapeModulus)
    return [map = reference::rationalMap<Wide>(scene.rational), n = scene.iterations](auto points, auto field) {
      for (std::size_t i = 0; i < points.size(); ++i) {
        const Quaternion<double> q{points[i][0], points[i][1], points[i][2], 0};
        field[i] = static_cast<double>(reference::orbit<Wide>(map, q.as<Wide>(), n, Wide(kEscape)).logModulus);
      }
    };
  const auto exponentAt = [](const Quaternion<Wide>& q) { return exponent<Wide>(q.a, q.b, q.c); };
  using Step = std::function<Quaternion<Wide>(const Quaternion<Wide>&)>;
  Step step;
  if (scene.waves)
    step = [texture = *scene.waves](const Quaternion<Wide>& q) {
      Wide least = 1;
      const Quaternion<Wide> u = reference::wavesAt<Wide>(texture, q, octave<Wide>(q.a, q.b, q.c), least);
      return u * Wide(exp(exponent<Wide>(q.a, q.b, q.c)) / sqrt(normSquared(u)));
    };
  else
    step = [map = reference::shapeModulus<Wide>(exponentAt, scene.rational)](const Quaternion<Wide>& q) {
      return *map(q);
    };
  return [exponentAt, step, n = scene.iterations](auto points, auto field) {
    const Wide logEscape = log(Wide(kEscape));
    for (std::size_t i = 0; i < points.size(); ++i) {
      Quaternion<Wide> q{points[i][0], points[i][1], points[i][2], 0};
      Wide l = exponentAt(q);
      for (int i = 1; i < n && l < logEscape; ++i) {
        q = step(q);
        l = exponentAt(q);
      }
      field[i] = static_cast<double>(l);
    }
  };
}

/// The reference runs one point at a time: small blocks keep the cores busy to the end.
std::vector<double> evaluate(const Field& field, std::span<const Point> points, std::size_t block = kBlock) {
  std::vector<double> result(points.size());
  inBlocks(points.size(), block, [&](std::size_t first, std::size_t last) {
    field(points.subspan(first, last - first), std::span(result).subspan(first, last - first));
  });
  return result;
}

/// Nodes of the lattice i side/N: of the part of a shape modulus' shell (docs/design.md 2.4) that holds its surface, or
/// of a rational's box.
std::vector<Point> randomNodes(const Scene& scene, std::size_t count, double voxels, std::uint64_t seed) {
  // ln r_in of the bumpy ball is -1.07; whatever leaves the unit ball in the first step escapes in the second.
  constexpr double kLeastE = -1.1, kLargestE = 0.1;
  Random random(seed);
  const double half = 0.55 * scene.side, voxel = scene.side / voxels;
  std::vector<Point> nodes;
  while (nodes.size() < count) {
    Point x;
    for (double& coordinate : x) coordinate = std::round(random.between(-half, half) / voxel) * voxel;
    if (scene.isShapeModulus) {
      const double e = exponent(x[0], x[1], x[2]);
      if (e < kLeastE || e > kLargestE) continue;
    }
    nodes.push_back(x);
  }
  return nodes;
}

bool differ(double f, double g) { return (f < 0) != (g < 0); }

struct Edge {
  Point from, to;
};

/// Where on the edges F changes sign, 0 to 1, by bisection.
std::vector<double> bisect(const Field& field, std::span<const Edge> edges, const std::vector<bool>& insideAtStart,
                           std::size_t block = kBlock) {
  std::vector<double> low(edges.size(), 0), high(edges.size(), 1);
  std::vector<Point> middle(edges.size());
  for (int step = 0; step < kBisections; ++step) {
    for (std::size_t i = 0; i < edges.size(); ++i)
      for (int axis = 0; axis < 3; ++axis)
        middle[i][axis] = edges[i].from[axis] + (edges[i].to[axis] - edges[i].from[axis]) * (low[i] + high[i]) / 2;
    const std::vector<double> f = evaluate(field, middle, block);
    for (std::size_t i = 0; i < edges.size(); ++i)
      ((f[i] < 0) == insideAtStart[i] ? low : high)[i] = (low[i] + high[i]) / 2;
  }
  for (std::size_t i = 0; i < edges.size(); ++i) low[i] = (low[i] + high[i]) / 2;
  return low;
}

struct Moves {
  std::size_t count = 0;
  double quantile = 0, largest = 0;  ///< voxels; the quantile is 99.99 %
  double farShare = 0;               ///< per million, moved more than 1/100 voxel
};

Moves movesOf(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> moves(std::min(a.size(), b.size()));
  for (std::size_t i = 0; i < moves.size(); ++i) moves[i] = std::abs(a[i] - b[i]);
  if (moves.empty()) return {};
  std::sort(moves.begin(), moves.end());
  const double size = static_cast<double>(moves.size());
  const auto far = moves.end() - std::upper_bound(moves.begin(), moves.end(), 0.01);
  const auto at = static_cast<std::size_t>(std::ceil(0.9999 * size)) - 1;
  return {moves.size(), moves[at], moves.back(), 1e6 * static_cast<double>(far) / size};
}

struct Row {
  std::size_t nodes = 0, wideNodes = 0, notFinite = 0;
  std::size_t floatFlips = 0, wideFloatFlips = 0, doubleFlips = 0;
  std::size_t judged = 0, doubleRight = 0;
  Moves floatMoves, fineFloatMoves, wideFloatMoves, doubleMoves;
};

std::size_t capped(double wanted, double work, double cost) {
  return static_cast<std::size_t>(std::max(1.0, std::floor(std::min(wanted, work / cost))));
}

std::size_t notFinite(const std::vector<double>& field) {
  return static_cast<std::size_t>(
      std::count_if(field.begin(), field.end(), [](double f) { return !(std::abs(f) < julia::kFieldLimit); }));
}

class Comparison {
 public:
  Comparison(const Scene& scene, double points)
      : mScene(scene), mPoints(points), mFloat(evaluatorOf<float>(scene)), mDouble(evaluatorOf<double>(scene)) {}

  Row row() {
    Row result;
    compareNodes(result);
    result.fineFloatMoves = compareVertices(10000, nullptr, nullptr);
    result.floatMoves = compareVertices(1000, &result.doubleMoves, &result.wideFloatMoves);
    return result;
  }

 private:
  void compareNodes(Row& row) {
    const std::vector<Point> nodes = randomNodes(mScene, capped(mPoints, kFastWork, mScene.cost()), 1000, 1);
    const std::vector<double> inFloat = evaluate(fieldOf(*mFloat), nodes),
                              inDouble = evaluate(fieldOf(*mDouble), nodes);
    row.nodes = nodes.size();
    row.notFinite = notFinite(inFloat) + notFinite(inDouble);
    row.wideNodes = std::min(nodes.size(), capped(kWideShare * mPoints, kWideWork, mScene.cost()));
    std::vector<std::size_t> disagreements;
    for (std::size_t i = 0; i < nodes.size(); ++i)
      if (differ(inFloat[i], inDouble[i])) disagreements.push_back(i);
    row.floatFlips = disagreements.size();

    const std::vector<double> inWide = evaluate(mWide, std::span(nodes).first(row.wideNodes), kWideBlock);
    for (std::size_t i = 0; i < row.wideNodes; ++i) {
      row.wideFloatFlips += differ(inFloat[i], inWide[i]);
      row.doubleFlips += differ(inDouble[i], inWide[i]);
    }

    disagreements.resize(
        std::min(disagreements.size(), capped(static_cast<double>(kJudged), kWideEdgeWork, mScene.cost())));
    std::vector<Point> judged;
    for (const std::size_t i : disagreements) judged.push_back(nodes[i]);
    const std::vector<double> verdict = evaluate(mWide, judged, kWideBlock);
    row.judged = judged.size();
    for (std::size_t i = 0; i < judged.size(); ++i) row.doubleRight += !differ(inDouble[disagreements[i]], verdict[i]);
  }

  /// Of float against double; and, if asked, of double and float against 128 bits on fewer edges.
  Moves compareVertices(double voxels, Moves* doubleToWide, Moves* floatToWide) {
    const double voxel = mScene.side / voxels;
    const std::vector<Point> from = randomNodes(mScene, capped(mPoints, kFastWork, mScene.cost()), voxels, 2);
    std::vector<Point> to = from;
    for (std::size_t i = 0; i < to.size(); ++i) to[i][i % 3] += voxel;
    const std::vector<double> fromDouble = evaluate(fieldOf(*mDouble), from),
                              toDouble = evaluate(fieldOf(*mDouble), to);
    std::vector<Edge> edges;
    std::vector<Point> starts, ends;
    std::vector<bool> inside;
    for (std::size_t i = 0; i < from.size(); ++i) {
      if (!differ(fromDouble[i], toDouble[i])) continue;
      starts.push_back(from[i]);
      ends.push_back(to[i]);
      inside.push_back(fromDouble[i] < 0);
    }
    const auto keepAgreeing = [&](const Field& field, std::size_t most, std::size_t block) {
      const std::size_t count = std::min(most, starts.size());
      const std::vector<double> f = evaluate(field, std::span(starts).first(count), block);
      const std::vector<double> g = evaluate(field, std::span(ends).first(count), block);
      std::vector<Edge> kept;
      std::vector<bool> sides;
      for (std::size_t i = 0; i < count; ++i) {
        if ((f[i] < 0) != inside[i] || (g[i] < 0) == inside[i]) continue;
        kept.push_back({starts[i], ends[i]});
        sides.push_back(inside[i]);
      }
      return std::pair(std::move(kept), std::move(sides));
    };
    const auto [fast, fastSides] = keepAgreeing(fieldOf(*mFloat), starts.size(), kBlock);
    const Moves result = movesOf(bisect(fieldOf(*mFloat), fast, fastSides), bisect(fieldOf(*mDouble), fast, fastSides));
    if (doubleToWide) {
      const auto wideCount = capped(mPoints, kWideEdgeWork, mScene.cost() * kBisections);
      auto [slow, slowSides] = keepAgreeing(mWide, wideCount, kWideBlock);
      const std::vector<double> inWide = bisect(mWide, slow, slowSides, kWideBlock);
      *doubleToWide = movesOf(bisect(fieldOf(*mDouble), slow, slowSides), inWide);
      *floatToWide = movesOf(bisect(fieldOf(*mFloat), slow, slowSides), inWide);
    }
    return result;
  }

  const Scene& mScene;
  double mPoints;
  std::unique_ptr<julia::FieldEvaluator> mFloat, mDouble;
  Field mWide = wideField(mScene);
};

Scene shapeScene(int iterations, int roots, double maxPower, bool integerPowers) {
  Scene scene{.map = "shape modulus", .roots = std::to_string(roots), .powers = {}, .rational = {}};
  scene.powers =
      (integerPowers ? "2 to " : "2.0 to ") + std::to_string(static_cast<int>(maxPower)) + (integerPowers ? "" : ".0");
  scene.rational.top = julia::randomPolynomial(
      {.seed = 1, .count = roots, .minPower = 2, .maxPower = maxPower, .integerPowers = integerPowers});
  scene.iterations = iterations;
  return scene;
}

/// Bands of two directions and a field of four waves, as the default of the shelf; or two fields of twelve, squared.
Scene waveScene(int iterations, bool fields) {
  Scene scene{.map = "shape modulus",
              .roots = fields ? "2 x 12 waves" : "6 waves",
              .powers = fields ? "2" : "1",
              .rational = {}};
  scene.iterations = iterations;
  Random random(7);
  const auto direction = [&random]() -> Quaternion<double> {
    for (;;) {
      const Quaternion<double> q{random.between(-1, 1), random.between(-1, 1), random.between(-1, 1),
                                 random.between(-1, 1)};
      const double squared = normSquared(q);
      if (squared < 1 && squared > 0.01) return q * (1 / std::sqrt(squared));
    }
  };
  const auto field = [&](int count, int power) {
    julia::WaveFactor factor{{}, power};
    for (int i = 0; i < count; ++i) {
      const Quaternion<double> cosine = direction(), other = direction();
      const double along = other.a * cosine.a + other.b * cosine.b + other.c * cosine.c + other.d * cosine.d;
      const Quaternion<double> sine = other - cosine * along;
      factor.waves.push_back({direction(), cosine, sine * (1 / std::sqrt(normSquared(sine)))});
    }
    return factor;
  };
  julia::WaveTexture texture;
  if (fields) {
    texture.factors = {field(12, 2), field(12, 2)};
  } else {
    const Quaternion<double> one = Quaternion<double>::one();
    texture.factors = {
        {{{{0.5, 0.8, 0.3, 0}, one, {0, 1, 0, 0}}}, 1}, {{{{0.5, -0.8, 0.3, 0}, one, {0, 0, 1, 0}}}, 1}, field(4, 1)};
  }
  scene.waves = std::move(texture);
  return scene;
}

/// Roots and poles in pairs, as a texture that is spread over a shape has them: the two of a pair are as far apart as
/// half the distance to the next pair, or so, and far away they cancel.
Scene pairScene(int iterations, int pairs, double power) {
  Scene scene{.map = "shape modulus", .roots = std::to_string(pairs) + " pairs", .powers = {}, .rational = {}};
  scene.powers = std::to_string(static_cast<int>(power));
  scene.iterations = iterations;
  Random random(11);
  const auto inBall = [&random](double radius) -> Quaternion<double> {
    for (;;) {
      const Quaternion<double> q{random.between(-1, 1), random.between(-1, 1), random.between(-1, 1), 0};
      if (normSquared(q) < 1) return q * radius;
    }
  };
  const double apart = 0.5 * std::cbrt(1.0 / pairs);
  for (int i = 0; i < pairs; ++i) {
    const Quaternion<double> middle = inBall(0.5), half = inBall(apart / 2);
    scene.rational.top.roots.push_back({middle + half, power});
    scene.rational.bottom.roots.push_back({middle - half, power});
  }
  return scene;
}

/// A rational like the bunny of [KD20] Table 1: 178 top roots, 153 bottom ones, near a sphere of radius 4, and the C
/// that puts the surface there.
Scene bunnyScene() {
  constexpr double kRadius = 4, kTop = 252, kBottom = 89;
  Random random(31);
  const auto onSphere = [&random](double radius) -> Quaternion<double> {
    for (;;) {
      const Quaternion<double> q{random.between(-1, 1), random.between(-1, 1), random.between(-1, 1), 0};
      const double squared = normSquared(q);
      if (squared < 1 && squared > 1e-6) return q * (radius / std::sqrt(squared));
    }
  };
  Scene scene{.map = "rational", .roots = "178 + 153", .powers = "real", .rational = {}};
  Rational& rational = scene.rational;
  for (int i = 0; i < 331; ++i)
    (i < 178 ? rational.top : rational.bottom)
        .roots.push_back({onSphere(random.between(0.8 * kRadius, kRadius)), random.unit()});
  rational.top.powerScale = kTop / summedPowers(rational.top);
  rational.bottom.powerScale = kBottom / summedPowers(rational.bottom);
  const julia::RationalEvaluator<double> unscaled(rational);
  constexpr int kSamples = 500;
  double mean = 0;
  for (int i = 0; i < kSamples; ++i) mean += unscaled.logModulus(onSphere(kRadius)) / kSamples;
  rational.logScale = -mean;
  scene.isShapeModulus = false;
  scene.side = 2 * kRadius;
  return scene;
}

double perMillion(std::size_t count, std::size_t of) {
  return of ? 1e6 * static_cast<double>(count) / static_cast<double>(of) : 0;
}

void printScene(const Scene& scene) {
  std::printf("| %s | %d | %s | %s | %.0f |", scene.map.c_str(), scene.iterations, scene.roots.c_str(),
              scene.powers.c_str(), scene.summed());
}

void printNodes(const Row& row) {
  std::printf(" %zu | %.1f | %zu of %zu | %zu | %.0f | %.0f | %zu |\n", row.nodes,
              perMillion(row.floatFlips, row.nodes), row.doubleRight, row.judged, row.wideNodes,
              perMillion(row.wideFloatFlips, row.wideNodes), perMillion(row.doubleFlips, row.wideNodes), row.notFinite);
}

void printMoves(const Moves& moves) {
  std::printf(" %zu | %.1e | %.1e | %.0f |", moves.count, moves.quantile, moves.largest, moves.farShare);
}

/// [KD20]: Cartesian doubles, without and with its guard.
void printGuard(const Scene& scene, double points) {
  const std::vector<Point> nodes =
      randomNodes(scene, static_cast<std::size_t>(std::max(1.0, kWideShare * points)), 1000, 3);
  // [KD20] does not tell its escape radius; the larger one gives about the share of its Fig. 3.
  for (const double escape : {kEscape, 1e6}) {
    std::atomic<std::size_t> bad{0}, tripped{0}, badWithGuard{0};
    const auto plain = reference::rationalMap<double>(scene.rational, false);
    const auto guarded = reference::rationalMap<double>(scene.rational, true);
    inBlocks(nodes.size(), kWideBlock, [&](std::size_t first, std::size_t last) {
      for (std::size_t i = first; i < last; ++i) {
        const Quaternion<double> q{nodes[i][0], nodes[i][1], nodes[i][2], 0};
        if (!std::isfinite(reference::orbit<double>(plain, q, scene.iterations, escape).logModulus)) ++bad;
        const auto orbit = reference::orbit<double>(guarded, q, scene.iterations, escape);
        if (orbit.guarded)
          ++tripped;
        else if (!std::isfinite(orbit.logModulus))
          ++badWithGuard;
      }
    });
    const auto percent = [&](std::size_t count) { return perMillion(count, nodes.size()) / 1e4; };
    std::printf("| %.0f | %zu | %.2f %% | %.2f %% | %.2f %% |\n", escape, nodes.size(), percent(bad), percent(tripped),
                percent(badWithGuard));
  }
}

std::vector<Scene> scenes() {
  std::vector<Scene> result;
  for (int n = 1; n <= 8; ++n) result.push_back(shapeScene(n, 10, 13, false));
  result.push_back(shapeScene(3, 10, 13, true));
  result.push_back(shapeScene(3, 10, 50, false));
  result.push_back(shapeScene(3, 10, 50, true));
  for (const int roots : {40, 100, 331, 1000}) result.push_back(shapeScene(3, roots, 13, false));
  for (const int n : {3, 5, 6, 8, 10})
    for (const bool fields : {false, true}) result.push_back(waveScene(n, fields));
  for (const int n : {3, 5, 8}) result.push_back(pairScene(n, 60, 1));
  for (const int n : {3, 5}) result.push_back(pairScene(n, 241, 1));
  result.push_back(pairScene(3, 241, 3));
  result.push_back(pairScene(3, 1000, 1));
  result.push_back(bunnyScene());
  return result;
}

constexpr char kSceneColumns[] = "| map | n | roots | powers | summed powers |";
constexpr char kMoveColumns[] = " vertices | 99.99 % | most | over 1/100 per million |";

void printTables(double points) {
  const std::vector<Scene> all = scenes();
  std::vector<Row> rows;
  std::printf(
      "Nodes:\n\n%s nodes | float flips per million, to double | 128 bits side with double | nodes in 128 bits |"
      " float flips per million | double flips per million | NaN or Inf |\n"
      "|---|--:|--:|---|--:|--:|--:|--:|--:|--:|--:|--:|\n",
      kSceneColumns);
  for (const Scene& scene : all) {
    rows.push_back(Comparison(scene, points).row());
    printScene(scene);
    printNodes(rows.back());
    std::fflush(stdout);
  }
  const auto vertices = [&](const char* title, Moves Row::*first, Moves Row::*second) {
    std::printf("\n%s:\n\n%s%s%s\n|---|--:|--:|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n", title, kSceneColumns,
                kMoveColumns, kMoveColumns);
    for (std::size_t i = 0; i < all.size(); ++i) {
      printScene(all[i]);
      printMoves(rows[i].*first);
      printMoves(rows[i].*second);
      std::printf("\n");
    }
  };
  vertices("Vertices, float to double, voxels at N = 1000, then at N = 10 000", &Row::floatMoves, &Row::fineFloatMoves);
  vertices("Vertices, float to 128 bits, then double to 128 bits, voxels at N = 1000", &Row::wideFloatMoves,
           &Row::doubleMoves);
  std::printf(
      "\n| escape radius | points | Cartesian double not finite | guard trips | not finite with the guard |\n"
      "|--:|--:|--:|--:|--:|\n");
  printGuard(bunnyScene(), points);
}

}  // namespace

int main(int argc, char** argv) {
  double points = kDefaultPoints;
  char* end = nullptr;
  if (argc == 3 && std::strcmp(argv[1], "--points") == 0) points = std::strtod(argv[2], &end);
  if (argc != 1 && !(end && *end == '\0' && points >= 1 && points <= 1e9)) {
    std::fprintf(stderr, "usage: juliavdb_precision [--points N]   (N nodes a row in float and double; default 1e6)\n");
    return 2;
  }
  try {
    printTables(points);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "juliavdb_precision: %s\n", error.what());
    return 70;
  }
  return 0;
}
