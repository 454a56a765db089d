// SPDX-License-Identifier: Apache-2.0
// How a device evaluates a field.
#include "device/opencl_device.h"
#include "device/same_bits.h"

#include "julia/orbit_trace.h"

#include "object_pool.h"
#include "orbit_limits.h"
#include "random_numbers.h"

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <variant>
#include <vector>

namespace julia::device {
namespace {

/// Points of the space of a map: in the ball in which orbits begin, and more of them near its centre. The processor
/// evaluates those outside of it, which would try nothing.
std::vector<Point> pointsToTry(double escapeRadius) {
  constexpr std::size_t kCount = 4096;
  std::vector<Point> points(kCount);
  Random random(2);
  for (std::size_t i = 0; i < kCount; ++i) {
    const double scale = i % 8 == 0 ? 0.57 * escapeRadius : i % 8 == 1 ? 1e-3 : i % 2 == 0 ? 1 : 0.5;
    for (double& x : points[i]) x = scale * random.between(-1, 1);
  }
  points[0] = {0, 0, 0};
  return points;
}

/// Evaluates a field of ProgramData in the type Real.
template <class Real>
class DeviceEvaluator final : public FieldEvaluator, public OrbitTracer {
 public:
  /// @param host  must outlive this until own() is called with it
  DeviceEvaluator(std::shared_ptr<const OpenClDevice> device, std::unique_ptr<const ProgramData> data,
                  const FieldEvaluator& host)
      : mDevice(std::move(device)),
        mData(std::move(data)),
        mHost(&host),
        mLevel(static_cast<Real>(mData->level)),
        mProgram(mDevice->program(mData->floats, mData->switches())) {
    const OpenClDevice::Lane lane(*mDevice, mProgram, kKernel);
    const auto& numbers = std::get<std::vector<Real>>(mData->numbers);
    mNumbers = lane.uploaded(numbers.data(), numbers.size() * sizeof(Real));
    mIntegers = lane.uploaded(mData->integers.data(), mData->integers.size() * sizeof(std::int32_t));
    const auto upload = [&](const std::shared_ptr<const Bricks>& bricks, auto& places, auto& values) {
      const std::size_t size = bricks ? bricks->values.size() * sizeof(float) : 0;
      if (size > mDevice->mostBytes())
        throw DeviceFailure("its memory holds " + std::to_string(mDevice->mostBytes() >> 20) +
                            " MB in one piece, and the field needs " + std::to_string(size >> 20));
      places = lane.uploaded(bricks ? bricks->brickAt.data() : nullptr,
                             bricks ? bricks->brickAt.size() * sizeof(std::uint32_t) : 0);
      values = lane.uploaded(bricks ? bricks->values.data() : nullptr, size);
    };
    upload(mData->exponent, mPlaces[0], mValues[0]);
    upload(mData->octave, mPlaces[1], mValues[1]);
  }

  void own(std::unique_ptr<const FieldEvaluator> host) { mOwnedHost = std::move(host); }

  /// Whether the device has the processor's bits at some thousand points of the field.
  bool agrees() const {
    const std::vector<Point> points = pointsToTry(mHost->describe().orbit.escapeRadius);
    std::vector<double> here(points.size()), there(points.size());
    std::vector<int> stepsHere(points.size()), stepsThere(points.size());
    evaluateThere(points, there, stepsThere);
    mHost->evaluate(points, here, stepsHere);
    for (std::size_t i = 0; i < points.size(); ++i)
      if (!sameBits(here[i], there[i]) || stepsHere[i] != stepsThere[i]) return false;
    return true;
  }

  void evaluate(std::span<const Point> points, std::span<double> field, std::span<int> iterations) const override {
    // A few points are evaluated sooner than they are sent.
    constexpr std::size_t kFew = 64;
    if (points.size() >= kFew && !mLost) {
      try {
        return evaluateThere(points, field, iterations);
      } catch (const DeviceFailure& failure) {
        if (!mLost.exchange(true))
          mDevice->notify("The device " + mDevice->info().name + " failed (" + failure.what() +
                          "). The processor goes on; the result is the same.");
      }
    }
    mHost->evaluate(points, field, iterations);
  }

  /// A device wants many points at a time.
  std::size_t preferredBatch() const override { return mLost ? mHost->preferredBatch() : std::size_t{1} << 16; }
  FieldDescription describe() const override { return mHost->describe(); }
  int dimension() const override { return mHost->dimension(); }
  void versors(std::span<const Point> points, std::span<Quaternion<double>> versors) const override {
    mHost->versors(points, versors);
  }
  void orbitTraps(std::span<const Point> points, std::span<double> nearest) const override {
    mHost->orbitTraps(points, nearest);
  }
  void trace(std::span<const Point> points, const OrbitTrace& trace) const override {
    traceOrbits(*mHost, points, trace);
  }
  void decide(std::span<const Point> centres, double radius, std::span<Decision> out) const override {
    mHost->decide(centres, radius, out);
  }
  void evaluateBlocks(std::span<const NodeBlock> blocks) const override {
    if (mLost) return mHost->evaluateBlocks(blocks);
    FieldEvaluator::evaluateBlocks(blocks);
  }

 private:
  static constexpr const char* kKernel = "followOrbits";
  static constexpr std::size_t kMostAtOnce = std::size_t{1} << 20;

  /// What one thread needs, kept between calls.
  struct Work {
    explicit Work(const DeviceEvaluator& of) : lane(*of.mDevice, of.mProgram, kKernel) {}

    OpenClDevice::Lane lane;
    std::size_t capacity = 0;
    OpenClDevice::Memory points{}, ends{}, steps{};
    std::vector<Real> pointsHere{}, endsHere{};
    std::vector<std::int32_t> stepsHere{};
  };

  void reserve(Work& work, std::size_t count) const {
    if (count <= work.capacity) return;
    std::size_t capacity = 4096;
    while (capacity < count) capacity *= 2;
    work.points = work.lane.made(3 * capacity * sizeof(Real));
    work.ends = work.lane.made(capacity * sizeof(Real));
    work.steps = work.lane.made(capacity * sizeof(std::int32_t));
    const cl_mem arguments[] = {work.points.get(), work.ends.get(), work.steps.get()};
    for (cl_uint k = 0; k < 3; ++k) work.lane.setArgument(k, arguments[k]);
    const cl_mem shared[] = {mNumbers.get(),   mIntegers.get(),  mPlaces[0].get(),
                             mValues[0].get(), mPlaces[1].get(), mValues[1].get()};
    for (cl_uint k = 0; k < 6; ++k) work.lane.setArgument(4 + k, shared[k]);
    work.capacity = capacity;
  }

  /// @throw DeviceFailure
  void evaluateThere(std::span<const Point> points, std::span<double> field, std::span<int> iterations) const {
    const auto work = mWork.borrow();
    for (std::size_t first = 0; first < points.size(); first += kMostAtOnce) {
      const std::size_t count = std::min(kMostAtOnce, points.size() - first);
      evaluatePiece(*work, points.subspan(first, count), field.subspan(first, count),
                    iterations.empty() ? iterations : iterations.subspan(first, count));
    }
  }

  void evaluatePiece(Work& work, std::span<const Point> points, std::span<double> field,
                     std::span<int> iterations) const {
    const std::size_t count = points.size();
    reserve(work, count);
    work.pointsHere.resize(3 * count);
    work.endsHere.resize(count);
    work.stepsHere.resize(count);
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t k = 0; k < 3; ++k) work.pointsHere[3 * i + k] = static_cast<Real>(points[i][k]);
    work.lane.write(work.points.get(), work.pointsHere.data(), 3 * count * sizeof(Real));
    work.lane.setArgument(3, static_cast<cl_uint>(count));
    work.lane.run(count);
    work.lane.read(work.ends.get(), work.endsHere.data(), count * sizeof(Real));
    work.lane.read(work.steps.get(), work.stepsHere.data(), count * sizeof(std::int32_t));
    std::vector<std::size_t> unusual;
    for (std::size_t i = 0; i < count; ++i) {
      if (work.stepsHere[i] < 0) {
        unusual.push_back(i);
        continue;
      }
      field[i] = fieldOfEnd(work.endsHere[i], mLevel);
      if (!iterations.empty()) iterations[i] = work.stepsHere[i];
    }
    evaluateHere(unusual, points, field, iterations);
  }

  /// Evaluates those points of a piece that the device leaves out.
  void evaluateHere(std::span<const std::size_t> numbers, std::span<const Point> points, std::span<double> field,
                    std::span<int> iterations) const {
    if (numbers.empty()) return;
    std::vector<Point> some(numbers.size());
    for (std::size_t i = 0; i < some.size(); ++i) some[i] = points[numbers[i]];
    std::vector<double> values(some.size());
    std::vector<int> steps(some.size());
    mHost->evaluate(some, values, steps);
    for (std::size_t i = 0; i < some.size(); ++i) {
      field[numbers[i]] = values[i];
      if (!iterations.empty()) iterations[numbers[i]] = steps[i];
    }
  }

  std::shared_ptr<const OpenClDevice> mDevice;
  std::unique_ptr<const ProgramData> mData;
  const FieldEvaluator* mHost;
  std::unique_ptr<const FieldEvaluator> mOwnedHost;
  Real mLevel;
  std::shared_ptr<const OpenClDevice::Program> mProgram;
  OpenClDevice::Memory mNumbers, mIntegers, mPlaces[2], mValues[2];
  mutable std::atomic<bool> mLost = false;
  mutable ObjectPool<Work> mWork{[this] { return std::make_unique<Work>(*this); }};
};

}  // namespace

std::unique_ptr<FieldEvaluator> OpenClDevice::evaluator(std::unique_ptr<FieldEvaluator> host,
                                                        std::string& reason) const {
  reason.clear();
  auto data = programDataOf(host->describe(), reason);
  if (!data) return host;
  if (data->needsDoubles && !mInfo.doubles) {
    reason = "the device does not compute in 64 bits";
    return host;
  }
  try {
    const auto make = [&]<class Real>(Real) -> std::unique_ptr<FieldEvaluator> {
      auto evaluator = std::make_unique<DeviceEvaluator<Real>>(shared_from_this(), std::move(data), *host);
      if (!evaluator->agrees()) {
        reason = "the device has other bits than the processor at some of the points that were tried";
        return nullptr;
      }
      evaluator->own(std::move(host));
      return evaluator;
    };
    const bool floats = data->floats;
    if (auto evaluator = floats ? make(float{}) : make(double{})) return evaluator;
  } catch (const DeviceFailure& failure) {
    reason = failure.what();
  }
  return host;
}

}  // namespace julia::device
