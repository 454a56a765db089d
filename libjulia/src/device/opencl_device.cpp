// SPDX-License-Identifier: Apache-2.0
#include "device/opencl_device.h"

#include "device/program_text.h"
#include "device/same_bits.h"

#include "random_numbers.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <mutex>
#include <optional>
#include <thread>
#include <type_traits>
#include <utility>

namespace julia::device {
namespace {

/// Explains the error codes of OpenCL that a user can do something about.
std::string meaningOf(cl_int error) {
  switch (error) {
    case CL_MEM_OBJECT_ALLOCATION_FAILURE:
    case CL_OUT_OF_RESOURCES: return "it is out of memory or was lost";
    case CL_OUT_OF_HOST_MEMORY: return "the driver is out of memory";
    case CL_DEVICE_NOT_AVAILABLE: return "it is not available";
    case CL_BUILD_PROGRAM_FAILURE: return "its compiler failed";
    case CL_INVALID_BUFFER_SIZE: return "it cannot hold that much in one piece";
    default: return "an error of its driver";
  }
}

void require(cl_int error, const char* what) {
  if (error == CL_SUCCESS) return;
  const std::string message = std::string(what) + ": OpenCL's error " + std::to_string(error) + ", " + meaningOf(error);
  // Drivers may allocate memory only when it is used first.
  if (error == CL_MEM_OBJECT_ALLOCATION_FAILURE || error == CL_INVALID_BUFFER_SIZE) throw DeviceIsFull(message);
  throw DeviceFailure(message);
}

template <class T>
T valueOf(const OpenClFunctions& cl, cl_device_id device, cl_device_info what) {
  T value{};
  require(cl.GetDeviceInfo(device, what, sizeof(value), &value, nullptr), "asking for its properties failed");
  return value;
}

template <class Ask>
std::string textOf(const Ask& ask) {
  std::size_t size = 0;
  require(ask(0, nullptr, &size), "asking for its name failed");
  std::string text(size, '\0');
  require(ask(size, text.data(), nullptr), "asking for its name failed");
  while (!text.empty() && (text.back() == '\0' || text.back() == ' ')) text.pop_back();
  return text;
}

std::string textOf(const OpenClFunctions& cl, cl_device_id device, cl_device_info what) {
  return textOf([&](std::size_t size, char* to, std::size_t* needed) {
    return cl.GetDeviceInfo(device, what, size, to, needed);
  });
}

/// Why floating-point numbers of one size do not follow IEEE 754; empty if they do.
std::string arithmeticRefusal(cl_device_fp_config has, bool floats) {
  if (!(has & CL_FP_DENORM)) return "it has no denormal numbers";
  if (!(has & CL_FP_ROUND_TO_NEAREST)) return "it does not round to the nearest number";
  if (!(has & CL_FP_INF_NAN)) return "it has no infinities";
  if (floats && !(has & CL_FP_CORRECTLY_ROUNDED_DIVIDE_SQRT))
    return "its divisions and square roots are not correctly rounded";
  return {};
}

/// Numbers whose products, quotients and sums reveal fused operations, flushed denormal numbers and inexact roots.
template <class Real>
std::array<std::vector<Real>, 3> treacherousNumbers() {
  constexpr std::size_t kCount = 4096;
  constexpr Real eps = std::numeric_limits<Real>::epsilon(), least = std::numeric_limits<Real>::min();
  std::array<std::vector<Real>, 3> numbers;
  Random random(1);
  // Numbers of all exponents, including those of denormal numbers: a mantissa from 1 to 2 times a power of two.
  const auto next = [&](int exponents) {
    const auto mantissa = static_cast<Real>(1 + random.unit());
    const auto exponent = static_cast<int>(random.between(-exponents, exponents));
    return std::ldexp(random.unit() < 0.5 ? -mantissa : mantissa, exponent);
  };
  const int all = std::numeric_limits<Real>::max_exponent;
  for (std::size_t i = 0; i < kCount; ++i) {
    const auto k = static_cast<Real>(i % 61 + 1);
    Real x = next(all), y = next(all), z = next(all);
    if (i % 4 == 0) x = next(8), y = next(8), z = -x * y;                       // fused: the product's rounding error
    if (i % 4 == 1) x = 1 + k * eps, y = 1 - k * eps, z = -1;                   // the same, where it is known
    if (i % 4 == 2) x = least * k, y = Real(1) / (1 << i % 31), z = least / k;  // denormal results
    numbers[0].push_back(x);
    numbers[1].push_back(y);
    numbers[2].push_back(z);
  }
  return numbers;
}

template <class Real>
std::array<Real, 6> arithmeticOf(Real x, Real y, Real z) {
  const Real product = x * y;
  return {product + z, x / y, std::sqrt(std::abs(x)), product, z - product, product * z};
}

constexpr const char* kTimeLimit = "JULIAVDB_DEVICE_TIMEOUT";

std::string givenTimeLimit() {
  const char* const text = std::getenv(kTimeLimit);
  return text ? text : "";
}

/// 0 if the text is not a number.
double secondsOf(const std::string& text) {
  char* end = nullptr;
  const double seconds = std::strtod(text.c_str(), &end);
  return *end == '\0' && std::isfinite(seconds) ? seconds : 0;
}

}  // namespace

void keepUntilExit(void* object) {
  static std::mutex mutex;
  static auto* const kept = new std::vector<void*>;
  const std::lock_guard lock(mutex);
  kept->push_back(object);
}

// --- The device ---

std::vector<OpenClDevice::Place> OpenClDevice::places(std::string& refusal) {
  const Drivers& drivers = openClDrivers();
  std::vector<Place> places;
  for (const Platform& platform : drivers.platforms) {
    const OpenClFunctions& cl = *platform.functions;
    cl_uint found = 0;
    if (cl.GetDeviceIDs(platform.id, CL_DEVICE_TYPE_ALL, 0, nullptr, &found) != CL_SUCCESS || found == 0) continue;
    std::vector<cl_device_id> devices(found);
    if (cl.GetDeviceIDs(platform.id, CL_DEVICE_TYPE_ALL, found, devices.data(), nullptr) != CL_SUCCESS) continue;
    for (const cl_device_id device : devices) places.push_back({platform, device});
  }
  if (places.empty()) refusal = drivers.platforms.empty() ? drivers.refusal : "none of OpenCL's platforms has a device";
  return places;
}

OpenClDevice::OpenClDevice(const Place& place, DeviceNotice notice, std::shared_ptr<const DeviceCache> cache)
    : mCl(*place.platform.functions), mDevice(place.device), mNotice(std::move(notice)), mCache(std::move(cache)) {
  try {
    const auto platform = textOf([&](std::size_t size, char* to, std::size_t* needed) {
      return mCl.GetPlatformInfo(place.platform.id, CL_PLATFORM_NAME, size, to, needed);
    });
    mInfo.name = textOf(mCl, mDevice, CL_DEVICE_NAME) + " (" + platform + ", driver " +
                 textOf(mCl, mDevice, CL_DRIVER_VERSION) + ")";
    mInfo.isGpu = (valueOf<cl_device_type>(mCl, mDevice, CL_DEVICE_TYPE) & CL_DEVICE_TYPE_GPU) != 0;
    mMostBytes = valueOf<cl_ulong>(mCl, mDevice, CL_DEVICE_MAX_MEM_ALLOC_SIZE);
    mInfo.refusal = refusalOf();
  } catch (const DeviceFailure& failure) {
    mInfo.refusal = failure.what();
  }
}

OpenClDevice::~OpenClDevice() {
  mPrograms.clear();
  if (mContext) release(mContext, mCl.ReleaseContext);
}

std::string OpenClDevice::refusalOf() {
  if (const std::string text = givenTimeLimit(); !text.empty()) {
    mSeconds = secondsOf(text);
    if (!(mSeconds > 0)) return std::string(kTimeLimit) + " is '" + text + "'; it must be a number of seconds above 0";
  } else {
    mSeconds = 60;
  }
  if (!valueOf<cl_bool>(mCl, mDevice, CL_DEVICE_AVAILABLE) ||
      !valueOf<cl_bool>(mCl, mDevice, CL_DEVICE_COMPILER_AVAILABLE))
    return "it is not available, or has no compiler";
  if (!valueOf<cl_bool>(mCl, mDevice, CL_DEVICE_ENDIAN_LITTLE)) return "its bytes are in the other order";
  std::string why = arithmeticRefusal(valueOf<cl_device_fp_config>(mCl, mDevice, CL_DEVICE_SINGLE_FP_CONFIG), true);
  if (!why.empty()) return why;
  cl_device_fp_config doubles = 0;
  // A device without doubles may not support this query.
  if (mCl.GetDeviceInfo(mDevice, CL_DEVICE_DOUBLE_FP_CONFIG, sizeof(doubles), &doubles, nullptr) != CL_SUCCESS)
    doubles = 0;
  mInfo.doubles = arithmeticRefusal(doubles, false).empty();
  cl_int error = CL_SUCCESS;
  mContext = mCl.CreateContext(nullptr, 1, &mDevice, nullptr, nullptr, &error);
  require(error, "its context cannot be made");
  if (!hadArithmetic<float>()) return "its 32-bit arithmetic has other bits than the processor's";
  if (mInfo.doubles) mInfo.doubles = hadArithmetic<double>();
  return {};
}

/// hasArithmetic(), or what an earlier process found.
template <class Real>
bool OpenClDevice::hadArithmetic() {
  const std::string key =
      "arithmetic 1\n" + mInfo.name + "\n" + programText(std::is_same_v<Real, float>, ProgramData{}.texture);
  constexpr const char* kPassed = "passed";
  if (mCache && mCache->find(key) == kPassed) return true;
  const bool passes = hasArithmetic<Real>();
  if (mCache && passes) mCache->keep(key, kPassed);
  return passes;
}

/// Compiles and runs the kernel tryArithmetic().
template <class Real>
bool OpenClDevice::hasArithmetic() {
  const auto numbers = treacherousNumbers<Real>();
  const std::size_t count = numbers[0].size();
  ProgramData plain;
  plain.map = MapKind::Quadratic;
  plain.versor = VersorKind::None;
  Lane lane(*this, program(sizeof(Real) == sizeof(float), plain.switches(false), plain.texture), "tryArithmetic");
  std::array<Memory, 3> in;
  for (std::size_t k = 0; k < 3; ++k) in[k] = lane.uploaded(numbers[k].data(), count * sizeof(Real));
  Memory out = lane.made(6 * count * sizeof(Real));
  for (std::size_t k = 0; k < 3; ++k) lane.setArgument(static_cast<cl_uint>(k), in[k].get());
  lane.setArgument(3, out.get());
  lane.setArgument(4, static_cast<cl_uint>(count));
  lane.run(count);
  auto held = std::make_unique<std::vector<Real>>(6 * count);
  std::vector<Real>& results = *held;
  try {
    lane.read(out.get(), results.data(), results.size() * sizeof(Real));
    lane.wait();
  } catch (...) {
    if (!lane.settle()) keepUntilExit(held.release());
    throw;
  }
  for (std::size_t i = 0; i < count; ++i) {
    const auto expected = arithmeticOf<Real>(numbers[0][i], numbers[1][i], numbers[2][i]);
    for (std::size_t k = 0; k < expected.size(); ++k)
      if (!sameBits(expected[k], results[6 * i + k])) return false;
  }
  return true;
}

std::shared_ptr<const OpenClDevice::Program> OpenClDevice::program(bool floats, const std::string& switches,
                                                                   const std::string& texture) const {
  const std::lock_guard lock(mMutex);
  auto& program = mPrograms[(floats ? "float" : "double") + switches + "\n" + texture];
  if (!program) program = std::make_shared<const Program>(*this, floats, switches, texture);
  return program;
}

// --- Programs, and the queues through which threads run them ---

/// Builds a program in a thread of its own, because a driver's compiler may hang.
/// @throw DeviceHangs
cl_int OpenClDevice::built(cl_program program, const std::string& options) const {
  // A compiler has more to do than a kernel.
  constexpr double kCompilerShare = 4;
  struct Build {
    std::mutex mutex;
    std::condition_variable done;
    std::optional<cl_int> error;
  };
  const auto build = std::make_shared<Build>();
  // What the thread uses lives as long as it does: the functions and the device as long as the process.
  std::thread([build, &cl = mCl, device = mDevice, program, options] {
    const cl_int error = cl.BuildProgram(program, 1, &device, options.c_str(), nullptr, nullptr);
    const std::lock_guard lock(build->mutex);
    build->error = error;
    build->done.notify_all();
  }).detach();
  std::unique_lock lock(build->mutex);
  const std::chrono::duration<double> limit(kCompilerShare * mSeconds);
  if (!build->done.wait_for(lock, limit, [&] { return build->error.has_value(); })) {
    mHangs = true;
    char seconds[32];
    std::snprintf(seconds, sizeof(seconds), "%g", limit.count());
    throw DeviceHangs("its compiler did not end in " + std::string(seconds) + " s");
  }
  return *build->error;
}

OpenClDevice::Program::Program(const OpenClDevice& device, bool floats, const std::string& switches,
                               const std::string& texture)
    : mDevice(device) {
  const std::string text = programText(floats, texture);
  const std::string options = "-cl-std=CL1.2 -cl-fp32-correctly-rounded-divide-sqrt -w" + switches;
  const std::string key = "program\n" + device.mInfo.name + "\n" + options + "\n" + text;
  if (fromCache(key, options)) return;
  build(text, options);
  if (!device.mCache) return;
  if (const std::string data = binary(); !data.empty()) device.mCache->keep(key, data);
}

bool OpenClDevice::Program::fromCache(const std::string& key, const std::string& options) {
  const std::string data = mDevice.mCache ? mDevice.mCache->find(key) : std::string();
  if (data.empty()) return false;
  const OpenClFunctions& cl = mDevice.mCl;
  const std::size_t size = data.size();
  const auto* bytes = reinterpret_cast<const unsigned char*>(data.data());
  cl_int status = CL_SUCCESS, error = CL_SUCCESS;
  mProgram = cl.CreateProgramWithBinary(mDevice.mContext, 1, &mDevice.mDevice, &size, &bytes, &status, &error);
  if (error == CL_SUCCESS && status == CL_SUCCESS && mDevice.built(mProgram, options) == CL_SUCCESS) return true;
  // A driver may refuse what another version of it has made under the same name.
  if (error == CL_SUCCESS) cl.ReleaseProgram(mProgram);
  mProgram = nullptr;
  return false;
}

void OpenClDevice::Program::build(const std::string& text, const std::string& options) {
  const OpenClFunctions& cl = mDevice.mCl;
  const char* source = text.c_str();
  const std::size_t length = text.size();
  cl_int error = CL_SUCCESS;
  mProgram = cl.CreateProgramWithSource(mDevice.mContext, 1, &source, &length, &error);
  require(error, "its program cannot be made");
  error = mDevice.built(mProgram, options);
  if (error == CL_SUCCESS) return;
  std::string log;
  try {
    log = textOf([&](std::size_t size, char* to, std::size_t* needed) {
      return cl.GetProgramBuildInfo(mProgram, mDevice.mDevice, CL_PROGRAM_BUILD_LOG, size, to, needed);
    });
  } catch (const DeviceFailure&) {
  }
  cl.ReleaseProgram(mProgram);
  // The first error is the most informative one.
  const std::size_t first = std::min(log.find("error:"), log.size());
  throw DeviceFailure("its compiler refused the program: " + log.substr(first, log.find('\n', first) - first));
}

/// The compiled program as the driver gives it out; empty if it does not.
std::string OpenClDevice::Program::binary() const {
  const OpenClFunctions& cl = mDevice.mCl;
  std::size_t size = 0;
  if (cl.GetProgramInfo(mProgram, CL_PROGRAM_BINARY_SIZES, sizeof(size), &size, nullptr) != CL_SUCCESS) return {};
  std::string data(size, '\0');
  auto* bytes = reinterpret_cast<unsigned char*>(data.data());
  if (cl.GetProgramInfo(mProgram, CL_PROGRAM_BINARIES, sizeof(bytes), &bytes, nullptr) != CL_SUCCESS) return {};
  return data;
}

OpenClDevice::Program::~Program() { mDevice.release(mProgram, mDevice.mCl.ReleaseProgram); }

OpenClDevice::Lane::Lane(const OpenClDevice& device, std::shared_ptr<const Program> program, const char* kernel,
                         std::size_t fewestTogether)
    : mDevice(device), mProgram(std::move(program)), mFewestTogether(fewestTogether), mTogether(fewestTogether) {
  const OpenClFunctions& cl = device.mCl;
  cl_int error = CL_SUCCESS;
  mQueue = cl.CreateCommandQueue(device.mContext, device.mDevice, 0, &error);
  require(error, "its queue cannot be made");
  mKernel = cl.CreateKernel(mProgram->get(), kernel, &error);
  if (error == CL_SUCCESS) return;
  cl.ReleaseCommandQueue(mQueue);
  require(error, "its kernel cannot be made");
}

OpenClDevice::Lane::~Lane() {
  release(mBegun);
  mDevice.release(mKernel, mDevice.mCl.ReleaseKernel);
  mDevice.release(mQueue, mDevice.mCl.ReleaseCommandQueue);
}

OpenClDevice::Memory OpenClDevice::Lane::made(std::size_t bytes, cl_mem_flags flags) const {
  cl_int error = CL_SUCCESS;
  // A kernel's argument cannot be empty memory.
  const cl_mem memory =
      mDevice.mCl.CreateBuffer(mDevice.mContext, flags, std::max<std::size_t>(bytes, 16), nullptr, &error);
  require(error, "its memory cannot be had");
  return Memory(memory, {&mDevice});
}

OpenClDevice::Memory OpenClDevice::Lane::uploaded(const void* data, std::size_t bytes) const {
  Memory memory = made(bytes, CL_MEM_READ_ONLY);
  if (bytes != 0)
    require(mDevice.mCl.EnqueueWriteBuffer(mQueue, memory.get(), CL_TRUE, 0, bytes, data, 0, nullptr, nullptr),
            "its memory cannot be written");
  mDevice.countUse([&](DeviceUse& use) { use.bytesOfFields += bytes; });
  return memory;
}

/// @param enqueue  gives the driver a kernel or a copy, whose event it sets
template <class Enqueue>
void OpenClDevice::Lane::begin(const char* refusal, const Enqueue& enqueue) {
  mBegun.reserve(mBegun.size() + 1);
  cl_event event = nullptr;
  require(enqueue(&event), refusal);
  mBegun.push_back(event);
}

void OpenClDevice::Lane::write(cl_mem memory, const void* data, std::size_t bytes) {
  begin("its memory cannot be written", [&](cl_event* event) {
    return mDevice.mCl.EnqueueWriteBuffer(mQueue, memory, CL_FALSE, 0, bytes, data, 0, nullptr, event);
  });
  mDevice.countUse([&](DeviceUse& use) { use.bytesTo += bytes; });
}

void OpenClDevice::Lane::read(cl_mem memory, void* data, std::size_t bytes) {
  begin("its results cannot be read", [&](cl_event* event) {
    return mDevice.mCl.EnqueueReadBuffer(mQueue, memory, CL_FALSE, 0, bytes, data, 0, nullptr, event);
  });
  mDevice.countUse([&](DeviceUse& use) { use.bytesFrom += bytes; });
}

void OpenClDevice::Lane::wait() {
  const auto begin = std::chrono::steady_clock::now();
  require(mDevice.mCl.Flush(mQueue), "its queue cannot be started");
  // Each part may take as long as an answer may, so a large call is no slow one.
  for (std::size_t i = 0; i < mBegun.size(); ++i) await(mBegun[i]);
  release(mBegun);
  const std::chrono::duration<double> waited = std::chrono::steady_clock::now() - begin;
  // How many numbers take about half a second, as a power of two.
  constexpr double kSecondsOfKernel = 0.5;
  if (mCount >= mFewestTogether) {
    const double seconds = static_cast<double>(mTogether) / static_cast<double>(mCount) * waited.count();
    if (seconds > 2 * kSecondsOfKernel)
      mTogether = std::max(mTogether / 2, mFewestTogether);
    else if (seconds < kSecondsOfKernel / 2)
      mTogether = std::min(mTogether * (seconds < kSecondsOfKernel / 16 ? 8 : 2), kMostTogether);
  }
  mCount = 0;
  mDevice.countUse([&](DeviceUse& use) {
    ++use.calls;
    use.waited += waited.count();
  });
}

void OpenClDevice::Lane::release(std::vector<cl_event>& events) const {
  for (const cl_event event : events) mDevice.release(event, mDevice.mCl.ReleaseEvent);
  events.clear();
}

bool OpenClDevice::Lane::settle() {
  if (mDevice.mHangs) return false;
  try {
    require(mDevice.mCl.Flush(mQueue), "its queue cannot be started");
    for (const cl_event event : mBegun) statusAtEnd(event);
  } catch (const DeviceFailure&) {
    return false;
  }
  release(mBegun);
  return true;
}

/// Waits until a kernel or a copy has ended. @return below 0 if it has failed  @throw DeviceHangs
cl_int OpenClDevice::Lane::statusAtEnd(cl_event event) const {
  using Clock = std::chrono::steady_clock;
  // A driver's own wait has no timeout. Most answers take less than a millisecond.
  constexpr int kRoundsAwake = 200;
  constexpr std::chrono::microseconds kNap(100);
  const auto begin = Clock::now();
  cl_int status = CL_QUEUED;
  for (int round = 0;; ++round) {
    require(mDevice.mCl.GetEventInfo(event, CL_EVENT_COMMAND_EXECUTION_STATUS, sizeof(status), &status, nullptr),
            "it does not say how far it is");
    if (status <= CL_COMPLETE) break;
    // As long as the device does the work of other threads, it does not hang.
    const Clock::duration since = std::max(begin.time_since_epoch(), mDevice.mLastAnswer.load());
    if (std::chrono::duration<double>(Clock::now().time_since_epoch() - since).count() > mDevice.mSeconds) {
      mDevice.mHangs = true;
      char seconds[32];
      std::snprintf(seconds, sizeof(seconds), "%g", mDevice.mSeconds);
      throw DeviceHangs("it gave no answer in " + std::string(seconds) + " s");
    }
    if (round < kRoundsAwake)
      std::this_thread::yield();
    else
      std::this_thread::sleep_for(kNap);
  }
  mDevice.mLastAnswer = Clock::now().time_since_epoch();
  return status;
}

void OpenClDevice::Lane::await(cl_event event) const {
  require(statusAtEnd(event), "its work failed");
  // Only this call guarantees that the data that was read is visible.
  require(mDevice.mCl.WaitForEvents(1, &event), "its work failed");
}

void OpenClDevice::Lane::run(std::size_t count) {
  // All groups are full: devices may require that, and the kernels skip the numbers beyond the last point.
  constexpr std::size_t kGroup = 64;
  const std::size_t all = (count + kGroup - 1) / kGroup * kGroup;
  mCount += count;
  for (std::size_t first = 0; first < all; first += mTogether) {
    const std::size_t size = std::min(mTogether, all - first);
    begin("its kernel cannot be run", [&](cl_event* event) {
      return mDevice.mCl.EnqueueNDRangeKernel(mQueue, mKernel, 1, &first, &size, &kGroup, 0, nullptr, event);
    });
    mDevice.countUse([](DeviceUse& use) { ++use.kernels; });
  }
}

// --- What it did ---

DeviceUse OpenClDevice::use() const {
  const std::lock_guard lock(mUseMutex);
  return mUse;
}

void OpenClDevice::countPoints(std::size_t points) const {
  countUse([&](DeviceUse& use) {
    use.points += points;
    use.mostPoints = std::max<std::uint64_t>(use.mostPoints, points);
  });
}

void OpenClDevice::countRays(std::size_t rays) const {
  countUse([&](DeviceUse& use) {
    use.rays += rays;
    use.mostRays = std::max<std::uint64_t>(use.mostRays, rays);
  });
}

void OpenClDevice::countEdges(std::size_t edges) const {
  countUse([&](DeviceUse& use) {
    use.edges += edges;
    use.mostEdges = std::max<std::uint64_t>(use.mostEdges, edges);
  });
}

}  // namespace julia::device
