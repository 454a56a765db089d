// SPDX-License-Identifier: Apache-2.0
#include "julia/evaluator.h"

#include "norms.h"
#include "orbit_evaluator.h"

#include <algorithm>
#include <stdexcept>

namespace julia {
namespace {

/// Of maps in Cartesian form.
template <class Real>
class CartesianEvaluator final : public OrbitEvaluator<Real> {
  using Base = OrbitEvaluator<Real>;
  using typename Base::Batch;

 public:
  CartesianEvaluator(std::shared_ptr<const CartesianMap<Real>> map, const Embedding& embedding,
                     const OrbitOptions& options)
      : Base(embedding, options, Base::logEscapeOf(options)), mMap(std::move(map)) {
    if (mMap->dimension() == 3 && (embedding.slice != 0 || embedding.dropped != DropAxis::K))
      throw std::invalid_argument("this map is one of three dimensions; it has no slice and no dropped axis");
  }

  int dimension() const override { return mMap->dimension(); }

  /// Of the steps nothing is known.
  void decide(std::span<const Point> centres, double radius, std::span<Decision> out) const override {
    std::fill(out.begin(), out.end(), Decision::Undecided);
    if (mOptions.confirmTrap || !(radius >= 0)) return;
    for (std::size_t i = 0; i < centres.size(); ++i)
      if (this->hasEscaped(this->embeddedBall(centres[i], radius))) out[i] = Decision::Outside;
  }

  void versors(std::span<const Point> points, std::span<Quaternion<double>> versors) const override {
    QuaternionBatch<Real> direction, u;
    mMap->direction(this->embed(points), direction);
    versorsOf(direction, u);
    for (std::size_t i = 0; i < points.size(); ++i) versors[i] = u.get(i).template as<double>();
  }

 private:
  using Base::mOptions;

  void takeStep(Batch& batch, int step) const override {
    if (step == 1)
      mMap->begin(batch.q, batch.carried, batch.next);
    else
      mMap->step(batch.q, batch.carried, batch.next);
    std::swap(batch.q, batch.next);
    logNorms<Real>(batch.q, batch.l);
  }

  void formIterates(Batch&) const override {}

  std::shared_ptr<const CartesianMap<Real>> mMap;
};

}  // namespace

template <class Real>
std::unique_ptr<FieldEvaluator> makeFieldEvaluator(std::shared_ptr<const CartesianMap<Real>> map,
                                                   const Embedding& embedding, const OrbitOptions& options) {
  return std::make_unique<CartesianEvaluator<Real>>(std::move(map), embedding, options);
}

template std::unique_ptr<FieldEvaluator> makeFieldEvaluator(std::shared_ptr<const CartesianMap<float>>,
                                                            const Embedding&, const OrbitOptions&);
template std::unique_ptr<FieldEvaluator> makeFieldEvaluator(std::shared_ptr<const CartesianMap<double>>,
                                                            const Embedding&, const OrbitOptions&);

}  // namespace julia
