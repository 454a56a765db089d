// SPDX-License-Identifier: Apache-2.0
/// @file image_module.h
/// The functions that need OpenImageIO. It brings some 200 libraries, which take longer to load than many jobs take to
/// run. The code that needs them is therefore a module of its own, loaded with the first picture that is read or
/// written as EXR. In static builds it is part of the library, and there is nothing to load.
#pragma once

namespace vdbtools {

/// The address of one of the module's functions.
/// @throw IoError      the module cannot be loaded
/// @throw MemoryError  there is no room for its libraries
void* imageFunction(const char* name);

/// How many threads reading or writing a picture should use: those that the program may, but fewer where the limit of
/// address space leaves little for them once the module is loaded.
int imageThreads();

}  // namespace vdbtools
