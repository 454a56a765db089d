// SPDX-License-Identifier: Apache-2.0
// How many nodes, points, edges and rays a second a device of OpenCL evaluates, and one core of the processor beside
// it. It needs libjulia alone, prints one object of JSON a line as soon as it is measured, and goes with the bundle for
// bench/gpu.
//
//     device_bench [--device N] [--nodes N] [--points N] [--edges N] [--rays N] [--seconds S]
//
// Without a number, the device is the first graphics processor, or else the first one that can be used. The numbers say
// how much goes to the device at a time, and the seconds how long each measurement takes at least.
#include "julia/brick_field.h"
#include "julia/device/device.h"
#include "julia/mandelbulb.h"
#include "julia/random_roots.h"
#include "julia/rational_map.h"
#include "julia/shape_modulus.h"
#include "julia/wave_versor.h"

#include <algorithm>
#include <array>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <memory>
#include <random>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

using julia::FieldEvaluator;

struct Amounts {
  int device = -1;
  std::size_t nodes = std::size_t{1} << 22, points = std::size_t{1} << 20, edges = std::size_t{1} << 18,
              rays = std::size_t{1} << 17;
  double seconds = 0.5;
};

std::shared_ptr<const julia::Device> chosenDevice(int number) {
  std::string refusal;
  const auto devices = julia::openDevices({}, refusal);
  if (number >= 0) {
    const auto place = static_cast<std::size_t>(number);
    if (place < devices.size() && devices[place]->info().refusal.empty()) return devices[place];
    throw std::runtime_error("there is no device " + std::to_string(number) + " that can be used");
  }
  std::shared_ptr<const julia::Device> found;
  for (const auto& one : devices)
    if (one->info().refusal.empty() && (!found || (one->info().isGpu && !found->info().isGpu))) found = one;
  if (!found) throw std::runtime_error("no device of OpenCL can be used");
  return found;
}

/// A ball's exponent and a constant octave, as bricks of 9^3 values.
julia::PlacedBricks bricksOf(const std::function<double(double)>& valueAtRadius) {
  constexpr std::uint32_t kAcross = 8;
  constexpr double kSpacing = 1.3 / (8 * kAcross), kHalf = 0.65;
  auto bricks = std::make_shared<julia::Bricks>();
  bricks->count = {kAcross, kAcross, kAcross};
  for (std::uint32_t place = 0; place < kAcross * kAcross * kAcross; ++place) {
    bricks->brickAt.push_back(place);
    const std::array<std::uint32_t, 3> brick = {place / (kAcross * kAcross), place / kAcross % kAcross,
                                                place % kAcross};
    for (std::uint32_t k = 0; k < bricks->size(); ++k) {
      const std::array<std::uint32_t, 3> node = {k / 81, k / 9 % 9, k % 9};
      double square = 0;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const double x = kSpacing * (8.0 * brick[axis] + node[axis]) - kHalf;
        square += x * x;
      }
      bricks->values.push_back(static_cast<float>(valueAtRadius(std::sqrt(square))));
    }
  }
  julia::BrickPlacement placement;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    placement.matrix[axis][axis] = 1 / kSpacing;
    placement.offset[axis] = kHalf / kSpacing;
    placement.high[axis] = 8 * kAcross - 1;
  }
  return {bricks, placement};
}

/// The field that a name stands for: roots:N, waves or mandelbulb.
template <class Real>
std::unique_ptr<FieldEvaluator> fieldOf(const std::string& name) {
  if (name.rfind("roots:", 0) == 0) {
    const int roots = std::atoi(name.c_str() + 6);
    const julia::Rational rational{.top = julia::randomPolynomial({.seed = 1, .count = roots, .integerPowers = true})};
    return julia::makeFieldEvaluator<Real>(std::make_shared<const julia::RationalMap<Real>>(rational), {},
                                           {.maxIterations = 4});
  }
  if (name == "mandelbulb")
    return julia::makeFieldEvaluator<Real>(
        std::shared_ptr<const julia::CartesianMap<Real>>(std::make_shared<const julia::Mandelbulb<Real>>(
            julia::MandelbulbOptions{8, julia::TriplexAngle::AbovePlane, {}})),
        {}, {.maxIterations = 8, .escapeRadius = 2});
  std::mt19937 random(5);
  const auto unit = [&] { return static_cast<double>(random()) / 0x1p32 - 0.5; };
  const auto quaternion = [&](double scale) {
    return julia::Quaternion<double>{scale * unit(), scale * unit(), scale * unit(), scale * unit()};
  };
  julia::WaveTexture texture;
  for (int factor = 0; factor < 3; ++factor) {
    texture.factors.push_back({{}, 1 + factor});
    for (int wave = 0; wave < 4; ++wave)
      texture.factors.back().waves.push_back({quaternion(4), quaternion(1), quaternion(1)});
  }
  const auto placed = [](const julia::PlacedBricks& of) {
    return std::make_shared<julia::BrickField<Real>>(of.bricks, of.placement);
  };
  const auto exponent = placed(bricksOf([](double radius) { return 16 * (radius - 0.5); }));
  const auto octave = placed(bricksOf([](double) { return 2.0; }));
  const auto versor = std::make_shared<julia::WaveVersor<Real>>(texture, octave, julia::DropAxis::K);
  return julia::makeFieldEvaluator<Real>(
      std::make_shared<const julia::ShapeModulus<Real>>(exponent, versor, julia::DropAxis::K), {},
      {.maxIterations = 5});
}

/// Blocks that fill the cube about the set, at least one, and their lattice.
struct Cube {
  explicit Cube(std::size_t nodes) {
    const int across = std::max(1, static_cast<int>(std::cbrt(static_cast<double>(nodes)) / 8));
    lattice.voxelSize = 1.2 / (8 * across);
    for (int x = 0; x < across; ++x)
      for (int y = 0; y < across; ++y)
        for (int z = 0; z < across; ++z)
          blocks.push_back({.origin = {8 * x - 4 * across, 8 * y - 4 * across, 8 * z - 4 * across}});
  }
  julia::SearchLattice lattice;
  std::vector<julia::SignBlock> blocks;
};

/// Edges between nodes of a block on which the sign changes, along x.
void addEdges(const julia::SignBlock& block, std::vector<julia::NodeEdge>& edges) {
  constexpr auto kLimit = static_cast<float>(julia::kFieldLimit);
  for (std::size_t x = 0; x + 1 < 8; ++x)
    for (std::uint64_t rest = block.inside[x] ^ block.inside[x + 1]; rest != 0; rest &= rest - 1) {
      const int k = std::countr_zero(rest);
      const float from = block.inside[x] >> k & 1 ? -kLimit : kLimit;
      edges.push_back(
          {{block.origin[0] + static_cast<int>(x), block.origin[1] + k / 8, block.origin[2] + k % 8}, 0, from, -from});
    }
}

/// Some thousand edges of the surface, which are repeated until there are so many.
std::vector<julia::NodeEdge> edgesOf(const FieldEvaluator& field, Cube& cube, std::size_t count) {
  std::vector<julia::NodeEdge> edges;
  // Blocks from all over the cube, a few at a time.
  constexpr std::size_t kFew = 512;
  const std::size_t stride = std::max<std::size_t>(1, cube.blocks.size() / kFew);
  std::vector<julia::SignBlock> some;
  for (std::size_t i = 0; i < cube.blocks.size(); i += stride) some.push_back(cube.blocks[i]);
  field.evaluateSigns(cube.lattice, some);
  for (const julia::SignBlock& block : some) addEdges(block, edges);
  const std::size_t distinct = edges.size();
  if (distinct == 0) return edges;
  edges.reserve(count);
  while (edges.size() < count) edges.push_back(edges[edges.size() % distinct]);
  edges.resize(count);
  return edges;
}

/// Calls work(), which does @a each things, until the time is over. @return things a second
double rateOf(double seconds, std::size_t each, const std::function<void()>& work) {
  using Clock = std::chrono::steady_clock;
  double done = 0, passed = 0;
  const auto begin = Clock::now();
  do {
    work();
    done += static_cast<double>(each);
    passed = std::chrono::duration<double>(Clock::now() - begin).count();
  } while (passed < seconds);
  return done / passed;
}

struct Place {
  const FieldEvaluator& field;
  const char* name;
  bool isDevice;
};

void say(const char* what, const std::string& field, bool floats, const Place& at, std::size_t each, double rate) {
  std::printf("{\"what\":\"%s\",\"field\":\"%s\",\"real\":\"%s\",\"where\":\"%s\",\"together\":%zu,\"rate\":%.6g}\n",
              what, field.c_str(), floats ? "float" : "double", at.name, each, rate);
  std::fflush(stdout);
}

void measureNodes(const Place& at, const std::string& name, bool floats, const Amounts& amounts) {
  Cube cube(amounts.nodes);
  // The processor evaluates a few blocks from all over the cube at a time.
  constexpr std::size_t kFew = 8;
  std::vector<julia::SignBlock> some = cube.blocks;
  std::size_t next = 0;
  if (!at.isDevice) some.resize(std::min(kFew, some.size()));
  const double rate = rateOf(amounts.seconds, some.size() * 512, [&] {
    if (!at.isDevice)
      for (julia::SignBlock& block : some) block = cube.blocks[next++ * 1009 % cube.blocks.size()];
    at.field.evaluateSigns(cube.lattice, some);
  });
  say("nodes", name, floats, at, some.size() * 512, rate);
}

void measureEdges(const Place& at, const FieldEvaluator& device, const std::string& name, bool floats,
                  const Amounts& amounts) {
  Cube cube(amounts.nodes);
  const auto edges = edgesOf(device, cube, at.isDevice ? amounts.edges : std::min<std::size_t>(512, amounts.edges));
  if (edges.empty()) return;
  std::vector<double> found(edges.size());
  say("edges", name, floats, at, edges.size(),
      rateOf(amounts.seconds, edges.size(), [&] { at.field.findNodeCrossings(edges, cube.lattice, found); }));
}

void measurePoints(const Place& at, const std::string& name, bool floats, const Amounts& amounts) {
  std::mt19937 random(2);
  std::vector<julia::Point> points(at.isDevice ? amounts.points : std::min<std::size_t>(4096, amounts.points));
  for (julia::Point& x : points)
    for (double& c : x) c = 1.2 * (static_cast<double>(random()) / 0x1p32 - 0.5);
  std::vector<double> values(points.size());
  say("points", name, floats, at, points.size(),
      rateOf(amounts.seconds, points.size(), [&] { at.field.evaluate(points, values, {}); }));
}

/// A picture of the field by so many rays, each of them sampled 300 times at most.
struct Picture {
  explicit Picture(std::size_t count) {
    march = {.eye = {0, -2, 0.3}, .alpha = 0, .epsilon = 8e-3, .delta = 1, .members = {&first, 1}, .bisections = 12};
    const auto side = static_cast<std::size_t>(std::ceil(std::sqrt(static_cast<double>(count))));
    for (std::size_t i = 0; i < count; ++i) {
      const auto across = [&](std::size_t k) {
        return (static_cast<double>(k) + 0.5) / static_cast<double>(side) - 0.5;
      };
      julia::Point direction = {across(i % side), 1.4, across(i / side)};
      const double length =
          std::sqrt(direction[0] * direction[0] + direction[1] * direction[1] + direction[2] * direction[2]);
      for (double& x : direction) x /= length;
      rays.push_back({direction, 1, 1, 3.4});
    }
  }
  double first = 0.9;
  julia::RayMarch march;
  std::vector<julia::MarchedRay> rays;
};

/// Follows rays as a device does, sample by sample. @return how many met the set
std::size_t followHere(const FieldEvaluator& field, const Picture& picture) {
  std::vector<julia::MarchedRay> rays = picture.rays;
  std::vector<double> inside, outside;
  std::vector<julia::Point> directions, points;
  std::vector<double> values;
  const auto evaluate = [&] {
    values.resize(points.size());
    field.evaluate(points, values, {});
  };
  while (!rays.empty()) {
    points.clear();
    for (const julia::MarchedRay& ray : rays)
      points.push_back(julia::pointAlong(picture.march.eye, ray.t, ray.direction));
    evaluate();
    std::size_t kept = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      julia::MarchedRay ray = rays[i];
      if (values[i] < 0) {
        inside.push_back(ray.t);
        outside.push_back(ray.before);
        directions.push_back(ray.direction);
        continue;
      }
      ray.before = ray.t;
      ray.t += picture.march.epsilon;
      if (ray.t <= ray.end) rays[kept++] = ray;
    }
    rays.resize(kept);
  }
  for (int k = 0; k < picture.march.bisections; ++k) {
    points.clear();
    for (std::size_t i = 0; i < inside.size(); ++i)
      points.push_back(julia::pointAlong(picture.march.eye, 0.5 * (outside[i] + inside[i]), directions[i]));
    evaluate();
    for (std::size_t i = 0; i < inside.size(); ++i)
      (values[i] < 0 ? inside[i] : outside[i]) = 0.5 * (outside[i] + inside[i]);
  }
  return inside.size();
}

void measureRays(const Place& at, const std::string& name, bool floats, const Amounts& amounts) {
  const Picture picture(at.isDevice ? amounts.rays : std::min<std::size_t>(256, amounts.rays));
  std::vector<julia::RayMeeting> met(picture.rays.size());
  if (at.isDevice && at.field.preferredRays() == 0) return;
  // The first rays of a field are tried, and some drivers compile a kernel when it is first run.
  if (at.isDevice) at.field.followRays(picture.march, std::span(picture.rays).first(1), met);
  say("rays", name, floats, at, picture.rays.size(), rateOf(amounts.seconds, picture.rays.size(), [&] {
        if (at.isDevice)
          at.field.followRays(picture.march, picture.rays, met);
        else
          followHere(at.field, picture);
      }));
}

template <class Real>
void measure(const julia::Device& device, const std::string& name, const Amounts& amounts) {
  constexpr bool kFloats = sizeof(Real) == sizeof(float);
  std::string reason;
  const auto host = fieldOf<Real>(name);
  const auto there = device.evaluator(fieldOf<Real>(name), reason);
  if (!reason.empty()) {
    std::printf("{\"field\":\"%s\",\"real\":\"%s\",\"refusal\":\"%s\"}\n", name.c_str(), kFloats ? "float" : "double",
                reason.c_str());
    return;
  }
  for (const Place& at : {Place{*there, "device", true}, Place{*host, "one core", false}}) {
    measureNodes(at, name, kFloats, amounts);
    measureEdges(at, *there, name, kFloats, amounts);
    measurePoints(at, name, kFloats, amounts);
    measureRays(at, name, kFloats, amounts);
  }
}

Amounts amountsOf(int count, char** words) {
  Amounts amounts;
  for (int i = 1; i < count; i += 2) {
    const std::string name = words[i];
    if (i + 1 >= count) throw std::runtime_error(name + " needs a number");
    const double value = std::atof(words[i + 1]);
    if (name == "--device")
      amounts.device = static_cast<int>(value);
    else if (name == "--seconds")
      amounts.seconds = value;
    else if (name == "--nodes")
      amounts.nodes = static_cast<std::size_t>(value);
    else if (name == "--points")
      amounts.points = static_cast<std::size_t>(value);
    else if (name == "--edges")
      amounts.edges = static_cast<std::size_t>(value);
    else if (name == "--rays")
      amounts.rays = static_cast<std::size_t>(value);
    else
      throw std::runtime_error(name +
                               " is no option; there are --device, --nodes, --points, --edges, --rays and --seconds");
  }
  if (!(amounts.seconds >= 0) || amounts.points == 0 || amounts.edges == 0 || amounts.rays == 0)
    throw std::runtime_error("the numbers must be above 0");
  return amounts;
}

}  // namespace

int main(int count, char** words) {
  try {
    const Amounts amounts = amountsOf(count, words);
    const auto device = chosenDevice(amounts.device);
    // The most telling ones first, for whoever stops it.
    for (const char* const name : {"roots:10", "roots:400", "waves", "roots:60", "mandelbulb"}) {
      measure<float>(*device, name, amounts);
      if (device->info().doubles) measure<double>(*device, name, amounts);
    }
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "device_bench: %s\n", error.what());
    return 1;
  }
}
