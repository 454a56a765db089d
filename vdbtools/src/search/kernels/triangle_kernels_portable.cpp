// SPDX-License-Identifier: Apache-2.0
#define JULIA_FLOATS 4
#include "search/kernels/triangle_bodies.h"

namespace vdbtools::kernels {

const Kernels kPortable = {nearest, collect, gather, makeFrames, resolve};

}  // namespace vdbtools::kernels
