// SPDX-License-Identifier: Apache-2.0
#include "device/program_data.h"

#include "julia/cross_map.h"
#include "julia/grain_versor.h"
#include "julia/mandelbulb.h"
#include "julia/mixed_versor.h"
#include "julia/moved_versor.h"
#include "julia/quadratic_map.h"
#include "julia/rational.h"
#include "julia/shape_modulus.h"
#include "julia/vector_versor.h"
#include "julia/wave_versor.h"

#include "kernels/elementary.h"
#include "orbit_limits.h"
#include "rational_factors.h"
#include "wave_tables.h"

#include <any>
#include <array>
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <optional>
#include <type_traits>

namespace julia::device {
namespace {

/// Fills in the data of a field in the type Real; each function says whether it could.
template <class Real>
class Builder {
 public:
  Builder(const FieldDescription& field, ProgramData& data, std::string& reason)
      : mField(field), mData(data), mReason(reason), mNumbers(kNumbersList), mIntegers(kIntegersList) {}

  bool build() {
    if (mField.orbit.confirmTrap) return refuse("it checks its trap");
    const OrbitLimits<Real> limits(mField.orbit);
    mNumbers[kSlice] = static_cast<Real>(mField.embedding.slice);
    mNumbers[kNearSquared] = limits.nearSquared;
    mNumbers[kLogEscape] = limits.logEscape;
    mData.traps = limits.logTrap > -std::numeric_limits<Real>::infinity();
    mNumbers[kLogTrap] = mData.traps ? limits.logTrap : Real(0);
    mNumbers[kLevel] = static_cast<Real>(mField.level);
    mIntegers[kMostSteps] = mField.orbit.maxIterations;
    mData.dropped = static_cast<int>(mField.embedding.dropped);
    mData.floats = std::is_same_v<Real, float>;
    mData.needsDoubles = !mData.floats;
    mData.level = mField.level;
    if (!addMap()) return false;
    if (!mNodes.empty()) {
      mData.versor = VersorKind::Texture;
      mData.texture += "#define versorOfTexture " + nameOf(mNodes.size() - 1) + "\n";
    }
    addRecords(kLatticesAt, mLattices);
    addRecords(kNodesAt, mNodes);
    mData.numbers = std::move(mNumbers);
    mData.integers = std::move(mIntegers);
    return true;
  }

 private:
  bool refuse(const char* why) {
    mReason = why;
    return false;
  }

  bool addMap() {
    const MapDescription& map = mField.map;
    if (const auto* shape = std::any_cast<ShapeModulusDescription>(&map)) return addShapeModulus(*shape);
    if (const auto* rational = std::any_cast<Rational>(&map)) {
      mData.map = MapKind::Rational;
      mNumbers[kScale] = static_cast<Real>(rational->logScale);
      return addTexture(*rational);
    }
    if (const auto* quadratic = std::any_cast<QuadraticDescription>(&map)) {
      mData.map = MapKind::Quadratic;
      mData.versor = quadratic->constant ? VersorKind::Value : VersorKind::None;
      mData.ownConstant = !quadratic->constant;
      if (quadratic->constant) addConstant(*quadratic->constant);
      return true;
    }
    if (const auto* cross = std::any_cast<CrossOptions>(&map)) return addCross(*cross);
    if (const auto* bulb = std::any_cast<MandelbulbOptions>(&map)) {
      mData.map = MapKind::Triplex;
      mData.versor = VersorKind::None;
      mData.ownConstant = !bulb->constant;
      if (bulb->constant) addConstant(Embedding{}.quaternion<double>(*bulb->constant));
      mNumbers[kScale] = static_cast<Real>(bulb->power);
      mIntegers[kPower] = wholeTriplexPower(bulb->power);
      mIntegers[kFromPole] = bulb->angle == TriplexAngle::FromPole ? 1 : 0;
      return true;
    }
    return refuse("its map does not describe itself as plain data");
  }

  bool addCross(const CrossOptions& cross) {
    if (cross.pair == CrossPair::User) return refuse("its map is made of expressions");
    mData.map = MapKind::Cross;
    mData.versor = VersorKind::None;
    mData.ownConstant = cross.scheme == CrossScheme::Mandelbrot;
    mData.fixedFactor = cross.scheme == CrossScheme::FixedFactor;
    mData.needsDoubles = true;  // cosines of radians are computed in doubles
    if (cross.scheme == CrossScheme::Julia) addConstant(Embedding{}.quaternion<double>(cross.constant));
    mIntegers[kPair] = static_cast<std::int32_t>(cross.pair);
    return true;
  }

  bool addShapeModulus(const ShapeModulusDescription& shape) {
    mData.map = MapKind::ShapeModulus;
    if (!shape.exponent) return refuse("its exponent is not one of bricks");
    if (shape.dropped != mField.embedding.dropped) return refuse("its exponent is read along other axes");
    addLattice(*shape.exponent);
    return addTexture(shape.versor);
  }

  /// Adds the nodes of a texture. @param described  as VersorField::describe()
  bool addTexture(const std::any& described) {
    if (const auto* rational = std::any_cast<Rational>(&described)) return addRoots(*rational);
    if (const auto* waves = std::any_cast<WaveVersorDescription>(&described)) return addWaves(*waves);
    if (const auto* grain = std::any_cast<GrainVersorDescription>(&described)) return addGrain(*grain);
    if (const auto* fields = std::any_cast<VectorVersorDescription>(&described)) return addFields(*fields);
    if (const auto* moved = std::any_cast<MovedVersorDescription>(&described)) return addMoved(*moved);
    if (const auto* symmetric = std::any_cast<SymmetricVersorDescription>(&described)) return addSymmetric(*symmetric);
    if (const auto* mixed = std::any_cast<MixedVersorDescription>(&described)) return addMixed(*mixed);
    return refuse("its texture is a formula or a function");
  }

  bool addRoots(const Rational& rational) {
    double largest = 0;
    const auto factors = rootFactors<Real>(rational, largest);
    if (largest > kernels::Ieee<Real>::kLargestPower) return refuse("its powers are too large");
    addNode("ROOTS_VERSOR", factors.size());
    for (const kernels::RootFactor<Real>& factor : factors) {
      mNumbers.insert(mNumbers.end(), factor.root, factor.root + 4);
      mNumbers.push_back(factor.power);
      mIntegers.push_back(static_cast<std::int32_t>(factor.method));
      mIntegers.push_back(static_cast<std::int32_t>(factor.integer));
      mIntegers.push_back(factor.renormaliseAfterward ? 1 : 0);
    }
    return true;
  }

  bool addWaves(const WaveVersorDescription& waves) {
    if (!waves.octave) return refuse("its octave is not one of bricks");
    if (waves.dropped != mField.embedding.dropped) return refuse("its octave is read along other axes");
    const WaveTables<Real> tables(waves.texture);
    addLattice(*waves.octave);
    addNode("WAVES_VERSOR", tables.factors.size(), {}, 1);
    mNumbers.insert(mNumbers.end(), tables.origin, tables.origin + 4);
    addWaveTables(tables);
    return true;
  }

  bool addGrain(const GrainVersorDescription& grain) {
    if (grain.dropped != mField.embedding.dropped) return refuse("its grain is read along other axes");
    for (const auto& field : grain.fields)
      if (!field) return refuse("the fields of its grain are not of bricks");
    for (const auto& field : grain.fields) addLattice(*field);
    const WaveTables<Real> tables(grain.texture);
    addNode("GRAIN_VERSOR", tables.factors.size(), {}, grain.fields.size());
    addWaveTables(tables);
    return true;
  }

  void addWaveTables(const WaveTables<Real>& tables) {
    for (const kernels::WaveTerm<Real>& wave : tables.waves)
      for (const Real(*part)[4] : {&wave.frequency, &wave.cosine, &wave.sine})
        mNumbers.insert(mNumbers.end(), *part, *part + 4);
    for (const kernels::WaveSpan<Real>& factor : tables.factors) {
      mIntegers.push_back(static_cast<std::int32_t>(factor.first));
      mIntegers.push_back(static_cast<std::int32_t>(factor.last));
      mIntegers.push_back(static_cast<std::int32_t>(factor.power));
      mIntegers.push_back(factor.conjugated < 0 ? -1 : 1);
    }
  }

  bool addFields(const VectorVersorDescription& fields) {
    if (fields.dropped != mField.embedding.dropped) return refuse("its texture is read along other axes");
    for (const auto& component : fields.components)
      if (!component) return refuse("the fields of its texture are not of bricks");
    for (const auto& component : fields.components) addLattice(*component);
    addNode("FIELDS_VERSOR", fields.components.size(), {}, fields.components.size());
    return true;
  }

  bool addMoved(const MovedVersorDescription& moved) {
    if (!addTexture(moved.versor)) return false;
    addNode("MOVED_VERSOR", 0, {mNodes.size() - 1});
    const Quaternion<Real> by = moved.translate.as<Real>();
    mNumbers.insert(mNumbers.end(), {by.a, by.b, by.c, by.d, static_cast<Real>(moved.scale)});
    return true;
  }

  bool addSymmetric(const SymmetricVersorDescription& symmetric) {
    const Symmetry& symmetry = symmetric.symmetry;
    if (symmetric.dropped != mField.embedding.dropped) return refuse("its symmetry is one along other axes");
    if (!addTexture(symmetric.versor)) return false;
    const std::vector<SectorTurn> turns = sectorTurns(symmetry.fold);
    addNode(symmetry.kaleidoscope || turns.size() == 1 ? "FOLDED_VERSOR" : "TURNED_VERSOR", turns.size(),
            {mNodes.size() - 1});
    for (const double x : symmetry.centre) mNumbers.push_back(static_cast<Real>(x));
    for (const SectorTurn& turn : turns)
      mNumbers.insert(mNumbers.end(), {static_cast<Real>(turn.cosine), static_cast<Real>(turn.sine)});
    std::int32_t mirrored = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) mirrored |= symmetry.mirrored[axis] ? 1 << axis : 0;
    mIntegers.insert(mIntegers.end(), {symmetry.axis, mirrored, symmetry.kaleidoscope ? 1 : 0});
    return true;
  }

  bool addMixed(const MixedVersorDescription& mixed) {
    if (!mixed.mix) return refuse("the mask of its texture is not one of bricks");
    if (mixed.dropped != mField.embedding.dropped) return refuse("the mask of its texture is read along other axes");
    if (!addTexture(mixed.under)) return false;
    const std::size_t under = mNodes.size() - 1;
    if (!addTexture(mixed.over)) return false;
    addLattice(*mixed.mix);
    addNode("MIXED_VERSOR", 0, {under, mNodes.size() - 1}, 1);
    return true;
  }

  static std::string nameOf(std::size_t node) { return "versor" + std::to_string(node); }

  /// Begins a node whose numbers and integers follow. @param word  the macro of versors.cl that defines its function
  /// @param lattices  the number of lattices that it reads, which are the last ones added
  void addNode(const char* word, std::size_t count, std::initializer_list<std::size_t> children = {},
               std::size_t lattices = 0) {
    const std::size_t number = mNodes.size();
    mData.texture += std::string(word) + "(" + nameOf(number) + ", " + std::to_string(number);
    for (const std::size_t child : children) mData.texture += ", " + nameOf(child);
    mData.texture += ")\n";
    mNodes.push_back({static_cast<std::int32_t>(mNumbers.size()), static_cast<std::int32_t>(mIntegers.size()),
                      static_cast<std::int32_t>(count), static_cast<std::int32_t>(mLattices.size() - lattices)});
  }

  template <std::size_t kSize>
  void addRecords(Integer where, const std::vector<std::array<std::int32_t, kSize>>& records) {
    mIntegers[where] = static_cast<std::int32_t>(mIntegers.size());
    for (const auto& record : records) mIntegers.insert(mIntegers.end(), record.begin(), record.end());
  }

  void addConstant(const Quaternion<double>& c) {
    const Quaternion<Real> rounded = c.as<Real>();
    mNumbers[kConstant] = rounded.a;
    mNumbers[kConstant + 1] = rounded.b;
    mNumbers[kConstant + 2] = rounded.c;
    mNumbers[kConstant + 3] = rounded.d;
  }

  /// @pre a BrickField was made from them, which has checked them
  void addLattice(const PlacedBricks& placed) {
    const Bricks& bricks = *placed.bricks;
    const auto [places, values] = startOf(placed.bricks);
    constexpr int kLowerBits = 31;  // no place is negative
    mLattices.push_back({static_cast<std::int32_t>(mNumbers.size()), static_cast<std::int32_t>(bricks.count[1]),
                         static_cast<std::int32_t>(bricks.count[2]),
                         bricks.interpolation == Interpolation::Quadratic ? 1 : 0, static_cast<std::int32_t>(places),
                         static_cast<std::int32_t>(values % (std::uint64_t{1} << kLowerBits)),
                         static_cast<std::int32_t>(values >> kLowerBits)});
    for (const auto& row : placed.placement.matrix)
      for (const double x : row) mNumbers.push_back(static_cast<Real>(x));
    for (const auto& part : {placed.placement.offset, placed.placement.low, placed.placement.high})
      for (const double x : part) mNumbers.push_back(static_cast<Real>(x));
    for (const double x : {placed.placement.knee.at, placed.placement.knee.more})
      mNumbers.push_back(static_cast<Real>(x));
  }

  /// Where a field's places and values of bricks begin in the arrays of all fields.
  struct Start {
    std::uint64_t places = 0, values = 0;
  };
  /// Adds the bricks, unless another lattice has added them.
  Start startOf(const std::shared_ptr<const Bricks>& bricks) {
    Start start;
    for (const std::shared_ptr<const Bricks>& added : mData.bricks) {
      if (added == bricks) return start;
      start.places += added->brickAt.size();
      start.values += added->values.size();
    }
    mData.bricks.push_back(bricks);
    return start;
  }

  const FieldDescription& mField;
  ProgramData& mData;
  std::string& mReason;
  std::vector<Real> mNumbers;
  std::vector<std::int32_t> mIntegers;
  std::vector<std::array<std::int32_t, kLatticeSize>> mLattices;
  std::vector<std::array<std::int32_t, kNodeSize>> mNodes;
};

}  // namespace

std::string ProgramData::switches(bool searches) const {
  const auto one = [](const char* name, int value) { return std::string(" -D ") + name + "=" + std::to_string(value); };
  return one("MAP", static_cast<int>(map)) + one("VERSOR", static_cast<int>(versor)) + one("DROPPED", dropped) +
         one("TRAPS", traps) + one("OWN_CONSTANT", ownConstant) + one("FIXED_FACTOR", fixedFactor) +
         one("SEARCHES", searches);
}

std::unique_ptr<const ProgramData> programDataOf(const FieldDescription& field, std::string& reason) {
  auto data = std::make_unique<ProgramData>();
  const bool done =
      field.inFloats ? Builder<float>(field, *data, reason).build() : Builder<double>(field, *data, reason).build();
  if (!done) data.reset();
  return data;
}

}  // namespace julia::device
