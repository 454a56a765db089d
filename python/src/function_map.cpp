// SPDX-License-Identifier: Apache-2.0
#include "function_map.h"

#include "vdbtools/maps/map_options.h"

#include "julia/cartesian_map.h"

#include <memory>
#include <optional>
#include <stdexcept>
#include <utility>

namespace {

using vdbtools::MapContext;
using vdbtools::MapInstance;

std::vector<double> rowsOf(const auto& batch) {
  std::vector<double> rows;
  rows.reserve(4 * batch.size());
  for (std::size_t i = 0; i < batch.size(); ++i)
    for (const auto component : {batch.a[i], batch.b[i], batch.c[i], batch.d[i]})
      rows.push_back(static_cast<double>(component));
  return rows;
}

template <class Real>
class FunctionMap final : public julia::CartesianMap<Real> {
  using Batch = julia::QuaternionBatch<Real>;

 public:
  explicit FunctionMap(MapFunction function) : mFunction(std::move(function)) {}

  int dimension() const override { return 4; }
  void begin(const Batch& start, Batch& carried, Batch& next) const override {
    carried = start;
    step(start, carried, next);
  }
  void step(const Batch& q, const Batch& carried, Batch& next) const override {
    const std::vector<double> rows = mFunction(rowsOf(q), rowsOf(carried));
    next.resize(q.size());
    for (std::size_t i = 0; i < q.size(); ++i)
      next.set(i, julia::Quaternion<double>{rows[4 * i], rows[4 * i + 1], rows[4 * i + 2], rows[4 * i + 3]}
                      .template as<Real>());
  }
  /// The function may return values that are not finite anywhere.
  bool isDefinedEverywhere() const override { return false; }

 private:
  MapFunction mFunction;
};

class FunctionInstance final : public MapInstance {
 public:
  FunctionInstance(MapFunction function, const julia::Embedding& embedding)
      : mFunction(std::move(function)), mEmbedding(embedding) {}

  std::unique_ptr<julia::FieldEvaluator> evaluator(vdbtools::Arithmetic arithmetic,
                                                   const julia::OrbitOptions& orbit) const override {
    return arithmetic == vdbtools::Arithmetic::Float ? evaluatorIn<float>(orbit) : evaluatorIn<double>(orbit);
  }

 private:
  /// Always on the processor, whatever the device.
  template <class Real>
  std::unique_ptr<julia::FieldEvaluator> evaluatorIn(const julia::OrbitOptions& orbit) const {
    return julia::makeFieldEvaluator<Real>(
        std::shared_ptr<const julia::CartesianMap<Real>>(std::make_shared<FunctionMap<Real>>(mFunction)), mEmbedding,
        orbit);
  }

  MapFunction mFunction;
  julia::Embedding mEmbedding;
};

class FunctionSettings final : public vdbtools::MapSettings {
 public:
  FunctionSettings(const julia::OrbitOptions& orbit, const julia::Embedding& embedding, MapFunction function)
      : MapSettings(orbit, embedding), mFunction(std::move(function)) {}

  /// Points outside of it have escaped before the first step.
  std::optional<double> radius() const override { return orbit().escapeRadius; }
  std::shared_ptr<const MapInstance> instance(const MapContext&) const override {
    return std::make_shared<FunctionInstance>(mFunction, embedding());
  }

 private:
  MapFunction mFunction;
};

class FunctionDescriptor final : public vdbtools::MapDescriptor {
 public:
  explicit FunctionDescriptor(MapFunction function) : mFunction(std::move(function)) {}

  std::string name() const override { return "function"; }
  std::string summary() const override { return "a function of the program's own on the quaternions"; }
  std::string proofs() const override { return "Nothing is proved: every node of the ball is evaluated."; }
  vdbtools::TargetUse targetUse() const override { return vdbtools::TargetUse::None; }
  std::vector<vdbtools::OptionSpec> options() const override {
    std::vector<vdbtools::OptionSpec> options{vdbtools::iterationsOption("10"), vdbtools::radiusOption()};
    for (vdbtools::OptionSpec& option : vdbtools::embeddingOptions()) options.push_back(std::move(option));
    return options;
  }
  std::shared_ptr<const vdbtools::MapSettings> parse(const vdbtools::RecipeReader& reader) const override {
    return std::make_shared<FunctionSettings>(vdbtools::parseOrbit(reader, "radius"), vdbtools::parseEmbedding(reader),
                                              mFunction);
  }

 private:
  MapFunction mFunction;
};

}  // namespace

vdbtools::MapRegistry::Descriptor functionMap(MapFunction function) {
  return std::make_shared<FunctionDescriptor>(std::move(function));
}
