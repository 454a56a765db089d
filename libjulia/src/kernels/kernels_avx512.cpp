// SPDX-License-Identifier: Apache-2.0
#include "kernel_tables.h"

#include "kernel_bodies.h"

namespace julia::kernels {

const Tables kAvx512 = {&kTable<float>, &kTable<double>};

}  // namespace julia::kernels
