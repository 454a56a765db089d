// SPDX-License-Identifier: Apache-2.0
#include "explore/failure_answer.h"

#include "explore/file_access.h"
#include "explore/scene_store.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/records/failure_text.h"

#include <algorithm>
#include <new>
#include <stdexcept>

namespace vdbtools::explore {
namespace {

FailureAnswer answerOf() {
  try {
    throw;
  } catch (const FileRefused& error) {
    return {403, error.what()};
  } catch (const Superseded& error) {
    return {409, error.what()};
  } catch (const Interrupted& error) {
    return {409, error.what()};
  } catch (const std::invalid_argument& error) {
    return {400, error.what()};
  } catch (const DataError& error) {
    return {422, failureText(error)};
  } catch (const MissingInputError& error) {
    return {422, error.what()};
  } catch (const CreateError& error) {
    return {500, error.what()};
  } catch (const IoError& error) {
    return {500, error.what()};
  } catch (const MemoryError& error) {
    return {500, failureText(error)};
  } catch (const std::bad_alloc&) {
    return {500, kOutOfMemory};
  } catch (const std::exception& error) {
    return {500, std::string("internal error: ") + error.what()};
  }
}

}  // namespace

FailureAnswer currentFailureAnswer() {
  FailureAnswer answer = answerOf();
  std::replace_if(
      answer.text.begin(), answer.text.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');
  return answer;
}

}  // namespace vdbtools::explore
