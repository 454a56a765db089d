// SPDX-License-Identifier: Apache-2.0
/// @file small_disk.h
/// A file system with room for 64 KiB, where this process may mount one.
#pragma once

#include <sys/mount.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <string>

class SmallDisk {
 public:
  explicit SmallDisk(const std::filesystem::path& folder) : mFolder(folder) {
    std::filesystem::create_directory(folder);
    mMounted = ::mount("none", folder.c_str(), "tmpfs", 0, "size=64k") == 0;
    if (!mMounted) mError = errno;
  }
  ~SmallDisk() {
    if (mMounted) ::umount(mFolder.c_str());
  }
  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;
  bool isMounted() const { return mMounted; }
  std::string error() const { return std::strerror(mError); }

 private:
  std::filesystem::path mFolder;
  bool mMounted = false;
  int mError = 0;
};
