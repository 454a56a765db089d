// SPDX-License-Identifier: Apache-2.0
/// @file output_files.h
/// The outputs of a job, none of which is one of its inputs. Everything that a command, the page of `juliavdb explore`
/// or the Python module writes under a name chosen by the user goes through here.
#pragma once

#include "vdbtools/files/atomic_file.h"
#include "vdbtools/files/input_files.h"

#include <filesystem>
#include <list>
#include <map>
#include <utility>

namespace vdbtools {

/// Names of outputs, checked against the inputs and each other before anything is written.
class OutputPlaces {
 public:
  explicit OutputPlaces(InputFiles inputs) : mInputs(std::move(inputs)) {}

  /// @throw std::invalid_argument  the output is an input, or the same file as an earlier output; the message names
  ///                               both
  void claim(const std::filesystem::path& output);

 private:
  InputFiles mInputs;
  std::map<std::filesystem::path, std::filesystem::path> mClaimed;
};

/// Files that are committed together.
class OutputFiles {
 public:
  /// @param inputs  all files that the job reads or has read
  explicit OutputFiles(InputFiles inputs) : mPlaces(std::move(inputs)) {}

  /// Claims a path; the content is written to the file's stream.
  /// @throw std::invalid_argument  as OutputPlaces::claim()
  /// @throw CreateError
  AtomicFile& add(const std::filesystem::path& path);
  /// Claims the standard output. It gets its bytes after all files are on the disk, and before they are committed.
  /// @throw std::invalid_argument  it is an output already, or a file that is an input
  /// @throw CreateError
  AtomicFile& addStandardOutput();

  /// Flushes all files to the disk, which takes most of the time of a commit, and fills the standard output if that is
  /// one of them. @throw IoError
  void finish();
  /// Commits all files. @throw as commitAll()
  void commit();

  const std::list<AtomicFile>& files() const { return mFiles; }
  /// Discards what was added so far.
  void clear() {
    mFiles.clear();
    mHasStandardOutput = false;
  }

 private:
  OutputPlaces mPlaces;
  std::list<AtomicFile> mFiles;
  bool mHasStandardOutput = false;
};

}  // namespace vdbtools
