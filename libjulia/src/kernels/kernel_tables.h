// SPDX-License-Identifier: Apache-2.0
/// @file kernel_tables.h
/// One table of kernels for each instruction set that the program was built with.
#pragma once

#include "kernels.h"

namespace julia::kernels {

struct Tables {
  const Kernels<float>* floats;
  const Kernels<double>* doubles;
};

extern const Tables kPortable;
#ifdef JULIA_X86_KERNELS
extern const Tables kAvx2;
extern const Tables kAvx512;
#endif

}  // namespace julia::kernels
