// SPDX-License-Identifier: Apache-2.0
// Several devices that share the calls of an evaluator.
#include "device/forwarding_evaluator.h"
#include "julia/device/device.h"

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

using device::ForwardingEvaluator;

/// An evaluator on a device.
struct Part {
  std::shared_ptr<const Device> device;
  std::unique_ptr<const FieldEvaluator> evaluator;
};

/// Gives each device a part of each call. All of them have the same bits.
class JoinedEvaluator final : public ForwardingEvaluator {
 public:
  JoinedEvaluator(std::shared_ptr<const FieldEvaluator> host, std::vector<Part> parts)
      : ForwardingEvaluator(std::move(host)), mParts(std::move(parts)) {}

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
  void followRays(const RayMarch& march, std::span<const MarchedRay> rays, std::span<RayMeeting> met) const override {
    share(rays.size(), kFewestEdges, [&](const FieldEvaluator& on, std::size_t first, std::size_t count) {
      on.followRays(march, rays.subspan(first, count), met.subspan(first, count));
    });
  }
  void evaluateAround(std::span<const Point> centres, std::span<const double> distances,
                      std::span<const Point> directions, std::span<double> field,
                      std::span<int> iterations) const override {
    const std::size_t each = directions.size();
    share(centres.size(), kFewestEdges, [&](const FieldEvaluator& on, std::size_t first, std::size_t count) {
      on.evaluateAround(centres.subspan(first, count), distances.subspan(first, count), directions,
                        field.subspan(first * each, count * each),
                        iterations.empty() ? iterations : iterations.subspan(first * each, count * each));
    });
  }

  /// Of all devices together.
  std::size_t preferredBatch() const override {
    std::size_t all = 0;
    for (const Part* part : working()) all += part->evaluator->preferredBatch();
    return all > 0 ? all : host().preferredBatch();
  }
  std::size_t preferredNodes() const override {
    std::size_t all = 0;
    for (const Part* part : working()) all += part->evaluator->preferredNodes();
    return all;
  }
  std::size_t preferredRays() const override {
    std::size_t all = 0;
    for (const Part* part : working()) all += part->evaluator->preferredRays();
    return all;
  }
  void evaluateBlocks(std::span<const NodeBlock> blocks) const override {
    if (working().empty()) return host().evaluateBlocks(blocks);
    FieldEvaluator::evaluateBlocks(blocks);
  }

 private:
  static constexpr std::size_t kFewestEdges = 1024;  ///< or rays

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
    if (parts.empty()) return work(host(), 0, size);
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
      all.rays += one.rays;
      all.mostPoints = std::max(all.mostPoints, one.mostPoints);
      all.mostEdges = std::max(all.mostEdges, one.mostEdges);
      all.mostRays = std::max(all.mostRays, one.mostRays);
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
      auto evaluator = device->evaluator(std::make_unique<ForwardingEvaluator>(shared), why);
      if (why.empty())
        parts.push_back({device, std::move(evaluator)});
      else if (reasons.find(why) == std::string::npos)
        reasons += (reasons.empty() ? "" : "; ") + why;
    }
    if (parts.empty()) {
      reason = reasons;
      return std::make_unique<ForwardingEvaluator>(shared);
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
