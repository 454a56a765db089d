// SPDX-License-Identifier: Apache-2.0
#include "device/program_data.h"

#include "julia/cross_map.h"
#include "julia/mandelbulb.h"
#include "julia/quadratic_map.h"
#include "julia/rational.h"
#include "julia/shape_modulus.h"
#include "julia/wave_versor.h"

#include "kernels/elementary.h"
#include "orbit_limits.h"
#include "rational_factors.h"
#include "wave_tables.h"

#include <any>
#include <cmath>
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
      : mField(field), mData(data), mReason(reason), mNumbers(kList), mIntegers(kIntegerList) {}

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
      return addRoots(*rational);
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
      mIntegers[kCount] = wholeTriplexPower(bulb->power);
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
    addLattice(*shape.exponent, kExponent, kExponentBricks, kExponentQuadratic);
    mData.exponent = shape.exponent->bricks;
    if (const auto* rational = std::any_cast<Rational>(&shape.versor)) return addRoots(*rational);
    if (const auto* waves = std::any_cast<WaveVersorDescription>(&shape.versor)) return addWaves(*waves);
    return refuse("its texture is neither one of roots nor one of waves, or it is moved, mixed or symmetric");
  }

  bool addRoots(const Rational& rational) {
    mData.versor = VersorKind::Roots;
    double largest = 0;
    const auto factors = rootFactors<Real>(rational, largest);
    if (largest > kernels::Ieee<Real>::kLargestPower) return refuse("its powers are too large");
    for (const kernels::RootFactor<Real>& factor : factors) {
      mNumbers.insert(mNumbers.end(), factor.root, factor.root + 4);
      mNumbers.push_back(factor.power);
      mIntegers.push_back(static_cast<std::int32_t>(factor.method));
      mIntegers.push_back(static_cast<std::int32_t>(factor.integer));
      mIntegers.push_back(factor.renormaliseAfterward ? 1 : 0);
    }
    mIntegers[kCount] = static_cast<std::int32_t>(factors.size());
    return true;
  }

  bool addWaves(const WaveVersorDescription& waves) {
    mData.versor = VersorKind::Waves;
    if (!waves.octave) return refuse("its octave is not one of bricks");
    if (waves.dropped != mField.embedding.dropped) return refuse("its octave is read along other axes");
    addLattice(*waves.octave, kOctave, kOctaveBricks, kOctaveQuadratic);
    mData.octave = waves.octave->bricks;
    const WaveTables<Real> tables(waves.texture);
    for (int k = 0; k < 4; ++k) mNumbers[static_cast<std::size_t>(kConstant + k)] = tables.origin[k];
    for (const kernels::WaveTerm<Real>& wave : tables.waves)
      for (const Real(*part)[4] : {&wave.frequency, &wave.cosine, &wave.sine})
        mNumbers.insert(mNumbers.end(), *part, *part + 4);
    for (const kernels::WaveSpan<Real>& factor : tables.factors) {
      mIntegers.push_back(static_cast<std::int32_t>(factor.first));
      mIntegers.push_back(static_cast<std::int32_t>(factor.last));
      mIntegers.push_back(static_cast<std::int32_t>(factor.power));
      mIntegers.push_back(factor.conjugated < 0 ? -1 : 1);
    }
    mIntegers[kCount] = static_cast<std::int32_t>(tables.factors.size());
    return true;
  }

  void addConstant(const Quaternion<double>& c) {
    const Quaternion<Real> rounded = c.as<Real>();
    mNumbers[kConstant] = rounded.a;
    mNumbers[kConstant + 1] = rounded.b;
    mNumbers[kConstant + 2] = rounded.c;
    mNumbers[kConstant + 3] = rounded.d;
  }

  /// @pre a BrickField was made of them, which has checked them
  void addLattice(const PlacedBricks& placed, int numbers, int bricks, int quadratic) {
    Real* to = mNumbers.data() + numbers;
    const auto add = [&](double x) { *to++ = static_cast<Real>(x); };
    for (const auto& row : placed.placement.matrix)
      for (const double x : row) add(x);
    for (const auto& part : {placed.placement.offset, placed.placement.low, placed.placement.high})
      for (const double x : part) add(x);
    for (int axis = 1; axis < 3; ++axis)
      mIntegers[static_cast<std::size_t>(bricks + axis - 1)] =
          static_cast<std::int32_t>(placed.bricks->count[static_cast<std::size_t>(axis)]);
    mIntegers[static_cast<std::size_t>(quadratic)] = placed.bricks->interpolation == Interpolation::Quadratic ? 1 : 0;
  }

  const FieldDescription& mField;
  ProgramData& mData;
  std::string& mReason;
  std::vector<Real> mNumbers;
  std::vector<std::int32_t> mIntegers;
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
