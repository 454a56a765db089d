// SPDX-License-Identifier: Apache-2.0
#include "maps/placed_versor.h"

#include "base/lattice_field.h"
#include "control/control_lattice.h"
#include "repair/solid_input.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/base/text.h"

#include "julia/expression.h"
#include "julia/grain_versor.h"
#include "julia/mixed_versor.h"
#include "julia/moved_versor.h"
#include "julia/rational_versor.h"
#include "julia/vector_versor.h"
#include "julia/wave_versor.h"

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

namespace vdbtools {
namespace {

using julia::DirectionFunction;

using openvdb::Vec3d;

/// A field that a function makes for either arithmetic. @param Maker  called as `maker.operator()<Real>()`
template <class Maker>
class MadeField final : public SharedField {
 public:
  explicit MadeField(Maker maker) : mMaker(std::move(maker)) {}

 private:
  void make(Pointer<float>& field) const override { field = mMaker.template operator()<float>(); }
  void make(Pointer<double>& field) const override { field = mMaker.template operator()<double>(); }

  Maker mMaker;
};

template <class Maker>
SharedFieldPtr madeField(Maker maker) {
  return std::make_shared<const MadeField<Maker>>(std::move(maker));
}

std::vector<SharedFieldPtr> sharedFields(const DirectionGrids& grids, const FractalSpace& space) {
  std::vector<SharedFieldPtr> fields;
  for (const openvdb::FloatGrid::Ptr& component : grids.components)
    fields.push_back(madeField([component, space, nodes = grids.nodes]<class Real>() {
      return makeLatticeField<Real>(*component, nodes, space, julia::Interpolation::Trilinear);
    }));
  return fields;
}

/// The value of a variable at the points of a batch.
using FormulaVariable =
    std::function<void(std::span<const julia::Quaternion<double>> points, std::span<double> values)>;

/// A coordinate of the point; nothing if the variable has another name.
FormulaVariable coordinate(const std::string& name, const julia::Embedding& embedding, const FractalSpace& space,
                           const openvdb::BBoxd& box) {
  if (name == "w")
    return [embedding](auto points, auto values) {
      for (std::size_t i = 0; i < points.size(); ++i) values[i] = embedding.slicePart(points[i]);
    };
  const std::string letters = name == "height" ? "hy" : name;
  const int axis = letters.back() - 'x';
  if (axis < 0 || axis > 2 || letters.size() > 2 || (letters.size() == 2 && letters[0] != 'h')) return nullptr;
  if (letters.size() == 1)
    return [embedding, axis](auto points, auto values) {
      for (std::size_t i = 0; i < points.size(); ++i)
        values[i] = embedding.point(points[i])[static_cast<std::size_t>(axis)];
    };
  return [embedding, space, axis, from = box.min()[axis], side = box.extents()[axis]](auto points, auto values) {
    for (std::size_t i = 0; i < points.size(); ++i) {
      const double at = space.toWorld(embedding.point(points[i]))[axis] - from;
      values[i] = side > 0 ? std::clamp(at / side, 0., 1.) : 0;
    }
  };
}

/// A value that is read from a grid.
FormulaVariable gridVariable(std::shared_ptr<const julia::ScalarField<double>> field,
                             const julia::Embedding& embedding) {
  return [field = std::move(field), embedding](auto points, auto values) {
    std::array<std::vector<double>, 3> at;
    for (std::vector<double>& part : at) part.resize(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
      const julia::Point x = embedding.point(points[i]);
      for (std::size_t axis = 0; axis < 3; ++axis) at[axis][i] = x[axis];
    }
    field->sample(at[0], at[1], at[2], values);
  };
}

/// Turns components into a quaternion: three are those that are not dropped.
julia::Quaternion<double> directionFrom(std::span<const double> components, const julia::Embedding& embedding) {
  if (components.size() == 4) return {components[0], components[1], components[2], components[3]};
  return julia::Embedding{0, embedding.dropped}.quaternion<double>({components[0], components[1], components[2]});
}

using FormulaParsers = std::vector<julia::Expression>;

DirectionFunction formulaFunction(const VersorFormula& formula, const julia::Embedding& embedding,
                                  const MapContext& context) {
  std::vector<FormulaVariable> variables;
  for (const std::string& name : formula.names) {
    FormulaVariable variable = coordinate(name, embedding, context.space, context.target->box);
    if (!variable) {
      if (!context.controls || !context.controls->contains("at-" + name))
        throw std::logic_error("a formula refers to '" + name + "', which nobody has made");
      variable = gridVariable(makeControlField<double>(context.controls->at("at-" + name)), embedding);
    }
    variables.push_back(std::move(variable));
  }
  // Parsers have state, so each thread has its own.
  const auto parsers = std::make_shared<tbb::enumerable_thread_specific<FormulaParsers>>([formula] {
    FormulaParsers made;
    for (const std::string& component : formula.components) made.emplace_back(component, formula.names);
    return made;
  });
  return [variables, parsers, embedding](std::span<const julia::Quaternion<double>> points,
                                         std::span<julia::Quaternion<double>> directions) {
    std::vector<std::vector<double>> values(variables.size(), std::vector<double>(points.size()));
    for (std::size_t v = 0; v < variables.size(); ++v) variables[v](points, values[v]);
    FormulaParsers& components = parsers->local();
    std::vector<double> at(variables.size()), result(components.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
      for (std::size_t v = 0; v < variables.size(); ++v) at[v] = values[v][i];
      for (std::size_t c = 0; c < components.size(); ++c) result[c] = components[c].at(at);
      directions[i] = directionFrom(result, embedding);
    }
  };
}

DirectionFunction programFunction(const VersorFunction& function, const julia::Embedding& embedding,
                                  const FractalSpace& space) {
  return [function, embedding, space](std::span<const julia::Quaternion<double>> points,
                                      std::span<julia::Quaternion<double>> directions) {
    if (points.empty()) return;
    std::vector<Vec3d> at(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) at[i] = space.toWorld(embedding.point(points[i]));
    const std::vector<double> values = function(at);
    const std::size_t components = values.size() / points.size();
    if (values.size() != components * points.size() || (components != 3 && components != 4))
      throw std::invalid_argument("a function of directions gave " + std::to_string(values.size()) + " numbers for " +
                                  std::to_string(points.size()) + " points; it must give three or four for each");
    for (std::size_t i = 0; i < points.size(); ++i)
      directions[i] = directionFrom(std::span(values).subspan(i * components, components), embedding);
  };
}

bool hasDirection(const julia::Quaternion<double>& q) {
  return std::isfinite(q.a) && std::isfinite(q.b) && std::isfinite(q.c) && std::isfinite(q.d) &&
         (q.a != 0 || q.b != 0 || q.c != 0 || q.d != 0);
}

/// Refuses a formula that has no direction in a whole cell of a lattice about the target.
void requireDirections(const VersorSource& source, const DirectionFunction& function, const julia::Embedding& embedding,
                       const MapContext& context) {
  constexpr double kSide = 50, kMargin = 0.1;  // cells along the longest side, and the margin around it
  openvdb::BBoxd box = context.target->box;
  const double longest = longestSide(box);
  box.expand(kMargin * longest);
  ControlLattice lattice{box.min(), longest / kSide, {}};
  for (int axis = 0; axis < 3; ++axis)
    lattice.size[axis] = static_cast<int>(std::ceil(box.extents()[axis] / lattice.voxel)) + 1;
  std::vector<julia::Quaternion<double>> points(lattice.count()), directions(lattice.count());
  lattice.forEachRow([&](int x, int y) {
    const std::size_t first = lattice.index(x, y, 0), count = static_cast<std::size_t>(lattice.size[2]);
    for (int z = 0; z < lattice.size[2]; ++z)
      points[first + static_cast<std::size_t>(z)] =
          embedding.quaternion<double>(context.space.toFractal(lattice.world(Vec3d(x, y, z))));
    function(std::span(points).subspan(first, count), std::span(directions).subspan(first, count));
  });
  for (int x = 0; x + 1 < lattice.size[0]; ++x)
    for (int y = 0; y + 1 < lattice.size[1]; ++y)
      for (int z = 0; z + 1 < lattice.size[2]; ++z) {
        bool isDefined = false;
        for (int corner = 0; corner < 8 && !isDefined; ++corner)
          isDefined =
              hasDirection(directions[lattice.index(x + (corner & 1), y + (corner >> 1 & 1), z + (corner >> 2))]);
        if (isDefined) continue;
        const julia::Point at = embedding.point(points[lattice.index(x, y, z)]);
        const julia::Quaternion<double>& q = directions[lattice.index(x, y, z)];
        std::string value;
        if (source.formula->components.size() == 4)
          for (const double part : {q.a, q.b, q.c, q.d}) value += (value.empty() ? "" : ", ") + shortText(part);
        else
          for (const double part : embedding.point(q)) value += (value.empty() ? "" : ", ") + shortText(part);
        throw DataError("the formula '" + source.formula->text + "' of --" + source.option + " is (" + value +
                        ") around x = " + shortText(at[0]) + ", y = " + shortText(at[1]) + ", z = " + shortText(at[2]) +
                        ", which is no direction; it must have one everywhere in the target's box and a tenth around "
                        "it, except at single points");
      }
}

/// The parts of a layer that come from files.
struct LayerFiles {
  const std::optional<RationalFile>& roots;
  const std::optional<DirectionGrids>& directions;
  const std::optional<WaveFile>& waves;
  std::string grain;  ///< the layer's name of it; empty: none
};

PlacedLayer placedLayer(const VersorSource& source, const julia::Embedding& embedding, const MapContext& context,
                        const LayerFiles& files, SharedFieldPtr octave, const VersorFunction& function) {
  PlacedLayer layer{.source = source, .octave = std::move(octave)};
  if (source.formula) {
    layer.function = formulaFunction(*source.formula, embedding, context);
    requireDirections(source, layer.function, embedding, context);
  } else if (source.field) {
    if (!files.directions) throw std::logic_error("a field of directions was not read");
    layer.directions =
        sharedFields(filledAbout(*files.directions, context.target->box, "--" + source.option), context.space);
  } else if (source.isFunction) {
    layer.function = programFunction(function, embedding, context.space);
  } else if (!files.grain.empty() && source.followsGrain()) {
    for (const std::string& name : grainGridNames(files.grain))
      layer.grain.push_back(sharedField(context.controls->at(name)));
    layer.scale = grainScale(*context.controls->at(grainGridNames(files.grain).back()).grid);
    layer.scale.wavelength /= context.space.scale;
    layer.waves = grainWaves(source.roots, files.waves, layer.scale.octave);
  } else if (source.followsThickness()) {
    layer.waves = placeWaves(source.roots, files.waves, embedding);
  } else {
    layer.roots = placeRoots(source.roots, files.roots, embedding, context);
  }
  return layer;
}

}  // namespace

SharedFieldPtr sharedField(const ExponentGrid& grid) {
  return madeField([grid]<class Real>() { return makeExponentField<Real>(grid); });
}

SharedFieldPtr sharedField(const ControlGrid& grid) {
  return madeField([grid]<class Real>() { return makeControlField<Real>(grid); });
}

PlacedVersor::PlacedVersor(const VersorSettings& settings, const julia::Embedding& embedding, const MapContext& context,
                           const VersorFunction& function)
    : mEmbedding(embedding),
      mUnder(placedLayer(
          settings.under, embedding, context,
          {context.files.roots, context.files.directions, context.files.waves, settings.grain ? "grain" : ""},
          context.octave ? sharedField(ControlGrid{context.octave->grid, context.octave->space}) : nullptr, function)) {
  if (settings.over) {
    const ControlGrids& controls = *context.controls;
    const auto octave = controls.find("over-octave");
    mOver = placedLayer(*settings.over, embedding, context,
                        {context.files.overRoots, context.files.overDirections, context.files.overWaves,
                         settings.grain ? "over-grain" : ""},
                        octave == controls.end() ? nullptr : sharedField(octave->second), function);
    mMix = sharedField(controls.at("mix"));
  }
  if (settings.symmetry) {
    mSymmetry = settings.symmetry;
    mSymmetry->centre = context.space.toFractal(context.target->box.getCenter());
  }
}

template <class Real>
std::shared_ptr<const julia::VersorField<Real>> PlacedVersor::layer(const PlacedLayer& layer) const {
  std::shared_ptr<const julia::VersorField<Real>> field;
  const RootsSettings& settings = layer.source.roots;
  if (!layer.grain.empty()) {
    typename julia::GrainVersor<Real>::Fields fields;
    for (std::size_t k = 0; k < fields.size(); ++k) fields[k] = layer.grain[k]->get<Real>();
    field = std::make_shared<julia::GrainVersor<Real>>(*layer.waves, std::move(fields), layer.scale.wavelength,
                                                       mEmbedding.dropped);
  } else if (layer.waves) {
    field = std::make_shared<julia::WaveVersor<Real>>(*layer.waves, layer.octave->get<Real>(), mEmbedding.dropped);
  } else if (layer.source.isRoots()) {
    field = std::make_shared<julia::RationalVersor<Real>>(layer.roots.placed);
  } else {
    if (layer.function) {
      field = std::make_shared<julia::FunctionVersor<Real>>(layer.function);
    } else {
      std::vector<std::shared_ptr<const julia::ScalarField<Real>>> components;
      for (const SharedFieldPtr& component : layer.directions) components.push_back(component->get<Real>());
      field = std::make_shared<julia::VectorVersor<Real>>(std::move(components), mEmbedding.dropped);
    }
    const Vec3d& by = settings.translate;
    if (settings.scale != 1 || by != Vec3d(0))
      field = std::make_shared<julia::MovedVersor<Real>>(
          field, settings.scale, julia::Embedding{0, mEmbedding.dropped}.quaternion<double>({by[0], by[1], by[2]}));
  }
  if (mSymmetry) field = std::make_shared<julia::SymmetricVersor<Real>>(field, *mSymmetry, mEmbedding.dropped);
  return field;
}

template <class Real>
std::shared_ptr<const julia::VersorField<Real>> PlacedVersor::field() const {
  auto under = layer<Real>(mUnder);
  if (!mOver) return under;
  return std::make_shared<julia::MixedVersor<Real>>(std::move(under), layer<Real>(*mOver), mMix->get<Real>(),
                                                    mEmbedding.dropped);
}

template std::shared_ptr<const julia::VersorField<float>> PlacedVersor::field() const;
template std::shared_ptr<const julia::VersorField<double>> PlacedVersor::field() const;

bool PlacedVersor::floatsServe(const julia::OrbitOptions& orbit) const {
  const auto serves = [&](const PlacedLayer& layer) {
    return layer.source.isRoots() && !layer.waves ? floatsServeVersor(orbit, layer.roots.placed)
                                                  : floatsServeWaves(orbit);
  };
  return serves(mUnder) && (!mOver || serves(*mOver));
}

const julia::Rational* PlacedVersor::roots() const {
  const bool isRoots = mUnder.source.isRoots() && !mUnder.waves && !mOver && !mSymmetry;
  return isRoots ? &mUnder.roots.placed : nullptr;
}

std::map<std::string, std::string> PlacedVersor::metadata() const {
  return roots() ? mUnder.roots.metadata() : std::map<std::string, std::string>();
}

std::optional<std::uint64_t> PlacedVersor::seed() const {
  return mUnder.source.isRoots() ? seedOf(mUnder.source.roots) : std::nullopt;
}

void PlacedVersor::reseed(std::uint64_t seed, const MapContext& context) {
  mUnder.source.roots.random.seed = seed;
  if (mUnder.waves)
    mUnder.waves = mUnder.grain.empty() ? placeWaves(mUnder.source.roots, std::nullopt, mEmbedding)
                                        : grainWaves(mUnder.source.roots, std::nullopt, mUnder.scale.octave);
  else
    mUnder.roots = placeRoots(mUnder.source.roots, context.files.roots, mEmbedding, context);
}

}  // namespace vdbtools
