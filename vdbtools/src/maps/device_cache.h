// SPDX-License-Identifier: Apache-2.0
/// @file device_cache.h
/// Compiled programs of devices, kept in files of the user's cache folder.
///
/// A file has the SHA-256 of its key and of its data in front of the data. Whatever is not as it should be (a folder or
/// a file of another user or that others may write, a link, other hashes) is treated as if it were not there. A file
/// appears complete, so several processes may use the folder at once.
#pragma once

#include "julia/device/device.h"

#include <memory>

namespace vdbtools {

/// The folder that JULIAVDB_DEVICE_CACHE names, or juliavdb/devices in the user's cache folder.
/// @return null if it says "none", or if there is no such folder and it cannot be made
std::shared_ptr<const julia::DeviceCache> deviceCache();

}  // namespace vdbtools
