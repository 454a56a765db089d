// SPDX-License-Identifier: Apache-2.0
// Controls from what is painted on a mesh, from pictures, from other meshes and from formulas, against slow references.
#include "support/temporary_folder.h"
#include "support/test_controls.h"
#include "support/test_meshes.h"

#include "control/control_lattice.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/control/control.h"
#include "vdbtools/distance/mesh_to_sdf.h"
#include "vdbtools/picture/image.h"

#include <openvdb/math/Proximity.h>
#include <tbb/global_control.h>

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>
#include <sstream>

namespace {

using namespace test_meshes;
using namespace vdbtools;
using openvdb::BBoxd;
using openvdb::FloatGrid;
using openvdb::Vec2s;
using test_controls::source;

Mesh painted(Mesh mesh, const std::string& name, const std::function<double(const Vec3d&)>& paint) {
  VertexAttribute attribute{name, {}};
  for (const Vec3d& point : mesh.points) attribute.values.push_back(static_cast<float>(paint(point)));
  mesh.attributes.push_back(std::move(attribute));
  return mesh;
}

ControlContext contextOf(const Mesh& mesh) {
  return {.targetBox = reportMesh(mesh).box, .mesh = std::make_shared<const Mesh>(mesh)};
}

/// With the distances as well.
ControlContext targetOf(const Mesh& mesh, double voxel) {
  openvdb::initialize();
  ControlContext context = contextOf(mesh);
  Monitor monitor;
  context.phi = meshToSdf(
      mesh, {.voxelSize = voxel, .exteriorBandWidth = 4, .interiorBandWidth = std::numeric_limits<double>::infinity()},
      monitor);
  const Vec3d sides = context.targetBox.extents();
  context.space = {context.targetBox.getCenter(), std::max({sides[0], sides[1], sides[2]})};
  return context;
}

std::string plyOf(const Mesh& mesh) {
  std::ostringstream text;
  text.precision(17);
  text << "ply\nformat ascii 1.0\nelement vertex " << mesh.points.size()
       << "\nproperty double x\nproperty double y\nproperty double z\n";
  for (const VertexAttribute& attribute : mesh.attributes) text << "property float " << attribute.name << "\n";
  text << "element face " << mesh.triangles.size() << "\nproperty list uchar int vertex_indices\nend_header\n";
  for (std::size_t p = 0; p < mesh.points.size(); ++p) {
    text << mesh.points[p][0] << ' ' << mesh.points[p][1] << ' ' << mesh.points[p][2];
    for (const VertexAttribute& attribute : mesh.attributes) text << ' ' << attribute.values[p];
    text << "\n";
  }
  for (const Vec3I& t : mesh.triangles) text << "3 " << t[0] << ' ' << t[1] << ' ' << t[2] << "\n";
  return text.str();
}

struct Nearest {
  double distance = std::numeric_limits<double>::infinity();
  double value = 0;  ///< of the mesh's first attribute, if it has one
};

Nearest nearestByHand(const Mesh& mesh, const Vec3d& position) {
  Nearest best;
  for (const Vec3I& t : mesh.triangles) {
    Vec3d w;
    const Vec3d point = openvdb::math::closestPointOnTriangleToPoint(mesh.points[t[0]], mesh.points[t[1]],
                                                                     mesh.points[t[2]], position, w);
    const double distance = (point - position).length();
    if (!(distance < best.distance)) continue;
    best.distance = distance;
    if (mesh.attributes.empty()) continue;
    const std::vector<float>& values = mesh.attributes[0].values;
    best.value = w[0] * values[t[0]] + w[1] * values[t[1]] + w[2] * values[t[2]];
  }
  return best;
}

std::vector<Vec3d> pointsIn(const BBoxd& box, int count, unsigned seed = 5) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> share(0, 1);
  std::vector<Vec3d> points;
  for (int i = 0; i < count; ++i) {
    const double x = share(random), y = share(random), z = share(random);
    points.push_back(box.min() + Vec3d(x, y, z) * box.extents());
  }
  return points;
}

/// A ball of radius 1 that is painted with a slope, which changes by 0.005 from node to node.
Mesh slopedBall() {
  return painted(makeSphere(1, 4), "wet", [](const Vec3d& p) { return 0.5 + 0.25 * p[0]; });
}
constexpr double kNodeStep = 0.005;

// ------------------------------------------------------------------------------------------------------------- paint

// Promise of controls.md: "At every place the value is that of the nearest point of the mesh", constant along the
//   normals
TEST(Painting, HasTheValueOfTheNearestPointOfTheMesh) {
  const Mesh ball = slopedBall();
  const Mesh half = withoutTriangles(ball, [](const Vec3d& p) { return p[1] > 0.3; });
  const Mesh soup = painted(makeSoup(makeSphere(1, 3), 0.01), "wet", [](const Vec3d& p) { return 0.5 + 0.25 * p[0]; });
  for (const Mesh* mesh : {&ball, &half, &soup}) {
    const Control control = source("paint:wet")->bind(contextOf(*mesh));
    for (const Vec3d& point : pointsIn(BBoxd(Vec3d(-1.1), Vec3d(1.1)), 400)) {
      // Near the ball's centre, and far from the rim of half of it, the nearest point jumps: there is no value.
      if (point.length() < 0.5 || (mesh == &half && point[1] > 0.2)) continue;
      EXPECT_NEAR(control.at(point), nearestByHand(*mesh, point).value, 4 * kNodeStep) << point;
    }
  }
}

// Promise: "At every place the value ..."
TEST(Painting, IsConstantAlongTheNormals) {
  const Control control = source("paint:wet:20:300")->bind(contextOf(slopedBall()));
  for (const Vec3d& at : pointsIn(BBoxd(Vec3d(-1), Vec3d(1)), 200)) {
    const Vec3d normal = at.unit();
    const double there = control.at(normal);
    for (const double height : {-0.3, -0.1, 0.05, 0.15})
      EXPECT_NEAR(control.at(normal * (1 + height)), there, 280 * kNodeStep) << normal << " at " << height;
  }
}

TEST(Painting, ScalesFromLowToHigh) {
  const ControlContext context = contextOf(slopedBall());
  const Control plain = source("paint:wet")->bind(context), scaled = source("paint:wet:300:20")->bind(context);
  for (const Vec3d& point : pointsIn(BBoxd(Vec3d(-1.3), Vec3d(1.3)), 100))
    EXPECT_NEAR(scaled.at(point), 300 - 280 * plain.at(point), 1e-3);
  // A ball that is painted all over has one value, exactly.
  const Mesh full = painted(makeSphere(), "wet", [](const Vec3d&) { return 1; });
  EXPECT_EQ(source("paint:wet:300:20")->bind(contextOf(full)).range(), std::pair(20.0, 20.0));
}

TEST(Painting, TakesAnotherMesh) {
  const TemporaryFolder folder;
  const Mesh ball = slopedBall();
  const std::string path = folder.write("painted.ply", plyOf(ball)).string();
  ControlContext context = contextOf(ball);
  const Control own = source("paint:wet:1:2")->bind(context);
  context.mesh = nullptr;
  const auto other = source("paint:wet@" + path + ":1:2");
  ASSERT_EQ(other->files().size(), 1U);
  EXPECT_EQ(other->files()[0].path, path);
  EXPECT_EQ(other->files()[0].recordedAs, "alpha-sha256");
  const Control control = other->bind(context);
  for (const Vec3d& point : pointsIn(context.targetBox, 100)) EXPECT_EQ(control.at(point), own.at(point));
  EXPECT_TRUE(source("paint:wet")->files().empty());
  EXPECT_FALSE(other->needsTarget());
}

TEST(Painting, MovesWithTheTarget) {
  const Mesh ball = slopedBall();
  const Vec3d shift(1000, -200, 33);
  const Control here = source("paint:wet")->bind(contextOf(ball));
  const Control there = source("paint:wet")->bind(contextOf(transformed(ball, 8, shift)));
  for (const Vec3d& point : pointsIn(BBoxd(Vec3d(-1.3), Vec3d(1.3)), 100)) {
    if (point.length() > 0.3) {
      EXPECT_NEAR(there.at(point * 8.0 + shift), here.at(point), 2e-3);
    }
  }
}

// Promise of controls.md: "A wrong name is refused with a list of the attributes that the mesh has"
TEST(Painting, RefusesAttributesThatCannotBeUsed) {
  const auto complaint = [](const std::string& text, const ControlContext& context) -> std::string {
    try {
      source(text)->bind(context);
    } catch (const DataError& error) {
      return error.what();
    }
    ADD_FAILURE() << text << " was taken";
    return {};
  };
  Mesh ball = slopedBall();
  ball = painted(std::move(ball), "dry", [](const Vec3d&) { return 1; });
  EXPECT_NE(complaint("paint:wte", contextOf(ball)).find("'wte'; it has wet, dry"), std::string::npos);
  EXPECT_NE(complaint("paint:wet", contextOf(makeSphere())).find("it has none"), std::string::npos);
  EXPECT_NE(complaint("paint:wet", {.targetBox = BBoxd(Vec3d(-1), Vec3d(1))}).find("paint:wet@FILE"),
            std::string::npos);
  EXPECT_NE(complaint("texture:a.png:1:2", {.targetBox = BBoxd(Vec3d(-1), Vec3d(1))}).find("is a VDB"),
            std::string::npos);
  ball.attributes[0].values[77] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_NE(complaint("paint:wet", contextOf(ball)).find("is nan at point 77"), std::string::npos);
  EXPECT_THROW(source("paint:wet@/nowhere/a.ply")->bind(contextOf(ball)), MissingInputError);
}

// ----------------------------------------------------------------------------------------------------------- texture

/// A cube of side 2 about the origin, each of whose faces shows the whole picture: every edge is a seam.
Mesh cubeOfPictures() {
  Mesh mesh = makeCube(2);
  for (const Vec3I& t : mesh.triangles) {
    const Vec3d middle = (mesh.points[t[0]] + mesh.points[t[1]] + mesh.points[t[2]]) / 3.0;
    int face = 0;
    for (int axis = 1; axis < 3; ++axis)
      if (std::abs(middle[axis]) > std::abs(middle[face])) face = axis;
    const int right = face == 0 ? 1 : 0, up = face == 2 ? 1 : 2;
    for (int c = 0; c < 3; ++c) {
      const Vec3d& p = mesh.points[t[c]];
      mesh.cornerUvs.emplace_back(static_cast<float>((p[right] + 1) / 2), static_cast<float>((p[up] + 1) / 2));
    }
  }
  return mesh;
}

/// Red grows to the right and green upwards, both from 0 to 1; blue is 0.25.
std::string slopes(const std::string& extension) {
  Image image(64, 32);
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 64; ++x)
      image.at(x, y) = {(static_cast<float>(x) + 0.5F) / 64, 1 - (static_cast<float>(y) + 0.5F) / 32, 0.25F};
  return encodeImage(image, extension);
}

// Promise of controls.md: "`luminance` is 0.2126 red + 0.7152 green + 0.0722 blue", and "Points without a colour are
//   white"
// Promise of controls.md#pictures: A picture is read "through the mesh's texture coordinates", of corners on either
//   side of a seam
TEST(Texture, IsReadThroughTheCoordinatesOfCorners) {
  const TemporaryFolder folder;
  const std::string path = folder.write("slopes.exr", slopes("exr")).string();
  const ControlContext context = contextOf(cubeOfPictures());
  const auto bound = [&](const std::string& channel) {
    return source("texture:" + path + ":" + channel + (channel.empty() ? "" : ":") + "10:20")->bind(context);
  };
  const Control red = bound("r"), green = bound("g"), blue = bound("b"), luminance = bound(""),
                named = bound("luminance");
  // Not so near to a seam that the nearest point is on its other side, or as near as the smoothing of the lattice.
  for (const double height : {-0.05, 0.0, 0.1})
    for (double u = 0.1; u < 0.95; u += 0.16)
      for (double v = 0.1; v < 0.95; v += 0.16) {
        const Vec3d top(2 * u - 1, 2 * v - 1, 1 + height), side(1 + height, 2 * u - 1, 2 * v - 1);
        for (const Vec3d& point : {top, side}) {
          EXPECT_NEAR(red.at(point), 10 + 10 * u, 0.1) << point;
          EXPECT_NEAR(green.at(point), 10 + 10 * v, 0.1) << point;
          EXPECT_NEAR(blue.at(point), 12.5, 0.01);
          EXPECT_NEAR(luminance.at(point), 10 + 10 * (0.2126 * u + 0.7152 * v + 0.0722 * 0.25), 0.1);
          EXPECT_EQ(named.at(point), luminance.at(point));
        }
      }
}

// Promise: Attributes and pictures have ...
TEST(Texture, RepeatsBeyondItsEdges) {
  const TemporaryFolder folder;
  const std::string path = folder.write("slopes.exr", slopes("exr")).string();
  Mesh cube = cubeOfPictures();
  const Control once = source("texture:" + path + ":r:0:1")->bind(contextOf(cube));
  for (Vec2s& uv : cube.cornerUvs) uv += Vec2s(-3, 5);
  const Control again = source("texture:" + path + ":r:0:1")->bind(contextOf(cube));
  for (double u = 0.1; u < 0.95; u += 0.1)
    EXPECT_NEAR(again.at(Vec3d(2 * u - 1, 0.1, 1)), once.at(Vec3d(2 * u - 1, 0.1, 1)), 1e-5) << u;
}

// Promise of controls.md: Attributes and pictures have the values "as they are in the file"
TEST(Texture, ValuesAreThoseOfTheFile) {
  // The code 128 of a PNG is 128 / 255, not the light that it stands for; and detail finer than the lattice is
  // averaged.
  const TemporaryFolder folder;
  Image grey(4, 4), board(1024, 1024);
  for (Colour& pixel : grey.pixels) pixel = {0.2158605F, 0.2158605F, 0.2158605F};
  for (int y = 0; y < board.height; ++y)
    for (int x = 0; x < board.width; ++x) board.at(x, y) = (x + y) % 2 == 0 ? Colour{0, 0, 0} : Colour{1, 1, 1};
  const std::string greyPath = folder.write("grey.png", encodeImage(grey, "png")).string();
  const std::string boardPath = folder.write("board.png", encodeImage(board, "png")).string();
  const ControlContext context = contextOf(cubeOfPictures());
  EXPECT_NEAR(source("texture:" + greyPath + ":0:255")->bind(context).at(Vec3d(0, 0, 1)), 128, 0.01);
  const auto [low, high] = source("texture:" + boardPath + ":0:1")->bind(context).range();
  EXPECT_NEAR(low, 0.5, 0.02);
  EXPECT_NEAR(high, 0.5, 0.02);
}

TEST(Texture, RefusesWhatCannotBeUsed) {
  const TemporaryFolder folder;
  const std::string picture = folder.write("a.png", slopes("png")).string();
  const std::string text = folder.write("text.png", "this is no picture").string();
  const std::string cut = folder.write("cut.png", slopes("png").substr(0, 200)).string();
  const ControlContext context = contextOf(cubeOfPictures());
  EXPECT_THROW(source("texture:/nowhere/a.png:1:2")->bind(context), MissingInputError);
  EXPECT_THROW(source("texture:" + text + ":1:2")->bind(context), DataError);
  EXPECT_THROW(source("texture:" + cut + ":1:2")->bind(context), DataError);
  EXPECT_THROW(source("texture:" + picture + ":a:1:2")->bind(context), DataError) << "it has no alpha";
  EXPECT_THROW(source("texture:" + picture + ":1:2")->bind(contextOf(makeCube())), DataError) << "no coordinates";
  Mesh partly = cubeOfPictures();
  partly.cornerUvs[5] = Vec2s(std::numeric_limits<float>::quiet_NaN());
  EXPECT_THROW(source("texture:" + picture + ":1:2")->bind(contextOf(partly)), DataError);
}

// -------------------------------------------------------------------------------------------------------------- near

double fallen(double distance, double reach, double near, double far) {
  const double t = std::clamp(distance / reach, 0.0, 1.0);
  return near + (far - near) * t * t * (3 - 2 * t);
}

// Promise of controls.md: The distance to a brush: NEAR on it and inside it, FAR "from DISTANCE on"
TEST(Near, FollowsTheDistanceToAnotherMesh) {
  const TemporaryFolder folder;
  const ControlContext context = contextOf(makeBox(Vec3d(-1, -0.5, -0.5), Vec3d(1, 0.5, 0.5)));
  const Mesh ball = makeSphere(0.4, 3, Vec3d(0.7, 0.3, 0.1));
  struct Case {
    std::string name;
    Mesh brush;
    bool closed;
  };
  const Case cases[] = {
      {"ball.ply", ball, true},
      {"turned.ply", flipped(ball), true},
      {"bowl.ply", withoutTriangles(ball, [](const Vec3d& p) { return p[2] > 0.3; }), false},
      {"soup.ply", makeSoup(makeSphere(0.4, 2, Vec3d(0.7, 0.3, 0.1)), 0), true},
      {"large.ply", makeBox(Vec3d(-0.11, -50, -50), Vec3d(50, 50, 50)), true},
  };
  for (const Case& c : cases) {
    const auto near = source("near:" + folder.write(c.name, plyOf(c.brush)).string() + ":0.25:20:300");
    ASSERT_EQ(near->files().size(), 1U);
    const Control control = near->bind(context);
    int inside = 0;
    for (const Vec3d& point : pointsIn(context.targetBox, 500)) {
      double distance = nearestByHand(c.brush, point).distance;
      const bool isInside = c.name == "large.ply" ? point[0] > -0.11 : (point - Vec3d(0.7, 0.3, 0.1)).length() < 0.39;
      if (c.closed && isInside) {
        distance = 0;
        ++inside;
      }
      // A quarter of the longest side, 2; half a node of the lattice, 0.01, at the steepest slope.
      EXPECT_NEAR(control.at(point), fallen(distance, 0.5, 20, 300), 1.5 * 280 / 0.5 * 0.01) << c.name << " " << point;
    }
    EXPECT_TRUE(!c.closed || inside > 10) << c.name;
  }
}

// Promise: The distance to a brush: NEAR ...
TEST(Near, FarFromTheBrushItIsFar) {
  const TemporaryFolder folder;
  const std::string path = folder.write("far.ply", plyOf(makeCube(1, Vec3d(1e5, 0, 0)))).string();
  const Control control = source("near:" + path + ":0.1:20:300")->bind(contextOf(makeCube()));
  EXPECT_EQ(control.range(), std::pair(300.0, 300.0));
  EXPECT_THROW(source("near:/nowhere/a.obj:0.1:1:2")->bind(contextOf(makeCube())), MissingInputError);
}

// -------------------------------------------------------------------------------------------------------------- expr

// Promise: `curvature` is "positive on ridges, negative ..."
TEST(ExpressionControl, KnowsThePlaceAndTheBall) {
  // A ball of radius 3 off the origin: its longest side is 6, so that curvature is 6 / 3.
  const Vec3d centre(5, -2, 1);
  ControlContext context = targetOf(makeSphere(3, 4, centre), 0.1);
  const auto tau = FloatGrid::create(9);
  tau->setTransform(openvdb::math::Transform::createLinearTransform(0.5));
  tau->denseFill(openvdb::CoordBBox(openvdb::Coord(-20), openvdb::Coord(30)), 1.5F, true);
  context.tau = [tau] { return tau; };
  struct Case {
    const char* text;
    std::function<double(const Vec3d&)> value;  ///< of a place in fractal space
    double tolerance;
  };
  const auto share = [](double x) { return std::clamp(x + 0.5, 0.0, 1.0); };
  const Case cases[] = {
      {"x + 10*y + 100*z", [](const Vec3d& p) { return p[0] + 10 * p[1] + 100 * p[2]; }, 1e-4},
      {"phi", [](const Vec3d& p) { return p.length() - 0.5; }, 1e-2},
      {"nx", [](const Vec3d& p) { return p.unit()[0]; }, 0.03},
      {"ny", [](const Vec3d& p) { return p.unit()[1]; }, 0.03},
      {"nz", [](const Vec3d& p) { return p.unit()[2]; }, 0.03},
      {"curvature", [](const Vec3d&) { return 2; }, 0.35},
      {"tau", [](const Vec3d&) { return 0.25; }, 1e-6},
      {"height", [&](const Vec3d& p) { return share(p[1]); }, 6e-3},
      {"hx + 2*hy + 4*hz", [&](const Vec3d& p) { return share(p[0]) + 2 * share(p[1]) + 4 * share(p[2]); }, 4e-2},
      {"ny > 0 ? 20 : 300", [](const Vec3d& p) { return p[1] > 0.02    ? 20
                                                        : p[1] < -0.02 ? 300
                                                                       : 160; }, 140.1},
  };
  for (const Case& c : cases) {
    const auto expression = source(std::string("expr:") + c.text);
    EXPECT_TRUE(expression->needsTarget());
    const Control control = expression->bind(context);
    for (const Vec3d& p : pointsIn(BBoxd(Vec3d(-0.55), Vec3d(0.55)), 300)) {
      if (p.length() < 0.25) continue;  // the directions meet
      EXPECT_NEAR(control.at(centre + p * 6.0), c.value(p), c.tolerance) << c.text << " at " << p;
    }
  }
  // Away from the jump the choice is exact.
  const Control choice = source("expr:ny > 0 ? 20 : 300")->bind(context);
  EXPECT_EQ(choice.at(centre + Vec3d(1, 2, 0)), 20);
  EXPECT_EQ(choice.at(centre + Vec3d(1, -2, 0)), 300);
  EXPECT_EQ(choice.range(), std::pair(20.0, 300.0));
}

// Promise of controls.md: `curvature` is "positive on ridges, negative in hollows"; the variables of formulas are those
//   of the table
TEST(ExpressionControl, CurvatureHasItsSign) {
  // A ring: outside it is curved like a ball, about its hole like a saddle, less.
  Mesh ring;
  constexpr int kAround = 96, kAcross = 48;
  for (int i = 0; i < kAround; ++i)
    for (int j = 0; j < kAcross; ++j) {
      const double u = 2 * kPi * i / kAround, v = 2 * kPi * j / kAcross, r = 0.7 + 0.3 * std::cos(v);
      ring.points.emplace_back(r * std::cos(u), r * std::sin(u), 0.3 * std::sin(v));
    }
  for (int i = 0; i < kAround; ++i)
    for (int j = 0; j < kAcross; ++j) {
      const auto at = [](int a, int b) { return static_cast<std::uint32_t>(a % kAround * kAcross + b % kAcross); };
      ring.triangles.emplace_back(at(i, j), at(i + 1, j), at(i + 1, j + 1));
      ring.triangles.emplace_back(at(i, j), at(i + 1, j + 1), at(i, j + 1));
    }
  const Control curvature = source("expr:curvature")->bind(targetOf(ring, 0.02));
  // Half the sum of 1 / 0.3 and cos v / (0.7 + 0.3 cos v), with the longest side, 2, as unit.
  for (const double v : {0.0, kPi / 2, kPi}) {
    const double r = 0.7 + 0.3 * std::cos(v);
    for (const double u : {0.3, 2.0, 4.5})
      EXPECT_NEAR(curvature.at(Vec3d(r * std::cos(u), r * std::sin(u), 0.3 * std::sin(v))), 1 / 0.3 + std::cos(v) / r,
                  0.25)
          << v;
  }
}

// Promise: `curvature` is "positive on ridges, negative ..."
TEST(ExpressionControl, KnowsWhatIsPainted) {
  const ControlContext context = targetOf(slopedBall(), 0.04);
  const Control painted = source("paint:wet:20:300")->bind(context);
  const Control written = source("expr:20 + 280*wet")->bind(context);
  for (const Vec3d& point : pointsIn(BBoxd(Vec3d(-1.1), Vec3d(1.1)), 200))
    EXPECT_NEAR(written.at(point), painted.at(point), 1e-3);
}

// Promise of controls.md: A formula without a finite value: "the run stops and says where"
TEST(ExpressionControl, RefusesWhatItCannotCompute) {
  const ControlContext context = targetOf(slopedBall(), 0.04);
  const std::pair<const char*, const char*> cases[] = {
      {"expr:wet + dry", "'dry', which is neither a variable (x, y, z,"},
      {"expr:wet + dry", "(it has wet)"},
      {"expr:sqrt(x - 100)", "'sqrt(x - 100)' of --alpha is"},
      {"expr:1 / max(0, x)", "inf where x = "},
      {"expr:log(-wet)", "where wet = "},
  };
  for (const auto& [text, words] : cases) try {
      source(text)->bind(context);
      ADD_FAILURE() << text << " was taken";
    } catch (const DataError& error) {
      EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
    }
}

// --------------------------------------------------------------------------------------------------------------- all

struct Kinds {
  TemporaryFolder folder;
  std::vector<std::string> texts;
  ControlContext context;

  Kinds() {
    Mesh ball = slopedBall();
    for (const Vec3I& t : ball.triangles)
      for (int c = 0; c < 3; ++c) {
        const Vec3d& p = ball.points[t[c]];
        ball.cornerUvs.emplace_back(static_cast<float>(p[0]), static_cast<float>(p[1]));
      }
    context = targetOf(ball, 0.04);
    const std::string brush = folder.write("brush.ply", plyOf(makeSphere(0.3, 2, Vec3d(0.8, 0, 0)))).string();
    const std::string picture = folder.write("slopes.png", slopes("png")).string();
    texts = {"paint:wet:20:300", "texture:" + picture + ":g:300:20", "near:" + brush + ":0.2:20:300",
             "expr:100 + 50*sin(20*x)*ny + wet"};
  }
};

TEST(PaintedControls, NoValueLeavesTheRange) {
  const Kinds kinds;
  for (const std::string& text : kinds.texts) {
    const Control control = source(text)->bind(kinds.context);
    const auto [least, most] = control.range();
    for (const Vec3d& point : pointsIn(BBoxd(Vec3d(-1.5), Vec3d(2)), 2000)) {
      const double value = control.at(point);
      ASSERT_GE(value, least) << text << " at " << point;
      ASSERT_LE(value, most) << text << " at " << point;
    }
    EXPECT_LT(control.range().first, control.range().second) << text;
    EXPECT_FALSE(control.constant());
  }
}

TEST(PaintedControls, AreTheSameForAnyNumberOfThreads) {
  const Kinds kinds;
  const std::vector<Vec3d> points = pointsIn(BBoxd(Vec3d(-1.2), Vec3d(1.2)), 1000);
  for (const std::string& text : kinds.texts) {
    std::vector<double> first(points.size()), other(points.size());
    {
      const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
      source(text)->bind(kinds.context).sample(points, first);
    }
    const tbb::global_control five(tbb::global_control::max_allowed_parallelism, 5);
    source(text)->bind(kinds.context).sample(points, other);
    EXPECT_EQ(first, other) << text;
  }
}

TEST(PaintedControls, TheirTextMakesThemAgain) {
  for (const char* text :
       {"paint:red", "paint:red:20:300", "paint:red@a.ply", "paint:red@dir/a.ply:2:-1", "texture:a.png:1:2",
        "texture:a.png:luminance:1:2", "near:a.obj:0.1:20:300", "expr: x > 0 ? 20 : 300 ", "expr:2"})
    EXPECT_EQ(source(text)->text(), text);
}

TEST(PaintedControls, RefuseBrokenTextByTheOptionsName) {
  for (const char* text : {"paint:",
                           "paint:red:1",
                           "paint:red:1:2:3",
                           "paint:red:a:2",
                           "paint:red:1:nan",
                           "paint:@a.ply",
                           "paint:red@",
                           "paint:red@c:/a.ply:1:2",
                           "texture:a.png",
                           "texture:a.png:1",
                           "texture::1:2",
                           "texture:a.png:x:1:2",
                           "texture:a.png:r:1:inf",
                           "texture:a.png:r:1:2:3",
                           "near:a.obj",
                           "near:a.obj:0:1:2",
                           "near:a.obj:-1:1:2",
                           "near::1:1:2",
                           "near:a.obj:1:1:b",
                           "near:a.obj:1:1:2:3",
                           "expr:",
                           "expr:2*",
                           "expr:x=2",
                           "expr:no(x)",
                           "expr:1,2",
                           "expr:x y"})
    try {
      source(text);
      ADD_FAILURE() << "'" << text << "' was taken";
    } catch (const std::invalid_argument& error) {
      EXPECT_NE(std::string(error.what()).find("--alpha is '" + std::string(text) + "'"), std::string::npos)
          << error.what();
    }
}

}  // namespace
