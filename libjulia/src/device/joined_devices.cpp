// SPDX-License-Identifier: Apache-2.0
// Several devices that share the calls of an evaluator.
#include "julia/device/device.h"
#include "julia/orbit_trace.h"

#include <algorithm>
#include <cstddef>
#include <exception>
#include <future>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace julia {
namespace {

/// An evaluator that several others own.
class SharedEvaluator final : public FieldEvaluator, public OrbitTracer {
 public:
  explicit SharedEvaluator(std::shared_ptr<const FieldEvaluator> evaluator) : mEvaluator(std::move(evaluator)) {}

  void evaluate(std::span<const Point> points, std::span<double> field, std::span<int> iterations) const override {
    mEvaluator->evaluate(points, field, iterations);
  }
  std::size_t preferredBatch() const override { return mEvaluator->preferredBatch(); }
  FieldDescription describe() const override { return mEvaluator->describe(); }
  int dimension() const override { return mEvaluator->dimension(); }
  void versors(std::span<const Point> points, std::span<Quaternion<double>> versors) const override {
    mEvaluator->versors(points, versors);
  }
  void orbitTraps(std::span<const Point> points, std::span<double> nearest) const override {
    mEvaluator->orbitTraps(points, nearest);
  }
  void decide(std::span<const Point> centres, double radius, std::span<Decision> out) const override {
    mEvaluator->decide(centres, radius, out);
  }
  void evaluateBlocks(std::span<const NodeBlock> blocks) const override { mEvaluator->evaluateBlocks(blocks); }
  std::size_t preferredNodes() const override { return mEvaluator->preferredNodes(); }
  void evaluateSigns(const SearchLattice& lattice, std::span<SignBlock> blocks) const override {
    mEvaluator->evaluateSigns(lattice, blocks);
  }
  void findNodeCrossings(std::span<const NodeEdge> edges, const SearchLattice& lattice,
                         std::span<double> found) const override {
    mEvaluator->findNodeCrossings(edges, lattice, found);
  }
  void findCrossings(std::span<const CrossedEdge> edges, const SearchLattice& lattice,
                     std::span<double> found) const override {
    mEvaluator->findCrossings(edges, lattice, found);
  }
  void trace(std::span<const Point> points, const OrbitTrace& trace) const override {
    traceOrbits(*mEvaluator, points, trace);
  }

 private:
  std::shared_ptr<const FieldEvaluator> mEvaluator;
};

/// An evaluator on a device.
struct Part {
  std::shared_ptr<const Device> device;
  std::unique_ptr<const FieldEvaluator> evaluator;
};

/// Gives each device a part of each call. All of them have the same bits.
class JoinedEvaluator final : public FieldEvaluator, public OrbitTracer {
 public:
  JoinedEvaluator(std::shared_ptr<const FieldEvaluator> host, std::vector<Part> parts)
      : mHost(std::move(host)), mParts(std::move(parts)) {}

  void evaluate(std::span<const Point> points, std::span<double> field, std::span<int> iterations) const override {
    constexpr std::size_t kFewest = 1 << 14;
    share(points.size(), kFewest, [&](const FieldEvaluator& on, std::size_t first, std::size_t count) {
      on.evaluate(points.subspan(first, count), field.subspan(first, count),
                  iterations.empty() ? iterations : iterations.subspan(first, count));
    });
  }
  void evaluateSigns(const SearchLattice& lattice, std::span<SignBlock> blocks) const override {
    constexpr std::size_t kFewest = 64;
    share(blocks.size(), kFewest, [&](const FieldEvaluator& on, std::size_t first, std::size_t count) {
      on.evaluateSigns(lattice, blocks.subspan(first, count));
    });
  }
  void findNodeCrossings(std::span<const NodeEdge> edges, const SearchLattice& lattice,
                         std::span<double> found) const override {
    share(edges.size(), kFewestEdges, [&](const FieldEvaluator& on, std::size_t first, std::size_t count) {
      on.findNodeCrossings(edges.subspan(first, count), lattice, found.subspan(first, count));
    });
  }
  void findCrossings(std::span<const CrossedEdge> edges, const SearchLattice& lattice,
                     std::span<double> found) const override {
    share(edges.size(), kFewestEdges, [&](const FieldEvaluator& on, std::size_t first, std::size_t count) {
      on.findCrossings(edges.subspan(first, count), lattice, found.subspan(first, count));
    });
  }

  /// Of all devices together.
  std::size_t preferredBatch() const override {
    std::size_t all = 0;
    for (const Part* part : working()) all += part->evaluator->preferredBatch();
    return all > 0 ? all : mHost->preferredBatch();
  }
  std::size_t preferredNodes() const override {
    std::size_t all = 0;
    for (const Part* part : working()) all += part->evaluator->preferredNodes();
    return all;
  }
  void evaluateBlocks(std::span<const NodeBlock> blocks) const override {
    if (working().empty()) return mHost->evaluateBlocks(blocks);
    FieldEvaluator::evaluateBlocks(blocks);
  }

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
  void trace(std::span<const Point> points, const OrbitTrace& trace) const override {
    traceOrbits(*mHost, points, trace);
  }

 private:
  static constexpr std::size_t kFewestEdges = 1024;

  /// Those whose devices have not failed.
  std::vector<const Part*> working() const {
    std::vector<const Part*> parts;
    for (const Part& part : mParts)
      if (part.device->evaluates(*part.evaluator)) parts.push_back(&part);
    return parts;
  }

  /// Calls work(evaluator, first, count) for a part of 0 to @a size - 1 on each device at the same time, unless a part
  /// would be less than @a fewest.
  template <class Work>
  void share(std::size_t size, std::size_t fewest, const Work& work) const {
    const std::vector<const Part*> parts = working();
    if (parts.empty()) return work(*mHost, 0, size);
    const std::size_t count = std::clamp<std::size_t>(size / fewest, 1, parts.size());
    const auto begin = [&](std::size_t k) { return size / count * k + std::min(size % count, k); };
    std::vector<std::exception_ptr> failures(count);
    const auto run = [&](std::size_t k) {
      try {
        work(*parts[k]->evaluator, begin(k), begin(k + 1) - begin(k));
      } catch (...) {
        failures[k] = std::current_exception();
      }
    };
    std::vector<std::future<void>> others;
    for (std::size_t k = 1; k < count; ++k) others.push_back(std::async(std::launch::async, run, k));
    run(0);
    others.clear();  // waits for them
    for (const std::exception_ptr& failure : failures)
      if (failure) std::rethrow_exception(failure);
  }

  std::shared_ptr<const FieldEvaluator> mHost;
  std::vector<Part> mParts;
};

class JoinedDevices final : public Device {
 public:
  explicit JoinedDevices(std::vector<std::shared_ptr<const Device>> devices) : mDevices(std::move(devices)) {
    if (mDevices.empty()) throw std::invalid_argument("there is no device to join");
    mInfo.isGpu = mInfo.doubles = true;
    for (const auto& device : mDevices) {
      const DeviceInfo& info = device->info();
      mInfo.name += (mInfo.name.empty() ? "" : "; ") + info.name;
      mInfo.isGpu = mInfo.isGpu && info.isGpu;
      mInfo.doubles = mInfo.doubles && info.doubles;
    }
  }

  const DeviceInfo& info() const override { return mInfo; }

  DeviceUse use() const override {
    DeviceUse all;
    for (const auto& device : mDevices) {
      const DeviceUse one = device->use();
      all.calls += one.calls;
      all.kernels += one.kernels;
      all.points += one.points;
      all.edges += one.edges;
      all.mostPoints = std::max(all.mostPoints, one.mostPoints);
      all.mostEdges = std::max(all.mostEdges, one.mostEdges);
      all.bytesTo += one.bytesTo;
      all.bytesOfFields += one.bytesOfFields;
      all.bytesFrom += one.bytesFrom;
      all.waited += one.waited;
    }
    return all;
  }

  std::unique_ptr<FieldEvaluator> evaluator(std::unique_ptr<FieldEvaluator> host, std::string& reason) const override {
    reason.clear();
    const std::shared_ptr<const FieldEvaluator> shared = std::move(host);
    std::vector<Part> parts;
    std::string reasons;
    for (const auto& device : mDevices) {
      std::string why;
      auto evaluator = device->evaluator(std::make_unique<SharedEvaluator>(shared), why);
      if (why.empty())
        parts.push_back({device, std::move(evaluator)});
      else if (reasons.find(why) == std::string::npos)
        reasons += (reasons.empty() ? "" : "; ") + why;
    }
    if (parts.empty()) {
      reason = reasons;
      return std::make_unique<SharedEvaluator>(shared);
    }
    if (!reasons.empty()) notify("Not all devices evaluate the field: " + reasons + ".");
    return std::make_unique<JoinedEvaluator>(shared, std::move(parts));
  }

  bool evaluates(const FieldEvaluator& evaluator) const override {
    const auto* const joined = dynamic_cast<const JoinedEvaluator*>(&evaluator);
    return joined && joined->preferredNodes() > 0;
  }

  void notify(const std::string& sentence) const override { mDevices.front()->notify(sentence); }

 private:
  std::vector<std::shared_ptr<const Device>> mDevices;
  DeviceInfo mInfo;
};

}  // namespace

std::shared_ptr<const Device> joinedDevices(std::vector<std::shared_ptr<const Device>> devices) {
  if (devices.size() == 1) return devices.front();
  return std::make_shared<const JoinedDevices>(std::move(devices));
}

}  // namespace julia
