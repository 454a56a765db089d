// SPDX-License-Identifier: Apache-2.0
// How a device evaluates a field.
#include "device/opencl_device.h"
#include "device/same_bits.h"

#include "julia/orbit_trace.h"

#include "object_pool.h"
#include "orbit_limits.h"
#include "random_numbers.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <variant>
#include <vector>

namespace julia::device {
namespace {

/// Points on which the device is tested: in the ball in which orbits begin, and more of them near its centre. Points
/// outside the ball would test nothing, because the processor evaluates those.
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
        mProgram(mDevice->program(mData->floats, mData->switches(mDevice->info().doubles), mData->texture)) {
    const OpenClDevice::Lane lane(*mDevice, mProgram, kFollow);
    const auto& numbers = std::get<std::vector<Real>>(mData->numbers);
    mNumbers = lane.uploaded(numbers.data(), numbers.size() * sizeof(Real));
    mIntegers = lane.uploaded(mData->integers.data(), mData->integers.size() * sizeof(std::int32_t));
    std::size_t placeCount = 0, valueCount = 0;
    for (const std::shared_ptr<const Bricks>& bricks : mData->bricks) {
      placeCount += bricks->brickAt.size();
      valueCount += bricks->values.size();
    }
    const std::size_t bytes = valueCount * sizeof(float);
    if (bytes > mDevice->mostBytes())
      throw DeviceFailure("its memory holds " + std::to_string(mDevice->mostBytes() >> 20) +
                          " MB in one piece, and the field needs " + std::to_string(bytes >> 20));
    std::vector<std::uint32_t> places;
    std::vector<float> values;
    places.reserve(placeCount);
    values.reserve(valueCount);
    for (const std::shared_ptr<const Bricks>& bricks : mData->bricks) {
      places.insert(places.end(), bricks->brickAt.begin(), bricks->brickAt.end());
      values.insert(values.end(), bricks->values.begin(), bricks->values.end());
    }
    mPlaces = lane.uploaded(places.data(), places.size() * sizeof(std::uint32_t));
    mValues = lane.uploaded(values.data(), bytes);
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
    return !searches() || agreesOnEdges(points, here);
  }

  void evaluate(std::span<const Point> points, std::span<double> field, std::span<int> iterations) const override {
    // A few points are evaluated faster than they are sent.
    constexpr std::size_t kFew = 64;
    if (points.size() < kFew || !isDone([&] { evaluateThere(points, field, iterations); }))
      mHost->evaluate(points, field, iterations);
  }

  /// All rounds of the search in one call.
  void findCrossings(std::span<const CrossedEdge> edges, const SearchLattice& lattice,
                     std::span<double> found) const override {
    constexpr std::size_t kFew = 16;
    if (edges.size() < kFew || !searches()) return FieldEvaluator::findCrossings(edges, lattice, found);
    if (!isDone([&] { findThere(edges, lattice, found); })) mHost->findCrossings(edges, lattice, found);
  }

  /// A device is efficient only with many points at a time.
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
  static constexpr const char* kFollow = "followOrbits";
  static constexpr std::size_t kMostAtOnce = std::size_t{1} << 18;

  /// The memory with which one thread evaluates points, kept between calls.
  struct Work {
    explicit Work(const DeviceEvaluator& of) : lane(*of.mDevice, of.mProgram, kFollow) { of.setShared(lane); }

    OpenClDevice::Lane lane;
    std::size_t capacity = 0;
    OpenClDevice::Memory points{}, ends{}, steps{};
    std::vector<Real> pointsHere{}, endsHere{};
    std::vector<std::int32_t> stepsHere{};
  };
  /// The memory with which one thread searches edges.
  struct Search {
    explicit Search(const DeviceEvaluator& of) : lane(*of.mDevice, of.mProgram, "searchEdges") { of.setShared(lane); }

    OpenClDevice::Lane lane;
    std::size_t capacity = 0;
    OpenClDevice::Memory edges{}, axes{}, found{}, lattice{};
    std::vector<double> edgesHere{}, foundHere{};
    std::vector<std::int32_t> axesHere{};
    std::array<double, 5> latticeHere{};
  };

  bool searches() const { return mDevice->info().doubles; }

  /// Calls @a work. @return false if the device fails; it is not used again after that
  template <class Function>
  bool isDone(const Function& work) const {
    if (mLost) return false;
    try {
      work();
      return true;
    } catch (const DeviceFailure& failure) {
      if (!mLost.exchange(true))
        mDevice->notify("The device " + mDevice->info().name + " failed (" + failure.what() +
                        "). The processor goes on; the result is the same.");
      return false;
    }
  }

  /// Whether the device finds the places of the processor on edges whose first ends are @a points.
  bool agreesOnEdges(std::span<const Point> points, std::span<const double> field) const {
    constexpr double kVoxel = 1e-2;
    const SearchLattice lattice{.voxelSize = kVoxel, .centre = {0.5, -0.25, 0}, .scale = 0.75};
    std::vector<CrossedEdge> edges;
    std::vector<Point> ends;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const int axis = static_cast<int>(i % 3);
      const double at = points[i][static_cast<std::size_t>(axis)];
      const double index = (at * lattice.scale + lattice.centre[static_cast<std::size_t>(axis)]) / kVoxel;
      edges.push_back({points[i], axis, index, storedField(field[i]), 0});
      ends.push_back(points[i]);
      ends.back()[static_cast<std::size_t>(axis)] = lattice.at(index + 1, axis);
    }
    std::vector<double> atEnds(ends.size());
    mHost->evaluate(ends, atEnds, {});
    std::size_t kept = 0;
    for (std::size_t i = 0; i < edges.size(); ++i) {
      edges[i].to = storedField(atEnds[i]);
      // For some edges, F at one end is known by its sign alone.
      if (i % 4 == 0) (edges[i].to < 0 ? edges[i].from : edges[i].to) = static_cast<float>(kFieldLimit);
      if ((field[i] < 0) != (atEnds[i] < 0)) edges[kept++] = edges[i];
    }
    edges.resize(kept);
    std::vector<double> here(kept), there(kept);
    findThere(edges, lattice, there);
    mHost->findCrossings(edges, lattice, here);
    return std::equal(here.begin(), here.end(), there.begin(), [](double a, double b) { return sameBits(a, b); });
  }

  /// The number of points or edges for which memory is allocated if it has to hold @a count.
  static std::size_t roomFor(std::size_t count) {
    std::size_t capacity = 4096;
    while (capacity < count) capacity *= 2;
    return capacity;
  }
  /// The arguments 4 to 7, which kernels have in common. Number 3 is how many points or edges there are.
  void setShared(const OpenClDevice::Lane& lane) const {
    const cl_mem shared[] = {mNumbers.get(), mIntegers.get(), mPlaces.get(), mValues.get()};
    for (cl_uint k = 0; k < 4; ++k) lane.setArgument(4 + k, shared[k]);
  }

  void reserve(Work& work, std::size_t count) const {
    if (count <= work.capacity) return;
    const std::size_t capacity = roomFor(count);
    work.points = work.lane.made(3 * capacity * sizeof(Real));
    work.ends = work.lane.made(capacity * sizeof(Real));
    work.steps = work.lane.made(capacity * sizeof(std::int32_t));
    const cl_mem arguments[] = {work.points.get(), work.ends.get(), work.steps.get()};
    for (cl_uint k = 0; k < 3; ++k) work.lane.setArgument(k, arguments[k]);
    work.capacity = capacity;
  }

  void reserve(Search& search, std::size_t count) const {
    if (count <= search.capacity) return;
    const std::size_t capacity = roomFor(count);
    search.edges = search.lane.made(6 * capacity * sizeof(double));
    search.axes = search.lane.made(capacity * sizeof(std::int32_t));
    search.found = search.lane.made(capacity * sizeof(double));
    search.lattice = search.lane.made(search.latticeHere.size() * sizeof(double));
    const cl_mem arguments[] = {search.edges.get(), search.axes.get(), search.found.get()};
    for (cl_uint k = 0; k < 3; ++k) search.lane.setArgument(k, arguments[k]);
    search.lane.setArgument(8, search.lattice.get());
    search.capacity = capacity;
  }

  /// @throw DeviceFailure
  void evaluateThere(std::span<const Point> points, std::span<double> field, std::span<int> iterations) const {
    auto work = mWork.borrow();
    inPieces(points.size(), work, [&](std::size_t first, std::size_t count) {
      evaluatePiece(*work, points.subspan(first, count), field.subspan(first, count),
                    iterations.empty() ? iterations : iterations.subspan(first, count));
    });
  }

  /// Calls @a piece for one part after another, each as large as a device gets at a time. @param loan  the memory for
  /// it
  template <class Loan, class Function>
  static void inPieces(std::size_t size, Loan& loan, const Function& piece) {
    try {
      for (std::size_t first = 0; first < size; first += kMostAtOnce) piece(first, std::min(kMostAtOnce, size - first));
    } catch (const DeviceHangs&) {
      keepUntilExit(loan.release());
      throw;
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

  /// @throw DeviceFailure
  void findThere(std::span<const CrossedEdge> edges, const SearchLattice& lattice, std::span<double> found) const {
    auto search = mSearch.borrow();
    inPieces(edges.size(), search, [&](std::size_t first, std::size_t count) {
      findPiece(*search, edges.subspan(first, count), lattice, found.subspan(first, count));
    });
  }

  void findPiece(Search& search, std::span<const CrossedEdge> edges, const SearchLattice& lattice,
                 std::span<double> found) const {
    const std::size_t count = edges.size();
    reserve(search, count);
    search.edgesHere.clear();
    search.axesHere.clear();
    for (const CrossedEdge& edge : edges) {
      search.edgesHere.insert(search.edgesHere.end(), {edge.begin[0], edge.begin[1], edge.begin[2], edge.index,
                                                       static_cast<double>(edge.from), static_cast<double>(edge.to)});
      search.axesHere.push_back(edge.axis);
    }
    search.latticeHere = {lattice.voxelSize, lattice.scale, lattice.centre[0], lattice.centre[1], lattice.centre[2]};
    search.lane.write(search.edges.get(), search.edgesHere.data(), 6 * count * sizeof(double));
    search.lane.write(search.axes.get(), search.axesHere.data(), count * sizeof(std::int32_t));
    search.lane.write(search.lattice.get(), search.latticeHere.data(), search.latticeHere.size() * sizeof(double));
    search.lane.setArgument(3, static_cast<cl_uint>(count));
    const double width = narrowBracket(lattice);
    search.lane.setArgument(9, width);
    search.lane.setArgument(10, std::ldexp(width, mostEvaluations(lattice) - 1));
    search.lane.run(count);
    search.foundHere.resize(count);
    search.lane.read(search.found.get(), search.foundHere.data(), count * sizeof(double));
    std::copy(search.foundHere.begin(), search.foundHere.end(), found.begin());
    // The edges that the device leaves to the processor.
    std::vector<CrossedEdge> some;
    for (std::size_t i = 0; i < count; ++i)
      if (found[i] < 0) some.push_back(edges[i]);
    if (some.empty()) return;
    std::vector<double> places(some.size());
    mHost->findCrossings(some, lattice, places);
    auto place = places.begin();
    for (double& one : found)
      if (one < 0) one = *place++;
  }

  /// Evaluates the points of a piece that the device leaves to the processor.
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
  OpenClDevice::Memory mNumbers, mIntegers, mPlaces, mValues;
  mutable std::atomic<bool> mLost = false;
  mutable ObjectPool<Work> mWork{[this] { return std::make_unique<Work>(*this); }};
  mutable ObjectPool<Search> mSearch{[this] { return std::make_unique<Search>(*this); }};
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
