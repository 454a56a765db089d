// SPDX-License-Identifier: Apache-2.0
// How a device evaluates a field.
#include "device/device_rays.h"
#include "device/field_check.h"
#include "device/forwarding_evaluator.h"
#include "device/in_pieces.h"
#include "device/opencl_device.h"

#include "object_pool.h"
#include "orbit_limits.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <utility>
#include <variant>
#include <vector>

namespace julia::device {
namespace {

/// Whether the device of an evaluator has failed.
class LosableEvaluator : public ForwardingEvaluator {
 public:
  using ForwardingEvaluator::ForwardingEvaluator;
  using ForwardingEvaluator::own;
  bool isLost() const { return mLost; }

 protected:
  mutable std::atomic<bool> mLost = false;
};

/// Evaluates a field of ProgramData in the type Real.
template <class Real>
class DeviceEvaluator final : public LosableEvaluator, public DeviceCalls {
 public:
  /// @param host  must outlive this until own() is called with it
  DeviceEvaluator(std::shared_ptr<const OpenClDevice> device, std::unique_ptr<const ProgramData> data,
                  const FieldEvaluator& host)
      : LosableEvaluator(std::shared_ptr<const FieldEvaluator>(std::shared_ptr<const void>(), &host)),
        mDevice(std::move(device)),
        mData(std::move(data)),
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

  /// A call has a fixed cost, which so many nodes outweigh by far.
  std::size_t preferredNodes() const override { return mLost || !searches() ? 0 : std::size_t{1} << 22; }

  /// The nodes' coordinates are made on the device; signs are all that comes back.
  void evaluateSigns(const SearchLattice& lattice, std::span<SignBlock> blocks) const override {
    if (!searches() || !isDone([&] { findSignsThere(lattice, blocks); })) host().evaluateSigns(lattice, blocks);
  }

  void findNodeCrossings(std::span<const NodeEdge> edges, const SearchLattice& lattice,
                         std::span<double> found) const override {
    constexpr std::size_t kFew = 16;
    if (edges.size() < kFew || !searches() || !isDone([&] { findThere(edges, lattice, found); }))
      host().findNodeCrossings(edges, lattice, found);
  }

  void evaluate(std::span<const Point> points, std::span<double> field, std::span<int> iterations) const override {
    // A few points are evaluated faster than they are sent.
    constexpr std::size_t kFew = 64;
    if (points.size() < kFew || !isDone([&] { evaluateThere(points, field, iterations); }))
      host().evaluate(points, field, iterations);
  }

  /// All rounds of the search in one call.
  void findCrossings(std::span<const CrossedEdge> edges, const SearchLattice& lattice,
                     std::span<double> found) const override {
    constexpr std::size_t kFew = 16;
    if (edges.size() < kFew || !searches()) return FieldEvaluator::findCrossings(edges, lattice, found);
    if (!isDone([&] { findThere(edges, lattice, found); })) host().findCrossings(edges, lattice, found);
  }

  std::size_t preferredRays() const override { return mLost || !searches() ? 0 : std::size_t{1} << 19; }

  /// A device that cannot leaves all rays to the caller.
  void followRays(const RayMarch& march, std::span<const MarchedRay> rays, std::span<RayMeeting> met) const override {
    const auto follow = [&] {
      std::call_once(mRaysTried, [&] {
        if (!agreesOnRays(*this, host())) throw DeviceFailure("it has other bits than the processor along rays");
      });
      followThere(march, rays, met);
    };
    if (!searches() || !isDone(follow)) FieldEvaluator::followRays(march, rays, met);
  }

  /// The points are made on the device.
  void evaluateAround(std::span<const Point> centres, std::span<const double> distances,
                      std::span<const Point> directions, std::span<double> field,
                      std::span<int> iterations) const override {
    constexpr std::size_t kFew = 16;
    const auto evaluate = [&] { evaluateAroundThere(centres, distances, directions, field, iterations); };
    if (centres.size() < kFew || directions.empty() || !searches() || !isDone(evaluate))
      host().evaluateAround(centres, distances, directions, field, iterations);
  }

  /// A device is efficient only with many points at a time.
  std::size_t preferredBatch() const override { return mLost ? host().preferredBatch() : std::size_t{1} << 16; }
  void evaluateBlocks(std::span<const NodeBlock> blocks) const override {
    if (mLost) return host().evaluateBlocks(blocks);
    FieldEvaluator::evaluateBlocks(blocks);
  }

  bool searches() const override { return mDevice->info().doubles; }

  void evaluateThere(std::span<const Point> points, std::span<double> field, std::span<int> iterations) const override {
    auto work = mWork.borrow();
    inPieces(points.size(), kMostAtOnce, work, [&](std::size_t first, std::size_t count) {
      evaluatePiece(*work, points.subspan(first, count), field.subspan(first, count),
                    iterations.empty() ? iterations : iterations.subspan(first, count));
    });
  }

  void findSignsThere(const SearchLattice& lattice, std::span<SignBlock> blocks) const override {
    auto signs = mSigns.borrow();
    inPieces(blocks.size(), kMostBlocks, signs, [&](std::size_t first, std::size_t count) {
      findSignsOfPiece(*signs, lattice, blocks.subspan(first, count));
    });
  }

  void findThere(std::span<const CrossedEdge> edges, const SearchLattice& lattice,
                 std::span<double> found) const override {
    findBy(mSearch, edges, lattice, found);
  }
  void findThere(std::span<const NodeEdge> edges, const SearchLattice& lattice,
                 std::span<double> found) const override {
    findBy(mNodeSearch, edges, lattice, found);
  }
  void followThere(const RayMarch& march, std::span<const MarchedRay> rays, std::span<RayMeeting> met) const override {
    mRays.follow(march, rays, met);
  }

 private:
  static constexpr const char* kFollow = "followOrbits";
  /// The largest numbers of points, edges and blocks of a call.
  static constexpr std::size_t kMostAtOnce = std::size_t{1} << 20, kMostBlocks = std::size_t{1} << 17,
                               kMostAround = std::size_t{1} << 23;

  /// The memory with which one thread evaluates points, kept between calls.
  struct Work {
    explicit Work(const DeviceEvaluator& of) : lane(*of.mDevice, of.mProgram, kFollow) { of.setShared(lane); }

    OpenClDevice::Lane lane;
    std::size_t capacity = 0;
    OpenClDevice::Memory points{}, ends{}, steps{};
    std::vector<Real> pointsHere{}, endsHere{};
    std::vector<std::int32_t> stepsHere{};
  };
  /// The memory with which one thread evaluates points around others.
  struct Around {
    explicit Around(const DeviceEvaluator& of) : lane(*of.mDevice, of.mProgram, "followAround") { of.setShared(lane); }

    OpenClDevice::Lane lane;
    std::size_t capacity = 0, each = 0;
    OpenClDevice::Memory centres{}, ends{}, steps{}, directions{};
    std::vector<double> centresHere{}, directionsHere{};
    std::vector<Real> endsHere{};
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

  /// The memory with which one thread searches edges between nodes.
  struct NodeSearch {
    explicit NodeSearch(const DeviceEvaluator& of) : lane(*of.mDevice, of.mProgram, "searchNodeEdges") {
      of.setShared(lane);
    }

    OpenClDevice::Lane lane;
    std::size_t capacity = 0, endsCapacity = 0;
    OpenClDevice::Memory edges{}, ends{}, found{}, lattice{};
    std::vector<std::int32_t> edgesHere{};
    std::vector<float> endsHere{};
    std::vector<double> foundHere{};
    std::array<double, 5> latticeHere{};
  };
  /// The memory with which one thread evaluates signs of blocks.
  struct Signs {
    explicit Signs(const DeviceEvaluator& of) : lane(*of.mDevice, of.mProgram, "findSigns") { of.setShared(lane); }

    OpenClDevice::Lane lane;
    std::size_t capacity = 0;
    OpenClDevice::Memory blocks{}, inside{}, unusual{}, lattice{};
    std::vector<std::int32_t> blocksHere{};
    std::vector<std::array<std::uint64_t, 8>> insideHere{}, unusualHere{};
    std::array<double, 5> latticeHere{};
  };

  static std::array<double, 5> numbersOf(const SearchLattice& lattice) {
    return {lattice.voxelSize, lattice.scale, lattice.centre[0], lattice.centre[1], lattice.centre[2]};
  }

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

  /// The arguments 4 to 7, which kernels have in common. Number 3 is how many points or edges there are.
  void setShared(const OpenClDevice::Lane& lane) const {
    const cl_mem shared[] = {mNumbers.get(), mIntegers.get(), mPlaces.get(), mValues.get()};
    for (cl_uint k = 0; k < 4; ++k) lane.setArgument(4 + k, shared[k]);
  }

  void reserve(Work& work, std::size_t count) const {
    if (count <= work.capacity) return;
    const std::size_t capacity = roomFor(count);
    work.capacity = 0;
    work.points = work.lane.made(3 * capacity * sizeof(Real));
    work.ends = work.lane.made(capacity * sizeof(Real));
    work.steps = work.lane.made(capacity * sizeof(std::int32_t));
    const cl_mem arguments[] = {work.points.get(), work.ends.get(), work.steps.get()};
    for (cl_uint k = 0; k < 3; ++k) work.lane.setArgument(k, arguments[k]);
    work.capacity = capacity;
  }

  void reserve(Around& around, std::size_t count, std::size_t each) const {
    if (count <= around.capacity && each == around.each) return;
    const std::size_t capacity = roomFor(count);
    around.capacity = 0;
    around.centres = around.lane.made(4 * (capacity / each + 1) * sizeof(double));
    around.ends = around.lane.made(capacity * sizeof(Real));
    around.steps = around.lane.made(capacity * sizeof(std::int32_t));
    around.directions = around.lane.made(3 * each * sizeof(double));
    const cl_mem arguments[] = {around.centres.get(), around.ends.get(), around.steps.get()};
    for (cl_uint k = 0; k < 3; ++k) around.lane.setArgument(k, arguments[k]);
    around.lane.setArgument(8, around.directions.get());
    around.capacity = capacity;
    around.each = each;
  }

  void reserve(Search& search, std::size_t count) const {
    if (count <= search.capacity) return;
    const std::size_t capacity = roomFor(count);
    search.capacity = 0;
    search.edges = search.lane.made(6 * capacity * sizeof(double));
    search.axes = search.lane.made(capacity * sizeof(std::int32_t));
    search.found = search.lane.made(capacity * sizeof(double));
    search.lattice = search.lane.made(search.latticeHere.size() * sizeof(double));
    const cl_mem arguments[] = {search.edges.get(), search.axes.get(), search.found.get()};
    for (cl_uint k = 0; k < 3; ++k) search.lane.setArgument(k, arguments[k]);
    search.lane.setArgument(8, search.lattice.get());
    search.capacity = capacity;
  }

  void reserve(NodeSearch& search, std::size_t count, bool known) const {
    if (count > search.capacity) {
      const std::size_t capacity = roomFor(count);
      search.capacity = search.endsCapacity = 0;
      search.edges = search.lane.made(4 * capacity * sizeof(std::int32_t));
      search.found = search.lane.made(capacity * sizeof(double));
      search.ends = search.lane.made(0);
      search.lattice = search.lane.made(search.latticeHere.size() * sizeof(double));
      search.lane.setArgument(0, search.edges.get());
      search.lane.setArgument(1, search.ends.get());
      search.lane.setArgument(2, search.found.get());
      search.lane.setArgument(8, search.lattice.get());
      search.capacity = capacity;
    }
    if (!known || count <= search.endsCapacity) return;
    const std::size_t capacity = roomFor(count);
    search.ends = search.lane.made(2 * capacity * sizeof(float));
    search.lane.setArgument(1, search.ends.get());
    search.endsCapacity = capacity;
  }

  void reserve(Signs& signs, std::size_t count) const {
    if (count <= signs.capacity) return;
    const std::size_t capacity = roomFor(count);
    signs.capacity = 0;
    signs.blocks = signs.lane.made(4 * capacity * sizeof(std::int32_t));
    signs.inside = signs.lane.made(capacity * NodeBlock::kSize / 8);
    signs.unusual = signs.lane.made(capacity * NodeBlock::kSize / 8);
    signs.lattice = signs.lane.made(signs.latticeHere.size() * sizeof(double));
    const cl_mem arguments[] = {signs.blocks.get(), signs.inside.get(), signs.unusual.get()};
    for (cl_uint k = 0; k < 3; ++k) signs.lane.setArgument(k, arguments[k]);
    signs.lane.setArgument(8, signs.lattice.get());
    signs.capacity = capacity;
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
    work.lane.wait();
    mDevice->countPoints(count);
    take(work, field, iterations, [&](std::size_t i) { return points[i]; });
  }

  /// Takes the ends of the orbits of points, and evaluates those that the device leaves to the processor.
  /// @param pointAt  makes a point from its number
  template <class AnyWork, class Function>
  void take(const AnyWork& work, std::span<double> field, std::span<int> iterations, const Function& pointAt) const {
    std::vector<std::size_t> unusual;
    for (std::size_t i = 0; i < field.size(); ++i) {
      if (work.stepsHere[i] < 0) {
        unusual.push_back(i);
        continue;
      }
      field[i] = fieldOfEnd(work.endsHere[i], mLevel);
      if (!iterations.empty()) iterations[i] = work.stepsHere[i];
    }
    evaluateHere(unusual, field, iterations, pointAt);
  }

  /// @throw DeviceFailure
  void evaluateAroundThere(std::span<const Point> centres, std::span<const double> distances,
                           std::span<const Point> directions, std::span<double> field,
                           std::span<int> iterations) const {
    auto around = mAround.borrow();
    const std::size_t each = directions.size();
    inPieces(centres.size(), std::max<std::size_t>(1, kMostAround / each), around,
             [&](std::size_t first, std::size_t count) {
               evaluatePieceAround(*around, centres.subspan(first, count), distances.subspan(first, count), directions,
                                   field.subspan(first * each, count * each),
                                   iterations.empty() ? iterations : iterations.subspan(first * each, count * each));
             });
  }

  void evaluatePieceAround(Around& around, std::span<const Point> centres, std::span<const double> distances,
                           std::span<const Point> directions, std::span<double> field,
                           std::span<int> iterations) const {
    const std::size_t each = directions.size(), count = field.size();
    reserve(around, count, each);
    around.centresHere.clear();
    for (std::size_t i = 0; i < centres.size(); ++i)
      around.centresHere.insert(around.centresHere.end(), {centres[i][0], centres[i][1], centres[i][2], distances[i]});
    around.directionsHere.clear();
    for (const Point& x : directions) around.directionsHere.insert(around.directionsHere.end(), x.begin(), x.end());
    around.endsHere.resize(count);
    around.stepsHere.resize(count);
    around.lane.write(around.centres.get(), around.centresHere.data(), 4 * centres.size() * sizeof(double));
    around.lane.write(around.directions.get(), around.directionsHere.data(), 3 * each * sizeof(double));
    around.lane.setArgument(3, static_cast<cl_uint>(count));
    around.lane.setArgument(9, static_cast<cl_uint>(each));
    around.lane.run(count);
    around.lane.read(around.ends.get(), around.endsHere.data(), count * sizeof(Real));
    around.lane.read(around.steps.get(), around.stepsHere.data(), count * sizeof(std::int32_t));
    around.lane.wait();
    mDevice->countPoints(count);
    take(around, field, iterations,
         [&](std::size_t i) { return pointAlong(centres[i / each], distances[i / each], directions[i % each]); });
  }

  void findSignsOfPiece(Signs& signs, const SearchLattice& lattice, std::span<SignBlock> blocks) const {
    const std::size_t count = blocks.size(), nodes = count * NodeBlock::kSize;
    reserve(signs, count);
    signs.blocksHere.clear();
    for (const SignBlock& block : blocks)
      signs.blocksHere.insert(signs.blocksHere.end(), {block.origin[0], block.origin[1], block.origin[2],
                                                       static_cast<std::int32_t>(block.wanted)});
    signs.insideHere.resize(count);
    signs.unusualHere.resize(count);
    signs.latticeHere = numbersOf(lattice);
    signs.lane.write(signs.blocks.get(), signs.blocksHere.data(), 4 * count * sizeof(std::int32_t));
    signs.lane.write(signs.lattice.get(), signs.latticeHere.data(), signs.latticeHere.size() * sizeof(double));
    signs.lane.setArgument(3, static_cast<cl_uint>(nodes));
    signs.lane.run(nodes);
    signs.lane.read(signs.inside.get(), signs.insideHere.data(), nodes / 8);
    signs.lane.read(signs.unusual.get(), signs.unusualHere.data(), nodes / 8);
    signs.lane.wait();
    mDevice->countPoints(nodes);
    struct Node {
      SignBlock* block;
      std::size_t x, bit;
    };
    std::vector<Node> unusual;
    std::vector<Point> points;
    for (std::size_t i = 0; i < count; ++i) {
      blocks[i].inside = signs.insideHere[i];
      for (std::size_t x = 0; x < 8; ++x)
        for (std::uint64_t rest = signs.unusualHere[i][x]; rest != 0; rest &= rest - 1) {
          const auto bit = static_cast<std::size_t>(std::countr_zero(rest));
          const std::array<std::size_t, 3> offset = {x, bit / 8, bit % 8};
          unusual.push_back({&blocks[i], x, bit});
          Point& point = points.emplace_back();
          for (std::size_t axis = 0; axis < 3; ++axis)
            point[axis] = lattice.at(static_cast<double>(blocks[i].origin[axis]) + static_cast<double>(offset[axis]),
                                     static_cast<int>(axis));
        }
    }
    if (unusual.empty()) return;
    std::vector<double> field(points.size());
    host().evaluate(points, field, {});
    for (std::size_t k = 0; k < unusual.size(); ++k)
      if (field[k] < 0) unusual[k].block->inside[unusual[k].x] |= std::uint64_t{1} << unusual[k].bit;
  }

  /// @param searches  the memory for edges of this kind
  template <class AnySearch, class Edge>
  void findBy(ObjectPool<AnySearch>& searches, std::span<const Edge> edges, const SearchLattice& lattice,
              std::span<double> found) const {
    auto search = searches.borrow();
    inPieces(edges.size(), kMostAtOnce, search, [&](std::size_t first, std::size_t count) {
      const auto some = edges.subspan(first, count);
      const auto places = found.subspan(first, count);
      findPiece(*search, some, lattice, places);
      searchHere(some, lattice, places);
    });
  }
  void findHere(std::span<const CrossedEdge> edges, const SearchLattice& lattice, std::span<double> found) const {
    host().findCrossings(edges, lattice, found);
  }
  void findHere(std::span<const NodeEdge> edges, const SearchLattice& lattice, std::span<double> found) const {
    host().findNodeCrossings(edges, lattice, found);
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
    search.latticeHere = numbersOf(lattice);
    search.lane.write(search.edges.get(), search.edgesHere.data(), 6 * count * sizeof(double));
    search.lane.write(search.axes.get(), search.axesHere.data(), count * sizeof(std::int32_t));
    search.lane.write(search.lattice.get(), search.latticeHere.data(), search.latticeHere.size() * sizeof(double));
    runSearch(search, count, lattice, found);
  }

  void findPiece(NodeSearch& search, std::span<const NodeEdge> edges, const SearchLattice& lattice,
                 std::span<double> found) const {
    constexpr auto kLimit = static_cast<float>(kFieldLimit);
    const std::size_t count = edges.size();
    const bool known = std::any_of(edges.begin(), edges.end(), [](const NodeEdge& edge) {
      return std::abs(edge.from) < kLimit || std::abs(edge.to) < kLimit;
    });
    reserve(search, count, known);
    search.edgesHere.clear();
    search.endsHere.clear();
    for (const NodeEdge& edge : edges) {
      search.edgesHere.insert(search.edgesHere.end(), {edge.node[0], edge.node[1], edge.node[2], edge.axis});
      if (known) search.endsHere.insert(search.endsHere.end(), {edge.from, edge.to});
    }
    search.latticeHere = numbersOf(lattice);
    search.lane.write(search.edges.get(), search.edgesHere.data(), 4 * count * sizeof(std::int32_t));
    if (known) search.lane.write(search.ends.get(), search.endsHere.data(), 2 * count * sizeof(float));
    search.lane.write(search.lattice.get(), search.latticeHere.data(), search.latticeHere.size() * sizeof(double));
    search.lane.setArgument(11, static_cast<cl_int>(known));
    runSearch(search, count, lattice, found);
  }

  /// Runs one of the two kernels of searches.
  template <class AnySearch>
  void runSearch(AnySearch& search, std::size_t count, const SearchLattice& lattice, std::span<double> found) const {
    search.lane.setArgument(3, static_cast<cl_uint>(count));
    const double width = narrowBracket(lattice);
    search.lane.setArgument(9, width);
    search.lane.setArgument(10, std::ldexp(width, mostEvaluations(lattice) - 1));
    search.lane.run(count);
    search.foundHere.resize(count);
    search.lane.read(search.found.get(), search.foundHere.data(), count * sizeof(double));
    search.lane.wait();
    mDevice->countEdges(count);
    std::copy(search.foundHere.begin(), search.foundHere.end(), found.begin());
  }

  /// Searches the edges that the device leaves to the processor, whose places are below 0.
  template <class Edge>
  void searchHere(std::span<const Edge> edges, const SearchLattice& lattice, std::span<double> found) const {
    std::vector<Edge> some;
    for (std::size_t i = 0; i < edges.size(); ++i)
      if (found[i] < 0) some.push_back(edges[i]);
    if (some.empty()) return;
    std::vector<double> places(some.size());
    findHere(std::span<const Edge>(some), lattice, places);
    auto place = places.begin();
    for (double& one : found)
      if (one < 0) one = *place++;
  }

  /// Evaluates the points of a piece that the device leaves to the processor.
  template <class Function>
  void evaluateHere(std::span<const std::size_t> numbers, std::span<double> field, std::span<int> iterations,
                    const Function& pointAt) const {
    if (numbers.empty()) return;
    std::vector<Point> some(numbers.size());
    for (std::size_t i = 0; i < some.size(); ++i) some[i] = pointAt(numbers[i]);
    std::vector<double> values(some.size());
    std::vector<int> steps(some.size());
    host().evaluate(some, values, steps);
    for (std::size_t i = 0; i < some.size(); ++i) {
      field[numbers[i]] = values[i];
      if (!iterations.empty()) iterations[numbers[i]] = steps[i];
    }
  }

  std::shared_ptr<const OpenClDevice> mDevice;
  std::unique_ptr<const ProgramData> mData;
  Real mLevel;
  std::shared_ptr<const OpenClDevice::Program> mProgram;
  OpenClDevice::Memory mNumbers, mIntegers, mPlaces, mValues;
  mutable ObjectPool<Work> mWork{[this] { return std::make_unique<Work>(*this); }};
  mutable ObjectPool<NodeSearch> mNodeSearch{[this] { return std::make_unique<NodeSearch>(*this); }};
  mutable ObjectPool<Signs> mSigns{[this] { return std::make_unique<Signs>(*this); }};
  mutable ObjectPool<Around> mAround{[this] { return std::make_unique<Around>(*this); }};
  mutable std::once_flag mRaysTried;
  DeviceRays mRays{*mDevice, mProgram, [this](const OpenClDevice::Lane& lane) { setShared(lane); }};
  mutable ObjectPool<Search> mSearch{[this] { return std::make_unique<Search>(*this); }};
};

}  // namespace

bool OpenClDevice::evaluates(const FieldEvaluator& evaluator) const {
  const auto* const own = dynamic_cast<const LosableEvaluator*>(&evaluator);
  return own && !own->isLost();
}

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
      if (!agrees(*evaluator, *host)) {
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
