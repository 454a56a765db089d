// SPDX-License-Identifier: Apache-2.0
/// @file forwarding_evaluator.h
/// An evaluator that leaves everything to another one, except what its subclass does itself.
#pragma once

#include "julia/evaluator.h"
#include "julia/orbit_trace.h"

#include <cstddef>
#include <memory>
#include <span>
#include <utility>

namespace julia::device {

class ForwardingEvaluator : public FieldEvaluator, public OrbitTracer {
 public:
  explicit ForwardingEvaluator(std::shared_ptr<const FieldEvaluator> host) : mHost(std::move(host)) {}

  void evaluate(std::span<const Point> points, std::span<double> field, std::span<int> iterations) const override {
    mHost->evaluate(points, field, iterations);
  }
  std::size_t preferredBatch() const override { return mHost->preferredBatch(); }
  FieldDescription describe() const override { return mHost->describe(); }
  int dimension() const override { return mHost->dimension(); }
  void versors(std::span<const Point> points, std::span<Quaternion<double>> versors) const override {
    mHost->versors(points, versors);
  }
  void orbitTraps(std::span<const Point> points, std::span<double> nearest) const override {
    mHost->orbitTraps(points, nearest);
  }
  void decide(std::span<const Point> centres, double radius, std::span<Decision> out) const override {
    mHost->decide(centres, radius, out);
  }
  void evaluateBlocks(std::span<const NodeBlock> blocks) const override { mHost->evaluateBlocks(blocks); }
  std::size_t preferredNodes() const override { return mHost->preferredNodes(); }
  void evaluateSigns(const SearchLattice& lattice, std::span<SignBlock> blocks) const override {
    mHost->evaluateSigns(lattice, blocks);
  }
  void findNodeCrossings(std::span<const NodeEdge> edges, const SearchLattice& lattice,
                         std::span<double> found) const override {
    mHost->findNodeCrossings(edges, lattice, found);
  }
  void findCrossings(std::span<const CrossedEdge> edges, const SearchLattice& lattice,
                     std::span<double> found) const override {
    mHost->findCrossings(edges, lattice, found);
  }
  std::size_t preferredRays() const override { return mHost->preferredRays(); }
  void followRays(const RayMarch& march, std::span<const MarchedRay> rays, std::span<RayMeeting> met) const override {
    mHost->followRays(march, rays, met);
  }
  void evaluateAround(std::span<const Point> centres, std::span<const double> distances,
                      std::span<const Point> directions, std::span<double> field,
                      std::span<int> iterations) const override {
    mHost->evaluateAround(centres, distances, directions, field, iterations);
  }
  void trace(std::span<const Point> points, const OrbitTrace& trace) const override {
    traceOrbits(*mHost, points, trace);
  }

 protected:
  const FieldEvaluator& host() const { return *mHost; }
  /// Takes the evaluator, which the constructor may have got without its ownership.
  void own(std::unique_ptr<const FieldEvaluator> host) { mHost = std::move(host); }

 private:
  std::shared_ptr<const FieldEvaluator> mHost;
};

}  // namespace julia::device
