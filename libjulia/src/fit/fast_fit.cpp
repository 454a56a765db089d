// SPDX-License-Identifier: Apache-2.0
#include "julia/fit/fast_fit.h"

#include "fit/bounded_quadratic.h"
#include "fit/log_matrix.h"
#include "kernels/kernels.h"
#include "number_text.h"
#include "random_numbers.h"

#include "julia/fit/cancelled.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <tuple>

namespace julia {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

// Cells that a root needs: enough of them that its power is not fitted to their places, and few enough for speed.
constexpr std::size_t kCellsPerRoot = 160, kLeastCells = 20'000, kMostCells = 160'000;
constexpr std::size_t kHeldOut = 10;  // one cell in so many
// On the sum of the squared powers. It settles what the cells leave open; the shape does not depend on it.
constexpr double kRidge = 1e-6;
// Far away the map is |q|^degree, the summed powers of the top less those of the bottom. Where that is not above 1,
// what lies outside comes back, and below 0 infinity is a root; nothing that the cells say forbids it. So a degree
// below 2, that of q^2, costs as a spring does.
constexpr double kLeastDegree = 2, kDegreeStiffness = 1;
// The power of the root at the origin, likewise: 0 attracts from 1 on, and faster than in proportion above it.
constexpr double kLeastAtOrigin = 2;
// Roots that a round adds: a share of those that there may be, and of those that there are.
constexpr double kShareOfMost = 0.15, kShareOfPresent = 0.35;
constexpr std::size_t kMostRounds = 60;
constexpr int kPatience = 3;  // rounds without a better fit of the held-out cells
constexpr double kLeastRise = 2e-4;
// Logarithms that one round may take to compare candidates; beyond it each round looks at others of them.
constexpr double kMostScores = 2e9;
// Multiply-adds that one Gram matrix may take; beyond it a part of the cells stands for all.
constexpr double kMostWork = 4e10;
constexpr std::size_t kLeastCellsPerColumn = 6;
// How far Newton's method goes: steps at most, and the relative fall of the loss that counts as none.
struct Effort {
  int steps;
  double settled;
};
constexpr Effort kRound{5, 1e-3}, kLast{12, 1e-4}, kSharpen{6, 1e-4};
constexpr double kEnergySharpness[] = {1, 2, 4, 8};

enum class Loss { Logistic, Energy };

/// A loss of z = -side L, positive where a cell is on the wrong side, with its slope, and a curvature that is positive
/// where the loss is concave too.
struct LossAt {
  double value, slope, curvature;
};

LossAt lossAt(Loss kind, double z) {
  constexpr double kLeastCurvature = 1e-4;
  if (kind == Loss::Logistic) {
    const double e = std::exp(-std::abs(z));
    const double p = (z > 0 ? 1 : e) / (1 + e);
    return {std::max(z, 0.0) + std::log1p(e), p, std::max(p * (1 - p), kLeastCurvature)};
  }
  const double t = std::tanh(z), s = 1 - t * t;
  return {t, s, std::max(s * std::max(-2 * t, 0.3), kLeastCurvature)};
}

struct FitRoot {
  Point x;
  bool bottom;
  double least;  // power
};

class Fitter {
 public:
  Fitter(std::span<const FitCell> cells, std::span<const RootCandidate> candidates, const FastFitOptions& options);
  FastFit run();

 private:
  double sign(std::size_t root) const { return mRoots[root].bottom ? -1 : 1; }
  std::vector<double> weights(const VectorXd& x) const;
  double constant(const VectorXd& x) const { return x[x.size() - 1]; }
  double degree(const VectorXd& x) const;
  double penalty(const VectorXd& x) const;
  double loss(Loss kind, double sharpness, const std::vector<double>& l) const;
  void add(const std::vector<FitRoot>& roots);
  void dropUnused();
  std::size_t addBest(std::size_t count);
  void newton(Loss kind, double sharpness, const Effort& effort);
  double heldOutIou() const;
  Rational rational() const;
  void report(std::string_view stage, double energy, bool roundEnds);

  const FastFitOptions& mOptions;
  std::span<const RootCandidate> mCandidates;
  std::vector<char> mUsed;
  std::vector<FitCell> mCells, mHeld;  // fitted, and held out
  std::vector<double> mWeight, mSide;  // |W| summing to 1; -1 inside, 1 outside
  LogMatrix mLogs, mHeldLogs;
  std::vector<FitRoot> mRoots;
  VectorXd mX;             // powers, and last the constant
  std::vector<double> mL;  // of the fitted cells, at mX
  std::string_view mStage;
  double mBestEnergy = 0;
  int mSteps = 0;
  std::size_t mRound = 0;
};

/// Shuffled cells: every one in kHeldOut is held out, and of the rest there are at most @a most.
std::pair<std::vector<FitCell>, std::vector<FitCell>> split(std::span<const FitCell> cells, std::uint64_t seed,
                                                            std::size_t most) {
  Random random(seed);
  std::vector<FitCell> shuffled(cells.begin(), cells.end());
  for (std::size_t i = shuffled.size(); i > 1; --i)
    std::swap(shuffled[i - 1],
              shuffled[std::min(i - 1, static_cast<std::size_t>(random.unit() * static_cast<double>(i)))]);
  const auto held = static_cast<std::ptrdiff_t>(shuffled.size() / kHeldOut);
  const auto end = std::min(static_cast<std::ptrdiff_t>(shuffled.size()), held + static_cast<std::ptrdiff_t>(most));
  return {{shuffled.begin() + held, shuffled.begin() + end}, {shuffled.begin(), shuffled.begin() + held}};
}

Fitter::Fitter(std::span<const FitCell> cells, std::span<const RootCandidate> candidates, const FastFitOptions& options)
    : mOptions(options), mCandidates(candidates), mUsed(candidates.size()), mLogs({}, 0), mHeldLogs({}, 0) {
  std::tie(mCells, mHeld) =
      split(cells, options.seed, std::clamp(kCellsPerRoot * options.maxRoots, kLeastCells, kMostCells));
  mLogs = LogMatrix(pointsOf(mCells), options.memoryLimit);
  mHeldLogs = LogMatrix(pointsOf(mHeld), options.memoryLimit / kHeldOut);
  double eta = 0;
  for (const double weight : cellWeights(mCells, options.weights, options.cellSize)) {
    mWeight.push_back(std::abs(weight));
    mSide.push_back(weight < 0 ? -1 : 1);
    eta += std::abs(weight);
  }
  for (double& weight : mWeight) weight /= eta;
  mX = VectorXd::Zero(1);
  mL.assign(mCells.size(), 0);
}

std::vector<double> Fitter::weights(const VectorXd& x) const {
  std::vector<double> weights(mRoots.size());
  for (std::size_t j = 0; j < weights.size(); ++j) weights[j] = sign(j) * x[static_cast<Index>(j)];
  return weights;
}

double Fitter::degree(const VectorXd& x) const {
  double sum = 0;
  for (std::size_t j = 0; j < mRoots.size(); ++j) sum += sign(j) * x[static_cast<Index>(j)];
  return sum;
}

double Fitter::penalty(const VectorXd& x) const {
  const auto powers = x.head(x.size() - 1);
  const double missing = std::max(0.0, kLeastDegree - degree(x));
  return kRidge / 2 * powers.squaredNorm() + mOptions.powerPenalty * powers.sum() +
         kDegreeStiffness / 2 * missing * missing;
}

double Fitter::loss(Loss kind, double sharpness, const std::vector<double>& l) const {
  double sum = 0;
  for (std::size_t i = 0; i < l.size(); ++i) sum += mWeight[i] * lossAt(kind, -sharpness * mSide[i] * l[i]).value;
  return sum;
}

void Fitter::add(const std::vector<FitRoot>& roots) {
  std::vector<Quaternion<double>> positions;
  for (const FitRoot& root : roots) {
    positions.push_back(Embedding{}.quaternion<double>(root.x));
    mRoots.push_back(root);
  }
  mLogs.append(positions);
  mHeldLogs.append(positions);
  VectorXd x = VectorXd::Zero(static_cast<Index>(mRoots.size()) + 1);
  x.head(mX.size() - 1) = mX.head(mX.size() - 1);
  x[x.size() - 1] = constant(mX);
  for (std::size_t j = mRoots.size() - roots.size(); j < mRoots.size(); ++j) x[static_cast<Index>(j)] = mRoots[j].least;
  mX = std::move(x);
}

void Fitter::dropUnused() {
  std::vector<std::size_t> kept;
  for (std::size_t j = 0; j < mRoots.size(); ++j)
    if (mX[static_cast<Index>(j)] > 0) kept.push_back(j);
  VectorXd x(static_cast<Index>(kept.size()) + 1);
  for (std::size_t k = 0; k < kept.size(); ++k) {
    x[static_cast<Index>(k)] = mX[static_cast<Index>(kept[k])];
    mRoots[k] = mRoots[kept[k]];
  }
  x[x.size() - 1] = constant(mX);
  mRoots.resize(kept.size());
  mX = std::move(x);
  mLogs.keep(kept);
  mHeldLogs.keep(kept);
}

/// Adds the candidates by which the loss would fall most: the square of its slope by the power over the curvature, once
/// the constant has adapted. Those of one round keep apart.
std::size_t Fitter::addBest(std::size_t count) {
  std::vector<float> x, y, z;
  std::vector<double> slope, curvature;
  double total = 0;
  for (std::size_t i = 0; i < mCells.size(); ++i) {
    const LossAt at = lossAt(Loss::Logistic, -mSide[i] * mL[i]);
    x.push_back(static_cast<float>(mCells[i].x[0]));
    y.push_back(static_cast<float>(mCells[i].x[1]));
    z.push_back(static_cast<float>(mCells[i].x[2]));
    slope.push_back(-mSide[i] * mWeight[i] * at.slope);
    curvature.push_back(mWeight[i] * at.curvature);
    total += curvature.back();
  }
  // A top root helps the spring of the degree, a bottom root strains it.
  const double pull = kDegreeStiffness * std::max(0.0, kLeastDegree - degree(mX));
  // Whole vectors: the kernels leave no rest.
  const std::size_t size = (x.size() + LogMatrix::kBlock - 1) / LogMatrix::kBlock * LogMatrix::kBlock;
  for (std::vector<float>* coordinate : {&x, &y, &z}) coordinate->resize(size);
  slope.resize(size);
  curvature.resize(size);
  struct Score {
    double gain = 0;
    std::size_t candidate = 0;
    bool bottom = false;
  };
  std::vector<Score> scores(mCandidates.size());
  const double scoresToMake = static_cast<double>(mCandidates.size()) * static_cast<double>(size);
  const auto inTurn = static_cast<std::size_t>(1 + std::floor(scoresToMake / kMostScores));
  const kernels::Kernels<float>& kernel = kernels::kernels<float>();
  // A candidate shall not be chosen for the one cell that it happens to lie in.
  const float blur = static_cast<float>(4 * mOptions.cellSize * mOptions.cellSize);
  tbb::parallel_for(std::size_t{0}, mCandidates.size(), [&](std::size_t k) {
    scores[k].candidate = k;
    if (mUsed[k] || (k + mRound) % inTurn != 0) return;
    const Point& at = mCandidates[k].x;
    const float root[3] = {static_cast<float>(at[0]), static_cast<float>(at[1]), static_cast<float>(at[2])};
    std::vector<float> logs(size);
    kernel.logDistances(root, blur, x.data(), y.data(), z.data(), logs.data(), size);
    double bySlope = 0, mean = 0, square = 0;
    kernel.dotColumns(logs.data(), slope.data(), 1, &bySlope, size);
    bySlope -= pull;
    kernel.dotColumns(logs.data(), curvature.data(), 1, &mean, size);
    mean /= total;
    for (std::size_t i = 0; i < size; ++i) square += curvature[i] * ((logs[i] - mean) * (logs[i] - mean));
    using Side = RootCandidate::Side;
    const Side side = mCandidates[k].side;
    scores[k].bottom = side == Side::Either ? bySlope > 0 : side == Side::Bottom;
    if ((scores[k].bottom ? -bySlope : bySlope) < 0) scores[k].gain = bySlope * bySlope / (square + 1e-300);
  });
  std::stable_sort(scores.begin(), scores.end(), [](const Score& a, const Score& b) { return a.gain > b.gain; });
  constexpr double kSpacing = 0.6;  // of a root in a unit square
  const double apart = kSpacing / std::sqrt(static_cast<double>(mRoots.size() + count));
  std::vector<FitRoot> chosen;
  for (const Score& score : scores) {
    if (chosen.size() == count || !(score.gain > 0)) break;
    const Point& at = mCandidates[score.candidate].x;
    const bool near = std::any_of(chosen.begin(), chosen.end(), [&](const FitRoot& other) {
      double square = 0;
      for (std::size_t axis = 0; axis < 3; ++axis) square += (other.x[axis] - at[axis]) * (other.x[axis] - at[axis]);
      return square < apart * apart;
    });
    if (near) continue;
    mUsed[score.candidate] = 1;
    chosen.push_back({at, score.bottom, 0});
  }
  add(chosen);
  return chosen.size();
}

void Fitter::newton(Loss kind, double sharpness, const Effort& effort) {
  const Index n = mX.size();
  const auto roots = static_cast<std::size_t>(n - 1);
  VectorXd signs = VectorXd::Ones(n), least = VectorXd::Zero(n);
  std::vector<char> bounded(static_cast<std::size_t>(n), 1);
  bounded.back() = 0;
  for (std::size_t j = 0; j < roots; ++j) {
    signs[static_cast<Index>(j)] = sign(j);
    least[static_cast<Index>(j)] = mRoots[j].least;
  }
  const double columns = static_cast<double>(n), cells = static_cast<double>(mCells.size());
  const double affordable = std::max(2 * kMostWork / (columns * columns), kLeastCellsPerColumn * columns);
  const auto stride = static_cast<std::size_t>(std::max(1.0, std::floor(cells / affordable)));

  mLogs.logModuli(weights(mX), constant(mX), mL);
  double current = loss(kind, sharpness, mL) + penalty(mX), damping = 1e-9;
  mBestEnergy = current;
  std::vector<double> curvature(mCells.size()), difference(mCells.size()), moved(mCells.size());
  int small = 0;
  for (int step = 0; step < effort.steps && small < 2; ++step) {
    if (mOptions.cancelled && mOptions.cancelled()) throw Cancelled();
    const LogMatrix::Pass pass = mLogs.pass(
        weights(mX), constant(mX),
        [&](std::size_t begin, std::span<const double> l, std::span<double> factors) {
          for (std::size_t i = 0; i < l.size(); ++i) {
            const std::size_t k = begin + i;
            const LossAt at = lossAt(kind, -sharpness * mSide[k] * l[i]);
            factors[i] = -sharpness * mSide[k] * mWeight[k] * at.slope;
            curvature[k] = sharpness * sharpness * mWeight[k] * at.curvature;
          }
          return 0.0;
        },
        true);
    VectorXd gradient = Eigen::Map<const VectorXd>(pass.products.data(), n).cwiseProduct(signs);
    gradient.head(n - 1) += kRidge * mX.head(n - 1) + VectorXd::Constant(n - 1, mOptions.powerPenalty);
    Eigen::MatrixXd H = signs.asDiagonal() * mLogs.gram(curvature, stride) * signs.asDiagonal();
    H.diagonal().head(n - 1).array() += kRidge;
    const double scale = H.trace() / static_cast<double>(n);
    // The spring of the degree: it is M/2 (degree - least - s)^2 at its best s >= 0, one more variable.
    VectorXd spring(n + 1);
    spring << signs.head(n - 1), 0, -1;
    const double excess = degree(mX) - kLeastDegree, slack = std::max(0.0, excess);
    bounded.resize(static_cast<std::size_t>(n) + 1, 1);

    // The quadratic model's minimum within the bounds, and then along the line to it: every point there is feasible.
    bool lower = false;
    for (int attempt = 0; attempt < 4 && !lower; ++attempt) {
      Eigen::MatrixXd damped = kDegreeStiffness * spring * spring.transpose();
      damped.topLeftCorner(n, n) += H;
      damped.diagonal().head(n).array() += damping * scale;
      VectorXd origin(n + 1), slope = (kDegreeStiffness * (excess - slack)) * spring;
      origin << mX - least, slack;
      slope.head(n) += gradient;
      std::vector<char> passive(bounded.size());
      for (Index i = 0; i <= n; ++i) passive[static_cast<std::size_t>(i)] = origin[i] > 0;
      const auto minimum = minimiseBounded(damped, damped * origin - slope, bounded, passive);
      if (!minimum) {  // rounding in H
        damping *= 100;
        continue;
      }
      const VectorXd target = minimum->head(n) + least;
      const VectorXd direction = target - mX;
      mLogs.logModuli(weights(direction), constant(direction), difference);
      double length = 1;
      for (int cut = 0; cut < 8; ++cut, length *= 0.4) {
        for (std::size_t i = 0; i < mL.size(); ++i) moved[i] = mL[i] + length * difference[i];
        const VectorXd x = length == 1 ? target : VectorXd(mX + length * direction);
        const double value = loss(kind, sharpness, moved) + penalty(x);
        if (!(value < current)) continue;
        small = current - value < effort.settled * std::abs(value) ? small + 1 : 0;
        current = value;
        mX = x;
        std::swap(mL, moved);
        lower = true;
        break;
      }
      damping = !lower ? damping * 100 : length == 1 ? std::max(damping / 5, 1e-9) : damping * 2;
    }
    if (!lower) break;
    ++mSteps;
    report(mStage, current, false);
  }
}

double Fitter::heldOutIou() const {
  std::vector<double> l(mHeld.size());
  mHeldLogs.logModuli(weights(mX), constant(mX), l);
  double both = 0, either = 0;
  for (std::size_t i = 0; i < l.size(); ++i) {
    const bool target = mHeld[i].phi < 0, fractal = l[i] < 0;
    both += target && fractal ? mHeld[i].volume : 0;
    either += target || fractal ? mHeld[i].volume : 0;
  }
  return either > 0 ? both / either : 0;
}

Rational Fitter::rational() const {
  Rational result;
  result.logScale = constant(mX);
  for (std::size_t j = 0; j < mRoots.size(); ++j)
    (mRoots[j].bottom ? result.bottom : result.top)
        .roots.push_back({Embedding{}.quaternion<double>(mRoots[j].x), mX[static_cast<Index>(j)]});
  return result;
}

void Fitter::report(std::string_view stage, double energy, bool roundEnds) {
  mBestEnergy = energy;
  if (!mOptions.onStep) return;
  double psi = 0;
  for (std::size_t i = 0; i < mL.size(); ++i) psi -= mWeight[i] * mSide[i] * std::tanh(mL[i]);
  const Rational now = rational();
  mOptions.onStep({stage, mSteps, mRoots.size(), energy, psi, heldOutIou(), &now, roundEnds});
}

FastFit Fitter::run() {
  mStage = "roots";
  std::vector<FitRoot> first{{Point{0, 0, 0}, false, kLeastAtOrigin}};
  for (const Point& x : mOptions.start) {
    // The side is left to the cell nearest to it.
    const auto nearest = std::min_element(mCells.begin(), mCells.end(), [&](const FitCell& a, const FitCell& b) {
      const auto square = [&](const FitCell& cell) {
        return (cell.x[0] - x[0]) * (cell.x[0] - x[0]) + (cell.x[1] - x[1]) * (cell.x[1] - x[1]) +
               (cell.x[2] - x[2]) * (cell.x[2] - x[2]);
      };
      return square(a) < square(b);
    });
    if (first.size() < mOptions.maxRoots) first.push_back({x, nearest->phi > 0, 0});
  }
  add(first);
  newton(Loss::Logistic, 1, kRound);
  double best = 0;
  int worse = 0;
  for (; mRound < kMostRounds && worse < kPatience; ++mRound) {
    dropUnused();
    const double iou = heldOutIou();
    report(mStage, mBestEnergy, true);
    worse = iou > best + kLeastRise ? 0 : worse + 1;
    best = std::max(best, iou);
    if (best >= mOptions.targetIou || mRoots.size() >= mOptions.maxRoots) break;
    const std::size_t wanted =
        1 + static_cast<std::size_t>(std::max(kShareOfMost * static_cast<double>(mOptions.maxRoots),
                                              kShareOfPresent * static_cast<double>(mRoots.size())));
    if (addBest(std::min(wanted, mOptions.maxRoots - mRoots.size())) == 0) break;
    newton(Loss::Logistic, 1, kRound);
  }
  newton(Loss::Logistic, 1, kLast);
  mStage = "energy";
  for (const double sharpness : kEnergySharpness) {
    newton(Loss::Energy, sharpness, kSharpen);
    dropUnused();
    report(mStage, mBestEnergy, true);
  }
  FastFit fit{rational(), heldOutIou(), 0, mSteps};
  for (std::size_t i = 0; i < mL.size(); ++i) fit.psi -= mWeight[i] * mSide[i] * std::tanh(mL[i]);
  return fit;
}

}  // namespace

FastFit fastFit(std::span<const FitCell> cells, std::span<const RootCandidate> candidates,
                const FastFitOptions& options) {
  if (options.maxRoots < 1) throw std::invalid_argument("a fit needs at least one root; it may have 0");
  if (!(options.targetIou > 0 && options.targetIou <= 1))
    throw std::invalid_argument("the fit's target is an IoU of " + textOf(options.targetIou) +
                                "; it must be above 0 and at most 1");
  if (!(options.cellSize > 0) || !std::isfinite(options.cellSize))
    throw std::invalid_argument("the fit's cells are " + textOf(options.cellSize) + " wide; they must be wider than 0");
  if (!(options.powerPenalty >= 0) || !std::isfinite(options.powerPenalty))
    throw std::invalid_argument("the penalty on powers is " + textOf(options.powerPenalty) + "; it must be 0 or more");
  const auto requireFinitePlace = [](const Point& x, const char* what) {
    for (const double coordinate : x)
      if (!std::isfinite(coordinate))
        throw std::invalid_argument("a coordinate of one of the fit's " + std::string(what) + " is " +
                                    textOf(coordinate));
  };
  for (const FitCell& cell : cells) {
    requireFinitePlace(cell.x, "cells");
    if (!std::isfinite(cell.phi) || !(cell.volume > 0) || !std::isfinite(cell.volume))
      throw std::invalid_argument("one of the fit's cells has a distance of " + textOf(cell.phi) + " and a volume of " +
                                  textOf(cell.volume));
  }
  for (const RootCandidate& candidate : candidates) requireFinitePlace(candidate.x, "candidates");
  for (const Point& x : options.start) requireFinitePlace(x, "first roots");
  const auto inside = std::count_if(cells.begin(), cells.end(), [](const FitCell& cell) { return cell.phi < 0; });
  if (inside == 0 || inside == static_cast<std::ptrdiff_t>(cells.size()))
    throw std::invalid_argument("of the fit's " + std::to_string(cells.size()) + " cells " + std::to_string(inside) +
                                " are inside the target; some must be, and some not");
  return Fitter(cells, candidates, options).run();
}

}  // namespace julia
