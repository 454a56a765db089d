// SPDX-License-Identifier: Apache-2.0
// What meshes and grids carry: the values are those of the slow evaluator, and the colours those of the renderer.
#include "job/point_attributes.h"
#include "render/field_shading.h"
#include "scene/scene_colouring.h"
#include "support/temporary_folder.h"
#include "support/test_fields.h"
#include "support/test_meshes.h"

#include "mesh_files/mesh_file.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/formats/peer_formats.h"
#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/formats/versor_file.h"
#include "vdbtools/job/fractal_job.h"
#include "vdbtools/picture/image.h"
#include "vdbtools/scene/scene.h"

#include <gtest/gtest.h>

#include <openvdb/math/Proximity.h>
#include <openvdb/tools/Interpolation.h>

#include <tbb/global_control.h>

#include <limits>
#include <sstream>

namespace {

using namespace vdbtools;
using openvdb::Coord;
using openvdb::CoordBBox;
using openvdb::Vec3d;
using openvdb::Vec3s;

/// A mesh and the rows of its points.
struct Attributed {
  std::vector<VertexColumn> columns;
  Mesh mesh;
  std::vector<float> rows;

  /// The values of a column, as many as it has components.
  const float* at(const std::string& name, std::size_t point) const {
    std::size_t offset = 0;
    for (const VertexColumn& column : columns) {
      if (column.name == name) return &rows[point * rowLength(columns) + offset];
      offset += componentsOf(column.kind);
    }
    throw std::logic_error(name);
  }
};

class PointAttributesTest : public testing::Test {
 protected:
  PointAttributesTest() {
    openvdb::initialize();
    std::ostringstream stream;
    writeMesh(stream,
              test_meshes::merged(test_meshes::transformed(test_meshes::makeSphere(1, 3), 1, Vec3d(0.31, -0.17, 0.23)),
                                  test_meshes::makeBox(Vec3d(0.9, -0.4, 0.1), Vec3d(2.1, -0.1, 0.35))),
              {.format = &meshFormat(".obj")});
    mShape = write("shape.obj", stream.str());
  }

  std::string write(const std::string& name, const std::string& bytes) const {
    return mFolder.write(name, bytes).string();
  }
  static Recipe completed(const Recipe& recipe) { return completeRecipe(recipe, fractalOptionTable()); }
  Recipe shape(const Recipe& others) const {
    Recipe recipe = {{"input", mShape}, {"sdf-resolution", "40"}, {"resolution", "36"}};
    for (const auto& [name, value] : others) recipe[name] = value;
    return completed(recipe);
  }
  Scene scene(const Recipe& recipe) { return makeScene(parseFractalOptions(completed(recipe)), mMonitor); }
  Attributed made(const Scene& scene) {
    Attributed result{.columns = meshColumns(scene.options.output.attributes)};
    MeshCollector collector(result.mesh, &result.rows);
    runFractal(scene, planFractal(scene, {.mesh = true}), &collector, mMonitor);
    EXPECT_EQ(result.rows.size(), result.mesh.points.size() * rowLength(result.columns));
    return result;
  }
  std::string bytesOf(const Recipe& recipe, bool withGrids) {
    const std::filesystem::path vdbPath = mFolder.path() / "a.vdb", plyPath = mFolder.path() / "a.ply";
    AtomicFile vdb(vdbPath), ply(plyPath);
    FractalFiles files{.files = {{&ply, findFormat(".ply")}}};
    if (withGrids) files.files.push_back({&vdb, findFormat(".vdb")});
    writeFractal(makeScene(parseFractalOptions(recipe), mMonitor), recipe, files, mMonitor);
    ply.commit();
    return readWholeFile(plyPath);
  }

  TemporaryFolder mFolder;
  Monitor mMonitor;
  std::string mShape;
};

constexpr const char* kAll = "Cd,direction,trap,iterations,depth,tau,mask";

// Promise of attributes.md: Attributes of a vertex "do not depend on the grids"; those of a grid "are computed at the
//   voxels"
TEST_F(PointAttributesTest, ValuesAreThoseOfTheReference) {
  const CoordBBox box(Coord(-32), Coord(32));
  const double sdfVoxel = 1.0 / 64, alpha = 20, beta = 0.01, voxel = 0.03;
  const julia::Rational versor = test_fields::randomVersor(3, 6, 5, true);
  const std::string input =
      write("sdf.vdb", encodeVdb({test_fields::denseGrid(test_fields::lumpy, sdfVoxel, box)}, {}));
  const Attributed fractal = made(scene({{"input", input},
                                         {"texture", write("p.p4d", rationalToP4d(versor.top))},
                                         {"space", "world"},
                                         {"alpha", "20"},
                                         {"beta", "0.01"},
                                         {"precision", "double"},
                                         {"voxel-size", "0.03"},
                                         {"attributes", "direction,trap,iterations,depth"}}));
  const auto phi = [&](Vec3d x) {
    for (int axis = 0; axis < 3; ++axis) x[axis] = std::clamp(x[axis], -0.5, 0.5);
    return test_fields::trilinear(test_fields::lumpy, sdfVoxel, x);
  };
  using Quaternion = julia::Quaternion<double>;
  const auto map = julia::reference::shapeModulus<double>(
      [&](const Quaternion& q) { return alpha * (phi(Vec3d(q.a, q.b, q.c)) - beta); }, versor);
  constexpr int kSteps = 3;
  constexpr double kEscape = 20;
  ASSERT_GT(fractal.mesh.points.size(), 3000u);
  std::size_t otherTraps = 0, otherIterations = 0, sampled = 0;
  for (std::size_t i = 0; i < fractal.mesh.points.size(); ++i) {
    const Vec3d& x = fractal.mesh.points[i];
    EXPECT_NEAR(*fractal.at("depth", i), phi(x), 1e-6);
    Quaternion q{x[0], x[1], x[2], 0};
    const Quaternion first = map(q).value();
    const double length = julia::reference::norm(first);
    const float* direction = fractal.at("direction", i);
    EXPECT_NEAR(direction[0], first.a / length, 1e-5);
    EXPECT_NEAR(direction[1], first.b / length, 1e-5);
    EXPECT_NEAR(direction[2], first.c / length, 1e-5);
    double trap = std::numeric_limits<double>::infinity();
    for (int n = 0; n < kSteps && julia::reference::norm(q) < kEscape; ++n) {
      q = map(q).value();
      trap = std::min(trap, julia::reference::norm(q));
    }
    // A vertex lies where F changes its sign, so that a rounding may decide how many steps there are.
    otherTraps += std::abs(*fractal.at("trap", i) - trap) > 1e-4 * trap;
    if (i % 16 != 0) continue;
    double steps = 0, outside = 0;
    for (int n = 0; n < 27; ++n) {
      const Vec3d off(n / 9 - 1, n / 3 % 3 - 1, n % 3 - 1);
      if (n == 13) continue;
      const Vec3d at = x + voxel * off.unit();
      const auto orbit = julia::reference::orbit<double>(map, {at[0], at[1], at[2], 0.0}, kSteps, kEscape);
      if (orbit.logModulus < 0) continue;
      steps += orbit.iterations;
      ++outside;
    }
    otherIterations += std::abs(*fractal.at("iterations", i) - steps / std::max(1.0, outside)) > 1e-5;
    ++sampled;
  }
  EXPECT_LE(otherTraps, fractal.mesh.points.size() / 100);
  EXPECT_LE(otherIterations, sampled / 100);
}

// Promise: A picture of a file "has the same ..."
TEST_F(PointAttributesTest, ColoursAreTheRenderersAlbedo) {
  for (const std::string colour :
       {"direction", "versor", "trap:magma", "iterations:cividis", "depth:coolwarm", "clay", "gradient:inferno"}) {
    SCOPED_TRACE(colour);
    const Scene set = scene(shape({{"alpha", "20"}, {"colour", colour}}));
    const Attributed fractal = made(set);
    ASSERT_EQ(fractal.columns.size(), 1u);
    const FieldRenderOptions options = pictureOptions(set, pictureRegion(set), FieldPicture{});
    std::vector<FieldHit> hits;
    for (const Vec3d& point : fractal.mesh.points) {
      const julia::Point x = set.field.space.toFractal(point);
      hits.push_back({.inside = {x[0], x[1], x[2]},
                      .view = {0, 0, 1},
                      .step = set.voxelSize / set.field.space.scale,
                      .normal = Vec3d(0, 0, -1)});
    }
    const FieldAround around = fieldAround(*set.field.evaluator, hits);
    const std::vector<FieldPoint> seen =
        fieldPoints(*set.field.evaluator, options, hits, around.field, around.iterations);
    Vec3d low(1), high(0);
    for (std::size_t i = 0; i < hits.size(); ++i)
      for (int c = 0; c < 3; ++c) {
        const double value = fractal.at("Cd", i)[c];
        ASSERT_NEAR(value, seen[i].albedo.value_or(Material{}.albedo)[c], 1e-6) << i;
        low[c] = std::min(low[c], value);
        high[c] = std::max(high[c], value);
      }
    EXPECT_EQ((high - low).length() > 0.2, colour != "clay");
  }
}

// Promise: Attributes of a vertex "do ..."
TEST_F(PointAttributesTest, AStreamedMeshHasTheBytesOfAHeldOneForAnyNumberOfThreads) {
  const Recipe recipe = shape({{"attributes", kAll}, {"colour", "trap:inferno"}});
  std::string first;
  for (const int threads : {1, 2, 3}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
    for (const bool withGrids : {false, true}) {
      const std::string bytes = bytesOf(recipe, withGrids);
      if (first.empty()) first = bytes;
      EXPECT_TRUE(bytes == first) << threads << ' ' << withGrids;
    }
  }
  for (const char* property : {"uchar red", "float direction_x", "float trap", "float tau", "float mask"})
    EXPECT_NE(first.find(std::string("property ") + property + '\n'), std::string::npos) << property;
}

TEST_F(PointAttributesTest, AMadeFractalIsWrittenLikeOneThatIsMadeOnTheWay) {
  const Recipe recipe = shape({{"attributes", "Cd,depth"}});
  const Scene set = scene(recipe);
  const Attributed fractal = made(set);
  const FractalResult result = runFractal(set, planFractal(set, {.grids = true}), nullptr, mMonitor);
  const std::filesystem::path path = mFolder.path() / "made.ply";
  AtomicFile ply(path);
  writeMadeFractal(set, recipe, result, fractal.mesh, fractal.rows, {.files = {{&ply, findFormat(".ply")}}}, mMonitor);
  ply.commit();
  EXPECT_TRUE(readWholeFile(path) == bytesOf(recipe, false));
}

template <class Grid>
typename Grid::Ptr named(const FractalResult& result, const std::string& name) {
  for (const auto& grid : result.grids)
    if (grid->getName() == name) return openvdb::gridPtrCast<Grid>(grid);
  return nullptr;
}

// Promise: Attributes of a vertex "do ..."
TEST_F(PointAttributesTest, GridsHaveTheValuesOfTheirVoxels) {
  // Without "surface" the attributes still lie in its band.
  for (const std::string grids : {"surface", "logmodulus"}) {
    SCOPED_TRACE(grids);
    const Scene set = scene(shape({{"attributes", kAll}, {"grids", grids}}));
    const Attributed fractal = made(set);
    const FractalResult result = runFractal(set, planFractal(set, {.grids = true}), nullptr, mMonitor);
    EXPECT_EQ(result.grids.size(), 8u);
    const auto colour = named<openvdb::Vec3SGrid>(result, "Cd"),
               direction = named<openvdb::Vec3SGrid>(result, "direction");
    const auto depth = named<openvdb::FloatGrid>(result, "depth");
    ASSERT_TRUE(colour && direction && depth);
    EXPECT_EQ(colour->getVectorType(), openvdb::VEC_INVARIANT);
    EXPECT_EQ(colour->getGridClass(), openvdb::GRID_UNKNOWN);
    if (const auto surface = named<openvdb::FloatGrid>(result, "surface")) {
      EXPECT_TRUE(depth->tree().hasSameTopology(surface->tree()));
      EXPECT_EQ(direction->activeVoxelCount(), surface->activeVoxelCount());
    }
    const PointAttributes attributes(set);
    std::vector<float> row(attributes.rowLength());
    std::size_t count = 0;
    for (auto value = colour->cbeginValueOn(); value; ++value) {
      if (++count % 17 != 0) continue;
      const Vec3d world = colour->indexToWorld(value.getCoord());
      attributes.evaluate({&world, 1}, row);
      EXPECT_EQ(*value, Vec3s(row.data()));
      EXPECT_EQ(direction->tree().getValue(value.getCoord()), Vec3s(row.data() + 3));
      EXPECT_EQ(depth->tree().getValue(value.getCoord()), row[8]);
    }
    EXPECT_GT(count, 10000u);
    // The distance hardly bends within a voxel.
    const auto accessor = depth->getConstAccessor();
    for (std::size_t i = 0; i < fractal.mesh.points.size(); ++i)
      EXPECT_NEAR(openvdb::tools::BoxSampler::sample(accessor, depth->worldToIndex(fractal.mesh.points[i])),
                  *fractal.at("depth", i), 0.3 * set.voxelSize);
  }
}

TEST_F(PointAttributesTest, ThicknessAndMaskAreTheScenes) {
  const Scene set = scene(shape({{"attributes", "tau,mask"}, {"mask", "x:0.2:0.9"}}));
  const Attributed fractal = made(set);
  // The body is a ball of radius 1, the arm a box whose largest ball has a radius of 0.125.
  std::size_t body = 0, arm = 0;
  for (std::size_t i = 0; i < fractal.mesh.points.size(); ++i) {
    const Vec3d& x = fractal.mesh.points[i];
    EXPECT_NEAR(*fractal.at("mask", i), set.shellOptions().mask.at(x), 1e-6);
    const double tau = *fractal.at("tau", i);
    if (x[0] < -0.2) {
      EXPECT_NEAR(tau, 1, 0.2);
      ++body;
    }
    if (x[0] > 1.9) {
      EXPECT_NEAR(tau, 0.125, 0.06);
      ++arm;
    }
  }
  EXPECT_GT(body, 100u);
  EXPECT_GT(arm, 20u);
}

/// A cube of side 2 about 0 as OBJ: each face has texture coordinates of its own, with seams between them.
std::string cubeWithUvs() {
  const Mesh cube = test_meshes::makeCube(2);
  std::ostringstream text;
  text.precision(17);
  for (const Vec3d& p : cube.points) text << "v " << p[0] << ' ' << p[1] << ' ' << p[2] << '\n';
  int next = 1;
  for (const openvdb::Vec3I& t : cube.triangles) {
    const Vec3d normal = (cube.points[t[1]] - cube.points[t[0]]).cross(cube.points[t[2]] - cube.points[t[0]]);
    const int axis = std::abs(normal[0]) > 0.5 ? 0 : std::abs(normal[1]) > 0.5 ? 1 : 2;
    for (int k = 0; k < 3; ++k) {
      const Vec3d& p = cube.points[t[k]];
      text << "vt " << axis + (p[(axis + 1) % 3] + 1) / 4 << ' ' << (p[(axis + 2) % 3] + 1) / 2 << '\n';
    }
    text << "f " << t[0] + 1 << '/' << next << ' ' << t[1] + 1 << '/' << next + 1 << ' ' << t[2] + 1 << '/' << next + 2
         << '\n';
    next += 3;
  }
  return text.str();
}

// Promise of attributes.md: `--transfer` carries over what the target has "at its point nearest to the vertex"
TEST_F(PointAttributesTest, TextureCoordinatesAreThoseOfTheNearestPoint) {
  const Attributed fractal = made(scene({{"input", write("cube.obj", cubeWithUvs())},
                                         {"sdf-resolution", "40"},
                                         {"resolution", "40"},
                                         {"transfer", "uv"}}));
  std::size_t compared = 0;
  for (std::size_t i = 0; i < fractal.mesh.points.size(); ++i) {
    const Vec3d& x = fractal.mesh.points[i];
    // The nearest face; not where two of them are about as near.
    int axis = 0;
    for (int a = 1; a < 3; ++a)
      if (std::abs(x[a]) > std::abs(x[axis])) axis = a;
    bool clear = true;
    for (int a = 0; a < 3; ++a)
      clear = clear && (a == axis || std::abs(x[a]) < std::min(1.0, std::abs(x[axis])) - 1e-3);
    if (!clear) continue;
    const float* uv = fractal.at("uv", i);
    EXPECT_NEAR(uv[0], axis + (x[(axis + 1) % 3] + 1) / 4, 1e-5);
    EXPECT_NEAR(uv[1], (x[(axis + 2) % 3] + 1) / 2, 1e-5);
    ++compared;
  }
  EXPECT_GT(compared, fractal.mesh.points.size() / 2);
}

// Promise: `--transfer` carries over what ...
TEST_F(PointAttributesTest, PaintIsThatOfTheNearestPoint) {
  const Mesh ball = test_meshes::transformed(test_meshes::makeSphere(1, 2), 1, Vec3d(40, -3, 7));
  std::ostringstream text;
  text.precision(17);
  text << "ply\nformat ascii 1.0\nelement vertex " << ball.points.size()
       << "\nproperty double x\nproperty double y\nproperty double z\nproperty float wet\nproperty uchar red\n"
          "property uchar green\nproperty uchar blue\nelement face "
       << ball.triangles.size() << "\nproperty list uchar int vertex_indices\nend_header\n";
  for (const Vec3d& p : ball.points)
    text << p[0] << ' ' << p[1] << ' ' << p[2] << ' ' << 3 * p[1] - p[2] << " 188 0 255\n";
  for (const openvdb::Vec3I& t : ball.triangles) text << "3 " << t[0] << ' ' << t[1] << ' ' << t[2] << '\n';
  const Attributed fractal = made(scene({{"input", write("ball.ply", text.str())},
                                         {"sdf-resolution", "30"},
                                         {"resolution", "24"},
                                         {"transfer", "wet,Cd"}}));
  for (std::size_t i = 0; i < fractal.mesh.points.size(); ++i) {
    std::vector<std::pair<double, double>> candidates;  // the distance and the value of each triangle's nearest point
    for (const openvdb::Vec3I& t : ball.triangles) {
      Vec3d weights;
      const Vec3d point = openvdb::math::closestPointOnTriangleToPoint(
          ball.points[t[0]], ball.points[t[1]], ball.points[t[2]], fractal.mesh.points[i], weights);
      candidates.emplace_back((point - fractal.mesh.points[i]).length(), 3 * point[1] - point[2]);
    }
    // Inside a ball several triangles may be equally near.
    const double least = std::min_element(candidates.begin(), candidates.end())->first;
    double miss = std::numeric_limits<double>::infinity();
    for (const auto& [distance, value] : candidates)
      if (distance < least + 1e-4) miss = std::min(miss, std::abs(*fractal.at("wet", i) - value));
    EXPECT_LT(miss, 1e-4);
    EXPECT_NEAR(fractal.at("Cd", i)[0], 0.5029, 1e-3);  // the code 188 as linear light
    EXPECT_NEAR(fractal.at("Cd", i)[1], 0, 1e-6);
    EXPECT_NEAR(fractal.at("Cd", i)[2], 1, 1e-6);
  }
}

// Promise: `--colour` "adds `Cd` to the attributes"; "The name ..."
TEST_F(PointAttributesTest, APictureIsAGradientAndItsHashIsRecorded) {
  Image row(3, 2);
  row.at(0, 0) = {1, 0, 0};
  row.at(1, 0) = {0, 1, 0};
  row.at(2, 0) = {0, 0, 1};
  const std::string picture = write("ramp.png", encodeImage(row, "png"));
  const FractalOptions options = parseFractalOptions(shape({{"colour", "trap:" + picture}}));
  const FieldColouring colouring = colouringOf(options.output.attributes.colour.value());
  EXPECT_EQ(colouring.gradient.at(0), Vec3d(1, 0, 0));
  EXPECT_EQ(colouring.gradient.at(0.5), Vec3d(0, 1, 0));
  EXPECT_EQ(colouring.gradient.at(1), Vec3d(0, 0, 1));
  const Scene set = makeScene(options, mMonitor);
  EXPECT_EQ(set.metadata.at("julia_colour_sha256").size(), 64u);
  EXPECT_THROW(scene(shape({{"colour", "trap:" + picture}, {"colour-sha256", std::string(64, '0')}})), DataError);
  EXPECT_THROW(made(scene(shape({{"colour", "trap:none.png"}}))), MissingInputError);
}

// Promise of attributes.md: "pictures, meshes, VDBs, tiles and boxes of one recipe have the same colours at any
//   resolution"
TEST_F(PointAttributesTest, TheRangeOfAGradientDependsOnTheMapAlone) {
  const auto range = [&](const Recipe& recipe, const std::string& colour) {
    Recipe coloured = recipe;
    coloured["colour"] = colour;
    const Scene set = scene(coloured);
    return sceneColouring(set, set.options.output.attributes.colour.value()).range;
  };
  const Recipe bulb = {{"map", "mandelbulb"}, {"resolution", "20"}};
  for (const char* colour : {"trap", "iterations", "depth"}) {
    SCOPED_TRACE(colour);
    const std::optional<GradientRange> usual = range(shape({{"detail", "0.3"}}), colour);
    ASSERT_TRUE(usual);
    EXPECT_LT(usual->low, usual->high);
    for (const auto& [name, value] :
         {std::pair("resolution", "20"), std::pair("precision", "float"), std::pair("box", "0,-1,-1,1,1,1"),
          std::pair("tolerance", "0.3"), std::pair("crumbs", "keep")})
      EXPECT_EQ(range(shape({{"detail", "0.3"}, {name, value}}), colour), usual) << name;
    EXPECT_NE(range(shape({{"detail", "0.6"}}), colour), usual) << "the numbers of another set are others";
    EXPECT_EQ(range(shape({}), colour + std::string(":-2:7.5")), (GradientRange{-2, 7.5}));
  }
  const std::optional<GradientRange> whole = range(bulb, "trap");
  ASSERT_TRUE(whole);
  Recipe part = bulb;
  part["box"] = "0,0,0,1,1,1";
  EXPECT_EQ(range(part, "trap"), whole);
  EXPECT_FALSE(range(bulb, "direction"));
}

TEST_F(PointAttributesTest, AGradientIsSpreadOverTheNumbersOfTheSurface) {
  const Scene set = scene(shape({{"attributes", "trap"}}));
  const GradientRange range = sceneColouring(set, {.by = FieldColour::Trap}).range.value();
  const Attributed fractal = made(set);
  double within = 0, lowest = 1, highest = 0;
  for (std::size_t i = 0; i < fractal.mesh.points.size(); ++i) {
    const double trap = *fractal.at("trap", i);
    within += trap >= range.low && trap <= range.high ? 1 : 0;
    lowest = std::min(lowest, trap), highest = std::max(highest, trap);
  }
  // The places of the sample are others than the vertices, and no vertex lies on the surface but near it.
  EXPECT_GT(within / static_cast<double>(fractal.mesh.points.size()), 0.75) << "most vertices are within the range";
  EXPECT_GT(range.low, lowest - 0.02) << "the range is no wider than the numbers";
  EXPECT_LT(range.high, highest + 0.02);
}

// Promise of attributes.md: `--colour` "adds `Cd` to the attributes"; "The name of a picture takes the picture's first
//   row"
TEST_F(PointAttributesTest, ColourAloneMeansCd) {
  const auto columns = [&](const Recipe& recipe) {
    return meshColumns(parseFractalOptions(shape(recipe)).output.attributes);
  };
  EXPECT_TRUE(columns({}).empty());
  const auto names = [&](const Recipe& recipe) {
    std::string list;
    for (const VertexColumn& column : columns(recipe)) list += column.name + ' ';
    return list;
  };
  EXPECT_EQ(names({{"colour", "clay"}}), "Cd ");
  EXPECT_EQ(names({{"colour", "clay"}, {"attributes", "trap"}}), "Cd trap ");
  EXPECT_EQ(names({{"colour", "clay"}, {"attributes", "trap,Cd"}}), "trap Cd ");
  EXPECT_EQ(names({{"colour", "clay"}, {"transfer", "Cd"}}), "Cd ");
}

// Promise of attributes.md: "`depth` and `tau` need a target, and `mask` needs a map that has the option"
TEST_F(PointAttributesTest, RefusesWhatCannotBe) {
  const auto refusal = [&](const Recipe& recipe) -> std::string {
    try {
      parseFractalOptions(completed(recipe));
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  const Recipe bulb = {{"map", "mandelbulb"}};
  const auto with = [](Recipe recipe, const std::string& name, const std::string& value) {
    recipe[name] = value;
    return recipe;
  };
  const Recipe target = {{"input", "a.obj"}};
  for (const auto& [recipe, said] : std::initializer_list<std::pair<Recipe, std::string>>{
           {with(target, "attributes", "colour"), "a list of Cd"},
           {with(target, "attributes", "trap,trap"), "twice"},
           {with(target, "attributes", ""), "a list of Cd"},
           {with(bulb, "attributes", "depth"), "'depth', as there is no target"},
           {with(bulb, "attributes", "Cd,tau"), "'tau', as there is no target"},
           {with(bulb, "attributes", "mask"), "--mask"},
           {with(bulb, "transfer", "uv"), "no target"},
           {with(bulb, "colour", "depth:grey"), "no target"},
           {with(target, "colour", "pink"), "trap:magma"},
           {with(target, "colour", "gradient"), "trap:magma"},
           {with(target, "colour", "clay:magma"), "colours of its own"},
           {with(target, "colour", "trap:jet"), "viridis"},
           {with(target, "transfer", "uv,uv"), "twice"},
           {with(target, "transfer", "surface"), "--grids"},
           {with(target, "transfer", "nx"), "'nx' twice"},
           {with(with(target, "attributes", "Cd"), "transfer", "red"), "'red' twice"},
           {with(with(target, "attributes", "iterations"), "grids", "iterations"), "--grids"}})
    EXPECT_NE(refusal(recipe).find(said), std::string::npos) << refusal(recipe);
  // What only the target can tell.
  EXPECT_THROW(scene(shape({{"transfer", "uv"}})), DataError);
  EXPECT_THROW(scene(shape({{"transfer", "wet"}})), DataError);
  EXPECT_THROW(scene(shape({{"transfer", "Cd"}})), DataError);
  const std::string sdf = write("sdf.vdb", encodeVdb({test_fields::bandGrid(test_fields::lumpy, 0.05, 0.2)}, {}));
  EXPECT_THROW(scene({{"input", sdf}, {"transfer", "uv"}, {"resolution", "20"}}), DataError);
}

}  // namespace
