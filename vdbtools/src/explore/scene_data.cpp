// SPDX-License-Identifier: Apache-2.0
#include "explore/scene_data.h"

#include "base/base64.h"
#include "render/occupancy.h"
#include "vdbtools/files/named_file.h"
#include "vdbtools/scene/scene.h"

#include "julia/brick_field.h"
#include "julia/cross_map.h"
#include "julia/grain_versor.h"
#include "julia/mandelbulb.h"
#include "julia/quadratic_map.h"
#include "julia/rational.h"
#include "julia/shape_modulus.h"
#include "julia/wave_versor.h"

#include <openvdb/math/Half.h>

#include <algorithm>
#include <any>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <utility>
#include <vector>

namespace vdbtools::explore {
namespace {

using nlohmann::json;
using openvdb::Vec3d;

static_assert(std::endian::native == std::endian::little, "the volume is written as it lies in memory");

json vector(const Vec3d& v) { return {v[0], v[1], v[2]}; }
json vector(const julia::Point& v) { return {v[0], v[1], v[2]}; }
json quaternion(const julia::Quaternion<double>& q) { return {q.a, q.b, q.c, q.d}; }

/// The factors in the order in which they are multiplied, each as four components and the power. The inverse of the
/// bottom polynomial's product runs backwards.
json factors(const julia::Rational& rational) {
  json all = json::array();
  const auto append = [&](const julia::Root& root, double power) {
    const julia::Quaternion<double>& t = root.position;
    if (power != 0) all.push_back({t.a, t.b, t.c, t.d, power});
  };
  for (const julia::Root& root : rational.top.roots) append(root, root.power * rational.top.powerScale);
  for (auto root = rational.bottom.roots.rbegin(); root != rational.bottom.roots.rend(); ++root)
    append(*root, -root->power * rational.bottom.powerScale);
  return all;
}

/// A dense lattice over the bricks of one or several fields.
class Lattice {
 public:
  /// @param fields  whose placements differ by whole nodes at most
  /// @param side  the maximum number of nodes along any axis
  Lattice(std::span<const julia::PlacedBricks> fields, int side) : mFirst(fields.front().placement) {
    std::array<double, 3> high = mLow = mFirst.low;
    for (const julia::PlacedBricks& field : fields)
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const double shift = shiftOf(field.placement, axis);
        mLow[axis] = std::min(mLow[axis], field.placement.low[axis] - shift);
        high[axis] = std::max(high[axis], field.placement.high[axis] - shift);
      }
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double extent = high[axis] - mLow[axis];
      mCount[axis] = std::min(side, static_cast<int>(std::lround(extent)) + 1);
      mStep[axis] = mCount[axis] > 1 ? extent / (mCount[axis] - 1) : 1;
    }
  }

  std::size_t size() const {
    return static_cast<std::size_t>(mCount[0]) * static_cast<std::size_t>(mCount[1]) *
           static_cast<std::size_t>(mCount[2]);
  }

  /// The values of one of the fields at all nodes, X fastest, then Y, without its knee.
  std::vector<float> valuesOf(const julia::PlacedBricks& placed) const {
    // In units of nodes, so that a value at a node is read unchanged.
    julia::BrickPlacement nodes{.low = placed.placement.low, .high = placed.placement.high};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      nodes.matrix[axis][axis] = 1;
      nodes.offset[axis] = shiftOf(placed.placement, axis);
    }
    const julia::BrickField<float> field(placed.bricks, nodes);
    const auto width = static_cast<std::size_t>(mCount[0]);
    std::vector<float> x(width), y(width), z(width), values(size());
    for (std::size_t i = 0; i < width; ++i) x[i] = static_cast<float>(mLow[0] + static_cast<double>(i) * mStep[0]);
    std::size_t row = 0;
    for (int k = 0; k < mCount[2]; ++k)
      for (int j = 0; j < mCount[1]; ++j, row += width) {
        std::fill(y.begin(), y.end(), static_cast<float>(mLow[1] + j * mStep[1]));
        std::fill(z.begin(), z.end(), static_cast<float>(mLow[2] + k * mStep[2]));
        field.sample(x, y, z, std::span(values).subspan(row, width));
      }
    return values;
  }

  json description() const {
    json matrix = json::array(), offset = json::array();
    for (std::size_t row = 0; row < 3; ++row) {
      matrix.push_back(
          {mFirst.matrix[row][0] / mStep[row], mFirst.matrix[row][1] / mStep[row], mFirst.matrix[row][2] / mStep[row]});
      offset.push_back((mFirst.offset[row] - mLow[row]) / mStep[row]);
    }
    return {{"dims", mCount},
            {"matrix", matrix},
            {"offset", offset},
            {"coarser", std::max({mStep[0], mStep[1], mStep[2]})}};
  }

 private:
  /// By how many nodes the bricks of a field are placed beyond those of the first.
  double shiftOf(const julia::BrickPlacement& placement, std::size_t axis) const {
    return std::round(placement.offset[axis] - mFirst.offset[axis]);
  }

  julia::BrickPlacement mFirst;
  std::array<double, 3> mLow{};  ///< in nodes of the first field's bricks, as the steps
  std::array<int, 3> mCount{};
  std::array<double, 3> mStep{};
};

/// Values as 16-bit floats.
class Halves {
 public:
  explicit Halves(std::size_t count) { mBytes.reserve(2 * count); }

  void append(float value) {
    const float rounded = appendHalf(mBytes, value);
    mError = std::max(mError, std::abs(rounded - value));
    mLow = std::min(mLow, rounded);
    mHigh = std::max(mHigh, rounded);
  }

  const std::string& bytes() const { return mBytes; }
  std::string takenBytes() { return std::move(mBytes); }
  std::string id() const { return sha256Hex(mBytes).substr(0, 32); }
  float error() const { return mError; }
  float low() const { return mLow; }
  float high() const { return mHigh; }

 private:
  std::string mBytes;
  float mError = 0, mLow = 1e30F, mHigh = -1e30F;
};

/// The exponent, or another field, on a dense lattice.
class Volume {
 public:
  Volume(const julia::PlacedBricks& exponent, int side) {
    const Lattice lattice({&exponent, 1}, side);
    Halves halves(lattice.size());
    for (const float value : lattice.valuesOf(exponent)) halves.append(value);
    mDescription = lattice.description();
    mDescription.update(
        {{"id", halves.id()},
         {"type", "float16"},
         {"error", halves.error()},
         {"low", halves.low()},
         {"high", halves.high()},
         {"interpolation",
          exponent.bricks->interpolation == julia::Interpolation::Quadratic ? "quadratic" : "trilinear"}});
    mBytes = halves.takenBytes();
  }

  const std::string& bytes() const { return mBytes; }
  json description() const { return mDescription; }

 private:
  std::string mBytes;
  json mDescription;
};

/// The waves in the order of their factors.
json waveFactors(const julia::WaveTexture& texture) {
  json factors = json::array();
  for (const julia::WaveFactor& factor : texture.factors) {
    json all = json::array();
    for (const julia::Wave& wave : factor.waves)
      all.push_back({quaternion(wave.frequency), quaternion(wave.cosine), quaternion(wave.sine)});
    factors.push_back({{"power", factor.power}, {"waves", std::move(all)}});
  }
  return factors;
}

/// The waves, and the octave, which varies slowly, on a coarse lattice.
json waves(const julia::WaveVersorDescription& versor) {
  constexpr int kSide = 48;
  const Volume octave(*versor.octave, kSide);
  json description = octave.description();
  description["values"] = base64(octave.bytes());
  return {{"origin", quaternion(versor.texture.origin)},
          {"factors", waveFactors(versor.texture)},
          {"octave", std::move(description)}};
}

/// The lattice of a grain. Phases turn within a few nodes, so it is thinned out only if it is larger than that of any
/// target should be.
Lattice grainLattice(std::span<const julia::PlacedBricks> fields) {
  constexpr std::size_t kMostNodes = std::size_t(6) << 20;  // of 10 bytes
  for (int side = 1024;; side -= side / 8) {
    Lattice lattice(fields, side);
    if (lattice.size() <= kMostNodes) return lattice;
  }
}

/// The waves, and the fields of the grain, which go to @a volume.
json grain(const julia::GrainVersorDescription& versor, std::string& volume) {
  std::vector<julia::PlacedBricks> fields;
  for (const std::optional<julia::PlacedBricks>& field : versor.fields) fields.push_back(field.value());
  const Lattice lattice = grainLattice(fields);
  std::array<std::vector<float>, julia::kGrainFields> values;
  for (std::size_t k = 0; k < values.size(); ++k) values[k] = lattice.valuesOf(fields[k]);
  Halves halves(julia::kGrainFields * lattice.size());
  for (std::size_t i = 0; i < lattice.size(); ++i)
    for (std::size_t k = 0; k < julia::kGrainDepth; ++k) halves.append(values[k][i]);
  for (const float depth : values[julia::kGrainDepth]) halves.append(depth);
  json description = lattice.description();
  description.update(
      {{"id", halves.id()}, {"type", "float16"}, {"error", halves.error()}, {"factors", waveFactors(versor.texture)}});
  volume = halves.takenBytes();
  return description;
}

/// The cubes that are not proved to be outside the set: one bit per cube, X fastest, the first in the lowest bit.
json occupancy(const Scene& scene, const openvdb::BBoxd& region, Monitor& monitor) {
  constexpr int kCells = 64;  // along the longest side
  const Occupancy occupied(*scene.field.evaluator, region, kCells, monitor);
  monitor.throwIfCancelled();
  const openvdb::Coord count = occupied.count();
  const auto cubes =
      static_cast<std::size_t>(count[0]) * static_cast<std::size_t>(count[1]) * static_cast<std::size_t>(count[2]);
  std::string bits((cubes + 7) / 8, '\0');
  std::size_t at = 0;
  for (int k = 0; k < count[2]; ++k)
    for (int j = 0; j < count[1]; ++j)
      for (int i = 0; i < count[0]; ++i, ++at)
        if (occupied.holds({i, j, k})) bits[at / 8] = static_cast<char>(bits[at / 8] | 1 << at % 8);
  return {{"dims", {count[0], count[1], count[2]}},
          {"origin", vector(region.min())},
          {"cell", occupied.cell()},
          {"bits", base64(bits)}};
}

/// The lowest positions of the set along Y and Z, found on a lattice that is finer along that axis; fractal space.
json lowest(const Scene& scene, const openvdb::BBoxd& region) {
  constexpr int kCells = 48, kFiner = 8;
  const Vec3d cell = region.extents() / kCells;
  json places = json::array();
  for (const int axis : {1, 2}) {
    const int across[] = {(axis + 1) % 3, (axis + 2) % 3};
    std::vector<julia::Point> points(std::size_t(kCells) * kCells);
    std::vector<double> field(points.size());
    // Finds a point within the set in one layer across the axis.
    const auto within = [&](double height) -> std::optional<Vec3d> {
      for (int j = 0; j < kCells; ++j)
        for (int i = 0; i < kCells; ++i) {
          Vec3d at = region.min();
          at[axis] += height * cell[axis];
          at[across[0]] += (i + 0.5) * cell[across[0]];
          at[across[1]] += (j + 0.5) * cell[across[1]];
          points[static_cast<std::size_t>(j * kCells + i)] = {at[0], at[1], at[2]};
        }
      scene.field.evaluator->evaluate(points, field, {});
      const auto found = std::find_if(field.begin(), field.end(), [](double f) { return f < 0; });
      if (found == field.end()) return std::nullopt;
      return Vec3d(points[static_cast<std::size_t>(found - field.begin())].data());
    };
    int layer = 0;
    while (layer < kCells && !within(layer + 0.5)) ++layer;
    for (int part = 0; part <= kFiner; ++part)
      if (const std::optional<Vec3d> place = within(layer - 0.5 + static_cast<double>(part) / kFiner)) {
        places.push_back(vector(*place));
        break;
      }
  }
  return places;
}

constexpr const char* kNotShown =
    "the page has no live picture of this versor: it shows one texture or roots, without a layer and a symmetry; "
    "'juliavdb render --field' makes pictures of any";

/// Whether the page's shader supports the versor. @param described  as VersorField::describe()
bool isShown(const std::any& described) {
  const auto* const wave = std::any_cast<julia::WaveVersorDescription>(&described);
  const auto* const grain = std::any_cast<julia::GrainVersorDescription>(&described);
  return std::any_cast<julia::Rational>(&described) || (wave && wave->octave) ||
         (grain && std::all_of(grain->fields.begin(), grain->fields.end(), [](const auto& field) { return field; }));
}

/// Adds the entries of the map, its exponent and its grain.
void describeMap(const julia::MapDescription& map, const SceneDataOptions& options, SceneData& data) {
  json& scene = data.description;
  if (const auto* shape = std::any_cast<julia::ShapeModulusDescription>(&map)) {
    if (!shape->exponent) throw std::invalid_argument("the map's exponent has no description");
    if (!isShown(shape->versor)) throw std::invalid_argument(kNotShown);
    const Volume volume(*shape->exponent, options.side);
    scene["map"] = "shape-modulus";
    if (const auto* roots = std::any_cast<julia::Rational>(&shape->versor))
      scene["factors"] = factors(*roots);
    else if (const auto* followed = std::any_cast<julia::GrainVersorDescription>(&shape->versor))
      scene["grain"] = grain(*followed, data.grain);
    else
      scene["waves"] = waves(std::any_cast<const julia::WaveVersorDescription&>(shape->versor));
    scene["exponent"] = volume.description();
    const julia::Knee& knee = shape->exponent->placement.knee;
    scene["exponent"]["knee"] = {knee.at, knee.more};
    data.volume = volume.bytes();
  } else if (const auto* rational = std::any_cast<julia::Rational>(&map)) {
    scene["map"] = "rational";
    scene["factors"] = factors(*rational);
    scene["logScale"] = rational->logScale;
  } else if (const auto* quadratic = std::any_cast<julia::QuadraticDescription>(&map)) {
    scene["map"] = "quadratic";
    scene["constant"] = quadratic->constant ? quaternion(*quadratic->constant) : json();
  } else if (const auto* cross = std::any_cast<julia::CrossOptions>(&map)) {
    constexpr std::array kPairs = {"A", "A'", "B", "C", "D", "E", "user"};
    scene["map"] = "cross";
    scene["pair"] = kPairs.at(static_cast<std::size_t>(cross->pair));
    scene["scheme"] = cross->scheme == julia::CrossScheme::FixedFactor  ? 3
                      : cross->scheme == julia::CrossScheme::Mandelbrot ? 4
                                                                        : 5;
    scene["constant"] = vector(cross->constant);
    scene["f"] = cross->f;
    scene["g"] = cross->g;
  } else if (const auto* bulb = std::any_cast<julia::MandelbulbOptions>(&map)) {
    scene["map"] = "mandelbulb";
    scene["power"] = bulb->power;
    scene["theta"] = bulb->angle == julia::TriplexAngle::FromPole ? "pole" : "plane";
    scene["constant"] = bulb->constant ? vector(*bulb->constant) : json();
  } else {
    throw std::invalid_argument("the map has no description; only the maps of this program can be explored");
  }
}

}  // namespace

float appendHalf(std::string& bytes, float value) {
  constexpr float kMost = 65000;  // of a half
  const openvdb::math::half rounded(std::clamp(value, -kMost, kMost));
  const std::uint16_t bits = rounded.bits();
  bytes.push_back(static_cast<char>(bits & 0xff));
  bytes.push_back(static_cast<char>(bits >> 8));
  return rounded;
}

FractalOptions shownOptions(const FractalOptions& options) { return forPictures(optionsAtRest(options)); }

void requireShown(const Scene& scene) {
  const julia::MapDescription map = scene.field.evaluator->describe().map;
  const auto* const shape = std::any_cast<julia::ShapeModulusDescription>(&map);
  if (shape && !isShown(shape->versor)) throw std::invalid_argument(kNotShown);
}

SceneData sceneData(const Scene& scene, const SceneDataOptions& options, Monitor& monitor) {
  constexpr int kFewest = 16, kMost = 256;
  if (options.side < kFewest || options.side > kMost)
    throw std::invalid_argument("the side of the volume is " + std::to_string(options.side) +
                                "; it must be 16 to 256 nodes");
  requireShown(scene);
  const julia::FieldDescription field = scene.field.evaluator->describe();
  constexpr std::array kAxes = {"i", "j", "k"};
  SceneData data;
  json& description = data.description;
  description = {{"format", 1},
                 {"iterations", scene.field.orbit.maxIterations},
                 {"escape", scene.field.orbit.escapeRadius},
                 {"level", field.level},
                 {"logTrap", scene.field.orbit.logTrap},
                 {"slice", field.embedding.slice},
                 {"dropAxis", kAxes.at(static_cast<std::size_t>(field.embedding.dropped))},
                 {"space", {{"centre", vector(scene.field.space.centre)}, {"scale", scene.field.space.scale}}},
                 {"facts", scene.metadata}};
  describeMap(field.map, options, data);
  const openvdb::BBoxd world = pictureRegion(scene);
  const auto inFractalSpace = [&](const Vec3d& x) { return Vec3d(scene.field.space.toFractal(x).data()); };
  const openvdb::BBoxd region(inFractalSpace(world.min()), inFractalSpace(world.max()));
  description["region"] = {{"min", vector(region.min())}, {"max", vector(region.max())}};
  if (!scene.exponent()) description["occupancy"] = occupancy(scene, region, monitor);
  description["lowest"] = lowest(scene, region);
  const FramedBall ball = frameSet(scene.source(), world);
  description["frame"] = {{"centre", vector(ball.centre)}, {"radius", ball.radius}};
  if (scene.target)
    description["targetBox"] = {{"min", vector(inFractalSpace(scene.target->distances.box.min()))},
                                {"max", vector(inFractalSpace(scene.target->distances.box.max()))}};
  return data;
}

}  // namespace vdbtools::explore
