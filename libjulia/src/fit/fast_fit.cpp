// SPDX-License-Identifier: Apache-2.0
#include "julia/fit/fast_fit.h"

#include "fit/bounded_quadratic.h"
#include "fit/candidate_scores.h"
#include "fit/cell_sample.h"
#include "fit/log_matrix.h"
#include "number_text.h"
#include "random_numbers.h"

#include "julia/elementary.h"
#include "julia/fit/cancelled.h"
#include "julia/fit/minimise.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <string>
#include <tuple>

namespace julia {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

// Cells for each root: enough to avoid overfitting its power to their places, and few enough for speed.
constexpr std::size_t kCellsPerRoot = 160, kLeastCells = 20'000, kMostCells = 160'000;
constexpr std::size_t kHeldOut = 10;  // one in this many cells
// The weight of the summed squares of the powers. It determines what the cells leave undetermined, but does not change
// the shape.
constexpr double kRidge = 1e-6;
// Far away the map is |q|^degree, where the degree is the sum of the top's powers minus the sum of the bottom's. Unless
// it is above 1, points far outside return, and below 0 infinity is a root; the cells do not rule that out. Therefore a
// penalty acts on degrees below 2, the degree of q^2.
constexpr double kLeastDegree = 2, kDegreeStiffness = 1;
// The minimum power of the root at the origin, for the same reason: 0 attracts from 1 on, and faster than linearly
// above 1.
constexpr double kLeastAtOrigin = 2;
// Roots that a round adds: this fraction of the maximum number, or of those present.
constexpr double kShareOfMost = 0.15, kShareOfPresent = 0.35;
constexpr std::size_t kMostRounds = 60;
constexpr int kPatience = 3;  // rounds without an improvement on the held-out cells
constexpr double kLeastRise = 2e-4;
// Logarithms that one round may compute to score candidates for the first time; the others wait for later rounds.
constexpr double kMostScores = 2e9;
// Cells sampled when candidates are scored for the first time. Of the best candidates, this many for each wanted root
// are scored again with all cells.
constexpr std::size_t kScoredCells = 16384, kScoredAgain = 8;
// Cells sampled for a Gram matrix: this multiple of the significant ones, with a minimum and a maximum for each column.
// With too few, a step does not lead to the minimum, and rounds end with useless roots.
constexpr double kGramShare = 3, kLeastGramCellsPerColumn = 6, kMostGramCellsPerColumn = 32;
constexpr std::size_t kLeastGramCells = 4096;
// A Gram matrix is reused until the cells' curvatures have changed by this fraction of their sum.
constexpr double kStale = 0.1;
// When Newton's method stops: the maximum number of steps, and the relative decrease of the objective that counts as
// none.
struct Effort {
  int steps;
  double settled;
};
constexpr Effort kRound{5, 1e-3}, kLast{12, 1e-4}, kSharpen{6, 1e-4};
// How far each coordinate of a root may move at once, in cells, and the optimiser's steps.
constexpr double kPlaceReach = 4;
constexpr int kPlaceSteps = 30;

enum class Loss { Logistic, Energy };

/// The objective of a pass of Newton's method, without the penalty on powers.
struct Objective {
  Loss loss;
  double sharpness;  ///< factor of L
};
constexpr Objective kLogistic{Loss::Logistic, 1};
constexpr double kEnergySharpness[] = {1, 2, 4, 8};

/// A loss of z = -side L, which is positive if a cell is on the wrong side; its slope; and a curvature, made positive
/// where the loss is concave.
struct LossAt {
  double value, slope, curvature;
};

LossAt lossAt(Loss kind, double z) {
  constexpr double kLeastCurvature = 1e-4;
  if (kind == Loss::Logistic) {
    const double e = elementary::exp(-std::abs(z));
    const double p = (z > 0 ? 1 : e) / (1 + e);
    return {std::max(z, 0.0) + elementary::log1p(e), p, std::max(p * (1 - p), kLeastCurvature)};
  }
  const double t = elementary::tanh(z), s = 1 - t * t;
  return {t, s, std::max(s * std::max(-2 * t, 0.3), kLeastCurvature)};
}

struct FitRoot {
  Point x;
  bool bottom;
  double least;  // of the power
};

std::vector<Quaternion<double>> positionsOf(std::span<const FitRoot> roots) {
  std::vector<Quaternion<double>> positions;
  for (const FitRoot& root : roots) positions.push_back(Embedding{}.quaternion<double>(root.x));
  return positions;
}

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
  double loss(const Objective& objective, const std::vector<double>& l) const;
  std::vector<FitRoot> firstRoots() const;
  void add(const std::vector<FitRoot>& roots);
  void dropUnused();

  CellSlopes cellSlopes(std::size_t most) const;
  std::vector<CandidateScore> rankedCandidates(std::size_t count) const;
  std::size_t addBest(std::size_t count);

  VectorXd signs() const;
  std::vector<double> slopes(const Objective& objective, VectorXd& gradient) const;
  bool isStale(const std::vector<double>& curvature) const;
  void remakeGram(const std::vector<double>& curvature);
  BoundedQuadratic& program(double damping);
  std::optional<VectorXd> minimumOf(const VectorXd& gradient, double damping);
  std::optional<double> stepTowards(const VectorXd& target, const Objective& objective);
  void newton(const Objective& objective, const Effort& effort);

  bool isOnItsSide(const FitRoot& root) const;
  void place(const std::vector<FitRoot>& roots);
  bool moveRoots(const Objective& objective);

  double heldOutIou() const;
  double psi() const;
  Rational rational() const;
  void report(bool roundEnds);

  const FastFitOptions& mOptions;
  std::span<const RootCandidate> mCandidates;
  std::vector<char> mUsed;
  std::vector<FitCell> mCells, mHeld;  // fitted cells, and held-out cells
  std::vector<double> mWeight, mSide;  // |W|, with the sum 1; -1 inside, 1 outside
  LogMatrix mLogs, mHeldLogs;
  std::vector<FitRoot> mRoots;
  VectorXd mX;             // powers, followed by the constant
  std::vector<double> mL;  // of the fitted cells, at mX
  /// The Gram matrix of the objective's second derivatives with respect to the powers of the roots and the constant,
  /// computed at an earlier iterate: the curvatures there, and the sampled cells.
  Eigen::MatrixXd mGram;
  std::vector<double> mGramCurvature;
  CellSample mGramCells;
  /// The quadratic program made from it, and its damping.
  std::optional<BoundedQuadratic> mProgram;
  double mDamping = 0;
  std::string_view mStage;
  double mEnergy = 0;  ///< the objective plus the penalty, at mX
  int mSteps = 0;
  std::size_t mRound = 0;
};

/// Shuffles the cells and splits them into those to fit, at most @a most, and those held out, one in kHeldOut.
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

double Fitter::loss(const Objective& objective, const std::vector<double>& l) const {
  double sum = 0;
  for (std::size_t i = 0; i < l.size(); ++i)
    sum += mWeight[i] * lossAt(objective.loss, -objective.sharpness * mSide[i] * l[i]).value;
  return sum;
}

void Fitter::add(const std::vector<FitRoot>& roots) {
  const std::vector<Quaternion<double>> positions = positionsOf(roots);
  mRoots.insert(mRoots.end(), roots.begin(), roots.end());
  mProgram.reset();
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
  if (kept.size() == mRoots.size()) return;
  if (mGram.size() > 0) {
    std::vector<std::size_t> columns = kept;
    columns.push_back(mRoots.size());
    mGram = Eigen::MatrixXd(mGram(columns, columns));
  }
  mProgram.reset();
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

/// The slope and the curvature of the logistic loss, for a sample of at most @a most cells.
CellSlopes Fitter::cellSlopes(std::size_t most) const {
  std::vector<double> slope(mCells.size()), curvature(mCells.size());
  for (std::size_t i = 0; i < mCells.size(); ++i) {
    const LossAt at = lossAt(Loss::Logistic, -mSide[i] * mL[i]);
    slope[i] = -mSide[i] * mWeight[i] * at.slope;
    curvature[i] = mWeight[i] * at.curvature;
  }
  return sampledSlopes(mCells, slope, curvature, most);
}

/// All candidates, the best first. Candidates that are used, or whose turn has not come, have no gain.
/// @param count  the number wanted; the best are scored more accurately
std::vector<CandidateScore> Fitter::rankedCandidates(std::size_t count) const {
  const double pull = kDegreeStiffness * std::max(0.0, kLeastDegree - degree(mX));
  // The blur keeps a candidate from being chosen only because of the one cell that contains it.
  const double blur = 4 * mOptions.cellSize * mOptions.cellSize;
  const CellSlopes some = cellSlopes(kScoredCells);
  const double scoresToMake = static_cast<double>(mCandidates.size()) * static_cast<double>(some.x.size());
  const auto inTurn = static_cast<std::size_t>(1 + std::floor(scoresToMake / kMostScores));
  std::vector<CandidateScore> scores(mCandidates.size());
  for (std::size_t k = 0; k < scores.size(); ++k)
    scores[k] = {!mUsed[k] && (k + mRound) % inTurn == 0 ? 1.0 : 0.0, k, false};
  rankCandidates(scores, mCandidates, some, blur, pull);
  const std::span best = std::span(scores).first(std::min(scores.size(), kScoredAgain * count));
  rankCandidates(best, mCandidates, cellSlopes(mCells.size()), blur, pull);
  return scores;
}

/// Adds the candidates that would lower the loss most. Candidates that are added together keep a distance.
std::size_t Fitter::addBest(std::size_t count) {
  constexpr double kSpacing = 0.6;  // spacing of a root in a unit square
  const double apart = kSpacing / std::sqrt(static_cast<double>(mRoots.size() + count));
  std::vector<FitRoot> chosen;
  for (const CandidateScore& score : rankedCandidates(count)) {
    if (chosen.size() == count) break;
    if (!(score.gain > 0)) continue;
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

/// 1 for top roots and the constant, -1 for bottom roots.
VectorXd Fitter::signs() const {
  VectorXd signs = VectorXd::Ones(mX.size());
  for (std::size_t j = 0; j < mRoots.size(); ++j) signs[static_cast<Index>(j)] = sign(j);
  return signs;
}

/// The gradient of the objective and the penalties at mX, except the penalty of the degree. @return the curvature of
/// the objective with respect to L, for each cell
std::vector<double> Fitter::slopes(const Objective& objective, VectorXd& gradient) const {
  const Index n = mX.size();
  const double sharpness = objective.sharpness;
  std::vector<double> curvature(mCells.size());
  const LogMatrix::Pass pass = mLogs.pass(
      weights(mX), constant(mX),
      [&](std::size_t begin, std::span<const double> l, std::span<double> factors) {
        for (std::size_t i = 0; i < l.size(); ++i) {
          const std::size_t k = begin + i;
          const LossAt at = lossAt(objective.loss, -sharpness * mSide[k] * l[i]);
          factors[i] = -sharpness * mSide[k] * mWeight[k] * at.slope;
          curvature[k] = sharpness * sharpness * mWeight[k] * at.curvature;
        }
        return 0.0;
      },
      LogMatrix::Products::Logs);
  gradient = Eigen::Map<const VectorXd>(pass.products.data(), n).cwiseProduct(signs());
  gradient.head(n - 1) += kRidge * mX.head(n - 1) + VectorXd::Constant(n - 1, mOptions.powerPenalty);
  return curvature;
}

/// Whether the Gram matrix was made with curvatures that differ too much from these.
bool Fitter::isStale(const std::vector<double>& curvature) const {
  if (mGram.size() == 0) return true;
  double sum = 0, change = 0;
  for (std::size_t i = 0; i < curvature.size(); ++i) {
    sum += curvature[i];
    change += std::abs(curvature[i] - mGramCurvature[i]);
  }
  return change > kStale * sum;
}

void Fitter::remakeGram(const std::vector<double>& curvature) {
  // The effective number of cells: if that many had equal curvatures and the others none, the ratio of the sums would
  // be the same.
  double sum = 0, squares = 0;
  for (const double value : curvature) {
    sum += value;
    squares += value * value;
  }
  const double columns = static_cast<double>(mX.size()), effective = sum * sum / squares;
  const double wanted =
      std::clamp(kGramShare * effective, kLeastGramCellsPerColumn * columns, kMostGramCellsPerColumn * columns);
  mGramCurvature = curvature;
  mGramCells = sampleCells(curvature, std::max(kLeastGramCells, static_cast<std::size_t>(wanted)));
  mGram.resize(0, 0);
  mProgram.reset();
}

/// The program of minimumOf(). Its variables are the powers less the minimum powers of their roots, the constant, and
/// the slack of the degree penalty.
BoundedQuadratic& Fitter::program(double damping) {
  if (mProgram && mDamping == damping) return *mProgram;
  const Index n = mX.size();
  if (mGram.rows() != n) mLogs.extendGram(mGramCells, mGram);
  const VectorXd signs = this->signs();
  VectorXd spring(n + 1);
  spring << signs.head(n - 1), 0, -1;
  Eigen::MatrixXd hessian = kDegreeStiffness * spring * spring.transpose();
  hessian.topLeftCorner(n, n) += signs.asDiagonal() * mGram * signs.asDiagonal();
  hessian.diagonal().head(n - 1).array() += kRidge;
  hessian.diagonal().head(n).array() += damping * (mGram.trace() / static_cast<double>(n) + kRidge);
  mDamping = damping;
  return mProgram.emplace(std::move(hessian));
}

/// The minimum of the quadratic model about mX with every power at least the minimum of its root; empty if rounding
/// leaves the model without one. The degree penalty is M/2 (degree - least - s)^2 at its best s >= 0, which is an
/// additional variable.
std::optional<VectorXd> Fitter::minimumOf(const VectorXd& gradient, double damping) {
  const Index n = mX.size();
  BoundedQuadratic& program = this->program(damping);
  VectorXd least = VectorXd::Zero(n);
  for (std::size_t j = 0; j < mRoots.size(); ++j) least[static_cast<Index>(j)] = mRoots[j].least;
  std::vector<char> bounded(static_cast<std::size_t>(n) + 1, 1);
  bounded[mRoots.size()] = 0;  // for the constant

  const double excess = degree(mX) - kLeastDegree, slack = std::max(0.0, excess);
  VectorXd origin(n + 1), slope(n + 1);
  slope << signs().head(n - 1), 0, -1;
  slope *= kDegreeStiffness * (excess - slack);
  origin << mX - least, slack;
  slope.head(n) += gradient;
  // The powers above their minimum, and those that the objective asks for.
  std::vector<char> passive(bounded.size());
  for (Index i = 0; i <= n; ++i) passive[static_cast<std::size_t>(i)] = origin[i] > 0 || slope[i] < 0;
  const auto minimum = program.minimise(program.matrix() * origin - slope, bounded, passive);
  if (!minimum) return std::nullopt;
  return VectorXd(minimum->head(n) + least);
}

/// Moves mX to @a target, or only part of the way, so that the objective decreases: every point on the line is
/// feasible.
/// @return the fraction of the way taken; empty if the objective does not decrease
std::optional<double> Fitter::stepTowards(const VectorXd& target, const Objective& objective) {
  const VectorXd direction = target - mX;
  std::vector<double> difference(mCells.size()), moved(mCells.size());
  mLogs.logModuli(weights(direction), constant(direction), difference);
  double length = 1;
  for (int cut = 0; cut < 8; ++cut, length *= 0.4) {
    for (std::size_t i = 0; i < mL.size(); ++i) moved[i] = mL[i] + length * difference[i];
    const VectorXd x = length == 1 ? target : VectorXd(mX + length * direction);
    const double value = loss(objective, moved) + penalty(x);
    if (!(value < mEnergy)) continue;
    mEnergy = value;
    mX = x;
    std::swap(mL, moved);
    return length;
  }
  return std::nullopt;
}

/// Newton's method, starting from mX, with Levenberg-Marquardt damping. Second derivatives of an earlier step are
/// reused until they have changed, or no step with them lowers the objective.
void Fitter::newton(const Objective& objective, const Effort& effort) {
  constexpr double kLeastDamping = 1e-9;
  constexpr int kMostAttempts = 4;
  mLogs.logModuli(weights(mX), constant(mX), mL);
  mEnergy = loss(objective, mL) + penalty(mX);
  double damping = kLeastDamping;
  bool cutShort = false;
  int small = 0;
  for (int step = 0; step < effort.steps && small < 2; ++step) {
    if (mOptions.cancelled && mOptions.cancelled()) throw Cancelled();
    VectorXd gradient;
    const std::vector<double> curvature = slopes(objective, gradient);
    bool fresh = cutShort || isStale(curvature);
    if (fresh) remakeGram(curvature);
    const double before = mEnergy;
    bool lower = false;
    for (int attempt = 0; attempt < kMostAttempts && !lower; ++attempt) {
      const std::optional<VectorXd> target = minimumOf(gradient, damping);
      const std::optional<double> taken = target ? stepTowards(*target, objective) : std::nullopt;
      lower = taken.has_value();
      cutShort = lower && *taken < 1;
      if (!lower && !fresh) {
        remakeGram(curvature);
        fresh = true;
      } else if (!lower) {
        damping *= 100;
      } else {
        damping = *taken == 1 ? std::max(damping / 5, kLeastDamping) : damping;
      }
    }
    if (!lower) break;
    small = before - mEnergy < effort.settled * std::abs(mEnergy) ? small + 1 : 0;
    ++mSteps;
    report(false);
  }
}

/// Whether the distances of the cells prove that a top root is inside the target, or a bottom root outside it.
bool Fitter::isOnItsSide(const FitRoot& root) const {
  return std::any_of(mCells.begin(), mCells.end(), [&](const FitCell& cell) {
    if ((cell.phi > 0) != root.bottom) return false;
    double square = 0;
    for (std::size_t axis = 0; axis < 3; ++axis)
      square += (cell.x[axis] - root.x[axis]) * (cell.x[axis] - root.x[axis]);
    return square < double{cell.phi} * cell.phi;
  });
}

/// Puts the roots at other places.
void Fitter::place(const std::vector<FitRoot>& roots) {
  mRoots = roots;
  const std::vector<Quaternion<double>> positions = positionsOf(roots);
  mLogs.move(positions);
  mHeldLogs.move(positions);
  mGram.resize(0, 0);
  mProgram.reset();
  mLogs.logModuli(weights(mX), constant(mX), mL);
}

/// Lowers the objective by the positions of the roots. A root that would leave its side, as far as the cells prove
/// where that ends, stays.
/// @return whether the objective is lower; otherwise nothing has changed
bool Fitter::moveRoots(const Objective& objective) {
  std::vector<double> signedWeights(mWeight);
  for (std::size_t i = 0; i < mCells.size(); ++i) signedWeights[i] *= mSide[i];
  const Rational start = rational();
  ShapeEnergy energy(pointsOf(mCells), std::move(signedWeights), start,
                     {.alpha = objective.sharpness, .memoryLimit = 0});
  // In the order of a rational: the top roots first.
  std::vector<std::size_t> order(mRoots.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_partition(order.begin(), order.end(), [&](std::size_t j) { return !mRoots[j].bottom; });
  std::vector<double> reach;
  for (const std::size_t j : order) reach.push_back(mRoots[j].least > 0 ? 0 : kPlaceReach * mOptions.cellSize);
  const std::vector<FitRoot> before = mRoots;
  std::vector<FitRoot> moved = mRoots;
  Rational found = start;
  julia::moveRoots(energy, found, reach, {.maxIterations = kPlaceSteps, .cancelled = mOptions.cancelled});
  for (std::size_t k = 0, tops = found.top.roots.size(); k < order.size(); ++k) {
    const Quaternion<double>& to = k < tops ? found.top.roots[k].position : found.bottom.roots[k - tops].position;
    FitRoot& root = moved[order[k]];
    root.x = {to.a, to.b, to.c};
    if (!isOnItsSide(root)) root = before[order[k]];
  }
  place(moved);
  const double value = loss(objective, mL) + penalty(mX);
  if (value < mEnergy) {
    mEnergy = value;
    ++mSteps;
    report(false);
    return true;
  }
  place(before);
  return false;
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

double Fitter::psi() const {
  double psi = 0;
  for (std::size_t i = 0; i < mL.size(); ++i) psi -= mWeight[i] * mSide[i] * elementary::tanh(mL[i]);
  return psi;
}

void Fitter::report(bool roundEnds) {
  if (!mOptions.onStep) return;
  const Rational now = rational();
  mOptions.onStep({mStage, mSteps, mRoots.size(), mEnergy, psi(), heldOutIou(), &now, roundEnds});
}

/// The root at the origin and the roots of the options, each on the side of the cell nearest to it.
std::vector<FitRoot> Fitter::firstRoots() const {
  std::vector<FitRoot> first{{Point{0, 0, 0}, false, kLeastAtOrigin}};
  for (const Point& x : mOptions.start) {
    const auto nearest = std::min_element(mCells.begin(), mCells.end(), [&](const FitCell& a, const FitCell& b) {
      const auto square = [&](const FitCell& cell) {
        return (cell.x[0] - x[0]) * (cell.x[0] - x[0]) + (cell.x[1] - x[1]) * (cell.x[1] - x[1]) +
               (cell.x[2] - x[2]) * (cell.x[2] - x[2]);
      };
      return square(a) < square(b);
    });
    if (first.size() < mOptions.maxRoots) first.push_back({x, nearest->phi > 0, 0});
  }
  return first;
}

FastFit Fitter::run() {
  mStage = "roots";
  add(firstRoots());
  newton(kLogistic, kRound);
  double best = 0;
  int worse = 0;
  for (; mRound < kMostRounds && worse < kPatience; ++mRound) {
    dropUnused();
    const double iou = heldOutIou();
    report(true);
    worse = iou > best + kLeastRise ? 0 : worse + 1;
    best = std::max(best, iou);
    if (best >= mOptions.targetIou || mRoots.size() >= mOptions.maxRoots) break;
    const std::size_t wanted =
        1 + static_cast<std::size_t>(std::max(kShareOfMost * static_cast<double>(mOptions.maxRoots),
                                              kShareOfPresent * static_cast<double>(mRoots.size())));
    if (addBest(std::min(wanted, mOptions.maxRoots - mRoots.size())) == 0) break;
    newton(kLogistic, kRound);
  }
  newton(kLogistic, kLast);
  mStage = "energy";
  for (const double sharpness : kEnergySharpness) {
    const Objective energy{Loss::Energy, sharpness};
    newton(energy, kSharpen);
    if (mOptions.moveRoots && moveRoots(energy)) newton(energy, kSharpen);
    dropUnused();
    report(true);
  }
  return {rational(), heldOutIou(), psi(), mSteps};
}

}  // namespace

FastFit fastFit(std::span<const FitCell> cells, std::span<const RootCandidate> candidates,
                const FastFitOptions& options) {
  if (options.maxRoots < 1) throw std::invalid_argument("maxRoots is 0; it must be at least 1");
  if (!(options.targetIou > 0 && options.targetIou <= 1))
    throw std::invalid_argument("the fit's target is an IoU of " + textOf(options.targetIou) +
                                "; it must be above 0 and at most 1");
  if (!(options.cellSize > 0) || !std::isfinite(options.cellSize))
    throw std::invalid_argument("the size of the fit's cells is " + textOf(options.cellSize) + "; it must be above 0");
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
