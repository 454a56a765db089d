// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/files/frames.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/files/standard_streams.h"

#include <system_error>

namespace vdbtools {

void FrameInputs::add(const std::filesystem::path& file, int frame) {
  if (!mKnown.insert(file).second) return;
  mFiles.add(file);
  std::error_code error;
  if (std::filesystem::exists(pathToOpen(file), error)) return;
  constexpr std::size_t kMostNamed = 3;
  if (++mMissing <= kMostNamed)
    mNames += (mNames.empty() ? "'" : ", '") + file.string() + "' (frame " + std::to_string(frame) + ")";
}

void FrameInputs::requireNoneMissing() const {
  if (mMissing == 0) return;
  throw MissingInputError(mMissing == 1 ? "an input of the sequence is missing: " + mNames
                                        : std::to_string(mMissing) +
                                              " inputs of the sequence are missing, the first of them " + mNames);
}

}  // namespace vdbtools
