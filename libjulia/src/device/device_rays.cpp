// SPDX-License-Identifier: Apache-2.0
#include "device/device_rays.h"

#include "device/in_pieces.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

namespace julia::device {
namespace {

/// The largest number of rays of a call, and the samples that a kernel evaluates for each of them at most.
constexpr std::size_t kMostRays = std::size_t{1} << 20;
constexpr std::int32_t kMostSamples = 256;
/// What a kernel says of a ray that has more samples.
constexpr std::int32_t kGoesOn = 3;
/// Rays take as long as many points, so a kernel begins with fewer of them.
constexpr std::size_t kFewestRaysTogether = std::size_t{1} << 13;

}  // namespace

/// The memory with which one thread follows rays, kept between calls.
struct DeviceRays::Work {
  Work(const OpenClDevice& device, std::shared_ptr<const OpenClDevice::Program> program, const SetField& setField)
      : lane(device, std::move(program), "followRays", kFewestRaysTogether) {
    setField(lane);
    numbers = lane.made(sizeof(numbersHere));
    integers = lane.made(sizeof(integersHere));
    lane.setArgument(8, numbers.get());
    lane.setArgument(9, integers.get());
  }

  void reserve(std::size_t count) {
    if (count <= capacity) return;
    const std::size_t more = roomFor(count);
    capacity = 0;
    rays = lane.made(6 * more * sizeof(double));
    brackets = lane.made(2 * more * sizeof(double));
    ends = lane.made(2 * more * sizeof(std::int32_t));
    const cl_mem arguments[] = {rays.get(), brackets.get(), ends.get()};
    for (cl_uint k = 0; k < 3; ++k) lane.setArgument(k, arguments[k]);
    capacity = more;
  }

  /// Begins to copy a march to the device.
  void write(const RayMarch& march) {
    numbersHere = {march.eye[0],    march.eye[1],    march.eye[2],    march.alpha, march.epsilon,
                   march.corner[0], march.corner[1], march.corner[2], march.side,  1 / march.side};
    integersHere = {march.delta,      static_cast<std::int32_t>(march.members.size()),
                    march.bisections, march.count[0],
                    march.count[1],   march.count[2]};
    // Grown only here, between calls.
    const auto hold = [&](OpenClDevice::Memory& memory, std::size_t& held, std::size_t bytes, cl_uint argument) {
      if (memory && bytes <= held) return;
      held = 0;
      memory = lane.made(bytes, CL_MEM_READ_ONLY);
      held = bytes;
      lane.setArgument(argument, memory.get());
    };
    hold(members, membersHeld, march.members.size_bytes(), 10);
    hold(occupied, occupiedHeld, march.occupied.size_bytes(), 11);
    lane.write(numbers.get(), numbersHere.data(), sizeof(numbersHere));
    lane.write(integers.get(), integersHere.data(), sizeof(integersHere));
    // Copies, because a device that hangs may read them later.
    membersHere.assign(march.members.begin(), march.members.end());
    occupiedHere.assign(march.occupied.begin(), march.occupied.end());
    lane.write(members.get(), membersHere.data(), march.members.size_bytes());
    if (!march.occupied.empty()) lane.write(occupied.get(), occupiedHere.data(), march.occupied.size_bytes());
    lane.setArgument(12, static_cast<cl_int>(!march.occupied.empty()));
    lane.setArgument(13, static_cast<cl_int>(kMostSamples));
  }

  OpenClDevice::Lane lane;
  std::size_t capacity = 0, membersHeld = 0, occupiedHeld = 0;
  OpenClDevice::Memory rays{}, brackets{}, ends{}, numbers{}, integers{}, members{}, occupied{};
  std::array<double, 10> numbersHere{};
  std::array<std::int32_t, 6> integersHere{};
  std::vector<double> raysHere{}, bracketsHere{}, membersHere{};
  std::vector<std::uint32_t> occupiedHere{};
  std::vector<std::int32_t> endsHere{};
};

DeviceRays::DeviceRays(const OpenClDevice& device, std::shared_ptr<const OpenClDevice::Program> program,
                       SetField setField)
    : mDevice(device), mWork([&device, program = std::move(program), setField = std::move(setField)] {
        return std::make_unique<Work>(device, program, setField);
      }) {}

DeviceRays::~DeviceRays() = default;

void DeviceRays::follow(const RayMarch& march, std::span<const MarchedRay> rays, std::span<RayMeeting> met) const {
  std::vector<std::size_t> left = begin(march, rays, met);
  std::vector<std::size_t> of = left;  // the numbers of the rays that go on
  std::vector<MarchedRay> some;
  std::vector<RayMeeting> ends;
  while (!of.empty()) {
    some.clear();
    ends.resize(of.size());
    for (const std::size_t i : of) some.push_back({rays[i].direction, met[i].outside, met[i].inside, rays[i].end});
    left = begin(march, some, ends);
    for (std::size_t k = 0; k < of.size(); ++k) {
      ends[k].samples += met[of[k]].samples;
      met[of[k]] = ends[k];
    }
    for (std::size_t& k : left) k = of[k];
    of = left;
  }
}

std::vector<std::size_t> DeviceRays::begin(const RayMarch& march, std::span<const MarchedRay> rays,
                                           std::span<RayMeeting> met) const {
  std::vector<std::size_t> goingOn;
  auto work = mWork.borrow();
  inPieces(rays.size(), kMostRays, work, [&](std::size_t first, std::size_t count) {
    work->reserve(count);
    work->write(march);
    followPiece(*work, rays.subspan(first, count), met.subspan(first, count), first, goingOn);
  });
  return goingOn;
}

void DeviceRays::followPiece(Work& work, std::span<const MarchedRay> rays, std::span<RayMeeting> met, std::size_t first,
                             std::vector<std::size_t>& goingOn) const {
  const std::size_t count = rays.size();
  work.raysHere.clear();
  for (const MarchedRay& ray : rays)
    work.raysHere.insert(work.raysHere.end(),
                         {ray.direction[0], ray.direction[1], ray.direction[2], ray.before, ray.t, ray.end});
  work.bracketsHere.resize(2 * count);
  work.endsHere.resize(2 * count);
  work.lane.write(work.rays.get(), work.raysHere.data(), 6 * count * sizeof(double));
  work.lane.setArgument(3, static_cast<cl_uint>(count));
  work.lane.run(count);
  work.lane.read(work.brackets.get(), work.bracketsHere.data(), 2 * count * sizeof(double));
  work.lane.read(work.ends.get(), work.endsHere.data(), 2 * count * sizeof(std::int32_t));
  work.lane.wait();
  mDevice.countRays(count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::int32_t end = work.endsHere[2 * i];
    met[i] = {.end = end == kGoesOn ? RayEnd::Left : static_cast<RayEnd>(end),
              .outside = work.bracketsHere[2 * i],
              .inside = work.bracketsHere[2 * i + 1],
              .samples = work.endsHere[2 * i + 1]};
    if (end == kGoesOn) goingOn.push_back(first + i);
  }
}

}  // namespace julia::device
