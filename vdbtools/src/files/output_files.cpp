// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/files/output_files.h"

#include "files/file_place.h"
#include "vdbtools/files/file_bytes.h"

#include <stdexcept>
#include <string>
#include <vector>

namespace vdbtools {

namespace fs = std::filesystem;

void OutputPlaces::claim(const fs::path& output) {
  mInputs.requireNot(output);
  if (isNoOrdinaryFile(output)) return;
  const auto [claimed, isNew] = mClaimed.try_emplace(placeOfFile(output), output);
  if (isNew) return;
  const std::string name = inOneLine(output.native());
  throw std::invalid_argument((claimed->second == output ? "two outputs are called '" + name + "'"
                                                         : "the outputs '" + inOneLine(claimed->second.native()) +
                                                               "' and '" + name + "' are the same file") +
                              "; give each output a name of its own");
}

AtomicFile& OutputFiles::add(const fs::path& path) {
  mPlaces.claim(path);
  return mFiles.emplace_back(path);
}

AtomicFile& OutputFiles::addStandardOutput() {
  if (mHasStandardOutput)
    throw std::invalid_argument("two outputs are to go to the standard output; give one of them the name of a file");
  mPlaces.claim("/dev/stdout");  // which may be an ordinary file
  mFiles.push_back(AtomicFile::standardOutput());
  mHasStandardOutput = true;
  return mFiles.back();
}

void OutputFiles::finish() {
  for (AtomicFile& file : mFiles) file.finish();
  for (AtomicFile& file : mFiles) file.deliver();
}

void OutputFiles::commit() {
  std::vector<AtomicFile*> files;
  for (AtomicFile& file : mFiles) files.push_back(&file);
  commitAll(files);
}

}  // namespace vdbtools
