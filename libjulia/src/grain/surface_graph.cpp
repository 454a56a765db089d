// SPDX-License-Identifier: Apache-2.0
#include "julia/grain/surface_graph.h"

#include "julia/elementary.h"

#include <Eigen/SparseCholesky>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>

namespace julia {
namespace {

using Complex = std::complex<double>;

Point operator+(const Point& a, const Point& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
Point operator-(const Point& a, const Point& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Point operator*(const Point& a, double by) { return {a[0] * by, a[1] * by, a[2] * by}; }
double dot(const Point& a, const Point& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Point cross(const Point& a, const Point& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
double length(const Point& a) { return std::sqrt(dot(a, a)); }

/// A tangent of length 1.
Point anyTangent(const Point& normal) {
  int least = 0;
  for (int axis = 1; axis < 3; ++axis)
    if (std::abs(normal[static_cast<std::size_t>(axis)]) < std::abs(normal[static_cast<std::size_t>(least)]))
      least = axis;
  Point axis{};
  axis[static_cast<std::size_t>(least)] = 1;
  const Point tangent = cross(axis, normal);
  return tangent * (1 / length(tangent));
}

/// @a v, turned by the smallest rotation that takes @a from to @a to, both of length 1.
Point turned(const Point& v, const Point& from, const Point& to) {
  const Point axis = cross(from, to);
  constexpr double kOpposite = 1e-3;
  const double by = 1 / std::max(1 + dot(from, to), kOpposite);
  const Point once = cross(axis, v);
  return v + once + cross(axis, once) * by;
}

Complex unitOr(const Complex& z, const Complex& otherwise) {
  const double size = std::sqrt(std::norm(z));
  constexpr double kLeast = 1e-100;
  return size > kLeast && std::isfinite(size) ? z / size : otherwise;
}

Complex unitAt(double radians) { return {elementary::cos(radians), elementary::sin(radians)}; }

/// The sparse system of sum w |z_j - r z_i|^2 + sum d_i |z_i|^2, factorised.
class HermitianSystem {
 public:
  HermitianSystem(const SurfaceGraph& graph, std::span<const Complex> factors, std::span<const double> diagonal) {
    const auto size = static_cast<int>(graph.size());
    std::vector<double> sums(diagonal.begin(), diagonal.end());
    std::vector<Eigen::Triplet<Complex>> entries;
    entries.reserve(graph.edges().size() + graph.size());
    for (std::size_t e = 0; e < graph.edges().size(); ++e) {
      const auto [from, to] = graph.edges()[e];
      const double w = graph.weight(e);
      sums[from] += w;
      sums[to] += w;
      const Complex entry = -w * factors[e];
      if (to > from)
        entries.emplace_back(static_cast<int>(to), static_cast<int>(from), entry);
      else
        entries.emplace_back(static_cast<int>(from), static_cast<int>(to), std::conj(entry));
    }
    for (int i = 0; i < size; ++i) entries.emplace_back(i, i, Complex(sums[static_cast<std::size_t>(i)]));
    Eigen::SparseMatrix<Complex> matrix(size, size);
    matrix.setFromTriplets(entries.begin(), entries.end());
    mFactors.compute(matrix);
    if (mFactors.info() != Eigen::Success)
      throw std::runtime_error("the system of a field of directions could not be factorised");
  }

  std::vector<Complex> solve(const std::vector<Complex>& right) const {
    using Vector = Eigen::VectorX<Complex>;
    std::vector<Complex> result(right.size());
    Eigen::Map<Vector>(result.data(), static_cast<Eigen::Index>(result.size())) =
        mFactors.solve(Eigen::Map<const Vector>(right.data(), static_cast<Eigen::Index>(right.size())));
    return result;
  }

 private:
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<Complex>> mFactors;
};

/// Sums of products of two unknowns, for least squares in a tangent plane.
struct PlaneFit {
  double xx = 0, xy = 0, yy = 0, xf = 0, yf = 0;

  void add(const Complex& way, double value, double weight) {
    xx += weight * way.real() * way.real();
    xy += weight * way.real() * way.imag();
    yy += weight * way.imag() * way.imag();
    xf += weight * way.real() * value;
    yf += weight * way.imag() * value;
  }
  Complex slope() const {
    const double determinant = xx * yy - xy * xy, trace = xx + yy;
    constexpr double kLeast = 1e-4;  // of the trace squared: the neighbours do not all lie on one line
    if (!(determinant > kLeast * trace * trace)) return {};
    return {(xf * yy - yf * xy) / determinant, (yf * xx - xf * xy) / determinant};
  }
};

bool stops(const std::function<bool()>& cancelled) { return cancelled && cancelled(); }

/// For each point, the edges that touch it, in order.
class EdgesOfPoints {
 public:
  explicit EdgesOfPoints(const SurfaceGraph& graph) : mStarts(graph.size() + 1) {
    for (const SurfaceEdge& edge : graph.edges()) {
      ++mStarts[edge.from + 1];
      ++mStarts[edge.to + 1];
    }
    for (std::size_t i = 0; i < graph.size(); ++i) mStarts[i + 1] += mStarts[i];
    mEdges.resize(mStarts.back());
    std::vector<std::size_t> next(mStarts.begin(), mStarts.end() - 1);
    for (std::size_t e = 0; e < graph.edges().size(); ++e) {
      mEdges[next[graph.edges()[e].from]++] = static_cast<std::uint32_t>(e);
      mEdges[next[graph.edges()[e].to]++] = static_cast<std::uint32_t>(e);
    }
  }
  std::span<const std::uint32_t> of(std::size_t i) const {
    return std::span(mEdges).subspan(mStarts[i], mStarts[i + 1] - mStarts[i]);
  }

 private:
  std::vector<std::size_t> mStarts;
  std::vector<std::uint32_t> mEdges;
};

}  // namespace

SurfaceGraph::SurfaceGraph(std::vector<Point> positions, std::vector<Point> normals, std::vector<double> spacings,
                           std::vector<SurfaceEdge> edges)
    : mPositions(std::move(positions)),
      mNormals(std::move(normals)),
      mSpacings(std::move(spacings)),
      mEdges(std::move(edges)) {
  if (mNormals.size() != mPositions.size() || mSpacings.size() != mPositions.size())
    throw std::invalid_argument("a surface has " + std::to_string(mPositions.size()) + " points, " +
                                std::to_string(mNormals.size()) + " normals and " + std::to_string(mSpacings.size()) +
                                " spacings; it must have one of each for every point");
  mFirst.reserve(size());
  mSecond.reserve(size());
  for (const Point& normal : mNormals) {
    mFirst.push_back(anyTangent(normal));
    mSecond.push_back(cross(normal, mFirst.back()));
  }
  mWeights.reserve(mEdges.size());
  mTransports.reserve(mEdges.size());
  std::vector<double> reach(size());
  for (const auto& [from, to] : mEdges) {
    if (from >= size() || to >= size() || from == to)
      throw std::invalid_argument("an edge of a surface joins the points " + std::to_string(from) + " and " +
                                  std::to_string(to) + " of " + std::to_string(size()) +
                                  "; it must join two different points");
    const double way = length(mPositions[to] - mPositions[from]);
    reach[from] = std::max(reach[from], way);
    reach[to] = std::max(reach[to], way);
  }
  for (const auto& [from, to] : mEdges) {
    constexpr double kBeyond = 1.05;
    const double share = length(mPositions[to] - mPositions[from]) / (kBeyond * std::max(reach[from], reach[to]));
    mWeights.push_back((1 - share * share) * (1 - share * share));
    mTransports.push_back(unitOr(tangent(to, turned(mFirst[from], mNormals[from], mNormals[to])), 1));
  }
}

Complex SurfaceGraph::tangent(std::size_t i, const Point& vector) const {
  return {dot(vector, mFirst[i]), dot(vector, mSecond[i])};
}

Point SurfaceGraph::vector(std::size_t i, const Complex& tangent) const {
  return mFirst[i] * tangent.real() + mSecond[i] * tangent.imag();
}

Complex SurfaceGraph::wayAtFrom(std::size_t edge) const {
  const auto [from, to] = mEdges[edge];
  const Point way = mPositions[to] - mPositions[from];
  return unitOr(tangent(from, way), 0) * length(way);
}

Complex SurfaceGraph::wayAtTo(std::size_t edge) const {
  const auto [from, to] = mEdges[edge];
  const Point way = mPositions[to] - mPositions[from];
  return unitOr(tangent(to, way), 0) * length(way);
}

std::vector<Bending> bendings(const SurfaceGraph& graph, int rounds) {
  // The symmetric matrix S of d normal = S d x: its mean, and its deviator as a complex number, which turns twice as
  // fast as its axes.
  struct Fit {
    // Of the unknowns mean, real and imaginary part of the deviator.
    std::array<double, 6> products{};
    std::array<double, 3> sums{};
  };
  std::vector<Fit> fits(graph.size());
  const auto add = [&](std::size_t at, const Complex& way, const Complex& change, double weight) {
    // (mean + p, q; q, mean - p) (x, y) = (dx, dy)
    const double x = way.real(), y = way.imag();
    const std::array<double, 3> rows[2] = {{x, x, y}, {y, -y, x}};
    const double values[2] = {change.real(), change.imag()};
    Fit& fit = fits[at];
    for (int row = 0; row < 2; ++row) {
      std::size_t k = 0;
      for (std::size_t a = 0; a < 3; ++a) {
        fit.sums[a] += weight * rows[row][a] * values[row];
        for (std::size_t b = a; b < 3; ++b) fit.products[k++] += weight * rows[row][a] * rows[row][b];
      }
    }
  };
  for (std::size_t e = 0; e < graph.edges().size(); ++e) {
    const auto [from, to] = graph.edges()[e];
    const Point change = graph.normal(to) - graph.normal(from);
    add(from, graph.wayAtFrom(e), graph.tangent(from, change), graph.weight(e));
    add(to, graph.wayAtTo(e), graph.tangent(to, change), graph.weight(e));
  }
  std::vector<double> mean(graph.size());
  std::vector<Complex> deviator(graph.size());
  for (std::size_t i = 0; i < graph.size(); ++i) {
    const auto& [m, s] = std::pair(fits[i].products, fits[i].sums);
    const double a = m[0], b = m[1], c = m[2], d = m[3], f = m[4], g = m[5];
    const double determinant = a * (d * g - f * f) - b * (b * g - c * f) + c * (b * f - c * d);
    constexpr double kLeast = 1e-6;
    if (!(determinant > kLeast * a * a * a)) continue;
    mean[i] = (s[0] * (d * g - f * f) - b * (s[1] * g - f * s[2]) + c * (s[1] * f - d * s[2])) / determinant;
    deviator[i] = {(a * (s[1] * g - f * s[2]) - s[0] * (b * g - c * f) + c * (b * s[2] - s[1] * c)) / determinant,
                   (a * (d * s[2] - s[1] * f) - b * (b * s[2] - s[1] * c) + s[0] * (b * f - d * c)) / determinant};
  }
  for (int round = 0; round < rounds; ++round) {
    std::vector<double> meanSums(mean), weights(graph.size(), 1);
    std::vector<Complex> sums(deviator);
    for (std::size_t e = 0; e < graph.edges().size(); ++e) {
      const auto [from, to] = graph.edges()[e];
      const double w = graph.weight(e);
      const Complex twice = graph.transport(e) * graph.transport(e);
      sums[to] += w * twice * deviator[from];
      sums[from] += w * std::conj(twice) * deviator[to];
      meanSums[to] += w * mean[from];
      meanSums[from] += w * mean[to];
      weights[to] += w;
      weights[from] += w;
    }
    for (std::size_t i = 0; i < graph.size(); ++i) {
      deviator[i] = sums[i] / weights[i];
      mean[i] = meanSums[i] / weights[i];
    }
  }
  std::vector<Bending> result(graph.size());
  for (std::size_t i = 0; i < graph.size(); ++i) {
    const double size = std::sqrt(std::norm(deviator[i]));
    // The deviator points along the larger signed curvature. Where the surface is hollow, that is the lesser bend.
    const Complex most = unitOr(deviator[i], 1);
    const double half = elementary::atan2(most.imag(), most.real()) / 2;
    const Complex alongMost = unitAt(half);
    result[i].least = mean[i] >= 0 ? alongMost * Complex(0, 1) : alongMost;
    // | |k1| - |k2| | of k = mean +- size.
    result[i].difference = 2 * std::min(size, std::abs(mean[i]));
  }
  return result;
}

std::vector<Complex> gradients(const SurfaceGraph& graph, std::span<const double> values) {
  std::vector<PlaneFit> fits(graph.size());
  for (std::size_t e = 0; e < graph.edges().size(); ++e) {
    const auto [from, to] = graph.edges()[e];
    const double change = values[to] - values[from];
    fits[from].add(graph.wayAtFrom(e), change, graph.weight(e));
    fits[to].add(graph.wayAtTo(e), change, graph.weight(e));
  }
  std::vector<Complex> result;
  result.reserve(graph.size());
  for (const PlaneFit& fit : fits) result.push_back(fit.slope());
  return result;
}

namespace {

/// Sets of points that are joined one after the other, and for each point a sign relative to the first of its set.
class SignedSets {
 public:
  explicit SignedSets(std::size_t size) : mParents(size), mSigns(size, 1) {
    for (std::size_t i = 0; i < size; ++i) mParents[i] = static_cast<std::uint32_t>(i);
  }
  /// The first point of a point's set, and the point's sign.
  std::pair<std::uint32_t, int> find(std::uint32_t i) {
    int sign = 1;
    std::uint32_t root = i;
    for (; mParents[root] != root; root = mParents[root]) sign *= mSigns[root];
    for (int rest = sign; mParents[i] != root && i != root;) {
      const std::uint32_t next = mParents[i];
      const int own = mSigns[i];
      mParents[i] = root;
      mSigns[i] = rest;
      rest *= own;
      i = next;
    }
    return {root, sign};
  }
  /// Joins the sets of two points that have the same sign, or opposite signs.
  void join(std::uint32_t a, std::uint32_t b, int sign) {
    const auto [first, firstSign] = find(a);
    const auto [second, secondSign] = find(b);
    if (first == second) return;
    mParents[std::max(first, second)] = std::min(first, second);
    mSigns[std::max(first, second)] = firstSign * secondSign * sign;
  }

 private:
  std::vector<std::uint32_t> mParents;
  std::vector<int> mSigns;
};

/// Gives lines a sign each, so that neighbours agree, those first whose lines agree best. What is joined as a whole
/// gets the sign of the wishes that have one, or points down.
void orient(const SurfaceGraph& graph, std::span<const DirectionWish> wishes, std::vector<Complex>& lines) {
  std::vector<std::pair<double, std::uint32_t>> order;
  std::vector<int> signs;
  for (std::size_t e = 0; e < graph.edges().size(); ++e) {
    const auto [from, to] = graph.edges()[e];
    const double agreement = (lines[to] * std::conj(graph.transport(e) * lines[from])).real();
    order.emplace_back(-std::abs(agreement), static_cast<std::uint32_t>(e));
    signs.push_back(agreement < 0 ? -1 : 1);
  }
  std::sort(order.begin(), order.end());
  SignedSets sets(graph.size());
  for (const auto& [agreement, e] : order) sets.join(graph.edges()[e].from, graph.edges()[e].to, signs[e]);
  constexpr Point kDown{0, -1, 0};
  constexpr double kLess = 0.02;  // than a wish of the same weight
  std::vector<double> agreements(graph.size());
  for (std::uint32_t i = 0; i < graph.size(); ++i) {
    const auto [root, sign] = sets.find(i);
    if (sign < 0) lines[i] = -lines[i];
    const auto agreement = [&](const Complex& with) { return (with * std::conj(lines[i])).real(); };
    const double area = graph.spacing(i) * graph.spacing(i);
    const double counts = wishes[i].signs ? 1 : wishes[i].lean;
    agreements[root] += area * wishes[i].weight * counts * agreement(wishes[i].towards);
    agreements[root] += area * kLess * wishes[i].weight * agreement(graph.tangent(i, kDown));
  }
  for (std::uint32_t i = 0; i < graph.size(); ++i)
    if (agreements[sets.find(i).first] < 0) lines[i] = -lines[i];
}

}  // namespace

std::vector<Complex> smoothDirections(const SurfaceGraph& graph, std::span<const DirectionWish> wishes,
                                      const std::function<bool()>& cancelled) {
  // What remains where nothing is wanted; it makes the system positive definite.
  constexpr double kRest = 1e-4;
  constexpr Point kAnyDirection{0.36, 0.8, 0.48};
  std::vector<double> diagonal(graph.size());
  double unsignedWeight = 0;
  for (std::size_t i = 0; i < graph.size(); ++i) {
    diagonal[i] = kRest + wishes[i].weight;
    if (!wishes[i].signs) unsignedWeight += wishes[i].weight;
  }
  std::vector<Complex> factors(graph.edges().size()), field(graph.size()), right(graph.size());
  for (std::size_t i = 0; i < graph.size(); ++i) field[i] = unitOr(graph.tangent(i, kAnyDirection), 0);
  if (unsignedWeight > 0) {
    // First a field of lines, whose squares have no sign.
    for (std::size_t e = 0; e < factors.size(); ++e) factors[e] = graph.transport(e) * graph.transport(e);
    for (std::size_t i = 0; i < graph.size(); ++i)
      right[i] = wishes[i].weight * wishes[i].towards * wishes[i].towards + kRest * field[i] * field[i];
    const std::vector<Complex> squares = HermitianSystem(graph, factors, diagonal).solve(right);
    for (std::size_t i = 0; i < graph.size(); ++i) {
      const Complex square = unitOr(squares[i], 1);
      field[i] = unitAt(elementary::atan2(square.imag(), square.real()) / 2);
    }
    orient(graph, wishes, field);
  }
  if (stops(cancelled)) return field;
  for (std::size_t e = 0; e < factors.size(); ++e) factors[e] = graph.transport(e);
  const HermitianSystem equations(graph, factors, diagonal);
  constexpr int kRounds = 12;
  for (int round = 0; round < kRounds && !stops(cancelled); ++round) {
    for (std::size_t i = 0; i < graph.size(); ++i) {
      const DirectionWish& wish = wishes[i];
      // A wish without a sign takes that of the field.
      const bool turns = !wish.signs && (wish.towards * std::conj(field[i])).real() < 0;
      right[i] = wish.weight * (turns ? -wish.towards : wish.towards) + kRest * unitOr(field[i], 0);
    }
    field = equations.solve(right);
  }
  for (Complex& z : field) z = unitOr(z, 1);
  return field;
}

std::vector<SurfacePhase> stripePhases(const SurfaceGraph& graph, std::span<const Complex> waves,
                                       const std::function<bool()>& cancelled) {
  std::vector<Complex> factors;
  std::vector<double> turns;
  factors.reserve(graph.edges().size());
  turns.reserve(graph.edges().size());
  const auto along = [](const Complex& a, const Complex& b) { return a.real() * b.real() + a.imag() * b.imag(); };
  for (std::size_t e = 0; e < graph.edges().size(); ++e) {
    const auto [from, to] = graph.edges()[e];
    turns.push_back((along(waves[from], graph.wayAtFrom(e)) + along(waves[to], graph.wayAtTo(e))) / 2);
    factors.push_back(unitAt(turns.back()));
  }
  const EdgesOfPoints edgesOf(graph);

  // Begins with phases that are right along a tree of edges, breadth first.
  std::vector<Complex> field(graph.size());
  std::vector<bool> reached(graph.size());
  std::vector<std::uint32_t> queue;
  for (std::uint32_t seed = 0; seed < graph.size(); ++seed) {
    if (reached[seed]) continue;
    reached[seed] = true;
    field[seed] = 1;
    queue.assign(1, seed);
    for (std::size_t next = 0; next < queue.size(); ++next) {
      const std::uint32_t i = queue[next];
      for (const std::uint32_t e : edgesOf.of(i)) {
        const auto [from, to] = graph.edges()[e];
        const std::uint32_t other = from == i ? to : from;
        if (reached[other]) continue;
        reached[other] = true;
        field[other] = unitOr(field[i] * (from == i ? factors[e] : std::conj(factors[e])), 1);
        queue.push_back(other);
      }
    }
  }
  // Power iteration, in which each point soon has the same weight: the field of phases alone that changes least.
  constexpr double kRest = 1e-3;
  const HermitianSystem equations(graph, factors, std::vector<double>(graph.size(), kRest));
  constexpr int kFirst = 10, kRounds = 10;
  for (int round = 0; round < kFirst + kRounds && !stops(cancelled); ++round) {
    field = equations.solve(field);
    for (Complex& z : field) z = round < kFirst ? z * kRest : unitOr(z, 1);
  }
  std::vector<PlaneFit> fits(graph.size());
  for (std::size_t e = 0; e < graph.edges().size(); ++e) {
    const auto [from, to] = graph.edges()[e];
    const Complex rest = field[to] * std::conj(field[from] * factors[e]);
    const double turn = elementary::atan2(rest.imag(), rest.real());
    fits[from].add(graph.wayAtFrom(e), turn, graph.weight(e));
    fits[to].add(graph.wayAtTo(e), turn, graph.weight(e));
  }
  std::vector<SurfacePhase> result(graph.size());
  for (std::size_t i = 0; i < graph.size(); ++i) {
    Complex correction = fits[i].slope();
    const double most = std::norm(waves[i]) / 4;
    if (std::norm(correction) > most) correction *= std::sqrt(most / std::norm(correction));
    result[i] = {field[i], graph.vector(i, waves[i] + correction)};
  }
  return result;
}

}  // namespace julia
