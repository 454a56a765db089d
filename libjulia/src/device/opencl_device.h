// SPDX-License-Identifier: Apache-2.0
/// @file opencl_device.h
/// A device of OpenCL, its programs, and the queues through which threads run them.
#pragma once

#include "julia/device/device.h"

#include "device/opencl_drivers.h"
#include "device/program_data.h"

#include <atomic>
#include <chrono>
#include <cstddef>
#include <map>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

namespace julia::device {

/// A device or its driver has failed. The message says in a few words what it could not do. The driver may still use
/// the memory that it was given, until Lane::settle() returns true.
class DeviceFailure : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The device or its driver did not answer in time. It may still read and write the memory that it was given, so that
/// memory is never released.
class DeviceHangs : public DeviceFailure {
 public:
  using DeviceFailure::DeviceFailure;
};

/// The device has no memory for something. Less of it may fit.
class DeviceIsFull : public DeviceFailure {
 public:
  using DeviceFailure::DeviceFailure;
};

/// Keeps an object that a device may still use although it has failed. The object is never released, but
/// stays reachable.
void keepUntilExit(void* object);

class OpenClDevice final : public Device, public std::enable_shared_from_this<OpenClDevice> {
 public:
  /// Where a device is found.
  struct Place {
    Platform platform;
    cl_device_id device;
  };

  /// All devices. @param refusal  receives the reason if there is none
  static std::vector<Place> places(std::string& refusal);

  /// Opens a device and tries its arithmetic; if it cannot be used, info().refusal says why.
  OpenClDevice(const Place& place, DeviceNotice notice, std::shared_ptr<const DeviceCache> cache);
  OpenClDevice(const OpenClDevice&) = delete;
  ~OpenClDevice() override;

  const DeviceInfo& info() const override { return mInfo; }
  DeviceUse use() const override;
  std::unique_ptr<FieldEvaluator> evaluator(std::unique_ptr<FieldEvaluator> host, std::string& reason) const override;

  bool evaluates(const FieldEvaluator& evaluator) const override;

  /// A compiled program.
  class Program {
   public:
    /// @throw DeviceFailure
    Program(const OpenClDevice& device, bool floats, const std::string& switches, const std::string& texture);
    Program(const Program&) = delete;
    ~Program();
    cl_program get() const { return mProgram; }

   private:
    /// @return whether the cache had it, and the driver takes it
    bool fromCache(const std::string& key, const std::string& options);
    void build(const std::string& text, const std::string& options);
    std::string binary() const;

    const OpenClDevice& mDevice;
    cl_program mProgram = nullptr;
  };

  void notify(const std::string& sentence) const override {
    if (mNotice) mNotice(sentence);
  }
  /// The program of a field. It is compiled once for all fields with the same switches and textures of the same kind.
  /// @param switches, texture  as in ProgramData  @throw DeviceFailure
  std::shared_ptr<const Program> program(bool floats, const std::string& switches, const std::string& texture) const;
  std::size_t mostBytes() const { return mMostBytes; }  ///< the size limit of a single allocation

  struct ReleaseMemory {
    const OpenClDevice* device;
    void operator()(cl_mem memory) const { device->release(memory, device->mCl.ReleaseMemObject); }
  };
  /// Memory of the device.
  using Memory = std::unique_ptr<std::remove_pointer_t<cl_mem>, ReleaseMemory>;

  /// A queue and a kernel with its arguments. One thread at a time uses it; its functions throw DeviceFailure.
  class Lane {
   public:
    /// @param fewestTogether  the numbers of a kernel at first, and on a slow device
    Lane(const OpenClDevice& device, std::shared_ptr<const Program> program, const char* kernel,
         std::size_t fewestTogether = kFewestTogether);
    Lane(const Lane&) = delete;
    ~Lane();

    /// @throw DeviceIsFull
    Memory made(std::size_t bytes, cl_mem_flags flags = CL_MEM_READ_WRITE) const;
    /// Memory that kernels only read.
    Memory uploaded(const void* data, std::size_t bytes) const;
    /// Begins to write. @a data must stay as it is until wait() or settle().
    void write(cl_mem memory, const void* data, std::size_t bytes);
    /// Begins to read, after everything that was begun earlier. @a data must stay valid until wait() or settle().
    void read(cl_mem memory, void* data, std::size_t bytes);
    /// Waits for everything that was begun. @throw DeviceHangs  one of the kernels or copies took too long
    void wait();
    /// After a failure, waits until the driver no longer uses the memory of the host.
    /// @return false if it does not say so: that memory may be neither changed nor released
    bool settle();
    template <class T>
    void setArgument(cl_uint number, const T& value) const {
      if (mDevice.mCl.SetKernelArg(mKernel, number, sizeof(T), &value) != CL_SUCCESS)
        throw DeviceFailure("its kernel refused argument " + std::to_string(number));
    }
    /// Begins to run the kernel for the numbers 0 to @a count - 1, and for some more that fill up the last group: as
    /// several kernels that follow each other. On a fast device each gets more of the numbers, so none takes long.
    void run(std::size_t count);

   private:
    template <class Enqueue>
    void begin(const char* refusal, const Enqueue& enqueue);
    cl_int statusAtEnd(cl_event event) const;
    void await(cl_event event) const;
    /// Forgets what was begun, if a failure ends the call.
    void release(std::vector<cl_event>& events) const;

    const OpenClDevice& mDevice;
    std::shared_ptr<const Program> mProgram;
    cl_command_queue mQueue = nullptr;
    cl_kernel mKernel = nullptr;
    std::vector<cl_event> mBegun;            ///< kernels and copies in their order, which have not been waited for
    std::size_t mFewestTogether, mTogether;  ///< the numbers of a kernel, at least and now
    std::size_t mCount = 0;                  ///< the numbers of the kernels that were begun
    static constexpr std::size_t kFewestTogether = std::size_t{1} << 16, kMostTogether = std::size_t{1} << 20;
  };

  /// Adds to the device's use.
  void countPoints(std::size_t points) const;
  void countEdges(std::size_t edges) const;
  void countRays(std::size_t rays) const;

 private:
  /// Gives an object back to the driver by its own function, unless the device may still use it.
  template <class Object, class Function>
  void release(Object object, const Function& function) const {
    if (mHangs)
      keepUntilExit(object);
    else
      function(object);
  }
  std::string refusalOf();
  template <class Change>
  void countUse(const Change& change) const {
    const std::lock_guard lock(mUseMutex);
    change(mUse);
  }
  template <class Real>
  bool hasArithmetic();
  template <class Real>
  bool hadArithmetic();
  cl_int built(cl_program program, const std::string& options) const;

  DeviceInfo mInfo;
  const OpenClFunctions& mCl;
  cl_device_id mDevice;
  cl_context mContext = nullptr;
  std::size_t mMostBytes = 0;
  double mSeconds = 0;  ///< how long an answer may take
  DeviceNotice mNotice;
  std::shared_ptr<const DeviceCache> mCache;
  mutable std::atomic<bool> mHangs =
      false;  ///< whether it stopped answering; nothing is released then, because that would wait for the driver
  /// When anything that was begun on the device was last known to be done.
  mutable std::atomic<std::chrono::steady_clock::duration> mLastAnswer{std::chrono::steady_clock::duration::min()};
  mutable std::mutex mUseMutex;
  mutable DeviceUse mUse;  ///< mUseMutex guards it
  mutable std::mutex mMutex;
  mutable std::map<std::string, std::shared_ptr<const Program>> mPrograms;  ///< by their options; mMutex guards them
};

}  // namespace julia::device
