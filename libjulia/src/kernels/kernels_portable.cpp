// SPDX-License-Identifier: Apache-2.0
#include "kernel_tables.h"

#include "kernel_bodies.h"

namespace julia::kernels {

const Tables kPortable = {&kTable<float>, &kTable<double>};

}  // namespace julia::kernels
