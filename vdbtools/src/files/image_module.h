// SPDX-License-Identifier: Apache-2.0
/// @file image_module.h
/// The functions that need OpenImageIO. It brings about 200 libraries, which take longer to load than many jobs take to
/// run. The code that needs them is therefore a separate module, loaded with the first picture that is read or written
/// as EXR. In static builds it is part of the library, and nothing is loaded.
#pragma once

namespace vdbtools {

/// The address of one of the module's functions.
/// @throw IoError      the module cannot be loaded
/// @throw MemoryError  there is not enough memory for its libraries
void* imageFunction(const char* name);

/// The number of threads for reading or writing a picture: as many as the program may use, but fewer if the limit of
/// address space leaves little for them once the module is loaded.
int imageThreads();

}  // namespace vdbtools
