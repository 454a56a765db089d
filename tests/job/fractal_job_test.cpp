// SPDX-License-Identifier: Apache-2.0
// The main job against programs written independently of it, and under changes that must not matter.
#include "support/mesh_laws.h"
#include "support/temporary_folder.h"
#include "support/test_fields.h"
#include "support/test_meshes.h"

#include "vdbtools/formats/peer_formats.h"
#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/formats/versor_file.h"
#include "vdbtools/job/fractal_job.h"
#include "vdbtools/mesh_files/mesh_writer.h"
#include "vdbtools/records/recorded_recipe.h"

#include <gtest/gtest.h>

#include <tbb/parallel_for.h>

#include <filesystem>
#include <fstream>
#include <mutex>
#include <sstream>

namespace {

using namespace vdbtools;
using openvdb::Coord;
using openvdb::CoordBBox;
using openvdb::Vec3d;

class FractalJob : public testing::Test {
 protected:
  FractalJob() { openvdb::initialize(); }

  std::string write(const std::string& name, const std::string& bytes) const {
    const std::string path = mFolder / name;
    std::ofstream(path, std::ios::binary) << bytes;
    return path;
  }
  std::string writeObj(const std::string& name, const Mesh& mesh) const {
    std::ostringstream stream;
    writeMesh(stream, mesh, {.format = &meshFormat(".obj")});
    return write(name, stream.str());
  }
  Scene scene(const Recipe& recipe) {
    return makeScene(parseFractalOptions(completeRecipe(recipe, fractalOptionTable())), mMonitor);
  }
  Mesh mesh(const Recipe& recipe) { return fractalMesh(scene(recipe), mMonitor); }

  const TemporaryFolder mTemporary;
  const std::filesystem::path mFolder = mTemporary.path();
  Monitor mMonitor;
};

std::map<mesh_laws::OnEdge, double> byEdge(const Mesh& mesh, double voxelSize) {
  std::map<mesh_laws::OnEdge, double> result;
  for (const Vec3d& p : mesh.points) {
    const mesh_laws::OnEdge edge = mesh_laws::onEdge(p, voxelSize);
    EXPECT_GE(edge.axis, 0) << p << " lies on no lattice edge";
    result[edge] = edge.t;
  }
  return result;
}

// What the released program of [SK23] does, said again from its description: phi from a box of nodes, its faces' values
// beyond; f = exp(alpha (phi - beta)) p/|p|; at most n steps; bisection along each crossing edge.
class Independent {
 public:
  Independent(CoordBBox box, double sdfVoxel, double alpha, double beta, julia::Rational versor)
      : mBox(box), mSdfVoxel(sdfVoxel) {
    mMap = julia::reference::shapeModulus<double>(
        [=, this](const julia::Quaternion<double>& q) { return alpha * (phi(Vec3d(q.a, q.b, q.c)) - beta); }, versor);
  }

  double field(const Vec3d& x) const {
    return julia::reference::orbit<double>(mMap, {x[0], x[1], x[2], 0.0}, 3, 20.0).logModulus;
  }

  std::map<mesh_laws::OnEdge, double> vertices(double h) const {
    const Coord low = Coord::ceil(mBox.min().asVec3d() * mSdfVoxel / h);
    const Coord high = Coord::floor(mBox.max().asVec3d() * mSdfVoxel / h);
    const CoordBBox nodes(low, high);
    std::map<mesh_laws::OnEdge, double> found;
    std::mutex mutex;
    tbb::parallel_for(low[0], high[0] + 1, [&](int x) {
      std::map<mesh_laws::OnEdge, double> mine;
      for (int y = low[1]; y <= high[1]; ++y)
        for (int z = low[2]; z <= high[2]; ++z) {
          const Coord node(x, y, z);
          const bool inside = field(node.asVec3d() * h) < 0;
          for (int axis = 0; axis < 3; ++axis) {
            Coord end = node;
            ++end[axis];
            if (!nodes.isInside(end) || (field(end.asVec3d() * h) < 0) == inside) continue;
            double a = 0, b = 1;
            while (b - a > 1e-9) {
              Vec3d at = node.asVec3d();
              at[axis] += (a + b) / 2;
              ((field(at * h) < 0) == inside ? a : b) = (a + b) / 2;
            }
            mine[{node, axis}] = (a + b) / 2;
          }
        }
      const std::lock_guard lock(mutex);
      found.merge(mine);
    });
    return found;
  }

 private:
  double phi(Vec3d x) const {
    for (int axis = 0; axis < 3; ++axis)
      x[axis] = std::clamp(x[axis], mBox.min()[axis] * mSdfVoxel, mBox.max()[axis] * mSdfVoxel);
    return test_fields::trilinear(test_fields::lumpy, mSdfVoxel, x);
  }

  CoordBBox mBox;
  double mSdfVoxel;
  julia::reference::MapFunction<double> mMap;
};

// Promise: "Tests compare everything fast ..."
TEST_F(FractalJob, AgreesWithAnIndependentMarchingCubes) {
  const CoordBBox box(Coord(-32), Coord(32));
  const double sdfVoxel = 1.0 / 64;
  const std::string input =
      write("sdf.vdb", encodeVdb({test_fields::denseGrid(test_fields::lumpy, sdfVoxel, box)}, {}));
  for (const double alpha : {12.0, 40.0}) {
    const julia::Rational versor = test_fields::randomVersor(static_cast<unsigned>(alpha), 10, 11, true);
    const std::string p4d = write("p.p4d", rationalToP4d(versor.top));
    const Mesh made = mesh({{"input", input},
                            {"texture", p4d},
                            {"space", "world"},
                            {"alpha", std::to_string(alpha)},
                            {"beta", "0.01"},
                            {"precision", "double"},
                            {"crumbs", "keep"},
                            {"voxel-size", "0.0121"}});
    const auto ours = byEdge(made, 0.0121);
    const auto theirs = Independent(box, sdfVoxel, alpha, 0.01, versor).vertices(0.0121);
    ASSERT_GT(theirs.size(), 5000u);
    EXPECT_EQ(ours.size(), theirs.size()) << "alpha " << alpha;
    // An edge may hold several changes of sign, and each of them is right: near our vertex the independent F must
    // change its sign, and mostly it is the vertex that bisection finds.
    const Independent independent(box, sdfVoxel, alpha, 0.01, versor);
    const auto changesNear = [&](const mesh_laws::OnEdge& edge, double t) {
      const auto at = [&](double along) {
        Vec3d node = edge.node.asVec3d();
        node[edge.axis] += along;
        return independent.field(node * 0.0121) < 0;
      };
      // In small steps, for two changes may lie close together.
      constexpr int kSteps = 64;
      const bool first = at(t - 1.0 / 500);
      for (int k = 1; k <= kSteps; ++k)
        if (at(t + (2.0 * k / kSteps - 1) / 500) != first) return true;
      return false;
    };
    std::size_t wrong = 0, elsewhere = 0;
    std::size_t missing = 0;
    for (const auto& [edge, t] : theirs) {
      const auto found = ours.find(edge);
      if (found == ours.end())
        ++missing;
      else if (std::abs(found->second - t) >= 1.0 / 500) {
        ++elsewhere;
        wrong += changesNear(edge, found->second) ? 0 : 1;
      }
    }
    EXPECT_EQ(missing, 0u) << "alpha " << alpha;
    EXPECT_EQ(wrong, 0u) << "alpha " << alpha;
    EXPECT_LT(elsewhere, theirs.size() / 20) << "alpha " << alpha;
  }
}

// Promise: "the same for a target of any ..."
TEST_F(FractalJob, SizeAndPlaceDoNotMatter) {
  // A shape without symmetry; the shift is a multiple of both voxel sizes, so that nodes fall on the same places.
  const Mesh shape = test_meshes::merged(test_meshes::makeSphere(0.8, 3),
                                         test_meshes::makeBox(Vec3d(0.1, 0.2, -0.3), Vec3d(1.2, 0.7, 0.4)));
  const double extent = 2.0, factor = 1000;
  const Vec3d shift(1e5, -1e5, 2e5);
  ASSERT_NEAR(reportMesh(shape).box.extents()[0], extent, 1e-2);
  const auto run = [&](const std::string& name, double scale, const Vec3d& by) {
    return mesh({{"input", writeObj(name, test_meshes::transformed(shape, scale, by))},
                 {"alpha", "25"},
                 {"texture-seed", "4"},
                 {"voxel-size", std::to_string(0.04 * scale)},
                 {"sdf-voxel-size", std::to_string(0.04 * scale)}});
  };
  const auto near = byEdge(run("near.obj", 1, Vec3d(0)), 0.04);
  const auto far = byEdge(run("far.obj", factor, shift), 0.04 * factor);
  const Coord nodes = Coord::round(shift / (0.04 * factor));
  ASSERT_GT(near.size(), 3000u);
  std::size_t same = 0, moved = 0;
  for (const auto& [edge, t] : near) {
    const auto found = far.find({edge.node + nodes, edge.axis});
    if (found == far.end()) continue;
    ++same;
    moved += std::abs(found->second - t) > 0.01;
  }
  // The files hold the shapes to different last bits, and a chaotic map makes those seen here and there.
  EXPECT_GT(static_cast<double>(same), 0.999 * static_cast<double>(near.size()));
  EXPECT_LT(static_cast<double>(far.size()), 1.001 * static_cast<double>(near.size()));
  EXPECT_LT(static_cast<double>(moved), 0.005 * static_cast<double>(near.size()));
}

// Promise: A larger alpha is nearer ...
TEST_F(FractalJob, AlphaThinsTheShellAndBetaMovesIt) {
  const std::string input = writeObj("ball.obj", test_meshes::makeSphere(1, 4));
  const double target = 4 * M_PI / 3;
  const auto volume = [&](const char* alpha, const char* beta) {
    return mesh_laws::volume(
        mesh({{"input", input}, {"alpha", alpha}, {"beta", beta}, {"resolution", "50"}, {"sdf-resolution", "60"}}));
  };
  double last = 1e9;
  for (const char* alpha : {"10", "40", "100", "300"}) {
    const double error = std::abs(volume(alpha, "0") - target);
    EXPECT_LT(error, last) << alpha;
    last = error;
  }
  // At 300 the shell, ln(20)/300 of the longest side, is thinner than a voxel.
  EXPECT_LT(last, 0.03 * target);
  EXPECT_LT(volume("40", "-0.05"), volume("40", "0"));
  EXPECT_LT(volume("40", "0"), volume("40", "0.05"));
}

// Promise: Floats and doubles give the same ...
TEST_F(FractalJob, FloatIsNearDouble) {
  const std::string input = writeObj("ball.obj", test_meshes::makeSphere(1, 4));
  const Recipe recipe{
      {"input", input}, {"alpha", "40"}, {"resolution", "60"}, {"sdf-resolution", "60"}, {"texture-integer", "true"}};
  Recipe asFloat = recipe;
  asFloat["precision"] = "float";
  const Scene scene = this->scene(recipe);
  const auto inDouble = byEdge(mesh(recipe), scene.voxelSize), inFloat = byEdge(mesh(asFloat), scene.voxelSize);
  std::size_t same = 0;
  for (const auto& [edge, t] : inDouble) {
    const auto found = inFloat.find(edge);
    same += found != inFloat.end() && std::abs(found->second - t) < 0.01;
  }
  EXPECT_GT(static_cast<double>(same), 0.9999 * static_cast<double>(inDouble.size()));
}

// Promise: A run from the recipe in a VDB, PLY, OBJ ...
TEST_F(FractalJob, TheRecipeMakesTheSameBytes) {
  const std::string input = writeObj("ball.obj", test_meshes::makeSphere(1, 3));
  const Recipe recipe{{"input", input},
                      {"resolution", "30"},
                      {"sdf-resolution", "40"},
                      {"grids", "surface,density,logmodulus,iterations,versor"}};
  const auto bytes = [&](const Recipe& what) {
    const Recipe complete = completeRecipe(what, fractalOptionTable());
    const Scene scene = makeScene(parseFractalOptions(complete), mMonitor);
    const VdbWriteOptions options{.metadata = sceneMetadata(scene, complete)};
    return encodeVdb(runFractal(scene, planFractal(scene, {.grids = true}), nullptr, mMonitor).grids, options);
  };
  const std::string first = bytes(recipe);
  const auto [command, again] = readRecordedRecipe(write("out.vdb", first));
  EXPECT_EQ(command, "fractal");
  Recipe expected = completeRecipe(recipe, fractalOptionTable());
  Recipe options = again;
  options.erase("source-sha256");
  EXPECT_EQ(options, expected);
  EXPECT_EQ(bytes(again), first.substr(0)) << "the recipe of a file made another file";
  // Another target under the same name is found out.
  writeObj("ball.obj", test_meshes::makeSphere(1.01, 3));
  EXPECT_THROW(bytes(again), DataError);
}

// Promise: Nothing that is written is infinite ...
TEST_F(FractalJob, NothingInfiniteReachesAGrid) {
  // Roots on nodes, where a rational is 0 or infinite; huge powers; the same roots above and below.
  julia::Rational rational;
  for (int k = 0; k < 6; ++k) {
    rational.top.roots.push_back({{0.1 * k, 0, 0, 0}, 1000});
    rational.bottom.roots.push_back({{0.1 * k, 0.1 * (k % 2), 0, 0}, k % 3 ? 1000.0 : 77.5});
  }
  const std::string versor = write("r.json", rationalToJson(rational));
  const Scene scene = this->scene({{"map", "rational"},
                                   {"texture", versor},
                                   {"voxel-size", "0.05"},
                                   {"box", "-1,-1,-1,1,1,1"},
                                   {"grids", "surface,density,logmodulus,iterations,versor"}});
  for (const auto& grid : runFractal(scene, planFractal(scene, {.grids = true}), nullptr, mMonitor).grids) {
    SCOPED_TRACE(grid->getName());
    if (const auto floats = openvdb::gridPtrCast<openvdb::FloatGrid>(grid)) {
      for (auto value = floats->cbeginValueAll(); value; ++value) ASSERT_TRUE(std::isfinite(*value));
    } else {
      const auto vectors = openvdb::gridPtrCast<openvdb::Vec3SGrid>(grid);
      ASSERT_TRUE(vectors);
      for (auto value = vectors->cbeginValueAll(); value; ++value) ASSERT_TRUE(value->isFinite());
    }
  }
}

}  // namespace
