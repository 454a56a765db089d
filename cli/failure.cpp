// SPDX-License-Identifier: Apache-2.0
#include "failure.h"

#include "exit_code.h"
#include "interruption.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/base/text.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/files/io_failure.h"
#include "vdbtools/maps/device_choice.h"
#include "vdbtools/records/failure_text.h"

#include <algorithm>
#include <new>
#include <string>
#include <string_view>
#include <system_error>

namespace cli {
namespace {

constexpr const char* kNoThread =
    "no further thread can be started: memory, or the number of threads that are allowed, is short";

Failure failureOf() {
  try {
    throw;
  } catch (const FailedWith& error) {
    return {error.code(), error.what()};
  } catch (const std::invalid_argument& error) {
    return {kUsage, error.what()};
  } catch (const vdbtools::DataError& error) {
    return {kBadData, vdbtools::failureText(error)};
  } catch (const vdbtools::MissingInputError& error) {
    return {kNoInput, error.what()};
  } catch (const vdbtools::CreateError& error) {
    return {kCannotCreate, error.what()};
  } catch (const vdbtools::UnreachableError& error) {
    return {kInterrupted, error.what()};
  } catch (const vdbtools::IoError& error) {
    return {kInputOutput, error.what()};
  } catch (const vdbtools::DeviceError& error) {
    return {kInternal, error.what()};
  } catch (const vdbtools::Interrupted&) {
    return {kInterrupted, "interrupted; " + whatIsLeft()};
  } catch (const vdbtools::MemoryError& error) {
    const bool isOurs = error.use() != vdbtools::MemoryUse::Libraries;
    return {kInternal, vdbtools::failureText(error) + (isOurs ? "; --memory sets another limit" : "")};
  } catch (const std::bad_alloc&) {
    return {kInternal, vdbtools::kOutOfMemory};
  } catch (const std::system_error& error) {
    if (error.code() == std::errc::resource_unavailable_try_again) return {kInternal, kNoThread};
    return {kInternal, std::string("internal error: ") + error.what()};
  } catch (const std::exception& error) {
    if (std::string_view(error.what()).starts_with("pthread_create has failed"))
      return {kInternal, kNoThread};  // oneTBB
    return {kInternal, std::string("internal error: ") + error.what()};
  }
}

/// Shortens a quoted value, which may be a whole file. Its beginning and its end are kept.
std::string shortened(const std::string& text) {
  constexpr std::size_t kLongest = 2000, kEnd = 600;
  if (text.size() <= kLongest) return text;
  return text.substr(0, vdbtools::characterAt(text, kLongest - kEnd)) + " [...] " +
         text.substr(vdbtools::characterAt(text, text.size() - kEnd));
}

}  // namespace

Failure currentFailure() {
  Failure failure = failureOf();
  std::replace_if(
      failure.text.begin(), failure.text.end(), [](char c) { return c == '\n' || c == '\r' || c == '\t'; }, ' ');
  failure.text = shortened(vdbtools::withoutControls(std::move(failure.text)));
  return failure;
}

}  // namespace cli
