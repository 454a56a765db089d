// SPDX-License-Identifier: Apache-2.0
// A loader of OpenCL that fails or lies, for tests of devices. What it does not define comes from the true one, to
// which it is linked. JULIAVDB_FAKE_OPENCL says what it does:
//
//   lost:N      the Nth kernel that is run, and every later one, fails
//   late:N      the same, and what is to be written for the Nth one is read two seconds later: a queue that is released
//               meanwhile, which says that the memory is too, ends the process
//   wrong:N     the Nth result that is read, and every later one, has one bit that is wrong
//   hang:N      the Nth result that is read, and every later one, never arrives
//   compiler    the compiler never ends
//   source      the compiler takes no source, only what it has compiled before
//   rounded     the device claims correctly rounded divisions and square roots, as Oclgrind has and does not say
//   denormals   the device has no denormal numbers
//   singles     the device does not compute in 64 bits
//   full:N      after two kernels, there is no memory of more than N bytes in one piece, but for what kernels only read
//   small       the device's memory holds a thousand bytes in one piece
//
// With JULIAVDB_FAKE_DEVICES=2, each device is listed twice.
#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>

#include <dlfcn.h>

#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <string>
#include <thread>

namespace {

std::string mode() {
  const char* const text = std::getenv("JULIAVDB_FAKE_OPENCL");
  return text ? text : "";
}

/// The number of the mode, if the mode is @a name.
std::optional<long> numberOf(const std::string& name) {
  const std::string set = mode();
  if (set.rfind(name + ":", 0) != 0) return std::nullopt;
  return std::atol(set.c_str() + name.size() + 1);
}

/// Whether the mode is @a name with a number that @a calls has reached.
bool isDue(const std::string& name, std::atomic<int>& calls) {
  const auto number = numberOf(name);
  return number && ++calls >= *number;
}

template <class Function>
Function* next(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

std::atomic<int> ran{0}, kernels{0}, wrongReads{0}, hungReads{0}, lateWrites{0};
std::atomic<bool> hangs{false};

}  // namespace

extern "C" {

cl_int clEnqueueNDRangeKernel(cl_command_queue queue, cl_kernel kernel, cl_uint dimensions, const size_t* offset,
                              const size_t* size, const size_t* group, cl_uint count, const cl_event* events,
                              cl_event* event) {
  ++ran;
  if (isDue("lost", kernels) || isDue("late", kernels)) return CL_OUT_OF_RESOURCES;
  return next<decltype(clEnqueueNDRangeKernel)>("clEnqueueNDRangeKernel")(queue, kernel, dimensions, offset, size,
                                                                          group, count, events, event);
}

cl_program clCreateProgramWithSource(cl_context context, cl_uint count, const char** texts, const size_t* lengths,
                                     cl_int* error) {
  if (mode() == "source") {
    if (error) *error = CL_COMPILER_NOT_AVAILABLE;
    return nullptr;
  }
  return next<decltype(clCreateProgramWithSource)>("clCreateProgramWithSource")(context, count, texts, lengths, error);
}

cl_int clBuildProgram(cl_program program, cl_uint count, const cl_device_id* devices, const char* options,
                      void (*notify)(cl_program, void*), void* data) {
  while (mode() == "compiler") std::this_thread::sleep_for(std::chrono::seconds(1));
  return next<decltype(clBuildProgram)>("clBuildProgram")(program, count, devices, options, notify, data);
}

cl_mem clCreateBuffer(cl_context context, cl_mem_flags flags, size_t size, void* host, cl_int* error) {
  const auto most = numberOf("full");
  if (most && ran >= 2 && !(flags & CL_MEM_READ_ONLY) && size > static_cast<size_t>(*most)) {
    if (error) *error = CL_MEM_OBJECT_ALLOCATION_FAILURE;
    return nullptr;
  }
  return next<decltype(clCreateBuffer)>("clCreateBuffer")(context, flags, size, host, error);
}

cl_int clEnqueueReadBuffer(cl_command_queue queue, cl_mem buffer, cl_bool blocking, size_t offset, size_t size,
                           void* to, cl_uint count, const cl_event* events, cl_event* event) {
  const bool isWrong = isDue("wrong", wrongReads);
  if (isDue("hang", hungReads)) hangs = true;
  const cl_int error = next<decltype(clEnqueueReadBuffer)>("clEnqueueReadBuffer")(
      queue, buffer, isWrong ? CL_TRUE : blocking, offset, size, to, count, events, event);
  if (isWrong && size > 0) static_cast<unsigned char*>(to)[size / 8 * 4] ^= 1;
  return error;
}

cl_int clEnqueueWriteBuffer(cl_command_queue queue, cl_mem buffer, cl_bool blocking, size_t offset, size_t size,
                            const void* from, cl_uint count, const cl_event* events, cl_event* event) {
  const auto write = next<decltype(clEnqueueWriteBuffer)>("clEnqueueWriteBuffer");
  const auto late = numberOf("late");
  if (blocking || !late || kernels + 1 < *late)
    return write(queue, buffer, blocking, offset, size, from, count, events, event);
  cl_context context = nullptr;
  clGetCommandQueueInfo(queue, CL_QUEUE_CONTEXT, sizeof(context), &context, nullptr);
  const cl_event begins = clCreateUserEvent(context, nullptr);
  ++lateWrites;
  std::thread([begins] {
    std::this_thread::sleep_for(std::chrono::seconds(2));
    --lateWrites;
    clSetUserEventStatus(begins, CL_COMPLETE);
  }).detach();
  return write(queue, buffer, blocking, offset, size, from, 1, &begins, event);
}

cl_int clReleaseCommandQueue(cl_command_queue queue) {
  if (lateWrites > 0) {
    std::fputs("what was to be written has not been read yet\n", stderr);
    std::abort();
  }
  return next<decltype(clReleaseCommandQueue)>("clReleaseCommandQueue")(queue);
}

cl_int clGetEventInfo(cl_event event, cl_event_info what, size_t size, void* to, size_t* needed) {
  const cl_int error = next<decltype(clGetEventInfo)>("clGetEventInfo")(event, what, size, to, needed);
  if (hangs && error == CL_SUCCESS && to && what == CL_EVENT_COMMAND_EXECUTION_STATUS)
    *static_cast<cl_int*>(to) = CL_RUNNING;
  return error;
}

cl_int clGetDeviceIDs(cl_platform_id platform, cl_device_type type, cl_uint room, cl_device_id* devices,
                      cl_uint* found) {
  const auto list = next<decltype(clGetDeviceIDs)>("clGetDeviceIDs");
  if (!std::getenv("JULIAVDB_FAKE_DEVICES")) return list(platform, type, room, devices, found);
  const cl_int error = list(platform, type, room / 2, devices, found);
  if (error != CL_SUCCESS) return error;
  if (found) *found *= 2;
  for (cl_uint i = 0; devices && i < room / 2; ++i) devices[room / 2 + i] = devices[i];
  return error;
}

cl_int clGetDeviceInfo(cl_device_id device, cl_device_info what, size_t size, void* to, size_t* needed) {
  const cl_int error = next<decltype(clGetDeviceInfo)>("clGetDeviceInfo")(device, what, size, to, needed);
  if (error != CL_SUCCESS || !to) return error;
  if (mode() == "denormals" && what == CL_DEVICE_SINGLE_FP_CONFIG)
    *static_cast<cl_device_fp_config*>(to) &= ~static_cast<cl_device_fp_config>(CL_FP_DENORM);
  if (mode() == "rounded" && what == CL_DEVICE_SINGLE_FP_CONFIG)
    *static_cast<cl_device_fp_config*>(to) |= CL_FP_CORRECTLY_ROUNDED_DIVIDE_SQRT;
  if (mode() == "singles" && what == CL_DEVICE_DOUBLE_FP_CONFIG) *static_cast<cl_device_fp_config*>(to) = 0;
  if (mode() == "small" && what == CL_DEVICE_MAX_MEM_ALLOC_SIZE) *static_cast<cl_ulong*>(to) = 1000;
  return error;
}

}  // extern "C"
