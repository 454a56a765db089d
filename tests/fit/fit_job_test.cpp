// SPDX-License-Identifier: Apache-2.0
// The fit from end to end: shapes whose fit is known, and changes that must not matter.
#include "support/interrupting.h"
#include "support/temporary_folder.h"
#include "support/test_fields.h"
#include "support/test_meshes.h"

#include "vdbtools/fit/fit_job.h"
#include "vdbtools/formats/peer_formats.h"
#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/formats/versor_file.h"
#include "vdbtools/mesh_files/mesh_writer.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
#include <limits>
#include <locale>
#include <sstream>
#include <string>
#include <vector>

namespace {

using namespace vdbtools;
using namespace vdbtools::fit;
using openvdb::Vec3d;
using test_monitors::Interrupting;

/// Two balls and the rod between them, along x: waists are what one root cannot have.
double dumbbellDistance(const Vec3d& x) {
  const double rod = std::max(std::hypot(x[1], x[2]) - 0.09, std::abs(x[0]) - 0.3);
  const double balls = (Vec3d(std::abs(x[0]), x[1], x[2]) - Vec3d(0.3, 0, 0)).length() - 0.2;
  return std::min(rod, balls);
}

/// Recipes and the files that they name.
class Job {
 public:
  Job(std::string input, Recipe recipe) : mRecipe(std::move(recipe)) {
    mRecipe["input"] = std::move(input);
    mRecipe.try_emplace("resolution", "33");
    mRecipe.try_emplace("triangles", "600");
  }
  FitOptions options() const { return parseFitOptions(mRecipe); }
  FitResult run(bool wantDistances = false) const {
    Monitor monitor;
    return run(wantDistances, monitor);
  }
  FitResult run(bool wantDistances, Monitor& monitor) const { return runFit(options(), wantDistances, monitor); }
  FitTarget target() const {
    Monitor monitor;
    return makeFitTarget(options().target, monitor);
  }

 private:
  Recipe mRecipe;
};

class Files {
 public:
  Files() {
    openvdb::initialize();
    mBall = mesh("ball.obj", test_meshes::makeSphere(2, 4, {10, -20, 30}));
    mBox = mesh("box.obj", box());
    mDumbbell = mFolder.write("dumbbell.vdb", encodeVdb({test_fields::bandGrid(dumbbellDistance, 1.0 / 48, 0.15)}, {}))
                    .string();
  }
  static Mesh box() { return test_meshes::makeBox({-1, -0.5, -0.25}, {1, 0.5, 0.25}); }
  std::string mesh(const std::string& name, const Mesh& mesh) const {
    std::ostringstream obj;
    writeMesh(obj, mesh, {.format = &meshFormat(".obj")});
    return mFolder.write(name, obj.str()).string();
  }
  std::filesystem::path write(const std::string& name, const std::string& bytes) const {
    return mFolder.write(name, bytes);
  }
  Job ball(Recipe recipe) const { return {mBall, std::move(recipe)}; }
  Job box(Recipe recipe) const { return {mBox, std::move(recipe)}; }
  Job dumbbell(Recipe recipe) const { return {mDumbbell, std::move(recipe)}; }

 private:
  TemporaryFolder mFolder;
  std::string mBall, mBox, mDumbbell;
};

const Files& files() {
  static const Files files;
  return files;
}

const std::string kSchedule = "9(V) 17(VFR)";
const Recipe kFastRecipe{{"roots", "24"}};
// By 1 over the distance, most of the weight would be outside so thin a shape, and a map without inside a minimum.
const Recipe kScheduleRecipe{{"roots", "24"}, {"schedule", kSchedule}, {"weights", "layers"}};

/// The fits that several tests look at.
const FitResult& fastFit() {
  static const FitResult fit = files().dumbbell(kFastRecipe).run(true);
  return fit;
}
const FitResult& scheduledFit() {
  static const FitResult fit = files().dumbbell(kScheduleRecipe).run(true);
  return fit;
}

std::string bytesOf(const FitResult& fit) {
  return rationalToJson(fit.rational, {}, vdbtools::FittedTo{fit.target.space, fit.target.box});
}

std::vector<double> logModuli(const julia::Rational& rational, const std::vector<julia::FitCell>& cells) {
  const julia::RationalEvaluator<double> evaluator(rational);
  std::vector<double> l;
  for (const julia::FitCell& cell : cells)
    l.push_back(evaluator.logModulus(julia::Embedding{}.quaternion<double>(cell.x)));
  return l;
}

std::string refusal(Recipe recipe) {
  recipe.try_emplace("input", "nowhere.obj");
  try {
    parseFitOptions(recipe);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  ADD_FAILURE() << "accepted";
  return {};
}

TEST(FitJob, RefusesBadOptionsAndNamesThem) {
  const std::vector<std::pair<std::string, std::vector<std::string>>> bad{
      {"roots", {"0", "-1", "1.5", "", "many", "100001", "99999999999999999999"}},
      {"epsilon", {"0", "1", "-1", "nan", "inf", "", "0.04x"}},
      {"target-iou", {"0", "2", "-0.5", "nan", "1.0000001"}},
      {"resolution", {"7", "1001", "0", "33.5", "-33"}},
      {"smooth", {"-1", "5", "nan", "inf"}},
      {"triangles", {"99", "0", "1000001"}},
      {"alpha", {"-1", "nan", "inf"}},
      {"power-penalty", {"-1e-9", "nan", "inf"}},
      {"repair-gap", {"-1", "nan"}},
      {"start", {"random", ""}},
      {"places", {"stay", ""}},
      {"weights", {"layer", ""}},
      {"seed", {"-1", "1.5", "18446744073709551616"}},
      {"repair", {"yes"}},
  };
  for (const auto& [option, values] : bad)
    for (const std::string& value : values) {
      SCOPED_TRACE(option + " = " + value);
      const std::string message = refusal({{option, value}});
      EXPECT_NE(message.find("--" + option), std::string::npos) << message;
      EXPECT_NE(message.find("'" + value + "'"), std::string::npos) << message;
    }
  EXPECT_NE(refusal({{"epsylon", "0.1"}}).find("--epsylon is not an option"), std::string::npos);
  EXPECT_NE(refusal({{"input", ""}}).find("no target"), std::string::npos);
}

TEST(FitJob, RefusesABadScheduleAndNamesTheCharacter) {
  const std::vector<std::pair<std::string, int>> bad{
      {"V", 1},          {"25", 3},    {"25()", 4},           {"25(VX)", 5}, {"25(V", 5},
      {"25(VF) 50", 10}, {" ", 2},     {"25(V) 50(V) )", 13}, {"3(V)", 1},   {"1001(V)", 1},
      {"25[V]", 3},      {"25(v)", 4}, {"-25(V)", 1}};
  for (const auto& [schedule, character] : bad) {
    const std::string message = refusal({{"schedule", schedule}});
    EXPECT_NE(message.find("at character " + std::to_string(character) + " "), std::string::npos)
        << "'" << schedule << "': " << message;
  }
}

TEST(FitJob, DefaultsAreThePapersOnlyWithItsMethod) {
  const FitOptions fast = parseFitOptions({{"input", "x.obj"}});
  EXPECT_TRUE(fast.schedule.empty());
  EXPECT_EQ(fast.powerPenalty, 0);
  EXPECT_EQ(fast.roots, 331u);
  EXPECT_EQ(fast.target.resolution, 97);
  const FitOptions paper = parseFitOptions({{"input", "x.obj"}, {"schedule", kSchedule}});
  EXPECT_EQ(julia::toString(paper.schedule), kSchedule);
  EXPECT_EQ(paper.powerPenalty, 1e-5);
  EXPECT_EQ(parseFitOptions({{"input", "x.obj"}, {"schedule", kSchedule}, {"power-penalty", "0"}}).powerPenalty, 0);
  const FitOptions usual = parseFitOptions({{"input", "x.obj"}, {"method", "kim15"}});
  EXPECT_EQ(julia::toString(usual.schedule), "25(VFRF) 50(VFRF) 97(VF)");
  EXPECT_EQ(usual.powerPenalty, 1e-5);
  EXPECT_TRUE(parseFitOptions({{"input", "x.obj"}, {"method", "fast"}}).schedule.empty());
  EXPECT_THROW(parseFitOptions({{"input", "x.obj"}, {"method", "quick"}}), std::invalid_argument);
}

TEST(FitJob, OneRootIsABall) {
  const FitResult fit = files().ball({{"roots", "1"}}).run();
  ASSERT_EQ(fit.rational.top.roots.size(), 1u);
  EXPECT_TRUE(fit.rational.bottom.roots.empty());
  EXPECT_EQ(fit.rational.top.roots[0].position, julia::Quaternion<double>{});
  EXPECT_GE(fit.rational.top.roots[0].power, 1);
  EXPECT_GT(fit.measure.iou, 0.99);
  // L = C + power ln|q|, 0 at the radius.
  const double power = fit.rational.top.roots[0].power * fit.rational.top.powerScale;
  EXPECT_NEAR(std::exp(-fit.rational.logScale / power), 0.5, 0.005);
}

TEST(FitJob, MoreRootsFitBetter) {
  for (const char* shape : {"dumbbell", "box"}) {
    SCOPED_TRACE(shape);
    const auto fitted = [&](const char* roots) {
      const Recipe recipe{{"roots", roots}};
      return (shape == std::string("box") ? files().box(recipe) : files().dumbbell(recipe)).run();
    };
    const FitResult one = fitted("1"), few = fitted("8"), more = fitted("60");
    EXPECT_LE(few.rational.top.roots.size() + few.rational.bottom.roots.size(), 8u);
    EXPECT_LE(more.rational.top.roots.size() + more.rational.bottom.roots.size(), 60u);
    EXPECT_GT(few.measure.iou, one.measure.iou);
    EXPECT_GT(more.measure.iou, few.measure.iou);
    EXPECT_LT(more.measure.psi, few.measure.psi);
    EXPECT_LT(more.measure.meanDistance, few.measure.meanDistance);
    EXPECT_GT(more.measure.iou, 0.9);
  }
}

// Promise: In each stage of a fit "the roots ..."
TEST(FitJob, RootsThatMoveFitBetter) {
  const FitResult moved = files().dumbbell({{"roots", "24"}}).run();
  const FitResult kept = files().dumbbell({{"roots", "24"}, {"places", "keep"}}).run();
  EXPECT_LT(moved.measure.psi, kept.measure.psi);
  EXPECT_GT(moved.measure.iou, kept.measure.iou);
  EXPECT_LT(moved.measure.meanDistance, kept.measure.meanDistance);
}

TEST(FitJob, TargetIouSavesRoots) {
  const FitResult all = files().dumbbell({{"roots", "60"}}).run();
  const FitResult enough = files().dumbbell({{"roots", "60"}, {"target-iou", "0.5"}}).run();
  EXPECT_LT(enough.rational.top.roots.size() + enough.rational.bottom.roots.size(),
            all.rational.top.roots.size() + all.rational.bottom.roots.size());
  EXPECT_GT(enough.measure.iou, 0.45);
}

void expectSoundRows(const FitResult& fit) {
  ASSERT_FALSE(fit.rows.empty());
  double seconds = 0;
  for (std::size_t i = 0; i < fit.rows.size(); ++i) {
    const FitRow& row = fit.rows[i];
    SCOPED_TRACE("row " + std::to_string(i) + ", " + row.stage);
    EXPECT_EQ(row.step, static_cast<int>(i) + 1);
    EXPECT_TRUE(std::isfinite(row.energy));
    EXPECT_GE(row.psi, -1);
    EXPECT_LE(row.psi, 1);
    EXPECT_GE(row.iou, 0);
    EXPECT_LE(row.iou, 1);
    EXPECT_GE(row.top, 1u);
    EXPECT_GE(row.topPowers, 0);
    EXPECT_GE(row.bottomPowers, 0);
    EXPECT_GE(row.seconds, seconds);
    seconds = row.seconds;
    // Both distances are measured or none.
    EXPECT_EQ(row.meanDistance < 0, row.hausdorff < 0);
    if (row.hausdorff >= 0) {
      EXPECT_LE(row.meanDistance, row.hausdorff);
    }
  }
  EXPECT_GE(fit.rows.back().hausdorff, 0) << "the last row ends a round";
  // What the rows judge by a sample is what the whole says.
  EXPECT_NEAR(fit.rows.back().iou, fit.measure.iou, 0.05);
  EXPECT_NEAR(fit.rows.back().psi, fit.measure.psi, 0.1);
  EXPECT_NEAR(fit.rows.back().meanDistance, fit.measure.meanDistance, 1e-9);
}

TEST(FitJob, FastFitGoesDown) {
  const FitResult& fit = fastFit();
  expectSoundRows(fit);
  EXPECT_EQ(fit.monopoles, 0u);
  std::size_t roots = 0, energies = 0;
  for (std::size_t i = 0; i < fit.rows.size(); ++i) {
    const FitRow& row = fit.rows[i];
    SCOPED_TRACE("row " + std::to_string(i) + ", " + row.stage);
    ASSERT_TRUE(row.stage == "roots" || (row.stage == "energy" && (i == 0 || roots > 0)));
    ++(row.stage == "roots" ? roots : energies);
    EXPECT_LE(row.top + row.bottom, 24u);
    if (i == 0 || fit.rows[i - 1].stage != row.stage) continue;
    // New roots begin with a power of 0 and those that go had it, so a round begins where the one before ended. The
    // energy is another one each time it gets sharper, which is where a round ends.
    const bool newEnergy = row.stage == "energy" && fit.rows[i - 1].hausdorff >= 0;
    if (!newEnergy) {
      EXPECT_LE(row.energy, fit.rows[i - 1].energy);
    }
  }
  EXPECT_GT(roots, 0u);
  EXPECT_GT(energies, 0u);
  EXPECT_GT(fit.measure.iou, 0.85);
}

TEST(FitJob, ScheduleGoesDown) {
  const FitResult& fit = scheduledFit();
  expectSoundRows(fit);
  EXPECT_GT(fit.monopoles, 0u);
  EXPECT_LE(fit.monopoles, 24u);
  EXPECT_EQ(fit.rational.top.roots.size() + fit.rational.bottom.roots.size(), fit.monopoles + 2)
      << "one at the origin on each side";
  std::vector<std::string> stages;
  for (std::size_t i = 0; i < fit.rows.size(); ++i) {
    const FitRow& row = fit.rows[i];
    SCOPED_TRACE("row " + std::to_string(i) + ", " + row.stage);
    if (stages.empty() || stages.back() != row.stage) stages.push_back(row.stage);
    // V and F of one grid lower one energy, R another.
    if (i > 0 && (fit.rows[i - 1].stage == row.stage || row.stage == "17(F)")) {
      EXPECT_LE(row.energy, fit.rows[i - 1].energy);
    }
  }
  const std::vector<std::string> passes{"9(V)", "17(V)", "17(F)", "17(R)"};
  // A pass that finds nothing better has no row, but the order is the schedule's.
  EXPECT_TRUE(std::includes(
      passes.begin(), passes.end(), stages.begin(), stages.end(), [&](const std::string& a, const std::string& b) {
        return std::find(passes.begin(), passes.end(), a) < std::find(passes.begin(), passes.end(), b);
      }));
  EXPECT_GE(stages.size(), 3u);
  EXPECT_GT(fit.measure.iou, 0.5);
}

TEST(FitJob, DistancesAreMeasuredOnRequestOnly) {
  for (const FitRow& row : files().ball({{"roots", "2"}}).run(false).rows) {
    EXPECT_EQ(row.meanDistance, -1);
    EXPECT_EQ(row.hausdorff, -1);
  }
}

// Promise: "The same seed gives the same ..."
TEST(FitJob, SameBytesForAnyThreadsAndForTheSeed) {
  const FitResult& fast = fastFit();
  for (const Recipe& recipe : {kFastRecipe, kScheduleRecipe, Recipe{{"roots", "12"}, {"start", "monopoles"}}}) {
    const Job job = files().dumbbell(recipe);
    std::string bytes[2];
    std::vector<FitRow> rows[2];
    for (const std::size_t threads : {1u, 2u}) {
      const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
      const FitResult fit = job.run();
      bytes[threads - 1] = bytesOf(fit);
      rows[threads - 1] = fit.rows;
    }
    EXPECT_EQ(bytes[0], bytes[1]);
    for (std::vector<FitRow>& side : rows)
      for (FitRow& row : side) row.seconds = 0;
    EXPECT_EQ(fitReportCsv(rows[0]), fitReportCsv(rows[1]));
  }
  EXPECT_EQ(bytesOf(files().dumbbell(kFastRecipe).run()), bytesOf(fast)) << "measuring distances changes no root";
  Recipe other = kFastRecipe;
  other["seed"] = "2";
  EXPECT_NE(bytesOf(files().dumbbell(other).run()), bytesOf(fast));
}

// Promise of fitting.md: "`fit` chooses C anew at the end, for the iterations of `--iterations`", and "powers stay as
//   they were found"
TEST(FitJob, TheSetHasTheShapeAfterItsIterations) {
  Recipe recipe = kFastRecipe;
  for (const char* const alpha : {"0", "40"}) {
    recipe["alpha"] = alpha;
    recipe["iterations"] = "1";
    const FitResult once = files().dumbbell(recipe).run();
    EXPECT_EQ(once.scaleShift, 0);
    recipe["iterations"] = "4";
    const FitResult often = files().dumbbell(recipe).run();
    // It is the same map but for C.
    EXPECT_EQ(often.rational.top.roots, once.rational.top.roots);
    EXPECT_EQ(often.rational.logScale, once.rational.logScale + often.scaleShift);
    EXPECT_EQ(often.measure.iou, once.measure.iou);
    Monitor monitor;
    EXPECT_EQ(often.iteratedIou, iteratedIou(often.target, often.rational, {.iterations = 4}, monitor));
    EXPECT_GT(often.iteratedIou, iteratedIou(once.target, once.rational, {.iterations = 4}, monitor));
    // Thin shells of detail leave nearly all of the shape.
    if (recipe["alpha"] == "0") {
      EXPECT_GT(often.iteratedIou, once.measure.iou - 0.05);
    }
  }
}

// Promise of fitting.md#the-fast-fit: "`--alpha A` sets the thickness", and keeps the set at n = 1
TEST(FitJob, AlphaThinsTheShellAndKeepsTheShape) {
  Recipe recipe = kFastRecipe;
  recipe["iterations"] = "1";
  const Job plain = files().dumbbell(recipe);
  const FitResult found = plain.run();
  recipe["alpha"] = "40";
  const FitResult scaled = files().dumbbell(recipe).run();
  EXPECT_EQ(scaled.slope, 40);
  const double factor = 40 / found.slope;
  EXPECT_NEAR(scaled.rational.logScale / found.rational.logScale, factor, 1e-9 * factor);
  EXPECT_NEAR(julia::summedPowers(scaled.rational.top) / julia::summedPowers(found.rational.top), factor,
              1e-9 * factor);
  EXPECT_EQ(scaled.rational.top.roots, found.rational.top.roots);
  EXPECT_EQ(scaled.rational.bottom.roots, found.rational.bottom.roots);

  const FitTarget target = plain.target();
  const std::vector<julia::FitCell> cells = adaptiveCells(target);
  const std::vector<double> before = logModuli(found.rational, cells), after = logModuli(scaled.rational, cells);
  std::vector<double> slopes;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    // But for those on the surface itself, where rounding decides.
    if (std::abs(before[i]) > 1e-9) {
      EXPECT_EQ(before[i] < 0, after[i] < 0);
    }
    const double cellsAway = std::abs(cells[i].phi) / target.cell;
    if (cellsAway > 0.5 && cellsAway < 2) slopes.push_back(std::abs(after[i] / cells[i].phi));
  }
  std::nth_element(slopes.begin(), slopes.begin() + static_cast<std::ptrdiff_t>(slopes.size() / 2), slopes.end());
  EXPECT_NEAR(slopes[slopes.size() / 2], 40, 0.05);
  EXPECT_EQ(scaled.measure.iou, found.measure.iou);
}

std::vector<std::vector<std::string>> parsed(const std::string& csv) {
  std::vector<std::vector<std::string>> lines;
  std::istringstream stream(csv);
  for (std::string line; std::getline(stream, line);) {
    lines.emplace_back();
    std::istringstream words(line);
    for (std::string word; std::getline(words, word, ',');) lines.back().push_back(word);
  }
  return lines;
}

TEST(FitJob, ReportParsesBack) {
  struct Comma : std::numpunct<char> {
    char do_decimal_point() const override { return ','; }
    char do_thousands_sep() const override { return '.'; }
    std::string do_grouping() const override { return "\1"; }
  };
  for (const FitResult* fit : {&fastFit(), &scheduledFit()}) {
    const std::locale before = std::locale::global(std::locale(std::locale::classic(), new Comma));
    const std::string csv = fitReportCsv(fit->rows);
    std::locale::global(before);
    EXPECT_EQ(csv, fitReportCsv(fit->rows)) << "numbers do not depend on the locale";
    EXPECT_EQ(csv.back(), '\n');
    const auto lines = parsed(csv);
    ASSERT_EQ(lines.size(), fit->rows.size() + 1);
    EXPECT_EQ(lines[0],
              (std::vector<std::string>{"step", "stage", "top_roots", "bottom_roots", "working_energy", "psi", "iou",
                                        "mean_distance", "hausdorff", "top_powers", "bottom_powers", "seconds"}));
    for (std::size_t i = 0; i < fit->rows.size(); ++i) {
      const FitRow& row = fit->rows[i];
      const std::vector<std::string>& words = lines[i + 1];
      SCOPED_TRACE(i);
      ASSERT_EQ(words.size(), lines[0].size());
      EXPECT_EQ(words[0], std::to_string(row.step));
      EXPECT_EQ(words[1], row.stage);
      EXPECT_EQ(words[2], std::to_string(row.top));
      EXPECT_EQ(words[3], std::to_string(row.bottom));
      const std::vector<std::pair<std::size_t, double>> numbers{
          {4, row.energy},    {5, row.psi},       {6, row.iou},           {7, row.meanDistance},
          {8, row.hausdorff}, {9, row.topPowers}, {10, row.bottomPowers}, {11, row.seconds}};
      for (const auto& [column, value] : numbers) {
        if ((column == 7 || column == 8) && value < 0) {
          EXPECT_EQ(words[column], "") << lines[0][column];
        } else {
          EXPECT_NEAR(std::stod(words[column]), value, 1e-5 * std::abs(value)) << lines[0][column];
        }
      }
    }
  }
  EXPECT_EQ(parsed(fitReportCsv({})).size(), 1u);
}

TEST(FitJob, ThePlotShowsTheReport) {
  const std::vector<std::vector<FitRow>> reports{fastFit().rows, scheduledFit().rows, {fastFit().rows.front()}};
  for (const std::vector<FitRow>& rows : reports) {
    const Plot plot = fitReportPlot(rows);
    ASSERT_EQ(plot.series.size(), 3u);
    for (std::size_t i = 0; i < rows.size(); ++i) {
      for (const PlotSeries& series : plot.series) EXPECT_EQ(series.points[i].first, rows[i].step);
      EXPECT_NEAR(2 * plot.series[0].points[i].second - 1, rows[i].psi, 1e-12);
      EXPECT_EQ(std::isnan(plot.series[1].points[i].second), rows[i].stage == "roots");
      EXPECT_NEAR(1 - plot.series[2].points[i].second, rows[i].iou, 1e-12);
    }
    EXPECT_NO_THROW(plotImage(plot));
  }
}

TEST(FitJob, MonopolesCanBeTheStart) {
  const FitResult fit = files().ball({{"roots", "16"}, {"start", "monopoles"}, {"epsilon", "0.02"}}).run();
  EXPECT_GT(fit.monopoles, 0u);
  EXPECT_LE(fit.monopoles, 8u);
  EXPECT_NEAR(fit.charge.capacitance, 0.5, 0.02) << "a ball's is its radius";
  EXPECT_GT(fit.measure.iou, 0.98);
}

TEST(FitJob, ChargeIsEvenOnABallAndLargeOnWhatSticksOut) {
  Monitor monitor;
  FitResult ball;
  ball.target = files().ball({}).target();
  const ChargedSurface even = chargedSurface(ball, monitor);
  ASSERT_EQ(even.mesh.points.size(), ball.target.surface.points.size());
  ASSERT_EQ(even.values.size(), even.mesh.points.size() * rowLength(even.columns));
  for (std::size_t i = 0; i < even.mesh.points.size(); ++i) {
    EXPECT_NEAR(even.values[4 * i + 3], 1, 0.15);
    EXPECT_NEAR((even.mesh.points[i] - Vec3d(10, -20, 30)).length(), 2, 0.1) << "world units";
  }
  // The whole charge is spread: the mean over the area is 1.
  FitResult thin;
  thin.target = files().dumbbell({}).target();
  const ChargedSurface dumbbell = chargedSurface(thin, monitor);
  double ends = 0, rod = 1e9, charge = 0, area = 0;
  for (std::size_t i = 0; i < dumbbell.mesh.points.size(); ++i) {
    const double x = std::abs(dumbbell.mesh.points[i][0]), value = dumbbell.values[4 * i + 3];
    if (x > 0.45) ends = std::max(ends, value);
    if (x < 0.12) rod = std::min(rod, value);
    EXPECT_TRUE(0 <= dumbbell.values[4 * i] && dumbbell.values[4 * i] <= 1);
  }
  EXPECT_GT(ends, 1.2);
  EXPECT_LT(rod, 0.9 * ends);
  for (const openvdb::Vec3I& t : dumbbell.mesh.triangles) {
    const Vec3d a = dumbbell.mesh.points[t[0]], b = dumbbell.mesh.points[t[1]], c = dumbbell.mesh.points[t[2]];
    const double size = 0.5 * (b - a).cross(c - a).length();
    area += size;
    for (int k = 0; k < 3; ++k) charge += size / 3 * dumbbell.values[4 * t[k] + 3];
  }
  EXPECT_NEAR(charge / area, 1, 0.02);
}

TEST(FitJob, O3dReadsBack) {
  const FitOptions options = files().box({{"roots", "20"}}).options();
  Monitor monitor;
  const FitResult fit = runFit(options, false, monitor);
  const std::string bytes = fitToO3d(fit, monitor);
  const OptimisedShape shape = readOptimisedShape(files().write("box.o3d", bytes));
  EXPECT_EQ(shape.rational.top, fit.rational.top);
  EXPECT_EQ(shape.rational.bottom, fit.rational.bottom);
  EXPECT_NEAR(shape.rational.logScale, fit.rational.logScale, 1e-12 * std::max(1.0, std::abs(fit.rational.logScale)));
  EXPECT_EQ(shape.resolutions, (std::array<int, 3>{33, 33, 33}));
  for (std::size_t axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(shape.centre[axis], 0, 1e-6);
    EXPECT_NEAR(shape.lengths[axis], 1.2, 1e-6) << "fractal space";
  }
  // Its last three fields: the fractal's, the distance, and the potential, x fastest.
  constexpr std::size_t kCells = 33 * 33 * 33, kHead = 3 * 4 + 6 * 8, kField = kHead + 8 * kCells;
  const auto field = [&](std::size_t which) {
    std::vector<double> values(kCells);
    std::memcpy(values.data(), bytes.data() + bytes.size() - (3 - which) * kField + kHead, 8 * kCells);
    return values;
  };
  const std::vector<double> fractal = field(0), distance = field(1), potential = field(2);
  const double cell = 1.2 / 33;
  std::vector<julia::FitCell> cells;
  for (int z = 0; z < 33; ++z)
    for (int y = 0; y < 33; ++y)
      for (int x = 0; x < 33; ++x) cells.push_back({{(x - 16) * cell, (y - 16) * cell, (z - 16) * cell}});
  const std::vector<double> l = logModuli(fit.rational, cells);
  for (std::size_t i = 0; i < kCells; ++i) {
    const julia::Point& p = cells[i].x;
    // The box is 1 by 1/2 by 1/4 there.
    const double outside = std::max({std::abs(p[0]) - 0.5, std::abs(p[1]) - 0.25, std::abs(p[2]) - 0.125});
    if (std::abs(outside) > cell) {
      ASSERT_EQ(distance[i] < 0, outside < 0) << p[0] << ' ' << p[1] << ' ' << p[2];
    }
    if (std::isfinite(l[i])) {
      ASSERT_NEAR(fractal[i], l[i], 1e-3 * std::max(1.0, std::abs(l[i])));
    }
    // A conductor has one potential; outside, it lies between those of the balls in and around the box. Next to the
    // surface, single panels show.
    if (outside < -cell) {
      ASSERT_NEAR(potential[i], 1, 0.02);
    } else if (const double far = std::hypot(p[0], p[1], p[2]); outside > cell) {
      ASSERT_GT(potential[i], 0.125 / far);
      ASSERT_LT(potential[i], std::min(1.0, std::hypot(0.5, 0.25, 0.125) / far));
    }
  }
}

TEST(FitJob, InterruptionIsAllThatItThrows) {
  for (Recipe recipe : {Recipe{}, Recipe{{"start", "monopoles"}}, Recipe{{"schedule", "9(VFR)"}}}) {
    recipe.merge(Recipe{{"roots", "10"}, {"resolution", "21"}, {"weights", "layers"}});
    const Job job = files().dumbbell(recipe);
    Interrupting never(std::numeric_limits<std::int64_t>::max());
    job.run(true, never);
    ASSERT_GT(never.asked(), 20);
    for (const double share : {0.0, 0.1, 0.3, 0.6, 0.8, 0.95}) {
      Interrupting monitor(1 + static_cast<std::int64_t>(share * static_cast<double>(never.asked())));
      SCOPED_TRACE(share);
      EXPECT_THROW(job.run(true, monitor), Interrupted);
    }
  }
}

// Promise: "the same for a target of any ..."
TEST(FitJob, SizeAndPlaceDoNotMatter) {
  const Mesh shape =
      test_meshes::merged(test_meshes::makeSphere(0.8, 3), test_meshes::makeBox({0.1, 0.2, -0.3}, {1.2, 0.7, 0.4}));
  const auto fitted = [&](double scale, const Vec3d& shift) {
    const Mesh moved = test_meshes::transformed(shape, scale, shift);
    const FitResult fit = Job(files().mesh("moved.obj", moved), {{"roots", "12"}}).run();
    const RationalFile file = rationalFileFromJson(bytesOf(fit), "x");
    EXPECT_EQ(file.rational, fit.rational);
    EXPECT_TRUE(file.target);
    // The box that it brings back is the mesh's, and the roots lie about it.
    const openvdb::BBoxd box = reportMesh(moved).box;
    for (int axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(file.target->box.min()[axis], box.min()[axis], 0.02 * scale);
      EXPECT_NEAR(file.target->box.max()[axis], box.max()[axis], 0.02 * scale);
    }
    openvdb::BBoxd room = box;
    room.expand(scale);
    for (const julia::Root& root : file.rational.top.roots)
      EXPECT_TRUE(room.isInside(file.target->space.toWorld({root.position.a, root.position.b, root.position.c})));
    return fit;
  };
  // The last bits differ, and with them a choice among roots that serve as well; what they are worth stays.
  const FitResult here = fitted(1, Vec3d(0));
  const Vec3d shift(100, -200, 50);
  const FitResult there = fitted(1000, shift);
  EXPECT_NEAR(there.measure.iou, here.measure.iou, 0.03);
  EXPECT_NEAR(there.target.space.scale / here.target.space.scale, 1000, 1e-2);
  EXPECT_NEAR((there.target.space.centre - (here.target.space.centre * 1000.0 + shift)).length(), 0, 0.1);
  // Where there is nothing to choose, the shape is the same; any power of it serves.
  const auto ball = [](double radius, const Vec3d& centre) {
    const std::string mesh = files().mesh("moved.obj", test_meshes::makeSphere(radius, 4, centre));
    return Job(mesh, {{"roots", "1"}}).run().rational;
  };
  const julia::Rational small = ball(1, Vec3d(0)), large = ball(1000, shift);
  ASSERT_EQ(small.top.roots.size(), 1u);
  ASSERT_EQ(large.top.roots.size(), 1u);
  EXPECT_EQ(large.top.roots[0].position, small.top.roots[0].position);
  EXPECT_NEAR(large.logScale / large.top.roots[0].power, small.logScale / small.top.roots[0].power, 1e-3);
}

TEST(FitJob, AMapWithoutInsideIsNoResult) {
  Recipe recipe = kScheduleRecipe;
  recipe["weights"] = "distance";
  try {
    const FitResult fit = files().dumbbell(recipe).run();
    EXPECT_GT(fit.measure.iou, 0);
  } catch (const DataError& error) {
    EXPECT_NE(std::string(error.what()).find("by layers"), std::string::npos) << error.what();
  }
}

TEST(FitJob, RefusesATargetWithoutInside) {
  Mesh plane;
  plane.points = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  plane.triangles = {{0, 1, 2}, {0, 2, 3}};
  EXPECT_THROW(Job(files().mesh("plane.obj", plane), {}).run(), DataError);
  EXPECT_THROW(Job("nowhere.obj", {}).run(), MissingInputError);
}

}  // namespace
